"""The paths that one input reaches from the initial configuration, without disassembly and within its range."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from gimcli.assemblies import all_configurations
from gimcli.assemblies.assemblies import ConfigurationFinder
from gimcli.branching.singular_positions import drawn_circuit
from gimcli.canonical import first_least
from gimcli.continuation.branches import SAME, all_circuits
from gimcli.continuation.circuit import Circuit, Ended
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import StructureError, UnassembledError
from gimcli.mechanism import FloatArray
from gimcli.numerics.interpolation import hermite, hermite_slope
from gimcli.positions.inputs import nearest_turns
from gimcli.positions.options import TOLERANCE
from gimcli.progress import Progress, no_progress
from gimcli.reach.circuit_paths import every_circuit, input_line, within
from gimcli.reach.critical_curves import CriticalCurve, spacing
from gimcli.reach.task import SETTLED, SLACK, WorkspaceTask, unreached

LOOPS = 4
"""Loops of a coupled group up to which its assemblies are counted: more loops can take seconds."""

NEAR = 1e-5
"""Distance within which a position is on a curve of cubics, relative to the size."""

REFINED = 4
"""Newton steps for the point of a cubic that is nearest to a position."""

ENDS = (Ended.CLOSED, Ended.INFINITE, Ended.LAW)
"""How a curve ends that was followed completely."""


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


def initial_paths(task: WorkspaceTask, progress: Progress = no_progress) -> InitialPaths:
    """Return the curves within the range of the input that are connected with the initial configuration.

    This is the circuit of the initial configuration, without the parts that the input cannot reach within its range.
    If neither the start of the law nor the drawn input can be assembled, it is the path nearest to the drawing.
    Raises UnassembledError if there is none.
    """
    curve = PositionCurve(task.mechanism, input_line(task))
    try:
        first = drawn_circuit(task.mechanism, TOLERANCE, curve)
    except UnassembledError:
        circuits, complete = every_circuit(task, progress)
        if not circuits:
            raise UnassembledError(unreached(task)) from None
        begin = task.coordinates(task.system.coordinates(task.mechanism.drawn))
    else:
        branches = all_circuits(first, progress)
        circuits, complete, begin = branches.circuits, branches.complete, _x(task, first.places[first.start].p)
    parts = [(circuit, part) for circuit in circuits for part in within(task, circuit)]
    if not parts:
        raise UnassembledError(f"{unreached(task)}, or search all assemblies with --all")
    initial = first_least(np.array([np.min(np.linalg.norm(part.x - begin, axis=1)) for _, part in parts]), SETTLED)
    kept = _connected(task, parts, initial)
    curves = [parts[k][1] for k in kept]
    complete = complete and all(_followed(task, *parts[k]) for k in kept)
    here = begin if _has(parts[initial][1], begin) else _middle_of(parts[initial][1])
    return InitialPaths(curves, kept.index(initial), complete, _start(task, curve, here, curves))


def _x(task: WorkspaceTask, p: FloatArray) -> FloatArray:
    """Return the task's coordinates of a point of a circuit."""
    return task.coordinates(p[:-1])


def _middle_of(part: CriticalCurve) -> FloatArray:
    return np.asarray(part.x[len(part.x) // 2])


def _connected(task: WorkspaceTask, parts: list[tuple[Circuit, CriticalCurve]], first: int) -> list[int]:
    """Return the indices of the parts that are connected with the first one by points that they share."""
    points = [
        *(_x(task, met.p) for circuit, _ in parts for met in circuit.crossings.values()),
        *(part.x[end] for _, part in parts if not part.closed for end in (0, -1)),
    ]
    shared = [{k for k, (_, part) in enumerate(parts) if _has(part, point)} for point in points]
    kept = {first}
    while True:
        more = kept.union(*(those for those in shared if those & kept))
        if more == kept:
            return sorted(kept)
        kept = more


def _has(part: CriticalCurve, point: FloatArray) -> bool:
    return bool(np.min(np.linalg.norm(part.x - point, axis=1)) <= SAME)


def _followed(task: WorkspaceTask, circuit: Circuit, part: CriticalCurve) -> bool:
    """Return whether a part of a circuit has no end but those of the range of the input."""
    ends = np.array([part.x[0], part.x[-1]])
    return circuit.ended in ENDS or bool((np.min(task.margins(ends), axis=1, initial=np.inf) <= SLACK).all())


def _start(task: WorkspaceTask, curve: PositionCurve, here: FloatArray, curves: list[CriticalCurve]) -> StartAssemblies:
    """Count the assemblies at the inputs of a position `here` (n,), and those that are on none of the curves."""
    begin = curve.inputs(curve.begin())
    inputs = nearest_turns(task.mechanism, task.inputs(here), begin)
    inputs = np.where(np.abs(inputs - begin) <= SLACK, begin, inputs)
    with suppress(StructureError):  # too many
        if max((g.family.loops for g in ConfigurationFinder(task.mechanism).groups), default=0) <= LOOPS:
            found = all_configurations(task.mechanism, inputs)
            x = [task.coordinates(task.system.coordinates(z)) for z in found.z]
            left = sum(not any(_passes(part, at) for part in curves) for at in x)
            return StartAssemblies(inputs, len(found), left, found.complete)
    return StartAssemblies(inputs, None, complete=False)


def _passes(part: CriticalCurve, x: FloatArray) -> bool:
    """Return whether a curve passes through a position x (n,)."""
    n = len(x)
    p = part.x
    apart = np.linalg.norm(p - x, axis=1)
    length = np.linalg.norm(np.diff(p, axis=0), axis=1)
    for k in np.flatnonzero(np.minimum(apart[:-1], apart[1:]) <= length + NEAR).tolist():
        here, there = part.knots[k], part.knots[k + 1]
        h = spacing(here, there)
        ends = here.p[:n], h * here.tangent[:n], there.p[:n], h * there.tangent[:n]
        t = 0.5
        for _ in range(REFINED):
            slope = hermite_slope(*ends, t)
            t = min(1.0, max(0.0, t + float(slope @ (x - hermite(*ends, t))) / max(float(slope @ slope), 1e-300)))
        if np.linalg.norm(hermite(*ends, t) - x) <= NEAR:
            return True
    return False
