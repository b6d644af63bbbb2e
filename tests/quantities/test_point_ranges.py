"""Ranges of traced points at the end of `gim trace`, and whether their curves are closed."""

from __future__ import annotations

import json

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim, printed

import gimcli
from gimcli.model.source import read_source
from gimcli.motion.motion import trace
from gimcli.quantities.point_ranges import PointRanges
from gimcli.table import Column, Table


def model(name="crank_rocker", law=None, **more):
    """Return a bundled model with all moving nodes traced, and with another law."""
    data = {**read_source(MODELS / f"{name}.yaml").data, **more}
    if law is not None:
        data["actuators"] = {key: {**value, "law": law} for key, value in data["actuators"].items()}
    return data


def curves(data, **arguments):
    found = gimcli.trace(gimcli.load(data), steps=72, **arguments)
    return {name: one["curve"] for name, one in found.points.items()}


TRACED = {"trace": ["A", "B", "P", "Q"], "points": {"P": {"on": "coupler", "at": [50, 80]}, "Q": {"on": "ground",
          "at": [5, 5]}}}  # fmt: skip


@pytest.mark.parametrize(
    ("law", "arguments", "expected"),
    [
        ({"by": 360}, {}, ["closed", "there and back", "closed", "fixed"]),
        ({"by": -720}, {}, ["closed", "there and back", "closed", "fixed"]),
        ({"by": 350}, {}, ["open", "open", "open", "fixed"]),
        ({"profile": {"polynomial": [0, 400, -400]}}, {}, ["there and back"] * 3 + ["fixed"]),  # up to 100, and back
        ({"by": 20}, {"circuit": True}, ["closed", "there and back", "closed", "fixed"]),
    ],
)
def test_kinds_of_curves_of_a_crank_rocker(law, arguments, expected):
    assert list(curves(model(law=law, **TRACED), **arguments).values()) == expected


def test_sliders_go_there_and_back():
    assert curves(model("slider_crank")) == {"B": "there and back", "P": "closed"}
    assert curves(model("whitworth", trace=["R", "E", "D"])) == {"R": "there and back", "E": "closed", "D": "closed"}


def test_rows_that_are_not_solved_leave_a_curve_open():
    """The law leaves the range of the input after the point was at its first position again."""
    found = gimcli.trace(gimcli.load(model("chebyshev", law={"from": 60, "to": 150})), steps=30)
    assert not found.complete
    assert {one["curve"] for one in found.points.values()} == {"open"}
    assert all(np.isfinite(one["x"] + one["y"]).all() for one in found.points.values())
    law = {"profile": {"polynomial": [60, 400, -400]}}  # to 160 degrees, beyond the limit, and back
    assert set(curves(model("chebyshev", law=law), at_limit="skip").values()) == {"open"}


def test_a_curve_through_both_limits_is_closed():
    """The circuit of a double-rocker: pins of the rockers return on their arcs, the coupler point on another curve."""
    found = curves(model("chebyshev", trace=["A", "B", "P"]), circuit=True)
    assert found == {"A": "there and back", "B": "there and back", "P": "closed"}


def test_ranges_are_those_of_the_columns_in_any_pieces():
    m = gimcli.load(model(**TRACED))
    found = gimcli.trace(m, steps=100)
    for name, one in found.points.items():
        xy = found.xy[name]
        assert [one["x"], one["y"]] == [[xy[:, k].min(), xy[:, k].max()] for k in (0, 1)]
    table, ranges = found.table(), PointRanges(m)
    for rows in (slice(0, 1), slice(1, 40), slice(40, 101)):
        piece = Table(tuple(Column(c.name, c.values[rows], c.unit) for c in table.columns))
        ranges.add(piece)
    assert ranges.report(trace(m, 100)) == found.points


def test_the_crank_pin_has_the_range_of_its_circle():
    points = gimcli.trace(gimcli.load(model(**TRACED)), steps=360).points
    assert points["A"]["x"] == pytest.approx([-40.0, 40.0])
    assert points["A"]["y"] == pytest.approx([-40.0, 40.0])
    assert points["Q"] == {"x": [5.0, 5.0], "y": [5.0, 5.0], "curve": "fixed"}


def test_the_report_ends_with_the_points(tmp_path):
    text = printed("trace", MODELS / "crank_rocker.yaml", "-n", "36", "-o", "t.csv", cwd=tmp_path)
    assert text.index("worst residual") < text.index("there and back") < text.index("wrote t.csv")
    many = {f"P{k}": {"on": "coupler", "at": [50 + k, 80]} for k in range(20)}
    (tmp_path / "m.json").write_text(json.dumps(model(points=many, trace=list(many))))
    (tmp_path / "m.json").rename(tmp_path / "m.yaml")
    text = printed("trace", "m.yaml", "-n", "12", "-o", "t.csv", cwd=tmp_path)
    assert "... and 8 more (--json lists all)" in text
    assert len(gim("trace", tmp_path / "m.yaml", "-n", "12", "-o", tmp_path / "t.csv", "--json").json["points"]) == 20


def test_each_circuit_has_its_points():
    result = gimcli.trace(gimcli.load(MODELS / "parallelogram.yaml"), steps=24, all_branches=True)
    heights = [one["points"]["M"]["y"] for one in result.report()["circuits"]]
    assert heights == [pytest.approx([-1.0, 1.0], rel=1e-2), pytest.approx([-1.0 / 6.0, 1.0 / 6.0], rel=1e-2)]
    assert result.points == {}
