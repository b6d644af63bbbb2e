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
    if not isinstance(data.get("ground"), list):
        return None
    data = copy.deepcopy(data)
    (x, y), *_ = places = written(data).nodes.values()
    size = math.hypot(*(max(part) - min(part) for part in zip(*places, strict=True)))
    data["nodes"][NEW] = [x + 0.8 * times * size, y - 0.6 * times * size]
    data["ground"].append(NEW)
    return data


def with_guide_nodes(data, times):
    """Return the model with a new second node of each guide, of the same member, `times` the distance away."""
    data, own, made = copy.deepcopy(data), written(data), {}
    for section in ("prismatic", "actuators", "springs", "dampers"):
        for part in (data.get(section) or {}).values():
            if part.get("guide"):
                guide = tuple(part["guide"])
                if guide not in made:
                    made[guide] = f"{NEW}{len(made)}"
                    _add(data, own, guide, made[guide], times)
                part["guide"] = [guide[0], made[guide]]
    return data if made else None


def with_plates(data):
    """Return the model whose links with guides are elements as in `with_guide_nodes`: members keep their order."""
    made = with_guide_nodes(data, 2.0)
    return data if made is None or made.get("links") == data.get("links") else made


def _add(data, own, guide, name, times):
    """Add a node on the line of a guide to the member of the guide; a link becomes an element."""
    data["nodes"][name] = _beyond(own.nodes, guide, times)
    if isinstance(data.get("ground"), list) and set(guide) <= set(data["ground"]):
        data["ground"].append(name)
        return
    ((key, part),) = [(key, part) for key, part in own.members.items() if set(guide) <= set(part.nodes)]
    data.get("links", {}).pop(key, None)
    shape = getattr(part, "shape", None)
    if getattr(part, "length", None) is not None:
        shape = dict(zip(part.nodes, ([0.0, 0.0], [part.length, 0.0]), strict=True))
    earlier = (data.setdefault("elements", {}).get(key) or {}) if key in data.get("elements", {}) else {}
    earlier = earlier if isinstance(earlier, dict) else {"nodes": earlier}
    nodes = earlier.get("nodes", part.nodes)
    made = {"nodes": [*nodes, name]}
    if shape:
        shape = {**shape, **earlier.get("shape", {})}
        made["shape"] = {**shape, name: _beyond(shape, guide, times)}
    data["elements"][key] = made


def _beyond(places, guide, times):
    return [a + times * (b - a) for a, b in zip(*(places[n] for n in guide), strict=True)]


CHANGES = {
    "a ground node at 1e3": (lambda data: data, lambda data: with_ground_node(data, 1e3)),
    "a ground node at 1e6": (lambda data: data, lambda data: with_ground_node(data, 1e6)),
    "guide nodes at 1e4": (with_plates, lambda data: with_guide_nodes(data, FAR)),
}
