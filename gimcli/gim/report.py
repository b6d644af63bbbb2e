"""Report of the sequence step by step: the rule for each move, and the states of the nodes after it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimcli.gim import sweeps
from gimcli.gim.sequence import INCOMPLETE, Sequence, SequenceGroup, find_sequence
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.dispatch import plain
from gimcli.structure.plan import make_plan
from gimcli.structure.restrictions import Move

PERTURBATION = 1e-2
"""Perturbation of the nodes, relative to the size, for which the number of sweeps is predicted and observed."""

STATES = ("P0", "P1", "P2")  # of a node that has been moved never, once, twice in a sweep

REASONS = {
    "settle": "{node} has been moved once (P1) and {about} {be} settled (P or P2), so {node} becomes settled (P2)",
    "start": "no P1 node can be settled; the next node is {node}, adjacent to an input or to settled nodes",
    "extend": "no free node is adjacent to settled nodes; the next node is {node}, moved about {about} (P1)",
    "other": "only P1 nodes are left; {node} is moved about {about}",
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
    rule: str  # of the paper: input, I, II, criteria; of the search: settle, start, extend, other; surplus, given
    states: dict[str, str]  # {node: P0, P1 or P2} of the group's nodes after the move
    reason: str


@dataclass(frozen=True)
class SequenceGroupReport:
    """One group of the sequence."""

    kind: str  # "dyad" or "coupled"; by the rules of the paper "weakly coupled" or "strongly coupled"
    nodes: tuple[str, ...]
    steps: tuple[StepReport, ...]
    radius: float  # spectral radius
    predicted_sweeps: float | None  # from the spectral radius; None if it is 1 or greater
    observed_sweeps: int | None  # None if the sweeps did not converge
    candidates: int  # number of sequences tried
    incomplete: str  # which nodes the rules of the paper do not move twice; "" if there are none


def report(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, strategy: str, tolerance: float
) -> list[SequenceGroupReport]:
    """Return the groups of the sequence at an assembled position z (nodes,)."""
    plan = make_plan(mechanism)
    coupled = {n for group in plan.coupled for n in group.nodes}
    sequence = find_sequence(mechanism, z, strategy, plan)
    return [_group(mechanism, sequence, g, coupled, z, inputs, tolerance) for g in sequence.groups]


def _group(
    mechanism: Mechanism, sequence: Sequence, group: SequenceGroup, coupled: set[int], z: ComplexArray,
    inputs: FloatArray,
    tolerance: float,
) -> SequenceGroupReport:  # fmt: skip
    counts = dict.fromkeys((*(m.node for m in group.placed), *group.nodes), 0)
    steps = []
    for k, move in enumerate((*group.placed, *group.moves)):
        counts[move.node] += 1 + (k < len(group.placed))
        states = {mechanism.nodes[n]: STATES[min(c, 2)] for n, c in counts.items()}
        steps.append(_step(mechanism, sequence, move, states))
    incomplete = INCOMPLETE + ", ".join(mechanism.nodes[n] for n in group.missing) if group.missing else ""
    factor, converges = math.log(max(group.radius, 1e-12)), group.radius < 1.0 and not incomplete
    return SequenceGroupReport(
        group.kind or ("coupled" if coupled & set(group.nodes) else "dyad"),
        tuple(mechanism.nodes[n] for n in group.nodes), tuple(steps), group.radius,
        max(1.0, math.log(tolerance / PERTURBATION) / factor) if converges else None,
        None if incomplete else observed_sweeps(mechanism, group, z, inputs, tolerance), group.candidates, incomplete,
    )  # fmt: skip


def _step(mechanism: Mechanism, sequence: Sequence, move: Move, states: dict[str, str]) -> StepReport:
    about = tuple(mechanism.nodes[n] for n in move.about)
    node = mechanism.nodes[move.node]
    joined = (" from " if move.reason and move.restriction.letters == "RA" else " and ").join(about) or "the frame"
    text = move.reason or REASONS[move.rule].format(node=node, about=joined, be="is" if len(about) < 2 else "are")
    carried = [mechanism.nodes[n] for n in move.about if n in sequence.carried_by_input]
    text += f" ({', '.join(carried)} carried by an input)" * bool(carried and not move.reason)
    what = {"RD": "its distance from", "RA": "its angle about", "RL": "its line through"}[move.restriction.letters]
    return StepReport(
        node, move.node, about, move.about, move.restriction.name, move.restriction.letters, move.rule, states,
        f"{node} is moved to {what} {joined}; {text}",
    )  # fmt: skip


def observed_sweeps(
    mechanism: Mechanism, group: SequenceGroup, z: ComplexArray, inputs: FloatArray, tolerance: float
) -> int | None:
    """Return the number of sweeps that solve a group after a random perturbation; None if they do not converge."""
    generator = np.random.default_rng(0)
    start = z.copy()
    own = list(group.nodes)
    noise = generator.standard_normal((2, len(own)))
    start[own] += PERTURBATION * mechanism.size * (noise[0] + 1j * noise[1]) / np.sqrt(2.0)
    done = sweeps.settle(group.moves, start, inputs, mechanism.size, tolerance, plain, sweeps.SweepConstants(3000))
    return done.sweeps if done.good else None
