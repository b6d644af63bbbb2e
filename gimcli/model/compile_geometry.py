"""Compiler of members, pairs, actuators and points: from the file's units to the normal frame."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gimcli.calculus.numbers import array, nominal, phase, places, scalar
from gimcli.mechanism import ANGLE, FRAME, HEIGHT, SPAN, ComplexArray, Input, Member, PairRow, Point
from gimcli.model import schema
from gimcli.model.pairs import having
from gimcli.model.references import CLOSEST, size_of
from gimcli.model.units import RADIANS

REMOTE = 10.0
"""Distance, relative to the size, beyond which a node that only marks the direction of a guide is carried."""


class GeometryCompiler:
    """Compiles the geometry of a validated model, part by part; nodes that no part uses are left out."""

    def __init__(
        self, model: schema.Model, folder: Path, used: set[str], sized: set[str],
        frame: tuple[complex, float] | None = None,
    ) -> None:  # fmt: skip
        """Compile the members; `frame` gives origin and scale of the normal frame, by default those of the model.

        used: the nodes that are compiled. sized: those that give the size.
        """
        self.model, self.folder = model, folder
        self.names = [name for name in model.nodes if name in used]
        self.index = {name: k for k, name in enumerate(self.names)}
        raw = places([model.nodes[n] for n in self.names])
        held = model.ground.member
        parts = model.members
        self.sized = sized
        self.size = size_of(model, sized)
        first = raw[self.index[(parts[held].nodes if held is not None else model.ground.nodes)[0]]]
        middle = next((raw[k] for k, name in enumerate(self.names) if name in sized), first)
        origin = middle if abs(nominal(first - middle)) > REMOTE * self.size else first
        self.origin, self.scale = frame or (complex(origin), 2.0 ** round(math.log2(self.size)))
        self.drawn: ComplexArray = (raw - self.origin) / self.scale
        self.units = {True: RADIANS[model.units.angle], False: 1.0 / self.scale}
        """The file's units of angle (True) and of length (False), in the normal frame."""
        moving = [self._with_remote(self._shaped(name, part)) for name, part in parts.items() if name != held]
        self.members = [self._frame(held), *moving]
        self.number = {m.name: k for k, m in enumerate(self.members)} | {"ground": FRAME}

    # -- members ------------------------------------------------------------------------------

    def _shaped(self, name: str, part: schema.Link | schema.Element) -> Member:
        nodes = tuple(self.index[n] for n in part.nodes)
        drawn: ComplexArray = self.drawn[list(nodes)]
        if isinstance(part, schema.Link):
            length = part.length / self.scale if part.length is not None else abs(drawn[1] - drawn[0])
            return Member(name, nodes, array([0.0, length]))
        z: ComplexArray = drawn
        if part.shape is not None:
            z = places([part.shape[n] for n in part.nodes]) / self.scale
        return Member(name, nodes, to_own_frame(z))

    def _with_remote(self, member: Member, near: complex | None = None) -> Member:
        """Return a member with its remote nodes last: those that do not give the size, far from the others.

        near: a place near the machine, by default the first node of the member that gives the size.
        """
        sized = [self.names[n] in self.sized for n in member.nodes]
        near = member.shape[sized.index(True) if True in sized else 0] if near is None else near
        away = [abs(nominal(z - near)) > REMOTE * self.size / self.scale for z in member.shape.tolist()]
        far = [not own and beyond for own, beyond in zip(sized, away, strict=True)]
        if not any(far):
            return member
        order = np.argsort(far, kind="stable")
        nodes = tuple(member.nodes[k] for k in order)
        return Member(member.name, nodes, member.shape[order], frozenset(nodes[len(far) - sum(far) :]))

    def _frame(self, held: str | None) -> Member:
        if held is None:
            nodes = tuple(self.index[n] for n in self.model.ground.nodes)
            return self._with_remote(Member("ground", nodes, self.drawn[list(nodes)]), 0.0j)
        member = self._shaped(held, self.model.members[held])
        first, second = self.drawn[member.nodes[0]], self.drawn[member.nodes[1]]
        direction = (second - first) / abs(second - first)
        return self._with_remote(Member(held, member.nodes, first + member.shape * direction), 0.0j)

    def _common(self, *names: str, but: int = -1) -> int:
        """Return the first member that has all nodes, except member `but`."""
        return next(k for k in (self.number[name] for name in having(self.model, names)) if k != but)

    def _local(self, member: int, name: str) -> complex:
        return self.members[member].local(self.index[name])

    def line(self, guide: list[str]) -> tuple[int, complex, complex]:
        """Return the member of a guide, and in its own frame the guide's first node and unit direction."""
        member = self._common(*guide)
        first, second = (self._local(member, n) for n in guide)
        return member, first, (second - first) / abs(second - first)

    def rows(self, name: str, pair: schema.Prismatic) -> list[PairRow]:
        """Return one constraint per sliding node of a pair: its height over the line of sliding is 0."""
        member, _, along = self.line(pair.guide)
        body = self.members[member]
        near = min((self.index[n] for n in pair.guide), key=body.remote.__contains__)  # a far one has fewer decimals
        point = body.local(near) + 1j * along * pair.offset / self.scale
        names = {name if pair.node is not None else f"{name} {node}": self.index[node] for node in pair.sliding}
        return [PairRow(n, HEIGHT, (v,), (member,), point, 1j * along, pair=name) for n, v in names.items()]

    # -- quantities ------------------------------------------------------------------

    def quantity(self, name: str, actuator: schema.Gauge) -> Input:
        """Return the quantity that an actuator drives, or that a gauge measures, without a law."""
        drawn = measured(actuator, {node: self.drawn[self.index[node]] for node in actuator.named})
        if actuator.rotary:
            return self._rotary(name, actuator, drawn)
        if actuator.nodes is not None:
            a, b = (self.index[n] for n in actuator.nodes)
            return Input(name, SPAN, (a, b), drawn=drawn)
        member, point, direction = self.line(list(actuator.guide or []))
        return Input(name, HEIGHT, (self.index[str(actuator.node)],), (member,), point, direction, drawn=drawn)

    def _rotary(self, name: str, actuator: schema.Gauge, drawn: Any) -> Input:
        pivot, arm, reference = str(actuator.pivot), str(actuator.arm), actuator.reference
        arm_member = self._common(pivot, arm, but=FRAME)
        arm_direction = _unit(self._local(arm_member, arm) - self._local(arm_member, pivot))
        reference_member, reference_direction = FRAME, 1.0 + 0.0j
        if reference is not None:
            reference_member = self._common(pivot, reference, but=arm_member)
            reference_direction = _unit(self._local(reference_member, reference) - self._local(reference_member, pivot))
        return Input(
            name, ANGLE, (self.index[pivot],), (arm_member, reference_member), arm=arm_direction,
            reference=reference_direction, drawn=drawn,
        )  # fmt: skip

    # -- points -------------------------------------------------------------------------------

    def point(self, name: str, point: schema.Tracer) -> Point:
        """Return a point fixed to a member."""
        k = self.number[point.on]
        member = self.members[k]
        if point.local is not None:
            local = scalar(places([point.local])[0]) / self.scale
            first, along = axes(member, self._written(point.on), CLOSEST * self.size / self.scale)
            return Point(name, k, first + local * along)
        drawn = (scalar(places([point.at or [0.0, 0.0]])[0]) - self.origin) / self.scale
        if k == FRAME:
            return Point(name, k, drawn)
        nodes = self._written(point.on)
        first, along = axes(member, nodes)
        away, second = (z - scalar(self.drawn[nodes[0]]) for z in (drawn, scalar(self.drawn[nodes[1]])))
        return Point(name, k, first + away / _unit(second) * along)

    def carried(self, member: str, at: list[float] | None, local: list[float] | None = None) -> complex:
        """Return a point of a member in its own frame; numbers may be recorded, which no validation accepts."""
        point = schema.Tracer(on=member).with_value("at", lambda _: at).with_value("local", lambda _: local)
        return self.point(member, point).local

    def _written(self, name: str) -> list[int]:
        """Return the nodes of a member, or of the ground, in the order of the file."""
        return [self.index[n] for n in (self.model.members[name] if name != "ground" else self.model.ground).nodes]


def measured(gauge: schema.Gauge, at: Mapping[str, Any]) -> Any:
    """Return the value of a quantity for positions of its nodes: a distance, a travel, or an angle [rad]."""
    if gauge.nodes is not None:
        return abs(scalar(at[gauge.nodes[1]] - at[gauge.nodes[0]]))
    if gauge.rotary:
        pivot, arm, reference = at[str(gauge.pivot)], at[str(gauge.arm)], gauge.reference
        ray = scalar(arm - pivot)
        ray = ray if reference is None else ray / (scalar(at[reference] - pivot) or 1.0)
        return phase(ray + 0.0j)  # -0.0 would turn pi into -pi
    first, second = (scalar(at[name]) for name in gauge.guide or [])
    along = second - first
    return ((scalar(at[str(gauge.node)]) - first) * (along / (abs(along) or 1.0)).conjugate()).real


def axes(member: Member, nodes: Sequence[int], zero: float = 0.0) -> tuple[complex, complex]:
    """Return the first of the nodes and the direction to the second, in the frame of their member.

    Nodes that are closer than `zero` coincide: the direction is then that to the next one, or 1.
    """
    first, *others = (member.local(n) for n in nodes)
    apart = [z - first for z in others if abs(nominal(z - first)) > zero]  # nodes of the ground may coincide
    return first, _unit(apart[0]) if apart else 1.0 + 0.0j


def _unit(z: complex) -> complex:
    return z / abs(z)


def to_own_frame(z: ComplexArray) -> ComplexArray:
    """Return a shape with its first node at 0 and its second on +x."""
    along = z[1] - z[0]
    turned = (z - z[0]) * (along.conjugate() / abs(along))
    turned[1] = abs(along)
    return np.asarray(turned)
