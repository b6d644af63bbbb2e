"""The columns of dynamics that --plot may name, and words for groups of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from gimcli.library.plots import Group, PlannedCurve, PlannedGraph, Vocabulary, amount, plotted
from gimcli.mechanism import Mechanism
from gimcli.output.graph import ORDINARY
from gimcli.table import Column

TEXTS = ("status", "friction.state")
"""Columns without numbers."""

SHAKING = "shaking"

CONSTANT = 1e-9
"""Range of a constant quantity, relative to its largest value."""


def force_vocabulary(table: Mapping[str, str], mechanism: Mechanism, more: Iterable[str] = ()) -> Vocabulary:
    """Return the words for columns of forces, powers and energies with their units; `more` belong to no word [N]."""
    columns = {name: unit for name, unit in table.items() if name not in TEXTS}
    words = {word: group for word, group in _words(columns).items() if group.quantities}
    return Vocabulary({**columns, **dict.fromkeys(more, "N")}, words, mechanism)


def _words(columns: Mapping[str, str]) -> dict[str, Group]:
    pins = [name[:-3] for name in columns if name.endswith(".fx") and name != f"{SHAKING}.fx"]
    pairs = [name for name in columns if name.endswith(".normal")]
    reactions = [
        *(amount(pin, (f"{pin}.fx", f"{pin}.fy"), columns[f"{pin}.fx"]) for pin in pins),
        *(amount(name[: -len(".normal")], (name,), columns[name]) for name in pairs),
    ]
    return {
        "effort": _ending(columns, "effort"),
        "reactions": Group("reaction", tuple(reactions)),
        "power": _beginning(columns, "power"),
        "energy": _beginning(columns, "energy"),
        "speed": _ending(columns, "speed"),
        "acceleration": _ending(columns, "acceleration"),
    }


def _ending(columns: Mapping[str, str], word: str) -> Group:
    own = [name for name in columns if name.endswith(f".{word}")]
    return Group(word, tuple(plotted(name, columns[name], name[: -len(word) - 1]) for name in own))


def _beginning(columns: Mapping[str, str], word: str) -> Group:
    own = [name for name in columns if name.startswith(f"{word}.")]
    return Group(word, tuple(plotted(name, columns[name], name[len(word) + 1 :]) for name in own))


def usual_graphs(mechanism: Mechanism) -> list[PlannedGraph]:
    """Return the graphs without --plot: driving efforts over the input."""
    plans = []
    for rotary, title in ((True, "driving torque"), (False, "driving force")):
        own = [a.name for k, a in enumerate(mechanism.actuators) if a.rotary is rotary and k not in mechanism.geared]
        unit = "N m" if rotary else "N"
        curves = tuple(PlannedCurve(plotted(f"{name}.effort", unit, name)) for name in own)
        plans += [PlannedGraph(ORDINARY, title, curves)] if own else []
    return plans


def varying(plans: Sequence[PlannedGraph], columns: Mapping[str, Column]) -> tuple[list[PlannedGraph], list[str]]:
    """Return the graphs that show more than a constant, and the values of the constant ones as texts."""
    kept, texts = [], []
    for plan in plans:
        names = sorted(plan.columns)
        if all(_is_constant(columns[name]) for name in names):
            texts += [_value(columns[name]) for name in names]
        else:
            kept.append(plan)
    return (kept, texts) if kept else (list(plans[:1]), [])


def _is_constant(column: Column) -> bool:
    values = column.values[np.isfinite(column.values)]
    return len(values) == 0 or float(np.ptp(values)) <= CONSTANT * float(np.max(np.abs(values)))


def _value(column: Column) -> str:
    """Return a constant column as text."""
    values = column.values[np.isfinite(column.values)]
    return f"{column.name} = {values[0]:.4g} {column.unit}" if len(values) else f"no {column.name}"
