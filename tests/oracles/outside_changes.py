"""Changes of a model outside its motion: far nodes of the ground, and far nodes that mark the lines of guides.

A change is a pair of functions from a model (as parsed) to two models with the same answers; None: not applicable.
"""

from __future__ import annotations

import copy
import math
import re

import yaml
from bundled import FILES

import gimcli

FAR = 1e4
"""How many times farther than the second node of a guide the new node is."""

MACHINE = "a machine at 1e3"

NEW = "outside"
"""The beginning of the names of new nodes."""


def model_of(name):
    return _numbers(yaml.safe_load((FILES[0].parent / f"{name}.yaml").read_text()))


def _numbers(value):
    """Convert texts such as 4e-5, which are no numbers for PyYAML, at any depth."""
    if isinstance(value, dict):
        return {key: _numbers(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_numbers(part) for part in value]
    return float(value) if isinstance(value, str) and re.fullmatch(r"-?[0-9.]+e-?[0-9]+", value) else value


def written(data):
    return gimcli.load(copy.deepcopy(data), folder=FILES[0].parent).written.model


def with_ground_node(data, times):
    """Return the model with a node of the ground that nothing uses, `times` the size away."""
    data = copy.deepcopy(data)
    if ground_of(data) is None:
        return None
    (x, y), *_ = places = written(data).nodes.values()
    size = math.hypot(*(max(part) - min(part) for part in zip(*places, strict=True)))
    data["nodes"][NEW] = [x + 0.8 * times * size, y - 0.6 * times * size]
    ground_of(data).append(NEW)
    return data


def with_guide_nodes(data, times, first=False):
    """Return the model with a new second node of each guide, of the same member, `times` the distance away.

    first: a new first node of the guides of pairs instead; travels are counted from that of the others.
    """
    data, own, made = copy.deepcopy(data), written(data), {}
    for section in ("prismatic",) if first else ("prismatic", "actuators", "springs", "dampers"):
        for part in (data.get(section) or {}).values():
            if part.get("guide"):
                guide = tuple(part["guide"])
                if guide not in made:
                    made[guide] = f"{NEW}{len(made)}"
                    _add(data, own, guide[::-1] if first else guide, made[guide], times)
                part["guide"] = [made[guide], guide[1]] if first else [guide[0], made[guide]]
    return data if made else None


def with_plates(data, first=False):
    """Return the model whose links with guides are elements as in `with_guide_nodes`: members keep their order."""
    made = with_guide_nodes(data, 2.0, first)
    return data if made is None or made.get("links") == data.get("links") else made


def _add(data, own, guide, name, times):
    """Add a node on the line of a guide to the member of the guide; a link becomes an element."""
    data["nodes"][name] = _beyond(own.nodes, guide, times)
    ground = ground_of(data)
    if ground is not None and set(guide) <= set(ground):
        ground.append(name)
        return
    ((key, part),) = [(key, part) for key, part in own.members.items() if set(guide) <= set(part.nodes)]
    if data.get("links", {}).pop(key, None) is not None:
        length = part.length
        shape = None if length is None else dict(zip(part.nodes, ([0.0, 0.0], [length, 0.0]), strict=True))
        data.setdefault("elements", {})[key] = {"nodes": list(part.nodes), **({"shape": shape} if shape else {})}
        if isinstance(data.get("masses", {}).get(key), dict):
            whole = math.dist(*(own.nodes[n] for n in part.nodes)) if length is None else length
            data["masses"][key].setdefault("centre", [0.5 * whole, 0.0])  # by default the mean of the nodes
    old = data["elements"][key]
    made = data["elements"][key] = old if isinstance(old, dict) else {"nodes": old}
    made["nodes"].append(name)
    if "shape" in made:
        made["shape"][name] = _beyond(made["shape"], guide, times)


def ground_of(data):
    """Return the list of the nodes of the ground; None if a member is held."""
    ground = data.get("ground")
    return ground.get("nodes") if isinstance(ground, dict) else ground if isinstance(ground, list) else None


def _beyond(places, guide, times):
    return [a + times * (b - a) for a, b in zip(*(places[n] for n in guide), strict=True)]


def with_machine(data, times):
    """Return the model with an independent crank, `times` the size away, that turns once."""
    data = with_ground_node(data, times)
    if data is not None:
        x, y = data["nodes"][NEW]
        data["nodes"][f"{NEW}_end"] = [x + 1.0, y]
        data.setdefault("links", {})[f"{NEW}_crank"] = [NEW, f"{NEW}_end"]
        data["actuators"][f"{NEW}_motor"] = {"pivot": NEW, "arm": f"{NEW}_end", "law": {"from": 0, "by": 360}}
    return data


CHANGES = {
    "a ground node at 1e3": (lambda data: data, lambda data: with_ground_node(data, 1e3)),
    "a ground node at 1e6": (lambda data: data, lambda data: with_ground_node(data, 1e6)),
    MACHINE: (lambda data: data, lambda data: with_machine(data, 1e3)),
    "guide nodes at 1e4": (with_plates, lambda data: with_guide_nodes(data, FAR)),
    "first guide nodes at 1e4": (lambda data: with_plates(data, True), lambda data: with_guide_nodes(data, FAR, True)),
}
