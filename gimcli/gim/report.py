"""The sequence step by step: which rule placed each move, and what it does to the nodes' states."""

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

DISTURBED = 1e-2
"""Disturbance of the nodes from which sweeps are predicted and observed, relative to the size."""

REASONS = {
    "I": "rule I: {node} has been moved once and {about} stand{s} for good, so that it can be settled",
    "II.1": "rule II, criterion 1: no node can be settled; on to {node}, next to an input or to what is settled",
    "II.2": "rule II, criterion 2: no settled node leads on; on to {node} about {about}, moved once",
    "II": "rule II: only nodes moved once are left; {node} is moved about {about}",
    "surplus": "surplus: the restriction is redundant and is imposed as well",
}


@dataclass(frozen=True)
class StepReport:
    """One move of the sequence."""

    node: str
    number: int
    about: tuple[str, ...]
    about_numbers: tuple[int, ...]
    constraint: str
    kind: str  # RD distance, RA angle, RL sliding pair
    rule: str
    states: dict[str, str]  # of the group's nodes, after the move
    reason: str


@dataclass(frozen=True)
class SequenceGroupReport:
    """One group of the sequence."""

    kind: str
    nodes: tuple[str, ...]
    steps: tuple[StepReport, ...]
    radius: float
    classic_radius: float
    predicted_sweeps: float | None
    observed_sweeps: int | None
    candidates: int


def report(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, strategy: str, tolerance: float
) -> list[SequenceGroupReport]:
    """Return the groups of the sequence, ranked at an assembled position z (nodes,)."""
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
        predicted = 1.0 if group.radius < 1e-12 else max(1.0, math.log(tolerance / DISTURBED) / math.log(group.radius))
    return SequenceGroupReport(
        "coupled" if coupled & set(group.nodes) else "dyad", tuple(mechanism.nodes[n] for n in group.nodes),
        tuple(steps), group.radius, group.classic_radius, predicted,
        observed_sweeps(mechanism, group, z, inputs, tolerance), group.candidates,
    )  # fmt: skip


def _step(mechanism: Mechanism, sequence: Sequence, move: Move, states: dict[str, str]) -> StepReport:
    about = tuple(mechanism.nodes[n] for n in move.about)
    node = mechanism.nodes[move.node]
    joined = " and ".join(about) or "the frame"
    text = REASONS[move.rule].format(node=node, about=joined, s="s" if len(about) < 2 else "")
    carried = [mechanism.nodes[n] for n in move.about if n in sequence.carried_by_input]
    if carried:
        text += f" ({', '.join(carried)} carried by an input)"
    what = {"RD": "its distance from", "RA": "its angle about", "RL": "its line by"}[move.restriction.letters]
    reason = f"{node} takes {what} {joined}; {text}"
    return StepReport(
        node, move.node, about, move.about, move.restriction.name, move.restriction.letters, move.rule, states, reason
    )


def observed_sweeps(
    mechanism: Mechanism, group: SequenceGroup, z: ComplexArray, inputs: FloatArray, tolerance: float
) -> int | None:
    """Return the sweeps that settle a group disturbed at random, or None where they do not."""
    generator = np.random.default_rng(0)
    start = z.copy()
    own = list(group.nodes)
    noise = generator.standard_normal((2, len(own)))
    start[own] += DISTURBED * mechanism.size * (noise[0] + 1j * noise[1]) / np.sqrt(2.0)
    constants = sweeps.SweepConstants(sweeps=3000)
    done = sweeps.settle(group.moves, start, inputs, mechanism.size, tolerance, plain, constants)
    return done.sweeps if done.good else None
