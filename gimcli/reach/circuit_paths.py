"""The curves along which one input moves a mechanism: the parts of its circuits within the range of the input.

Those of all assemblies contain every configuration that `gim solve --all` finds at many values of the input; others are
only the paths that the input reaches from the initial configuration, without disassembly.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gimcli.assemblies import all_configurations
from gimcli.assemblies.assemblies import ConfigurationFinder
from gimcli.branching.enumeration import CircuitSearch, EnumerationConstants
from gimcli.branching.resampling import exact_tangents
from gimcli.branching.singular_positions import drawn_circuit
from gimcli.canonical import first_least
from gimcli.connected import connected
from gimcli.continuation.arclength import CurvePoint
from gimcli.continuation.branches import SAME, all_circuits
from gimcli.continuation.circuit import Circuit, Ended, nearby
from gimcli.continuation.curve import Domain, PositionCurve
from gimcli.errors import StructureError, UnassembledError
from gimcli.mechanism import FloatArray
from gimcli.positions.inputs import InputLine, nearest_turns
from gimcli.positions.options import TOLERANCE
from gimcli.progress import Progress, no_progress
from gimcli.reach.arcs import PathArc, feet
from gimcli.reach.critical_curves import WALK, CriticalCurve, CriticalPath, CriticalPoint, Stratum, seamless, split
from gimcli.reach.task import SETTLED, SLACK, WorkspaceTask, law_range, unreached

LOOPS = 4
"""Loops of a coupled group up to which its assemblies are counted: more loops can take seconds."""

NEAR = 1e-5
"""Distance within which a position is on a curve of cubics, relative to the size."""

ENDS = (Ended.CLOSED, Ended.INFINITE, Ended.LAW)
"""How a curve ends that was followed completely."""


ROUNDING = 1e-13
"""Absolute value below which the distance from the end of a range is 0."""


@dataclass(frozen=True)
class StartAssemblies:
    """The assemblies at one value of the input, the start of its law if possible; how many are on other paths."""

    inputs: FloatArray  # (actuators,)
    count: int | None  # None: not counted, as this could take long
    left_out: int = 0
    complete: bool = True  # whether the count is proved


@dataclass(frozen=True)
class InitialPaths:
    """Curves of positions; `initial` is the index of the one through the initial configuration."""

    curves: list[CriticalCurve]
    initial: int
    complete: bool  # each was followed to an end of the range, to infinity or until it closed; so was each that crosses
    start: StartAssemblies


def along_circuits(task: WorkspaceTask, progress: Progress = no_progress) -> tuple[list[CriticalCurve], bool]:
    """Return the curves of positions within the range of the input, and whether they are proved to be complete."""
    circuits, complete = every_circuit(task, progress)
    return [part for circuit in circuits for part in within(task, circuit)], complete


def every_circuit(task: WorkspaceTask, progress: Progress = no_progress) -> tuple[tuple[Circuit, ...], bool]:
    """Return the circuits with configurations in the range of the input, and whether they are proved to be complete."""
    (actuator,) = task.moving
    span, turning = law_range(task.mechanism, actuator), not task.limited
    rotary = task.mechanism.actuators[actuator].rotary
    search = CircuitSearch(curve_of(task), rotary, EnumerationConstants(), progress)
    if search.curve.single:
        search.begin()
    search.sample(span.low, span.low + search.curve.period if turning else span.high)
    return tuple(strand.circuit for strand in search.strands), search.complete and not search.lost


def within(task: WorkspaceTask, circuit: Circuit) -> list[CriticalCurve]:
    """Return the parts of a circuit on which the input is within its range."""
    curve = CriticalPath(Stratum(task.whole, task.output[0]))
    whole = CriticalCurve(curve, tuple(_knots(task, circuit)), circuit.closed)
    return _within(task, whole) if task.limited else [whole]


def curve_of(task: WorkspaceTask) -> PositionCurve:
    """Return the curve along which one input moves and the others are constant, or follow it."""
    (actuator,) = task.moving
    if task.mechanism.couplings:
        curve = PositionCurve(task.mechanism)
        for r in task.limited:
            curve.domain = Domain(r.low, r.high)  # such a curve may close after many turns only
        return curve
    base = np.array([law_range(task.mechanism, k).low for k in range(len(task.mechanism.actuators))])
    along = np.zeros(len(base))
    base[actuator], along[actuator] = 0.0, 1.0
    return PositionCurve(task.mechanism, InputLine(base, along, actuator))


def _knots(task: WorkspaceTask, circuit: Circuit) -> Iterator[CriticalPoint]:
    """Yield positions along a circuit that are close enough for cubics between them; none far outside the range."""
    first, last = nearby(circuit)
    for k in range(first, last):
        count = _parts(*circuit.places[k : k + 2])
        yield from map(partial(_knot, task), *exact_tangents(circuit, np.full(count, k), np.arange(count) / count))
    yield _knot(task, circuit.places[last].p, circuit.places[last].tangent)


def _parts(here: CurvePoint, there: CurvePoint) -> int:
    """Return the number of parts into which a step of a circuit is divided."""
    bend = math.acos(min(1.0, max(-1.0, float(here.tangent @ there.tangent))))
    return max(1, math.ceil(max(float(np.linalg.norm(there.p - here.p)) / WALK.longest, bend / WALK.bend)))


def _knot(task: WorkspaceTask, p: FloatArray, tangent: FloatArray) -> CriticalPoint:
    """Return a position and tangent without the parameter of the circuit."""
    along = task.coordinates(tangent) - task.coordinates(np.zeros_like(tangent))  # these are linear in p
    return CriticalPoint(task.coordinates(p), along / max(float(np.linalg.norm(along)), 1e-300))


def _within(task: WorkspaceTask, branch: CriticalCurve) -> list[CriticalCurve]:
    """Return the parts of a curve on which the input is within its range."""

    def room(knot: CriticalPoint) -> FloatArray:
        room_left = task.room(knot.p)
        return np.where(np.abs(room_left) < ROUNDING, 0.0, room_left)

    parts = split(_rolled(branch, np.array([room(knot)[0] for knot in branch.knots])), room)
    return [part for part in parts if room(PathArc(part, *task.output).middle)[0] > 0.0]


def _rolled(branch: CriticalCurve, room: FloatArray) -> CriticalCurve:
    """Return a closed curve that begins where the input is farthest outside its range."""
    if not branch.closed:
        return branch
    k = int(np.argmin(room[:-1]))
    before = seamless(branch.knots[-1], branch.knots[: k + 1], branch.curve.stratum.n)
    return replace(branch, knots=(*branch.knots[k:-1], *before))


def initial_paths(task: WorkspaceTask, progress: Progress = no_progress) -> InitialPaths:
    """Return the curves within the range of the input that are connected with the initial configuration.

    This is the circuit of the initial configuration, without the parts that the input cannot reach within its range.
    If neither the start of the law nor the drawn input can be assembled, it is the path nearest to the drawing.
    Raises UnassembledError if there is none.
    """
    curve = curve_of(task)
    try:
        first = drawn_circuit(task.mechanism, TOLERANCE, curve)
    except UnassembledError:
        circuits, complete = every_circuit(task, progress)
        if not circuits:
            raise UnassembledError(unreached(task)) from None
        begin = task.coordinates(task.system.coordinates(task.mechanism.drawn))
    else:
        branches = all_circuits(first, progress)
        circuits, complete, begin = branches.circuits, branches.complete, task.coordinates(first.places[first.start].p)
    parts = [(circuit, part) for circuit in circuits for part in within(task, circuit)]
    if not parts:
        raise UnassembledError(f"{unreached(task)}, or search all assemblies")
    initial = nearest(task, [part for _, part in parts], begin)
    kept = _connected(task, parts, initial)
    curves = [parts[k][1] for k in kept]
    complete = complete and all(_followed(task, *parts[k]) for k in kept)
    own = parts[initial][1]
    here = begin if _has(task, own, begin) else np.asarray(own.x[len(own.x) // 2])
    return InitialPaths(curves, kept.index(initial), complete, _start(task, curve, here, curves))


def nearest(task: WorkspaceTask, curves: list[CriticalCurve], x: FloatArray) -> int:
    """Return the number of the curve nearest to a position x (n,)."""
    apart = [float(np.min(np.linalg.norm(one.x - task.beside(x, one.x), axis=1))) for one in curves]
    return first_least(np.array(apart), SETTLED)


def _connected(task: WorkspaceTask, parts: list[tuple[Circuit, CriticalCurve]], first: int) -> list[int]:
    """Return the indices of the parts that are connected with the first one by points that they share."""
    points = [
        *(task.coordinates(met.p) for circuit, _ in parts for met in circuit.crossings.values()),
        *(part.x[end] for _, part in parts if not part.closed for end in (0, -1)),
    ]
    shared = [{k for k, (_, part) in enumerate(parts) if _has(task, part, point)} for point in points]
    return next(sorted(kept) for kept in connected([{first}, *shared], set()) if first in kept)


def _has(task: WorkspaceTask, part: CriticalCurve, point: FloatArray) -> bool:
    return bool(np.min(np.linalg.norm(part.x - task.beside(point, part.x), axis=1)) <= SAME)


def _followed(task: WorkspaceTask, circuit: Circuit, part: CriticalCurve) -> bool:
    """Return whether a part of a circuit has no end but those of the range of the input."""
    ends = np.array([part.x[0], part.x[-1]])
    return circuit.ended in ENDS or bool((np.min(task.margins(ends), axis=1, initial=np.inf) <= SLACK).all())


def _start(task: WorkspaceTask, curve: PositionCurve, here: FloatArray, curves: list[CriticalCurve]) -> StartAssemblies:
    """Count the assemblies at the inputs of a position `here` (n,), and those that are on none of the curves."""
    begin = curve.given(curve.begin())
    inputs = nearest_turns(task.mechanism, task.inputs(here), begin)
    inputs = np.where(np.abs(inputs - begin) <= SLACK, begin, inputs)
    with suppress(StructureError):  # too many
        if max((g.family.loops for g in ConfigurationFinder(task.mechanism).groups), default=0) <= LOOPS:
            found = all_configurations(task.mechanism, inputs)
            x = [task.coordinates(task.system.coordinates(z)) for z in found.z]
            left = sum(not any(_passes(task, part, at) for part in curves) for at in x)
            return StartAssemblies(inputs, len(found), left, found.complete)
    return StartAssemblies(inputs, None, complete=False)


def _passes(task: WorkspaceTask, part: CriticalCurve, x: FloatArray) -> bool:
    """Return whether a curve passes through a position x (n,)."""
    near = task.beside(x, part.x[:-1])
    return bool(np.min(feet(part.cubics, np.broadcast_to(near, (len(part.knots) - 1, len(x))))[0]) <= NEAR)
