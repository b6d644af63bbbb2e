"""Units of rates: one spelling for all tables, and no unit of length but the time if the file has none."""

from __future__ import annotations

import pytest

import gimcli

FOUR_BAR = {
    "nodes": {"O": [0, 0], "G": [4, 0], "A": [0, 1], "B": [4, 3]},
    "ground": ["O", "G"],
    "links": {"crank": ["O", "A"], "rod": ["A", "B"], "rocker": ["G", "B"]},
    "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
}


@pytest.mark.parametrize(
    ("length", "rates"), [("mm", ["mm/s", "mm/s^2", "mm/s^3"]), ("unit", ["1/s", "1/s^2", "1/s^3"])]
)
def test_rates_of_points_have_one_spelling_in_tables_and_pictures(length, rates):
    mechanism = gimcli.load({**FOUR_BAR, "units": {"length": length}})
    found = gimcli.trace(mechanism, steps=2, derivatives=3)
    units = {column.name: column.unit for column in found.table().columns}
    assert [units[f"A.{letter}x"] for letter in "vaj"] == rates
    assert [units[f"rod.{name}"] for name in ("omega", "alpha", "jerk")] == ["deg/s", "deg/s^2", "deg/s^3"]
    texts = [own.text.split() for own in gimcli.solve(mechanism, velocities=True).picture().texts]
    assert [own[-1] for own in texts if own[0] in ("velocity", "acceleration")] == rates[:2]


@pytest.mark.parametrize(("length", "unit"), [("mm", "mm"), ("unit", "")])
def test_measures_of_lengths_have_the_files_unit_or_none(length, unit):
    mechanism = gimcli.load({**FOUR_BAR, "units": {"length": length}})
    found = gimcli.trace(mechanism, steps=2, measure=["curvature:A", "centre:frame/rod"])
    columns = [c for c in found.table().columns if c.name.endswith((".radius", "centre.x", "/rod.x"))]
    assert [column.unit for column in columns] == [unit] * 3
