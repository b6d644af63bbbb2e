"""Report of the sequence step by step: the rule for each move, and the states of the nodes after it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimcli.gim import sweeps
from gimcli.gim.rules import P0, P1, P2
from gimcli.gim.sequence import Sequence, SequenceGroup, find_sequence
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.dispatch import plain
from gimcli.structure.plan import make_plan
from gimcli.structure.restrictions import Move

PERTURBATION = 1e-2
"""Perturbation of the nodes, relative to the size, for which the number of sweeps is predicted and observed."""

REASONS = {
    "I": "rule I: {node} has been moved once (P1) and {about} {be} settled (P or P2), so {node} becomes settled (P2)",
    "II.1": "rule II, criterion 1: no P1 node can be settled; the next node is {node}, adjacent to an input or to"
    " settled nodes",
    "II.2": "rule II, criterion 2: no free node is adjacent to settled nodes; the next node is {node}, moved about"
    " {about} (P1)",
    "II": "rule II: only P1 nodes are left; {node} is moved about {about}",
    "surplus": "redundant: the restriction is not needed for the sequence, but is imposed too",
}


@dataclass(frozen=True)
class StepReport:
    """One move of the sequence."""

    node: str
    number: int
    about: tuple[str, ...]  # nodes that are fixed during the move
    about_numbers: tuple[int, ...]
    constraint: str
    kind: str  # RD distance, RA angle, RL sliding pair
    rule: str  # I, II.1, II.2, II, surplus or given
    states: dict[str, str]  # {node: P0, P1 or P2} of the group's nodes after the move
    reason: str


@dataclass(frozen=True)
class SequenceGroupReport:
    """One group of the sequence."""

    kind: str  # "dyad" or "coupled"
    nodes: tuple[str, ...]
    steps: tuple[StepReport, ...]
    radius: float  # spectral radius
    classic_radius: float  # spectral radius of the best sequence of the classic search
    predicted_sweeps: float | None  # from the spectral radius; None if it is 1 or greater
    observed_sweeps: int | None  # None if the sweeps did not converge
    candidates: int  # number of sequences tried


def report(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, strategy: str, tolerance: float
) -> list[SequenceGroupReport]:
    """Return the groups of the sequence that is best at an assembled position z (nodes,)."""
    plan = make_plan(mechanism)
    coupled = {n for group in plan.coupled for n in group.nodes}
    sequence = find_sequence(mechanism, z, inputs, strategy, plan)
    return [_group(mechanism, sequence, g, coupled, z, inputs, tolerance) for g in sequence.groups]


def _group(
    mechanism: Mechanism, sequence: Sequence, group: SequenceGroup, coupled: set[int], z: ComplexArray,
    inputs: FloatArray,
    tolerance: float,
) -> SequenceGroupReport:  # fmt: skip
    counts = dict.fromkeys(group.nodes, 0)
    steps = []
    for move in group.moves:
        counts[move.node] += 1
        states = {mechanism.nodes[n]: (P0, P1, P2)[min(c, 2)] for n, c in counts.items()}
        steps.append(_step(mechanism, sequence, move, states))
    predicted = None
    if group.radius < 1.0:
        predicted = (
            1.0 if group.radius < 1e-12 else max(1.0, math.log(tolerance / PERTURBATION) / math.log(group.radius))
        )
    return SequenceGroupReport(
        "coupled" if coupled & set(group.nodes) else "dyad", tuple(mechanism.nodes[n] for n in group.nodes),
        tuple(steps), group.radius, group.classic_radius, predicted,
        observed_sweeps(mechanism, group, z, inputs, tolerance), group.candidates,
    )  # fmt: skip


def _step(mechanism: Mechanism, sequence: Sequence, move: Move, states: dict[str, str]) -> StepReport:
    about = tuple(mechanism.nodes[n] for n in move.about)
    node = mechanism.nodes[move.node]
    joined = " and ".join(about) or "the frame"
    text = REASONS[move.rule].format(node=node, about=joined, be="is" if len(about) < 2 else "are")
    carried = [mechanism.nodes[n] for n in move.about if n in sequence.carried_by_input]
    if carried:
        text += f" ({', '.join(carried)} carried by an input)"
    what = {"RD": "its distance from", "RA": "its angle about", "RL": "its line through"}[move.restriction.letters]
    reason = f"{node} is moved to {what} {joined}; {text}"
    return StepReport(
        node, move.node, about, move.about, move.restriction.name, move.restriction.letters, move.rule, states, reason
    )


def observed_sweeps(
    mechanism: Mechanism, group: SequenceGroup, z: ComplexArray, inputs: FloatArray, tolerance: float
) -> int | None:
    """Return the number of sweeps that solve a group after a random perturbation; None if they do not converge."""
    generator = np.random.default_rng(0)
    start = z.copy()
    own = list(group.nodes)
    noise = generator.standard_normal((2, len(own)))
    start[own] += PERTURBATION * mechanism.size * (noise[0] + 1j * noise[1]) / np.sqrt(2.0)
    constants = sweeps.SweepConstants(sweeps=3000)
    done = sweeps.settle(group.moves, start, inputs, mechanism.size, tolerance, plain, constants)
    return done.sweeps if done.good else None
