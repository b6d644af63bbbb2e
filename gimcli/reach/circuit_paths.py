"""The curves along which one input moves a mechanism: the parts of its circuits within the range of the input.

They contain every configuration that `gim solve --all` finds at many values of the input.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from gimcli.branching.enumeration import CircuitSearch, EnumerationConstants
from gimcli.branching.resampling import beside, between, settled
from gimcli.continuation.arclength import CurvePoint, place
from gimcli.continuation.circuit import Circuit, nearby
from gimcli.continuation.curve import PositionCurve
from gimcli.mechanism import FloatArray
from gimcli.positions.inputs import InputLine
from gimcli.progress import Progress, no_progress
from gimcli.reach.critical_curves import WALK, CriticalCurve, CriticalPoint, point_between, split
from gimcli.reach.critical_positions import CriticalPath, Stratum
from gimcli.reach.task import WorkspaceTask, law_range

ROUNDING = 1e-13
"""Absolute value below which the distance from the end of a range is 0."""


def along_circuits(task: WorkspaceTask, progress: Progress = no_progress) -> tuple[list[CriticalCurve], bool]:
    """Return the curves of positions within the range of the input, and whether they are proved to be complete."""
    circuits, complete = every_circuit(task, progress)
    return [part for circuit in circuits for part in within(task, circuit)], complete


def every_circuit(task: WorkspaceTask, progress: Progress = no_progress) -> tuple[tuple[Circuit, ...], bool]:
    """Return the circuits with configurations in the range of the input, and whether they are proved to be complete."""
    (actuator,) = task.moving
    span, turning = law_range(task.mechanism, actuator), not task.limited
    rotary = task.mechanism.actuators[actuator].rotary
    search = CircuitSearch(PositionCurve(task.mechanism, input_line(task)), rotary, EnumerationConstants(), progress)
    if search.curve.single:
        search.begin()
    search.sample(span.low, span.low + 2.0 * math.pi if turning else span.high)
    return tuple(strand.circuit for strand in search.strands), search.complete and not search.lost


def within(task: WorkspaceTask, circuit: Circuit) -> list[CriticalCurve]:
    """Return the parts of a circuit on which the input is within its range."""
    curve = CriticalPath(Stratum(task.whole, task.output[0]))
    whole = CriticalCurve(curve, tuple(_knots(task, circuit)), circuit.closed)
    return _within(task, whole) if task.limited else [whole]


def input_line(task: WorkspaceTask) -> InputLine:
    """Return the line in the inputs along which one input moves and the others are constant."""
    (actuator,) = task.moving
    base = np.array([law_range(task.mechanism, k).low for k in range(len(task.mechanism.actuators))])
    along = np.zeros(len(base))
    base[actuator], along[actuator] = 0.0, 1.0
    return InputLine(base, along, actuator)


def _knots(task: WorkspaceTask, circuit: Circuit) -> Iterator[CriticalPoint]:
    """Yield positions along a circuit that are close enough for cubics between them; none far outside the range."""
    first, last = nearby(circuit)
    for k in range(first, last):
        here, there = circuit.places[k], circuit.places[k + 1]
        yield _knot(task, here.p, here.tangent)
        count = _parts(here, there)
        for part in np.arange(1, count) / count:
            p, slope = settled(circuit, k, part), between(here, there, part)[1]
            near = beside(circuit, k, p)
            yield _knot(task, p, slope if near else place(circuit.curve, p, slope).tangent)
    yield _knot(task, circuit.places[last].p, circuit.places[last].tangent)


def _parts(here: CurvePoint, there: CurvePoint) -> int:
    """Return the number of parts into which a step of a circuit is divided."""
    bend = math.acos(min(1.0, max(-1.0, float(here.tangent @ there.tangent))))
    return max(1, math.ceil(max(float(np.linalg.norm(there.p - here.p)) / WALK.longest, bend / WALK.bend)))


def _knot(task: WorkspaceTask, p: FloatArray, tangent: FloatArray) -> CriticalPoint:
    """Return a position and tangent without the parameter of the circuit."""
    along = task.velocity(tangent[:-1])
    return CriticalPoint(task.coordinates(p[:-1]), along / max(float(np.linalg.norm(along)), 1e-300))


def _within(task: WorkspaceTask, branch: CriticalCurve) -> list[CriticalCurve]:
    """Return the parts of a curve on which the input is within its range."""

    def room(knot: CriticalPoint) -> FloatArray:
        room_left = task.room(knot.p)
        return np.where(np.abs(room_left) < ROUNDING, 0.0, room_left)

    parts = split(_rolled(branch, np.array([room(knot)[0] for knot in branch.knots])), room)
    return [part for part in parts if room(_middle(part))[0] > 0.0]


def _middle(part: CriticalCurve) -> CriticalPoint:
    """Return a position between the ends of a curve."""
    knots = part.knots
    if len(knots) > 2:
        return knots[len(knots) // 2]
    return CriticalPoint(point_between(knots[0], knots[1], 0.5), knots[0].tangent)


def _rolled(branch: CriticalCurve, room: FloatArray) -> CriticalCurve:
    """Return a closed curve that begins where the input is farthest outside its range."""
    if not branch.closed:
        return branch
    k = int(np.argmin(room[:-1]))
    return replace(branch, knots=(*branch.knots[k:-1], *branch.knots[: k + 1]))
