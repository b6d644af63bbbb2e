"""Rotation classes: members that turn together because true prismatic pairs tie them.

e^(i phi) of a member is `phase[member]` times e^(i phi) of its class.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import ANGLE, Mechanism, Member, PairRow
from gimcli.structure.derived import derived

PARALLEL = 1e-9
"""Two guides are one line when they differ by less, relative to the size."""


@dataclass(frozen=True)
class Rotation:
    """Class and phase of every member, and the rows that the ties have made superfluous."""

    of: tuple[int, ...]
    phase: tuple[complex, ...]
    implied: frozenset[PairRow]  # heights implied by the tie and the pair's other one


@dataclass(frozen=True)
class Tie:
    """A member that its guide holds from turning: e^(i phi) of the body is `turn` times that of the guide."""

    pair: str
    row: PairRow  # that this makes superfluous
    body: int
    guide: int
    turn: complex


@derived
def members_of(mechanism: Mechanism) -> tuple[tuple[int, ...], ...]:
    """Return for every node the members that it belongs to."""
    table: list[list[int]] = [[] for _ in mechanism.nodes]
    for index, member in enumerate(mechanism.members):
        for node in member.nodes:
            table[node].append(index)
    return tuple(map(tuple, table))


@derived
def ties(mechanism: Mechanism) -> tuple[Tie, ...]:
    """Return what angles, true prismatic pairs and two pins in one slot hold from turning."""
    angles = [row for row in mechanism.pairs if row.kind == ANGLE]
    found = [Tie(r.pair, r, r.members[0], r.guide, r.reference / r.arm) for r in angles]
    earlier: dict[int, list[PairRow]] = {}
    for slide in mechanism.slides:
        for other in earlier.setdefault(slide.guide, []):  # on the same guide
            body = _tied_body(mechanism, slide, other)
            if body is not None:
                turn = _turn(mechanism, mechanism.members[body], other, slide)
                found.append(Tie(slide.pair, slide, body, slide.guide, turn))
                break
        earlier[slide.guide].append(slide)
    return tuple(found)


@derived
def rotation_classes(mechanism: Mechanism) -> Rotation:
    """Tie the members of true prismatic pairs, and of two pins in one slot."""
    parent = list(range(len(mechanism.members)))
    phase = [1.0 + 0.0j] * len(parent)

    def find(index: int) -> tuple[int, complex]:
        factor = 1.0 + 0.0j
        while parent[index] != index:
            factor *= phase[index]
            index = parent[index]
        return index, factor

    implied = set()
    for tie in ties(mechanism):
        (a, fa), (b, fb) = find(tie.body), find(tie.guide)
        implied.add(tie.row)
        if a != b:  # e_body = turn e_guide
            low, high = min(a, b), max(a, b)
            link = tie.turn * fb / fa if a == high else fa / (tie.turn * fb)
            parent[high], phase[high] = low, link / abs(link)
    found = [find(k) for k in range(len(parent))]
    return Rotation(tuple(f[0] for f in found), tuple(f[1] for f in found), frozenset(implied))


def _tied_body(mechanism: Mechanism, a: PairRow, b: PairRow) -> int | None:
    """Return the member that two slides hold parallel to their guide, if they are on one line."""
    if a.guide != b.guide or a.node == b.node:
        return None
    across = b.normal
    skew = abs((a.along.conjugate() * b.along).imag)
    height = abs((across.conjugate() * (a.point - b.point)).real)
    if skew > PARALLEL or height > PARALLEL * mechanism.size:
        return None
    members = members_of(mechanism)
    common = [m for m in members[a.node] if m in members[b.node] and m != a.guide]
    return common[0] if common else None


def drawn_turn(mechanism: Mechanism, member: Member) -> complex:
    """Return e^(i phi) of a member as drawn, times an area: from all its nodes, some of which may coincide."""
    shape, drawn = member.shape - member.shape.mean(), mechanism.drawn[list(member.nodes)]
    return complex(np.vdot(shape, drawn - drawn.mean()))


def _turn(mechanism: Mechanism, body: Member, a: PairRow, b: PairRow) -> complex:
    """Return e^(i (phi_body - phi_guide)); the sense along the guide is the drawn one."""
    along = body.reach(a.node, b.node)
    direction = a.along * drawn_turn(mechanism, mechanism.members[a.guide])
    run = complex(mechanism.drawn[b.node] - mechanism.drawn[a.node])
    sense = 1.0 if (run.conjugate() * direction).real >= 0.0 else -1.0
    turn = sense * a.along / along
    return turn / abs(turn)
