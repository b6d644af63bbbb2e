"""The long form of a model: no short forms, and explicit values in place of what follows from the coordinates."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from gimcli.dynamic_data import NO_MEMBER
from gimcli.mechanism import FRAME, Mechanism
from gimcli.model.compile_geometry import axes
from gimcli.model.dimensions import written
from gimcli.model.laws import ended
from gimcli.model.pairs import node_of
from gimcli.model.part import Part
from gimcli.model.references import CLOSEST
from gimcli.model.schema import Actuator, Element, Law, Link, Load, Mass, Model, Spring, Tracer
from gimcli.model.yaml_text import yaml_text

FIRST = ("name", "source", "units", "parameters", "nodes", "ground")
"""Sections in the order in which a text begins; those of the members follow as in the file, and then the others."""


def long_form(mechanism: Mechanism) -> str:
    """Return the model file of a mechanism in long form.

    Args:
        mechanism: from `load` or `loads`, or from its `with_`, possibly in another assembly.

    Returns:
        YAML text of a model of the same mechanism. Short forms are written out; types, lengths, shapes, local
        coordinates, ends of laws and the duration are explicit. Formulas are evaluated, and are comments.

    Raises:
        UsageError: the mechanism was not read from a model.
    """
    return yaml_text(_LongForm(mechanism).data(), notes=_notes(written(mechanism).model))


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
        self.model: Model = written(mechanism).model
        self.number = {member.name: k for k, member in enumerate(mechanism.members)}
        self.explicit: dict[str, Callable[[int, Any], dict[str, Any]]] = {
            "links": self._link, "elements": self._element, "actuators": self._actuator,
            "prismatic": lambda _, pair: {"offset": pair.offset},
            "points": lambda k, part: self._place(part, mechanism.points[k].member, mechanism.points[k].local),
            "masses": self._mass, "loads": self._load, "springs": self._spring,
        }  # fmt: skip

    def data(self) -> dict[str, Any]:
        """Return the sections; those that the model does not have are left out."""
        model, mechanism = self.model, self.mechanism
        members = ("links" if isinstance(part, Link) else "elements" for part in model.members.values())
        whole = {
            "name": mechanism.name, "units": dict(vars(model.units)), "nodes": self._nodes(),
            "trace": list(mechanism.traced), "duration": mechanism.duration,
        }  # fmt: skip
        found = {key: whole.get(key) or self._section(key) for key in dict.fromkeys((*FIRST, *members, *Model.fields))}
        return {key: value for key, value in found.items() if value not in ({}, [], "", None)}

    def _section(self, section: str) -> Any:
        """Return a section of the file, with the explicit values in its parts."""
        parts, explicit = getattr(self.model, section), self.explicit.get(section)
        if explicit is None:
            return plain(parts)
        return {name: _long(part, explicit(k, part)) for k, (name, part) in enumerate(parts.items())}

    def _nodes(self) -> dict[str, list[float]]:
        """Return the initial coordinates, those of the file unless another assembly was chosen."""
        mechanism, places = self.mechanism, self.model.nodes
        used = {name: complex(*places[name]) for name in mechanism.nodes}
        if not np.array_equal((np.array(list(used.values())) - mechanism.origin) / mechanism.scale, mechanism.drawn):
            solved = mechanism.to_file(mechanism.drawn)
            places = {**places, **{n: _pair(z) for n, z in zip(mechanism.nodes, solved.tolist(), strict=True)}}
        return places

    # -- members ----------------------------------------------------------------------------------

    def _link(self, _: int, part: Link) -> dict[str, Any]:
        return {"length": math.dist(*(self.model.nodes[node] for node in part.nodes))} if part.length is None else {}

    def _element(self, number: int, part: Element) -> dict[str, Any]:
        """Return the coordinates of the nodes in the member's own frame (file's unit)."""
        member, nodes = self.number[[*self.model.elements][number]], self.mechanism.nodes
        local = self.mechanism.members[member].local
        return {"shape": part.shape or {n: self._local(member, complex(local(nodes.index(n)))) for n in part.nodes}}

    def _local(self, member: int, place: complex) -> list[float]:
        """Return `local` for a position in the compiled frame of a member: from its first node, along its second."""
        own = self.mechanism.members[member]
        nodes = [self.mechanism.nodes.index(name) for name in self.model.members[own.name].nodes]
        first, along = axes(own, nodes, CLOSEST * self.mechanism.size)
        return _pair((place - complex(first)) / complex(along) * self.mechanism.scale)

    # -- inputs -----------------------------------------------------------------------------------

    def _actuator(self, number: int, actuator: Actuator) -> dict[str, Any]:
        own: dict[str, Any] = {"type": "rotary" if actuator.rotary else "linear"}
        own |= {"speed": actuator.speed} if actuator.free else {}
        if actuator.follows is not None:
            return own | self._coupled(number, actuator)
        return own | {"law": self._law(number, actuator.law or Law())}

    def _coupled(self, number: int, actuator: Actuator) -> dict[str, Any]:
        """Return the keys of an actuator that follows another; without a phase it agrees with the drawn position."""
        leader, ratio, phase = str(actuator.follows), actuator.ratio, actuator.phase
        ratio = 1.0 if ratio is None else ratio
        if phase is None:
            drawn = self.mechanism.inputs_to_file(np.array([one.drawn for one in self.mechanism.actuators]))
            phase = drawn[self.mechanism.actuators[number].name] - ratio * drawn[leader]
        return {"ratio": ratio, "phase": phase}

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

    def _place(self, part: Tracer | Load, member: int, place: complex) -> dict[str, Any]:
        """Return `local` of a point of a member, or `at` of a point of the ground."""
        if part.on == "ground":
            return {"at": part.at or _pair(complex(self.mechanism.to_file(np.array(place)))), "local": None}
        return {"at": None, "local": part.local or self._local(member, place)}

    def _mass(self, number: int, mass: Mass) -> dict[str, Any]:
        own = self.mechanism.dynamics.inertias[number]
        given = mass.centre or own.member in (FRAME, NO_MEMBER)
        return {} if given else {"centre": self._local(own.member, own.centre)}

    def _load(self, number: int, load: Load) -> dict[str, Any]:
        own = self.mechanism.dynamics.loads[number]
        carried = load.torque is None and node_of(self.model, load.on) is None
        return {
            **(self._place(load, own.member, own.point) if carried else {}),
            "over": load.over if load.table else None,
        }

    def _spring(self, number: int, spring: Spring) -> dict[str, Any]:
        unit, radian = self.mechanism.scale, 180.0 / math.pi if self.model.units.angle == "deg" else 1.0
        free = self.mechanism.dynamics.springs[number].free * (radian if spring.rotary else unit)
        return {"free": free if spring.free is None else spring.free}


def plain(data: Any) -> Any:
    """Return a part of a model as plain data, with the keys that the file gives."""
    if isinstance(data, Part):
        return {key.rstrip("_"): plain(value) for key, value in vars(data).items() if key in data.given}
    return {key: plain(value) for key, value in data.items()} if isinstance(data, Mapping) else data


def _long(part: Part, explicit: Mapping[str, Any]) -> dict[str, Any]:
    """Return a part as plain data with explicit values, its type first; None removes a key."""
    keys = {**plain(part), **explicit}
    return {key: keys[key] for key in dict.fromkeys(("type", *part.fields)) if keys.get(key) is not None}


def _pair(z: complex) -> list[float]:
    return [z.real, z.imag]
