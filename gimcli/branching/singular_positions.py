"""The singular positions of all circuits that intersect, without duplicates."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gimcli.branching.singularities import Singularity, input_ends, interval, limits, singularities
from gimcli.continuation.branches import SAME, Branches, all_circuits, first_circuit
from gimcli.continuation.circuit import Circuit
from gimcli.continuation.curve import PositionCurve
from gimcli.errors import GimError, StructureError, UnassembledError
from gimcli.mechanism import Mechanism
from gimcli.motion.linked_inputs import followed
from gimcli.motion.motion import Motion
from gimcli.motion.motion_curve import arrival
from gimcli.motion.solve import settled, start_position
from gimcli.positions.dispatch import plain
from gimcli.progress import Progress, no_progress
from gimcli.status import CHANGE, Status
from gimcli.structure.drive_check import require_consistent, require_driven_if_doubtful
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import holds

MOST_NODES, FEW_NODES = 100, 60
"""Most nodes of a mechanism whose circuits are followed, and of one whose circuit is followed after its motion."""


@dataclass(frozen=True)
class Found:
    """A singular position and the numbers (from 0) of the circuits through it."""

    what: Singularity
    circuits: tuple[int, ...]


@dataclass(frozen=True)
class Survey:
    """Circuits, their singular positions, and the least and greatest parameter of each."""

    branches: Branches = field(repr=False)
    found: tuple[Found, ...]
    reach: tuple[tuple[float, float], ...]
    complete: bool  # no circuit was left out

    @property
    def curve(self) -> PositionCurve:
        """The curve that all circuits are part of."""
        return self.branches.circuits[0].curve


def drawn_circuit(mechanism: Mechanism, tolerance: float, curve: PositionCurve | None = None) -> Circuit:
    """Return the circuit of the start of the laws, or of the initial position if that start is out of reach.

    curve: by default that of the laws; one along which a single input moves.
    Raises StructureError if there is no actuator or there are too many nodes, UnassembledError if neither position can
    be assembled.
    """
    if not mechanism.actuators:
        raise StructureError(f"{mechanism.name} has no actuator: add one, or use `gim solve`")
    if len(mechanism.nodes) > MOST_NODES:
        raise StructureError(
            f"{mechanism.name} has {len(mechanism.nodes)} nodes: circuits of at most {MOST_NODES} nodes are followed,"
            " since their equations are stored as full tables"
        )
    plan, alone = make_plan(mechanism), curve is not None
    curve = curve or PositionCurve(mechanism)
    starts = [curve.begin()]
    if curve.line is not None and (alone or curve.single):
        starts.append(float(mechanism.drawn_inputs[curve.line.main]))
    for q in starts:
        u = followed(mechanism, curve.given(q))
        start = start_position(mechanism, plan, u, plain, tolerance)
        require_driven_if_doubtful(mechanism, plan, start.regular)
        if start.status is Status.OK:
            z = start.row.x + 1j * start.row.y
            good = holds(mechanism, z[:, None], u[:, None], tolerance)[0]
            require_consistent(mechanism, z, u, Status.OK if good else Status.CONTRADICTORY, tolerance)
            return first_circuit(curve, z, q, arrival(curve, start, curve.single))
        if start.status is Status.TANGENT:
            raise UnassembledError(f"{mechanism.name} has no circuit that can be followed: {start.status.text}")
        if start.status is Status.SINGULAR:
            z = settled(mechanism, start)
            return first_circuit(curve, z, q)
    raise UnassembledError(
        f"{mechanism.name} cannot be assembled at the start of its laws or in its initial configuration:"
        f" {start.status.text}"
    )


def circuit_ranges(motion: Motion) -> dict[str, list[float]]:
    """Return the least and greatest value of every input on the whole circuit of a motion, in the file's unit.

    Empty if the circuit is not known, or the mechanism is too large for it to be followed in addition to the motion.
    """
    mechanism = motion.mechanism
    if motion.first_status is not Status.OK or len(mechanism.nodes) > FEW_NODES:
        return {}
    curve = PositionCurve(mechanism)
    good = np.flatnonzero(motion.good)
    ends = [curve.point(motion.z[:, k], curve.at_time(motion.time[[k]])) for k in (0, good[min(1, len(good) - 1)])]
    try:
        circuit = first_circuit(curve, motion.z[:, 0], curve.begin(), ends[1] - ends[0])
    except GimError:
        return {}
    low, high = map(mechanism.inputs_to_file, input_ends(circuit, interval(circuit, limits(circuit))))
    return {name: sorted((low[name], high[name])) for name in low}


def survey(mechanism: Mechanism, tolerance: float = 1e-10, progress: Progress = no_progress) -> Survey:
    """Follow all circuits that intersect the initial one, and list their singular positions."""
    branches = all_circuits(drawn_circuit(mechanism, tolerance), progress=progress)
    found: list[Found] = []
    reach: list[tuple[float, float]] = []
    complete = branches.complete
    for number, circuit in enumerate(branches.circuits):
        own = singularities(circuit, number)
        ends = interval(circuit, own)
        begin, turning = reach[0][0] if reach else ends[0], branches.circuits[0].turns
        reach.append(_first_round(ends, begin, circuit.curve.period) if turning else ends)
        for what in own:
            z, u = circuit.curve.nodes(what.p), circuit.curve.inputs(what.p)
            if holds(mechanism, z[:, None], u[:, None], tolerance)[0]:
                _add(found, what, number, circuit)
            else:
                complete = False
    return Survey(branches, tuple(found), tuple(reach), complete)


def _add(found: list[Found], what: Singularity, number: int, circuit: Circuit) -> None:
    """Add a position; a known change point gets the number of one more circuit."""
    for k, known in enumerate(found):
        same = known.what.kind == what.kind == CHANGE
        if same and np.linalg.norm(circuit.curve.apart(what.p, known.what.p)) <= SAME:
            if number not in known.circuits:
                found[k] = Found(known.what, (*known.circuits, number))
            return
    found.append(Found(what, (number,)))


def _first_round(ends: tuple[float, float], begin: float, turn: float) -> tuple[float, float]:
    """Return an interval moved by whole turns into the turn at which the first circuit begins."""
    shift = turn * math.floor((ends[0] - begin + SAME) / turn)
    return ends[0] - shift, ends[1] - shift


def first_turn(survey: Survey, q: float) -> float:
    """Return a parameter moved by whole turns into the turn at which the first circuit begins, for full turns."""
    curve, first = survey.curve, survey.branches.circuits[0]
    if not curve.single or not first.turns:
        return q
    begin, turn = min(float(first.p[-1, 0]), float(first.p[-1, -1])), curve.period
    over = (q - begin) % turn
    return begin + (0.0 if turn - over < SAME else over)
