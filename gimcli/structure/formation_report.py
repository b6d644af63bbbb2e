"""Reports of the formation of a mechanism (its Assur groups): texts, layers for the diagram, JSON."""

from __future__ import annotations

from typing import Any

from gimcli.connected import grouped
from gimcli.mechanism import FRAME, Mechanism
from gimcli.structure.assur import AssurGroup, Formation

ROMAN = {1: "I", 2: "II", 3: "III", 4: "IV", 5: "V", 6: "VI", 7: "VII", 8: "VIII", 9: "IX", 10: "X"}


def described(group: AssurGroup) -> str:
    """Return a short description of a group."""
    if group.driving:
        return "driving link, turning" if group.outer and group.outer[0].kind == "R" else "driving link, sliding"
    if group.dyad:
        return f"dyad {group.dyad}"
    return f"group of {len(group.links)} links"


def class_of(group: AssurGroup) -> str:
    """Return the class of a group in Roman numerals."""
    return ROMAN.get(group.grade, str(group.grade))


def drivers(mechanism: Mechanism, group: AssurGroup) -> tuple[str, ...]:
    """Return the names of the actuators whose inputs determine a group."""
    return tuple(mechanism.actuators[k].name for k in group.drivers)


def joined(formation: Formation, group: AssurGroup) -> dict[int, list[str]]:
    """Return, for each link formed before, the names of the pairs that join a group to it."""
    return grouped((base, pair.name) for pair, base in zip(group.outer, formation.bases(group), strict=True))


def layers(formation: Formation) -> list[int]:
    """Return the layer of every group: 1 if it is joined to the frame only, else 1 + the layer of its bases."""
    layer: dict[int, int] = {FRAME: 0}
    result = []
    for group in formation.groups:
        own = 1 + max((layer[base] for base in formation.bases(group)), default=0)
        layer |= dict.fromkeys(group.links, own)
        result.append(own)
    return result


def as_json(mechanism: Mechanism, formation: Formation) -> dict[str, Any]:
    """Return the formation by the names of the model file."""
    numbers = formation.numbers
    return {
        "formula": list(formation.formula),
        "links": {formation.links[k]: number for k, number in numbers.items()},
        "groups": [
            {
                "kind": "driving link" if g.driving else "group", "dyad": g.dyad or None,
                "links": [formation.links[k] for k in g.links], "class": g.grade, "order": g.order,
                "on": [formation.links[k] for k in formation.bases(g)], "outer": [_pair(formation, p) for p in g.outer],
                "inner": [_pair(formation, p) for p in g.inner], "driven_by": list(drivers(mechanism, g)),
                "redundant": g.surplus,
            }
            for g in formation.groups
        ],
    }  # fmt: skip


def _pair(formation: Formation, pair: Any) -> dict[str, Any]:
    return {"kind": pair.kind, "at": pair.name, "links": [formation.links[k] for k in pair.bodies]}
