"""Rotation classes: sets of members without relative rotation, because true prismatic pairs connect them.

e^(i phi) of a member is `phase[member]` times e^(i phi) of its class.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.calculus.numbers import nominal
from gimcli.mechanism import ANGLE, ComplexArray, FloatArray, Mechanism, Member, PairRow
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
class Phase:
    """The factor constant e^(i turns . inputs), of modulus 1."""

    constant: complex = 1.0 + 0.0j
    turns: tuple[int, ...] = ()  # factor of every input

    def __mul__(self, other: Phase) -> Phase:
        turns = tuple(a + b for a, b in zip(self.turns, other.turns, strict=True))
        return Phase(self.constant * other.constant, turns)

    def __truediv__(self, other: Phase) -> Phase:
        turns = tuple(a - b for a, b in zip(self.turns, other.turns, strict=True))
        ratio = self.constant / other.constant
        return Phase(ratio / abs(ratio), turns)

    def at(self, inputs: FloatArray) -> ComplexArray:
        """Return the complex factor (rows,) for inputs (actuators, rows)."""
        angle = np.array(self.turns, dtype=float) @ inputs if self.turns else np.zeros(inputs.shape[1])
        return np.asarray(self.constant * np.exp(1j * angle))


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
    tied = ties(mechanism)
    found, _ = united(len(mechanism.members), [(tie.body, tie.guide, Phase(tie.turn)) for tie in tied], Phase())
    phases = tuple(phase.constant for _, phase in found)
    return Rotation(tuple(k for k, _ in found), phases, frozenset(tie.row for tie in tied))


def united(
    count: int, tied: Sequence[tuple[int, int, Phase]], still: Phase
) -> tuple[list[tuple[int, Phase]], list[int]]:
    """Return class and phase of each of some bodies, and the numbers of the ties between bodies of one class.

    A tie is body, guide, and the phase of the body over the guide. The class is the first of its bodies.
    """
    found, idle = [(k, still) for k in range(count)], list[int]()
    for number, (body, guide, turn) in enumerate(tied):
        (a, own), (b, its) = found[body], found[guide]
        if a == b:
            idle.append(number)
            continue
        low, high = min(a, b), max(a, b)
        link = turn * its / own if a == high else own / (turn * its)
        found = [(low, phase * link) if k == high else (k, phase) for k, phase in found]
    return found, idle


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
