"""Calls of all verbs of the library that return results, on small models."""

from __future__ import annotations

from functools import cache
from typing import Any

from bundled import MODELS

import gimcli

CALLS: dict[str, tuple[str, dict[str, Any]]] = {
    "check": ("crank_rocker", {}),
    "circuits": ("crank_rocker", {"values": 4}),
    "configurations": ("crank_rocker", {"motor": 30}),
    "equilibrium": ("swing", {}),
    "fit": ("crank_rocker", {"goal": "max(P.y)", "vary": {"crank.length": (39, 41)}, "starts": 1}),
    "forces": ("engine", {"steps": 4}),
    "groups": ("watt_1", {}),
    "holding_forces": ("lift_table", {"cylinder": 0.5}),
    "mobility": ("crank_rocker", {}),
    "modes": ("double_pendulum", {}),
    "reduce": ("engine", {"steps": 4}),
    "sensitivity": ("crank_rocker", {"of": "P.x", "steps": 4}),
    "sequence": ("ten_bar", {}),
    "simulate": ("swing", {"duration": 0.01}),
    "singularities": ("parallelogram", {}),
    "solve": ("crank_rocker", {"motor": 30}),
    "sweep": ("crank_rocker", {"vary": {"crank.length": [39, 41]}, "steps": 4}),
    "trace": ("crank_rocker", {"steps": 4}),
    "tradeoff": ("crank_rocker", {"steps": 2, "tolerances": [1e-4]}),
    "workspace": ("crank_rocker", {}),
}
"""Verbs that return results, with a model and arguments."""

OTHERS: dict[str, tuple[str, dict[str, Any]]] = {
    "assembled": ("crank_rocker", {"assembly": 2}),
    "convert": ("crank_rocker", {}),
    "evaluator": ("crank_rocker", {"dimensions": ["crank.length"], "keep": ["max(P.y)"]}),
}

TIMED = ("tradeoff",)
"""Verbs that measure computing times, which differ."""


@cache
def result(verb: str) -> Any:
    """Return what a verb returns, computed once for tests that only read it."""
    return run(verb)


def run(verb: str, *, path: Any = str) -> Any:
    model, arguments = (CALLS | OTHERS)[verb]
    return getattr(gimcli, verb)(path(MODELS / f"{model}.yaml"), **arguments)
