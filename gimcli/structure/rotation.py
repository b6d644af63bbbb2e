"""Rotation classes: sets of members without relative rotation, because true prismatic pairs connect them.

e^(i phi) of a member is `phase[member]` times e^(i phi) of its class.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gimcli.calculus.numbers import nominal
from gimcli.mechanism import ANGLE, ComplexArray, Mechanism, Member, PairRow
from gimcli.structure.derived import derived

PARALLEL = 1e-9
"""Two guides are one line if their directions and offsets (relative to the size) differ by less."""


@dataclass(frozen=True)
class Rotation:
    """Rotation class and phase of every member, and the rows that the classes imply."""

    of: tuple[int, ...]  # (members,) class
    phase: tuple[complex, ...]  # (members,) modulus 1
    implied: frozenset[PairRow]  # heights that follow from the class and the other height of the pair


@dataclass(frozen=True)
class Tie:
    """A body that cannot rotate relative to its guide: e^(i phi) of the body is `turn` times that of the guide."""

    pair: str
    row: PairRow  # the constraint that the tie implies
    body: int
    guide: int
    turn: complex


@derived
def members_of(mechanism: Mechanism) -> tuple[tuple[int, ...], ...]:
    """Return, for every node, the members that contain it."""
    table: list[list[int]] = [[] for _ in mechanism.nodes]
    for index, member in enumerate(mechanism.members):
        for node in member.nodes:
            table[node].append(index)
    return tuple(map(tuple, table))


@derived
def ties(mechanism: Mechanism) -> tuple[Tie, ...]:
    """Return the ties by angle rows of pairs, true prismatic pairs, and two pins of a member in one slot."""
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
    """Return the rotation classes: members that ties connect."""
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
    """Return the member that has both nodes of two slides on one line, else None."""
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
    """Return e^(i phi) of a member at the drawn position, times an area; all nodes are used, as some may coincide."""
    shape, drawn = shapes(mechanism, member)
    return complex(nominal(np.vdot(shape, drawn)))


def shapes(mechanism: Mechanism, member: Member) -> tuple[ComplexArray, ComplexArray]:
    """Return the shape of a member without its remote nodes, and as drawn, both from their centres."""
    shape, drawn = member.shape[: member.near], mechanism.drawn[list(member.nodes[: member.near])]
    return shape - shape.mean(), drawn - drawn.mean()


def _turn(mechanism: Mechanism, body: Member, a: PairRow, b: PairRow) -> complex:
    """Return e^(i (phi_body - phi_guide)); the sense along the guide is that of the drawn position."""
    along = body.reach(a.node, b.node)
    direction = a.along * drawn_turn(mechanism, mechanism.members[a.guide])
    run = complex(nominal(mechanism.drawn[b.node] - mechanism.drawn[a.node]))
    sense = 1.0 if (run.conjugate() * nominal(direction)).real >= 0.0 else -1.0
    turn = sense * a.along / along
    return turn / abs(turn)
