"""A mechanism as the multibody notes see it: rigid bodies, and pairs and drivers between two of them.

Body 0 is the frame; bodies follow the members' numbers, and a node of no member is a body of its own
that does not turn. A node of k members is k - 1 revolute pairs about the first of them.
"""

from __future__ import annotations

import cmath
from dataclasses import dataclass

import numpy as np

from gimcli.kernels import bodies as kernels
from gimcli.mechanism import SPAN, ComplexArray, Mechanism, PairRow
from gimcli.structure.kinematic_nodes import loose_nodes
from gimcli.structure.residual import pose
from gimcli.structure.rotation import members_of
from gimcli.structure.steps import NONE


@dataclass(frozen=True)
class BodyPair:
    """One pair or driver between bodies a and b; points and directions in their own frames.

    ON_LINE: the point of a on the line of b through its point; `normal` is the line's, or the
    direction that a travel is measured along. ANGLE: from b to a, less `constant`.
    """

    kind: int
    a: int
    b: int
    za: complex = 0.0j
    zb: complex = 0.0j
    normal: complex = 0.0j
    constant: float = 0.0
    actuator: int = NONE
    name: str = ""  # of the pair in the file; two slides of a true prismatic pair share it

    @property
    def rows(self) -> int:
        """Number of scalar equations."""
        return 2 if self.kind == kernels.COINCIDENT else 1

    @property
    def slides(self) -> bool:
        """Tell whether it is a sliding pair, not a driver."""
        return self.kind == kernels.ON_LINE and self.actuator == NONE


class Bodies:
    """Bodies of a mechanism, where its nodes are in them, and the pairs between them."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.loose = loose_nodes(mechanism)
        self.count = len(mechanism.members) + len(self.loose)
        self.holders = list(members_of(mechanism))
        for k, node in enumerate(self.loose):
            self.holders[node] = (len(mechanism.members) + k,)
        self._sliding: dict[str, set[int]] = {}  # bodies that may slide in each pair
        for slide in mechanism.slides:
            may = set(self.holders[slide.node]) - {slide.guide}
            self._sliding[slide.pair] = self._sliding.get(slide.pair, may) & may
        rows = [*((row, NONE) for row in mechanism.pairs), *((a, k) for k, a in enumerate(mechanism.actuators))]
        self.pairs = [*self._revolutes(), *(self._row(*row) for row in rows)]

    def turns(self, body: int) -> bool:
        """Tell whether a body has an angle."""
        return body < len(self.mechanism.members)

    def local(self, body: int, node: int) -> complex:
        """Return the place of a node in a body's own frame."""
        return self.mechanism.members[body].local(node) if self.turns(body) else 0.0j

    def poses(self, z: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return origins and e^(i phi) of the bodies (bodies,) at a position z (nodes,)."""
        found = [pose(self.mechanism, k, z[:, None]) for k in range(len(self.mechanism.members))]
        origins = [complex(o[0]) for o, _ in found] + [complex(z[n]) for n in self.loose]
        return np.array(origins), np.array([complex(e[0]) for _, e in found] + [1.0 + 0.0j] * len(self.loose))

    def positions(self, poses: ComplexArray, turns: ComplexArray) -> ComplexArray:
        """Return nodes (nodes, rows) from origins and e^(i phi), each (rows, bodies)."""
        homes = [holders[0] for holders in self.holders]
        local = np.array([self.local(body, node) for node, body in enumerate(homes)])
        return np.asarray((poses[:, homes] + turns[:, homes] * local).T)

    def arrays(self, pairs: list[BodyPair]) -> tuple[np.ndarray, np.ndarray]:
        """Return pairs as pi, pz of the kernels."""
        heads = [(p.kind, p.a, p.b, p.actuator) for p in pairs]
        parts = [(p.za.real, p.za.imag, p.zb.real, p.zb.imag, p.normal.real, p.normal.imag, p.constant) for p in pairs]
        return np.array(heads, dtype=np.int64).reshape(-1, 4), np.array(parts, dtype=float).reshape(-1, 7)

    def _body_of(self, node: int, other: int = NONE) -> int:
        return next(b for b in self.holders[node] if b != other)

    def _revolutes(self) -> list[BodyPair]:
        pairs = []
        for node, holders in enumerate(self.holders):
            for body in holders[1:]:
                first = holders[0]
                at = self.local(body, node), self.local(first, node)
                pairs.append(BodyPair(kernels.COINCIDENT, body, first, *at, name=self.mechanism.nodes[node]))
        return pairs

    def _row(self, row: PairRow, actuator: int) -> BodyPair:
        """Return what a row of a pair, or of an actuator by its number, is between two bodies."""
        if row.rotary:
            turn = cmath.phase(row.reference) - cmath.phase(row.arm)
            return BodyPair(kernels.ANGLE, row.members[0], row.guide, constant=turn, actuator=actuator, name=row.pair)
        if row.kind == SPAN:
            p, q = row.nodes
            first = self._body_of(p)
            second = next((b for b in self.holders[q] if b != first), self.holders[q][0])
            at = self.local(second, q), self.local(first, p)
            return BodyPair(kernels.DISTANCE, second, first, *at, actuator=actuator, name=row.pair)
        common = self._sliding.get(row.pair)
        body = min(common) if common else self._body_of(row.node, row.guide)
        at = self.local(body, row.node), row.point
        return BodyPair(kernels.ON_LINE, body, row.guide, *at, row.normal, actuator=actuator, name=row.pair)
