"""Compiler of members, pairs, actuators and points: from the file's units to the normal frame."""

from __future__ import annotations

import math
from collections.abc import Set
from pathlib import Path

import numpy as np

from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, ComplexArray, Input, Member, Point
from gimcli.model import schema
from gimcli.model.references import CLOSEST
from gimcli.recording import array, nominal, phase, places, scalar


class GeometryCompiler:
    """Compiles the geometry of a validated model, part by part; nodes that no part uses are left out."""

    def __init__(
        self, model: schema.Model, folder: Path, used: Set[str], frame: tuple[complex, float] | None = None
    ) -> None:
        """Compile the members; `frame` gives origin and scale of the normal frame, by default those of the model."""
        self.model, self.folder = model, folder
        self.names = [name for name in model.nodes if name in used]
        self.index = {name: k for k, name in enumerate(self.names)}
        raw = places([model.nodes[n] for n in self.names])
        held = model.ground.member
        parts = model.members
        first = parts[held].nodes[0] if held is not None else model.ground.nodes[0]
        self.size = self._extent(raw)
        self.origin, self.scale = frame or (complex(raw[self.index[first]]), 2.0 ** round(math.log2(self.size)))
        self.drawn: ComplexArray = (raw - self.origin) / self.scale
        self.turn = math.pi / 180.0 if model.units.angle == "deg" else 1.0
        moving = [self._member(name, part) for name, part in parts.items() if name != held]
        self.members = [self._frame(held), *moving]
        self.number = {m.name: k for k, m in enumerate(self.members)}

    def _extent(self, raw: ComplexArray) -> float:
        """Return the largest dimension, from the initial coordinates or given."""
        spans = [_diagonal(raw)]
        spans += [nominal(link.length) for link in self.model.links.values() if link.length is not None]
        for element in self.model.elements.values():
            if element.shape is not None:
                spans.append(_diagonal(places(list(element.shape.values()))))
        return max(spans)

    # -- members ------------------------------------------------------------------------------

    def _member(self, name: str, part: schema.Link | schema.Element) -> Member:
        nodes = tuple(self.index[n] for n in part.nodes)
        drawn: ComplexArray = self.drawn[list(nodes)]
        if isinstance(part, schema.Link):
            length = part.length / self.scale if part.length is not None else abs(drawn[1] - drawn[0])
            return Member(name, nodes, array([0.0, length]))
        z: ComplexArray = drawn
        if part.shape is not None:
            z = places([part.shape[n] for n in part.nodes]) / self.scale
        return Member(name, nodes, to_own_frame(z))

    def _frame(self, held: str | None) -> Member:
        if held is None:
            nodes = tuple(self.index[n] for n in self.model.ground.nodes)
            return Member("ground", nodes, self.drawn[list(nodes)])
        part = self.model.links.get(held) or self.model.elements[held]
        member = self._member(held, part)
        first, second = self.drawn[member.nodes[0]], self.drawn[member.nodes[1]]
        direction = (second - first) / abs(second - first)
        return Member(held, member.nodes, first + member.shape * direction)

    def _common(self, *names: str, moving: bool = False, but: int = -1) -> int:
        """Return the first member that has all nodes, except member `but`; with `moving`, the frame is excluded."""
        nodes = {self.index[n] for n in names}
        for k, member in enumerate(self.members):
            if nodes <= set(member.nodes) and k != but and not (moving and k == FRAME):
                return k
        raise KeyError(names)

    def _local(self, member: int, name: str) -> complex:
        return self.members[member].local(self.index[name])

    def line(self, guide: list[str]) -> tuple[int, complex, complex]:
        """Return the member of a guide, and in its own frame the guide's first node and unit direction."""
        member = self._common(*guide)
        first, second = (self._local(member, n) for n in guide)
        return member, first, (second - first) / abs(second - first)

    # -- quantities ------------------------------------------------------------------

    def quantity(self, name: str, actuator: schema.Gauge) -> Input:
        """Return the quantity that an actuator drives, or that a gauge measures, without a law."""
        if actuator.rotary:
            return self._rotary(name, actuator)
        if actuator.nodes is not None:
            a, b = (self.index[n] for n in actuator.nodes)
            drawn = abs(scalar(self.drawn[b] - self.drawn[a]))
            return Input(name, SPAN, (a, b), drawn=drawn)
        guide = list(actuator.guide or [])
        member, point, direction = self.line(guide)
        a = self.index[str(actuator.node)]
        u, v = (scalar(self.drawn[self.index[n]]) for n in guide)
        along = (v - u) / abs(v - u)
        drawn = ((scalar(self.drawn[a]) - u) * along.conjugate()).real
        return Input(name, HEIGHT, (a,), (member,), point, direction, drawn=drawn)

    def _rotary(self, name: str, actuator: schema.Gauge) -> Input:
        pivot, arm, reference = str(actuator.pivot), str(actuator.arm), actuator.reference
        arm_member = self._common(pivot, arm, moving=True)
        arm_direction = _unit(self._local(arm_member, arm) - self._local(arm_member, pivot))
        reference_member, reference_direction = FRAME, 1.0 + 0.0j
        ray = scalar(self.drawn[self.index[arm]] - self.drawn[self.index[pivot]])
        if reference is not None:
            reference_member = self._common(pivot, reference, but=arm_member)
            away = self._local(reference_member, reference) - self._local(reference_member, pivot)
            reference_direction = _unit(away)
            ray /= scalar(self.drawn[self.index[reference]] - self.drawn[self.index[pivot]])
        drawn = phase(ray + 0.0j)  # -0.0 would turn pi into -pi
        return Input(
            name, ANGLE, (self.index[pivot],), (arm_member, reference_member), arm=arm_direction,
            reference=reference_direction, drawn=drawn,
        )  # fmt: skip

    # -- points -------------------------------------------------------------------------------

    def point(self, name: str, point: schema.Tracer) -> Point:
        """Return a point fixed to a member."""
        k = 0 if point.on == "ground" else self.number[point.on]
        member = self.members[k]
        if point.local is not None:
            local = scalar(places([point.local])[0]) / self.scale
            first = scalar(member.shape[0])
            apart = [z - first for z in member.shape.tolist() if abs(z - first) > CLOSEST * self.size / self.scale]
            along = _unit(apart[0]) if apart else 1.0 + 0.0j  # nodes of the ground may coincide
            return Point(name, k, first + local * along)
        drawn = (scalar(places([point.at or [0.0, 0.0]])[0]) - self.origin) / self.scale
        if k == FRAME:
            return Point(name, k, drawn)
        first, second = (scalar(self.drawn[n]) for n in member.nodes[:2])
        return Point(name, k, scalar(member.shape[0]) + (drawn - first) / _unit(second - first))


def _unit(z: complex) -> complex:
    return z / abs(z)


def _diagonal(z: ComplexArray) -> float:
    """Return the diagonal of the box around some positions, at the nominal design."""
    z = np.array([nominal(one) for one in z.tolist()])
    return abs(complex(np.ptp(z.real), np.ptp(z.imag)))


def to_own_frame(z: ComplexArray) -> ComplexArray:
    """Return a shape with its first node at 0 and its second on +x."""
    along = z[1] - z[0]
    turned = (z - z[0]) * (along.conjugate() / abs(along))
    turned[1] = abs(along)
    return np.asarray(turned)
