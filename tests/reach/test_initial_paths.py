"""Paths of one input: by default those that the initial configuration reaches within the range of the input."""

from __future__ import annotations

import cmath
import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim, ran, read_rows

import gimcli
from gimcli import UnassembledError
from gimcli.model.source import read_source
from gimcli.reach import circuit_paths

DOUBLE_ROCKER = {
    "nodes": {"A": [0, 0], "B": [3.7, 1.5], "C": [5.2, 2.4], "D": [4, 0]},
    "ground": ["A", "D"],
    "links": {
        "left": {"nodes": ["A", "B"], "length": 4},
        "coupler": {"nodes": ["B", "C"], "length": 1.5},
        "right": {"nodes": ["D", "C"], "length": 2},
    },
    "trace": ["C"],
}


def double_rocker(low: float, high: float, **nodes: list[float]) -> gimcli.Mechanism:
    """Return the mechanism of the manual: its input turns back at 51.9 deg, where coupler and right are in line."""
    motor = {"type": "rotary", "pivot": "A", "arm": "B", "law": {"from": low, "to": high}}
    data = {**DOUBLE_ROCKER, "actuators": {"motor": motor}}
    return gimcli.load({**data, "nodes": {**DOUBLE_ROCKER["nodes"], **nodes}})


def coupler_point(theta: float, side: float) -> complex:
    """Return P of the crank-rocker in closed form: B is an intersection of circles about A and O4."""
    a, o4 = 40.0 * cmath.exp(1j * theta), 100.0 + 0j
    span = o4 - a
    along = (abs(span) ** 2 + 120.0**2 - 80.0**2) / (2.0 * abs(span))
    b = a + span / abs(span) * (along + 1j * side * math.sqrt(120.0**2 - along**2))
    return a + (60.0 + 40.0j) * (b - a) / abs(b - a)


@pytest.mark.parametrize(("options", "sides"), [((), [1.0]), (("--assembly", "1"), [-1.0]), (("--all",), [1.0, -1.0])])
def test_the_crank_rocker_has_one_circuit_for_each_side(
    options: tuple[str, ...], sides: list[float], tmp_path: Any
) -> None:
    table = tmp_path / "paths.csv"
    report = gim("workspace", MODELS / "crank_rocker.yaml", *options, "--json", "-o", table).json
    assert report["complete"] is True
    assert len(report["paths"]) == len(sides)
    every = "--all" in options
    assert report["all"] is every
    counted = {"at": {"motor": 0.0}, "count": 2, "left_out": 1, "complete": True}
    assert report["assemblies"] == (None if every else counted)
    for row in read_rows(table):
        exact = coupler_point(math.radians(float(row["motor"])), sides[int(row["path"])])
        assert abs(complex(float(row["x"]), float(row["y"])) - exact) < 1e-9


def test_the_report_counts_the_assemblies_that_are_left_out(tmp_path: Any) -> None:
    text = ran("workspace", MODELS / "watt_1.yaml", "--no-png", cwd=tmp_path).text
    assert "3 of 4 assemblies" in text
    assert len(gim("solve", MODELS / "watt_1.yaml", "--all", "--json").json["configurations"]) == 4


def test_the_path_passes_through_a_limit_to_the_other_branch() -> None:
    """From 20 deg to the limit and back: both configurations at 20 deg are on one path."""
    found = gimcli.workspace(double_rocker(20, 200), "C").report()
    (path,) = found["paths"]
    limit = math.degrees(math.acos((16 + 16 - 3.5**2) / 32))
    assert path["inputs"]["motor"]["to"] == pytest.approx(limit, abs=1e-9)
    assert path["inputs"]["motor"]["turns_back_at"] == pytest.approx([limit], abs=1e-9)
    assert found["assemblies"]["left_out"] == 0
    assert found["complete"]


def test_a_range_that_ends_before_the_limit_leaves_the_other_branch_out() -> None:
    """Both branches belong to the same circuit, but the input would have to leave its range."""
    mechanism = double_rocker(20, 50)
    (own,) = gimcli.workspace(mechanism, "C").report()["paths"]
    both = gimcli.workspace(mechanism, "C", every=True).report()["paths"]
    assert len(both) == 2
    assert own["length"] == pytest.approx(both[0]["length"], rel=1e-7)
    start = gimcli.solve(mechanism).xy["C"]
    assert own["bounds"]["x"][0] - 1e-9 <= start[0] <= own["bounds"]["x"][1] + 1e-9
    (other,) = gimcli.workspace(gimcli.assembled(mechanism, assembly=1), "C").report()["paths"]
    lengths = sorted(path["length"] for path in both)
    assert sorted([own["length"], other["length"]]) == pytest.approx(lengths, rel=1e-7)


@pytest.mark.parametrize(("law", "count", "left"), [({"from": 5, "to": 365}, 2, 0), ({"from": 5, "to": 170}, 1, 1)])
def test_paths_that_cross_at_change_points_are_kept(law: dict[str, float], count: int, left: int) -> None:
    """The change points of a parallelogram are at 0 and 180 deg: both curves if the range contains one, else one."""
    data = read_source(MODELS / "parallelogram.yaml").data
    data["actuators"]["motor"]["law"] = law
    report = gimcli.workspace(gimcli.load(data)).report()
    assert [path["drawn"] for path in report["paths"]] == [True, False][:count]
    assert (report["assemblies"]["count"], report["assemblies"]["left_out"]) == (2, left)
    assert report["complete"]


def test_one_cylinder_of_an_excavator_moves_the_tip_on_one_arc() -> None:
    """The other cylinders are constant, so the tip turns about C; the mirrored cylinders are not reached."""
    data = read_source(MODELS / "excavator.yaml").data
    for name, length in (("arm_ram", 145), ("bucket_ram", 125)):
        data["actuators"][name]["law"] = {"from": length, "to": length}
    mechanism = gimcli.load(data)
    found = gimcli.workspace(mechanism, "tip")
    report = found.report()
    (path,) = report["paths"]
    assert (report["assemblies"]["count"], report["assemblies"]["left_out"]) == (16, 15)
    radius = math.hypot(*gimcli.solve(mechanism).xy["tip"])
    np.testing.assert_allclose(np.hypot(found["x"], found["y"]), radius, rtol=1e-9)

    def boom(ram: float) -> float:  # the angle at C of the triangle of the cylinder, by the law of cosines
        c, d = math.hypot(98.34221426109427, 135.96193913821995), math.hypot(47.4, 23.7)
        return math.acos((c**2 + d**2 - ram**2) / (2 * c * d))

    assert path["length"] == pytest.approx(radius * (boom(185) - boom(140)), rel=1e-8)


def test_a_drawing_that_cannot_be_assembled_takes_the_nearest_path() -> None:
    """The start of the law, 60 deg, and the drawn input, 7.1 deg, are both out of reach."""
    mechanism = double_rocker(60, 20, B=[4, 0.5])
    report = gimcli.workspace(mechanism, "C").report()
    (path,) = report["paths"]
    assert path["drawn"]
    assert path["inputs"]["motor"]["from"] == pytest.approx(20, abs=1e-9)
    assert report["assemblies"]["count"] == 2


def test_a_circuit_outside_the_range_is_an_error_that_names_the_option() -> None:
    """Drawn below the frame, at -30 deg; the law is on the mirrored circuit and its start is out of reach."""
    mechanism = double_rocker(100, 20, B=[3.5, -2.0], C=[4.9, -1.8])
    report = gimcli.workspace(mechanism, "C", every=True).report()
    assert len(report["paths"]) == 1
    with pytest.raises(UnassembledError):
        gimcli.workspace(mechanism, "C")


def test_paths_that_were_not_followed_to_their_end_are_reported(monkeypatch: Any, tmp_path: Any) -> None:
    followed = circuit_paths.all_circuits
    monkeypatch.setattr(circuit_paths, "all_circuits", lambda *given: replace(followed(*given), complete=False))
    done = ran("workspace", MODELS / "crank_rocker.yaml", "--no-png", cwd=tmp_path)
    assert done.code == 5
    assert "was not followed to its end" in done.text


def test_groups_of_many_loops_are_not_counted(monkeypatch: Any, tmp_path: Any) -> None:
    monkeypatch.setattr(circuit_paths, "LOOPS", 1)
    text = gim("workspace", MODELS / "gim_fig13c.yaml", "-o", tmp_path / "paths.json").text
    assert "were not counted" in text
    report = json.loads((tmp_path / "paths.json").read_text())
    assert report["assemblies"]["count"] is None
    assert report["assemblies"]["left_out"] is None
