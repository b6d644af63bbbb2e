"""Two models as the data of one file: the names of the second begin with `q`, and its nodes lie far away."""

from typing import Any

import yaml
from bundled import MODELS

ROCKER_AND_CRANK = """
units: {length: m}
nodes: {A: [0, 0], B: [0, 2], C: [3, 3], D: [4, 0], E: [10, 0], F: [11, 0]}
ground: [A, D, E]
links: {a: [A, B], b: {nodes: [B, C], length: 3.2}, c: {nodes: [C, D], length: 1.5}, e: [E, F]}
actuators: {rocker: {pivot: A, arm: B, law: {by: 15}}, crank: {pivot: E, arm: F, law: {by: 360}}}
"""
"""A rocker that meets its limit at 97.5 deg, and a crank that turns fully."""

NAMED = (
    "links", "elements", "prismatic", "actuators", "gears", "points", "loads", "springs", "dampers", "nodes",
)  # fmt: skip
KEYED = (*NAMED, "masses", "friction")
LISTED = ("ground", "trace")
COMMON = ("units", "gravity", "duration")
"""Keys with one value for the whole file: pairs are formed of models that have the same."""


def data_of(name: str) -> dict[str, Any]:
    """Return the data of a shipped model without its texts."""
    data = yaml.safe_load((MODELS / f"{name}.yaml").read_text())
    return {k: v for k, v in data.items() if k in (*KEYED, *LISTED, *COMMON)}


def renamed(data: dict[str, Any], away: float) -> dict[str, Any]:
    """Return the data of a model with other names, `away` along x."""
    names = {name for section in NAMED for name in data.get(section, {})}

    def named(part: Any) -> Any:
        if isinstance(part, dict):
            return {k: named(v) for k, v in part.items()}
        return [named(one) for one in part] if isinstance(part, list) else f"q{part}" if part in names else part

    found: dict[str, Any] = {k: v for k, v in data.items() if k in COMMON}
    for section in KEYED:
        if section in data:
            found[section] = {f"q{k}" if k in names else k: named(v) for k, v in data[section].items()}
    for part in found.get("elements", {}).values():
        if isinstance(part, dict) and "shape" in part:
            part["shape"] = {f"q{k}": v for k, v in part["shape"].items()}
    for section in LISTED:
        if section in data:
            found[section] = named(data[section])
    moved = [part["at"] for section in ("points", "loads") for part in found.get(section, {}).values() if "at" in part]
    for place in (*found["nodes"].values(), *moved):
        place[0] += away
    return found


def beside(data: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Return the data of two models with different names as one."""
    found = dict(data)
    for key, part in other.items():
        if key not in COMMON:
            old = found.get(key, type(part)())
            found[key] = [*old, *part] if isinstance(part, list) else {**old, **part}
    return found
