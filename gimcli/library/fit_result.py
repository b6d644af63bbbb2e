"""The result of a fit, and its picture: the mechanism at its targets, the curve and the targets, or a graph."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import numpy as np

from gimcli import output
from gimcli.fitting.targets import GIVEN
from gimcli.library.fit_targets import FittedTask
from gimcli.library.fitted_design import FitMotion, FittedDesign
from gimcli.library.record import Records, RowField
from gimcli.library.result import Result
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.quantities.state import State
from gimcli.rates.member_angles import full_turn
from gimcli.rounding import number
from gimcli.status import Status
from gimcli.table import Table


@dataclass(frozen=True)
class FitCounts:
    """What a search has tried."""

    drawn: int  # random designs
    started: int  # those that were refined
    hits: int  # fits with the error of the result
    seed: int
    ended: str = Status.OK.word  # how the search ended: ok, work-limit or interrupted


class FitResult(Result):
    """A fitted mechanism: `mechanism`, `dimensions`, `error` (sum of squares), and one row for each target."""

    KIND = "fit"

    def __init__(
        self, nominal: Mechanism, names: tuple[str, ...], found: FittedDesign | None, counts: FitCounts,
        task: FittedTask | None = None, reason: str = "", stand: tuple[str, ...] = (),
        undetermined: tuple[str, ...] = (), goal: str = "",
    ) -> None:  # fmt: skip
        self.status, self.undetermined, self.on_bounds, self.goal = counts.ended, undetermined, stand, goal
        self.reason = reason  # why no design is feasible
        self.nominal, self.names, self._found, self._counts = nominal, names, found, counts
        self._task = cast(FittedTask, task)  # a goal has none
        self.mechanism = nominal if found is None else found.mechanism

    @property
    def feasible(self) -> bool:
        """Whether a design was found whose real motion passes the targets in order on one branch."""
        return self._found is not None

    @property
    def complete(self) -> bool:
        """Whether a feasible design was found by a search that did not end early."""
        return self.feasible and self.status == Status.OK.word

    @property
    def dimensions(self) -> dict[str, float]:
        """The fitted dimensions by name, in the file's units; empty if no design is feasible."""
        return {} if self._found is None else {name: self._found.changes[name] for name in self.names}

    @property
    def error(self) -> float:
        """The sum of squares on the real motion; of an angle in the file's unit. NaN if no design is feasible."""
        return math.nan if self._found is None else self._found.error * self._units[0] ** 2

    @property
    def rms(self) -> float:
        """The root of the mean over the targets (of pairs: over all places) of the squared differences."""
        return math.sqrt(self.error / (len(self._task.targets.values) * max(1, self._task.points.shape[1])))

    @property
    def _units(self) -> Sequence[float]:
        """The file's unit of each component per its own: of angles per rad, else 1; the first is that of errors."""
        turned = math.degrees(1.0) if self.nominal.angle_unit == "deg" else 1.0
        return [turned if one.quantity.circular else 1.0 for one in self._task.components]

    def headline(self) -> str:
        """Return the result in one line."""
        if self._found is None:
            return (
                f"{self.nominal.name}: no feasible design was found from {self._counts.drawn} random designs:"
                f" {self.reason or 'none satisfies the conditions'}; widen the bounds, use more starts, or relax the"
                " conditions"
            )
        return f"{self.nominal.name}: {self._outcome()}"

    def _outcome(self) -> str:
        return f"sum of squares {self.error:.9g}, root mean square {number(self.rms)}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        report: dict[str, Any] = {
            "feasible": self.feasible, "kind": self.kind, "status": self.status,
            "starts": {"drawn": self._counts.drawn, "started": self._counts.started, "hits": self._counts.hits},
        }  # fmt: skip
        if self._found is None:
            return report | {"reason": self.headline()}
        return report | {
            "dimensions": self.dimensions, "changes": self._found.changes, "on_bounds": list(self.on_bounds),
            "undetermined": list(self.undetermined), **self._values(),
            "transmission": self._found.motion.worst_transmission,
        }  # fmt: skip

    @property
    def kind(self) -> str:
        """What is fitted: "path", "poses", "function" or "goal"."""
        return self._task.kind

    def _values(self) -> dict[str, Any]:
        return {
            "error": self.error, "rms": self.rms, "largest": float(np.max(self._distances)),
            "inputs": self._inputs.tolist(), "sense": self.sense,
        }  # fmt: skip

    @property
    def sense(self) -> str:
        """Whether the input increases or decreases from target to target; "" with given inputs."""
        if self._found is None or self._task.targets.unknown == 0 or not self._task.targets.in_order:
            return ""
        return "increasing" if self._found.inputs[-1] > self._found.inputs[0] else "decreasing"

    @property
    def _inputs(self) -> FloatArray:
        """The inputs (targets,) in the file's unit; unknown ones of a turning input are in its first turn."""
        assert self._found is not None
        limits, inputs = self._task.targets.range, self._found.inputs
        if limits.turning and self._task.targets.timing != GIVEN:
            inputs = limits.low + (inputs - limits.low) % (limits.high - limits.low)
        return np.asarray(self.nominal.value_to_file(self.nominal.drivers[0], inputs))

    @property
    def _distances(self) -> FloatArray:
        """The root of the squared differences (targets,) of each target."""
        assert self._found is not None
        residual, points = self._task.targets.residuals(self._found.motion.values), self._task.points
        centres = np.sum(points, axis=1, keepdims=True) / max(1, points.shape[1])
        apart = np.sum((points - centres) ** 2, axis=(1, 2))  # of pairs: their least possible error
        return np.asarray(np.sqrt(np.sum(residual**2, axis=1) + apart) * self._units[0])

    @cached_property
    def _state(self) -> State | None:
        """The positions at the targets, of which any quantity may be asked by its name; None if there are none."""
        from gimcli.library.solved_positions import positions_state

        if self._found is None:
            return None
        own, count = self._found.motion, len(self._found.inputs)
        z = Motion.joined(list(own.trace._motions)).z[:, own.places]
        return positions_state(self.mechanism, self._found.inputs[None], z, np.zeros(count), [0] * count)

    @cached_property
    def _design(self) -> Records:
        """The fitted dimensions, one row each."""
        return Records(
            RowField("dimension", list(self.dimensions), str, head="dimension"),
            RowField("value", list(self.dimensions.values()), float, head="value", text="{:.12g}".format),
        )

    @cached_property
    def _records(self) -> Records:
        """The targets, one row each: input, values, those of the motion, and their distance."""
        if self._found is None:
            return Records()
        actuator = self.nominal.actuators[self.nominal.drivers[0]]
        own = {"target.": self._task.targets.values, "": self._found.motion.values}
        heads, units = [one.head for one in self._task.components], self._units
        columns = [
            (actuator.name, self._inputs, self.nominal.unit_of(actuator)),
            *(
                (begin + head.name, values[:, k] * units[k], head.unit)
                for begin, values in own.items()
                for k, head in enumerate(heads)
            ),
            ("distance", self._distances, heads[0].unit),
        ]
        return Records(
            RowField("target", range(1, len(self._distances) + 1), int, head="target"),
            *(RowField(name, values, float, unit, head=name) for name, values, unit in columns),
        )

    def contents(self, paths: Iterable[Path]) -> dict[Path, Any]:
        """Return the content of each file; of files other than reports None if no design is feasible."""
        return {
            path: c if self.feasible or (c and not isinstance(c, Table)) else None
            for path, c in super().contents(paths).items()
        }

    def checks(self) -> list[str]:
        """Return what was checked on the real motion, as sentences."""
        assert self._found is not None
        worst, unit = self._found.motion.worst_transmission, self.nominal.angle_unit
        angle = "" if worst is None else number(worst)
        lines = (
            (True, self._confirmed()),
            (angle, f"worst transmission angle {angle} {unit} (from 0 and from a straight angle)"),
            (self.on_bounds, f"on a bound: {', '.join(self.on_bounds)}"),
            (self.undetermined, f"not determined by the targets: {', '.join(self.undetermined)}"),
            (self.status != Status.OK.word,
             f"{self.status}: the search ended early; this is the best design found until then"),
        )  # fmt: skip
        return [text for holds, text in lines if holds]

    def _confirmed(self) -> str:
        order = f"in order, with the input {self.sense}, " if self.sense else ""
        return f"the traced motion passes all targets {order}on one branch, over the whole law of the input"

    def picture(self) -> output.picture.Content | None:
        """Return the mechanism, the curve of its point and the targets; for a function its graph too."""
        if self._found is None:
            return None
        task, motion, mechanism = self._task, self._found.motion, self._found.motion.trace.mechanism
        poses = mechanism.to_file(motion.trace._motion.z[:, motion.places].T)
        if task.kind == "function":
            picture = output.drawing.motion_picture(mechanism, poses, {}, mechanism.name)
            return output.panels.with_panels(picture, _graphs(motion, task, self.table()))
        path = motion.trace.xy[task.point]
        targets = (task.points[..., 0] + 1j * task.points[..., 1]).ravel().tolist()
        return output.drawing.motion_picture(
            mechanism, poses, {task.point: path[:, 0] + 1j * path[:, 1]}, mechanism.name, targets=targets
        )  # fmt: skip

    def animation(self) -> output.animation.Animation | None:
        """Return the motion of the fitted mechanism; None if no design is feasible."""
        return None if self._found is None else self._found.motion.trace.animation()

    def model(self) -> output.model.ModelText | None:
        """Return the text of the model file with the fitted dimensions; None if no design is feasible.

        Raises UsageError if the mechanism was not read from a file.
        """
        if self._found is None:
            return None
        from gimcli.library.model_text import changed_text

        return changed_text(self.nominal, self._found.changes)


class GoalResult(FitResult):
    """A mechanism with the least goal: `mechanism`, `dimensions`, `error` (the goal); one row for each dimension."""

    kind, sense, rms, _units = "goal", "", math.nan, (1.0,)

    @cached_property
    def _state(self) -> State | None:
        """The motion along the law, of which any quantity may be asked by its name; None if there is none."""
        return None if self._found is None else self._found.motion.trace._state

    def _outcome(self) -> str:
        return f"{self.goal} is {self.error:.9g}"

    def _values(self) -> dict[str, Any]:
        return {"goal": self.error}

    def _confirmed(self) -> str:
        return "the traced motion passes over the whole law of the input"

    @property
    def _records(self) -> Records:
        """The dimensions, one row each: name and value."""
        return self._design

    def picture(self) -> output.picture.Content | None:
        """Return the motion of the fitted mechanism; None if no design is feasible."""
        return None if self._found is None else self._found.motion.trace.picture()


def _graphs(motion: FitMotion, task: FittedTask, table: Table) -> list[output.graph.CurveGraph]:
    """Return the output over the input, with the targets, and its difference from the targets.

    `table` has one row for each target, with the columns of a FitResult.
    """
    (one,), (given, target, fitted) = task.components, table.columns[1:4]
    trace = motion.trace
    found = np.asarray(trace[one.head.name])
    if one.quantity.circular:  # near its targets
        turn = full_turn(trace.mechanism)
        found = found - turn * np.rint(np.median(found[motion.places] - target.values) / turn)
    across, inputs = output.graph.Axis(given.name, given.unit), trace.table().floats(given.name)
    events = {"target": [complex(a, b) for a, b in zip(given.values, target.values, strict=True)]}
    curve = output.graph.Curve(fitted.name, inputs, found)
    order = np.argsort(given.values)
    difference = output.graph.Curve("difference", given.values[order], (found[motion.places] - target.values)[order])
    return [
        output.graph.CurveGraph(across, output.graph.Axis(fitted.name, fitted.unit), [curve], events=events),
        output.graph.CurveGraph(across, output.graph.Axis("difference", fitted.unit), [difference]),
    ]
