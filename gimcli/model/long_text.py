"""The long form of a model: no short forms, and explicit values in place of what follows from the coordinates."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gimcli.mechanism import FRAME, Mechanism, Member
from gimcli.model.bearers import node_of
from gimcli.model.compile_geometry import axes
from gimcli.model.law_ends import ended
from gimcli.model.references import CLOSEST
from gimcli.model.schema import Actuator, Gauge, Gear, Law, Link, Model
from gimcli.model.yaml_text import yaml_text


def long_text(mechanism: Mechanism) -> str:
    """Return the model of a mechanism as YAML text in long form.

    Args:
        mechanism: read from a model, possibly with other dimensions or in another assembly.

    Returns:
        The text of a model file of the same mechanism. Types, lengths, shapes, local coordinates, ends of laws and
        the duration are explicit. Formulas are evaluated, and are comments.
    """
    return yaml_text(_LongForm(mechanism).data(), notes=_notes(mechanism.written.model))


def _notes(model: Model) -> dict[tuple[str, ...], str]:
    """Return the formulas of the model as comments, by the section and the name of the part with the number."""
    found: dict[tuple[str, ...], list[str]] = {}
    for where, formula in model.formulas.items():
        part = tuple(str(key) for key in where[:2] if isinstance(key, str))
        keys = ".".join(map(str, where[len(part) :]))
        found.setdefault(part, []).append(f"{keys}: {formula.text}" if keys else formula.text)
    return {part: ", ".join(texts) for part, texts in found.items()}


class _LongForm:
    """The sections of a model in long form, as plain data."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism: Mechanism = mechanism
        self.model: Model = mechanism.written.model
        self.number = {member.name: k for k, member in enumerate(mechanism.members)}

    def data(self) -> dict[str, Any]:
        """Return the sections; those that the model does not have are left out."""
        model, mechanism = self.model, self.mechanism
        units, ground = model.units, model.ground
        found: dict[str, Any] = {
            "name": mechanism.name, "source": model.source,
            "units": {"length": units.length, "angle": units.angle, "mass": units.mass},
            "parameters": model.parameters, "nodes": self._nodes(),
            "ground": {"nodes": ground.nodes} if ground.member is None else {"member": ground.member},
            **self._members(),
            "prismatic": {
                name: _given(node=p.node, nodes=p.nodes, guide=p.guide, offset=p.offset)
                for name, p in model.prismatic.items()
            },
            "actuators": {name: self._actuator(k, one) for k, (name, one) in enumerate(model.actuators.items())},
            "gears": {name: self._gear(one) for name, one in model.gears.items()},
            "points": self._points(), "trace": list(mechanism.traced), "duration": mechanism.duration,
            "masses": self._masses(), "gravity": model.gravity, "loads": self._loads(), "springs": self._springs(),
            "dampers": {name: {**_gauge(one), "damping": one.damping} for name, one in model.dampers.items()},
            "friction": {name: _given(**vars(one)) for name, one in model.friction.items()},
            "tolerances": model.tolerances, "quantities": model.quantities,
        }  # fmt: skip
        return {key: value for key, value in found.items() if value not in ({}, [], "", None)}

    def _nodes(self) -> dict[str, list[float]]:
        """Return the initial coordinates, those of the file unless another assembly was chosen."""
        mechanism, places = self.mechanism, self.model.nodes
        used = {name: complex(*places[name]) for name in mechanism.nodes}
        if not np.array_equal((np.array(list(used.values())) - mechanism.origin) / mechanism.scale, mechanism.drawn):
            solved = mechanism.to_file(mechanism.drawn)
            places = {**places, **{n: _pair(z) for n, z in zip(mechanism.nodes, solved.tolist(), strict=True)}}
        return places

    def _members(self) -> dict[str, dict[str, Any]]:
        """Return the sections of links and elements, in the order of the file."""
        result: dict[str, dict[str, Any]] = {}
        for name, part in self.model.members.items():
            if isinstance(part, Link):
                ends = (self.model.nodes[node] for node in part.nodes)
                length = math.dist(*ends) if part.length is None else part.length
                result.setdefault("links", {})[name] = {"nodes": part.nodes, "length": length}
            else:
                shape = part.shape or dict(zip(part.nodes, self._shape(self.number[name]), strict=True))
                result.setdefault("elements", {})[name] = {"nodes": part.nodes, "shape": shape}
        return result

    def _shape(self, member: int) -> list[list[float]]:
        """Return the coordinates of a member's nodes in its own frame (file's unit)."""
        own = self.mechanism.members[member]
        return [self._local(member, complex(own.local(node))) for node in self._written(own)]

    def _local(self, member: int, place: complex) -> list[float]:
        """Return `local` for a position in the compiled frame of a member: from its first node, along its second."""
        own = self.mechanism.members[member]
        first, along = axes(own, self._written(own), CLOSEST * self.mechanism.size)
        return _pair((place - complex(first)) / complex(along) * self.mechanism.scale)

    def _written(self, member: Member) -> list[int]:
        """Return the nodes of a member in the order of the file."""
        return [self.mechanism.nodes.index(name) for name in self.model.members[member.name].nodes]

    # -- inputs -----------------------------------------------------------------------------------

    def _actuator(self, number: int, actuator: Actuator) -> dict[str, Any]:
        own = {"type": "rotary" if actuator.rotary else "linear", **_gauge(actuator)}
        if actuator.follows is None:
            own["law"] = self._law(number, actuator.law or Law())
        else:
            own |= self._coupled(number, actuator)
        if actuator.free:
            own |= {"free": True, **_given(start=actuator.start), "speed": actuator.speed}
        if actuator.effort is not None:
            effort = actuator.effort
            over = effort.over if effort.table is not None else None
            own["effort"] = _given(
                constant=effort.constant, table=effort.table, over=over, stall=effort.stall, idle=effort.idle
            )
        if (rotor := actuator.rotor) is not None:
            ratio = rotor.ratio if rotor.lead is None else None
            own["rotor"] = _given(inertia=rotor.inertia, ratio=ratio, lead=rotor.lead)
        return own

    def _coupled(self, number: int, actuator: Actuator) -> dict[str, Any]:
        """Return the keys of an actuator that follows another; without a phase it agrees with the drawn position."""
        leader, ratio, phase = str(actuator.follows), actuator.ratio, actuator.phase
        ratio = 1.0 if ratio is None else ratio
        if phase is None:
            drawn = self.mechanism.inputs_to_file(np.array([one.drawn for one in self.mechanism.actuators]))
            phase = drawn[self.mechanism.actuators[number].name] - ratio * drawn[leader]
        return {"follows": leader, "ratio": ratio, "phase": phase}

    @staticmethod
    def _gear(gear: Gear) -> dict[str, Any]:
        return _given(**{key: getattr(gear, key) for key in Gear.fields})

    def _law(self, number: int, law: Law) -> dict[str, Any]:
        profile = law.profile
        if profile.table is not None:
            return {"profile": {"table": profile.table}}
        shape = {"name": profile.name} if profile.polynomial is None else {"polynomial": profile.polynomial}
        if profile.polynomial is not None and not ended(law):
            return {"profile": shape}
        ends = self.mechanism.actuators[number].law(np.array([0.0, 1.0]))
        first, last = self.mechanism.value_to_file(number, ends).tolist()
        first, last = (law.from_ if law.from_ is not None else first), (law.to if law.to is not None else last)
        return {"from": first, "to": last, "profile": shape}

    # -- what members carry -----------------------------------------------------------------------

    def _points(self) -> dict[str, Any]:
        found = {}
        for point in self.mechanism.points:
            on = self.model.points[point.name].on
            found[point.name] = {"on": on, **self._place(on, self.model.points[point.name], point.member, point.local)}
        return found

    def _place(self, on: str, part: Any, member: int, place: complex) -> dict[str, list[float]]:
        """Return `local` of a point of a member, or `at` of a point of the ground."""
        if on == "ground":
            return {"at": part.at or _pair(complex(self.mechanism.to_file(np.array(place))))}
        return {"local": part.local or self._local(member, place)}

    def _masses(self) -> dict[str, Any]:
        found = {}
        for inertia, (name, mass) in zip(self.mechanism.dynamics.inertias, self.model.masses.items(), strict=True):
            own = {"mass": mass.mass, **_given(inertia=mass.inertia, centre=mass.centre)}
            if "centre" not in own and node_of(self.model, name) is None and inertia.member != FRAME:
                own["centre"] = self._local(inertia.member, inertia.centre)
            found[name] = own
        return found

    def _loads(self) -> dict[str, Any]:
        found = {}
        for applied, (name, load) in zip(self.mechanism.dynamics.loads, self.model.loads.items(), strict=True):
            own: dict[str, Any] = {"on": load.on}
            if load.torque is None and node_of(self.model, load.on) is None:
                own |= self._place(load.on, load, applied.member, applied.point)
            own |= _given(force=load.force, follower=load.follower, torque=load.torque, table=load.table)
            found[name] = {**own, "over": load.over} if load.table is not None else own
        return found

    def _springs(self) -> dict[str, Any]:
        found = {}
        for acting, (name, spring) in zip(self.mechanism.dynamics.springs, self.model.springs.items(), strict=True):
            unit = self.mechanism.scale
            if spring.rotary:
                unit = 180.0 / math.pi if self.model.units.angle == "deg" else 1.0
            free = acting.free * unit if spring.free is None else spring.free
            found[name] = {**_gauge(spring), "stiffness": spring.stiffness, "free": free}
        return found


def _gauge(part: Gauge) -> dict[str, Any]:
    """Return the nodes of an actuator, a spring or a damper."""
    return _given(**{key: getattr(part, key) for key in Gauge.fields})


def _given(**keys: Any) -> dict[str, Any]:
    """Return the keys with a value."""
    return {key: value for key, value in keys.items() if value is not None}


def _pair(z: complex) -> list[float]:
    return [z.real, z.imag]
