"""The picture of a fit: the mechanism at its targets, the curve and the targets, or the graph of a function."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gimcli.mechanism import FloatArray

if TYPE_CHECKING:
    from gimcli.library.fit_targets import FittedTask
    from gimcli.library.fitted_design import FitMotion
    from gimcli.output.graph import CurveGraph
    from gimcli.output.picture import Content
    from gimcli.table import Table


def fit_picture(motion: FitMotion, task: FittedTask, table: Table) -> Content:
    """Return the poses at the targets, the curve of the point and the targets; for a function also its graph.

    `table` has one row for each target, with the columns of a FitResult.
    """
    from gimcli.output.drawing import motion_picture
    from gimcli.output.panels import with_panels

    mechanism, z = motion.trace.mechanism, motion.trace.motion.z
    poses = mechanism.to_file(z[:, motion.places].T)
    if task.kind == "function":
        picture = motion_picture(mechanism, poses, {}, mechanism.name)
        return with_panels(picture, _graphs(motion, task, table))
    path = motion.trace.xy[task.point]
    targets = (task.points[..., 0] + 1j * task.points[..., 1]).ravel().tolist()
    return motion_picture(mechanism, poses, {task.point: path[:, 0] + 1j * path[:, 1]}, mechanism.name, targets=targets)


def _graphs(motion: FitMotion, task: FittedTask, table: Table) -> list[CurveGraph]:
    """Return the output over the input, with the targets, and its difference from the targets."""
    from gimcli.library.fitted_design import column_of
    from gimcli.output.graph import Axis, Curve, CurveGraph

    (one,), (given, target, fitted) = task.components, table.columns[1:4]
    trace = motion.trace
    output = column_of(trace, one)
    if one.quantity.circular:
        output = output + _turns(output[motion.places] - target.values, target.unit)
    across, inputs = Axis(given.name, given.unit), trace.table().floats(given.name)
    events = {"target": [complex(a, b) for a, b in zip(given.values, target.values, strict=True)]}
    curve = Curve(fitted.name, inputs, np.asarray(output))
    order = np.argsort(given.values)
    difference = Curve("difference", given.values[order], (np.asarray(output)[motion.places] - target.values)[order])
    return [
        CurveGraph(across, Axis(fitted.name, fitted.unit), [curve], events=events),
        CurveGraph(across, Axis("difference", fitted.unit), [difference]),
    ]


def _turns(difference: FloatArray, unit: str) -> float:
    """Return the full turns to add to an angle so that it is near its targets."""
    turn = 360.0 if unit == "deg" else 2.0 * np.pi
    return -turn * float(np.rint(np.median(difference) / turn))
