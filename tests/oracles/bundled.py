"""Paths of models, README, manual and tables of the tests; motions of models with all nodes recorded."""

from __future__ import annotations

import csv
import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml

from gimcli import load
from gimcli.model.part import Part
from gimcli.model.source import read_source
from gimcli.motion.motion import trace
from gimcli.positions.options import Options
from gimcli.quantities.motion_table import motion_table, usual

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
MANUAL = ROOT / "gimcli" / "manual"
MODELS, TABLES = ROOT / "models", ROOT / "tests" / "tables"
FILES = sorted(MODELS.glob("*.yaml"))

SHORT = re.compile(r"(?m)^parameters:|angle: rad|\.csv|rate: .* rpm")
EXPLICIT = [path for path in FILES if not SHORT.search(path.read_text())]
"""Models that tests read themselves: without formulas, radians, tables and rates."""

CHOSEN = frozenset({
    "antiparallelogram", "crank_rocker", "elliptic_trammel", "excavator", "five_bar", "floating_hexagon", "gim_fig11",
    "parallel_guide", "parallelogram_third_crank", "platform_3rpr", "scissor_lift", "scotch_yoke", "slider_crank",
    "stephenson_3_far", "whitworth",
})  # fmt: skip
"""One model of each kind: dyads, coupled groups, blocks, moving guides, rotary and linear inputs, several inputs,
redundant members, floating mechanisms, change points. Tests over all models run with these, with -m soak on all."""

FEWEST = ("antiparallelogram", "crank_rocker", "elliptic_trammel", "five_bar", "gim_fig11", "platform_3rpr")
"""Change points, dyads, sliding pairs, several inputs, a coupled group, linear inputs: for slow tests."""


@dataclass
class Traced:
    """A motion in the file's units, with all nodes and points recorded."""

    table: object
    mechanism: object
    motion: object

    @property
    def value(self):
        return {a.name: self.table.floats(a.name) for a in self.mechanism.actuators}

    @property
    def status(self):
        return list(self.table["status"])

    @property
    def residual(self):
        return self.table.floats("residual")

    def xy(self, name):
        return self.table.floats(f"{name}.x") + 1j * self.table.floats(f"{name}.y")


def run_model(path, steps=360, laws=None, change=None, **options):
    """Trace a model file (or a shipped model by its stem) with all nodes recorded; `laws` replaces its laws."""
    path = Path(path) if str(path).endswith(".yaml") else MODELS / f"{path}.yaml"
    mechanism = changed(path, laws, change) if laws or change else load(path)
    motion = trace(mechanism, steps, Options(**options))
    names = (*mechanism.nodes, *(p.name for p in mechanism.points))
    return Traced(motion_table(motion, usual(mechanism, names)), mechanism, motion)


def changed(path, laws, change):
    """Load a model with other laws, or after a function has changed its data."""
    data = plain_data(path)
    for name, law in (laws or {}).items():
        data["actuators"][name]["law"] = law
    if change:
        change(data)
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        copy.write_text(yaml.safe_dump(data, sort_keys=False))
        return load(copy, path.parent)  # where the tables are


def plain_data(path):
    """Return the data of a model; where it has formulas, they are replaced by numbers."""
    model = load(path).written.model
    if not model.formulas:
        return read_source(path).data
    data = _given(model)
    return {key: part for key, part in data.items() if key not in ("parameters", "tolerances")}


def _given(value):
    if isinstance(value, Part):
        return {name.rstrip("_"): _given(vars(value)[name]) for name in value.given}
    return {name: _given(part) for name, part in value.items()} if isinstance(value, dict) else value


def written(folder, text):
    """Load a model from its text."""
    path = folder / "m.yaml"
    path.write_text(text)
    return load(path)


def reference(name):
    """Return the columns of one of the tests' tables."""
    with (TABLES / name).open() as handle:
        rows = list(csv.DictReader(handle))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}
