"""Directions of members as columns and as a measure: full turns are counted, also in pieces and over coarse steps."""

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim, read_rows

import gimcli
import gimcli.library.trace

GROUND, CRANK, COUPLER, FOLLOWER = 1.0, 3.0, 2.5, 2.5
"""A drag link: the frame is the shortest link (1 + 3 < 2.5 + 2.5), so that all other links make full turns."""


def drag_link(turns):
    start = end_of_arm(0.0)
    return gimcli.load(
        {
            "nodes": {"O": [0, 0], "D": [GROUND, 0], "A": [CRANK, 0], "B": [start.real, start.imag]},
            "ground": ["O", "D"],
            "links": {"crank": ["O", "A"], "rod": ["A", "B"], "arm": ["D", "B"]},
            "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"by": 360 * turns}}},
            "trace": ["B"],
        }
    )


def end_of_arm(crank):
    """The end of the follower by the law of cosines in the triangle A, D, B, on the left of A -> D."""
    a = CRANK * np.exp(1j * crank)
    far = GROUND - a
    at_a = np.arccos((np.abs(far) ** 2 + COUPLER**2 - FOLLOWER**2) / (2.0 * np.abs(far) * COUPLER))
    return a + COUPLER * far / np.abs(far) * np.exp(1j * at_a)


def closed_form(turns, steps):
    """Directions of crank, rod and arm [deg]; the turns are counted over 1000 positions for each turn of the crank."""
    each = 1000 * turns
    crank = np.linspace(0.0, 2.0 * np.pi * turns, each * steps + 1)
    b = end_of_arm(crank)
    rod, arm = (np.unwrap(np.angle(z)) for z in (b - CRANK * np.exp(1j * crank), b - GROUND))
    return [np.degrees(angle[::each]) for angle in (crank, rod, arm)]


@pytest.mark.parametrize("steps", [4, 20, 300])
def test_turns_are_counted_across_the_pieces_of_a_motion(steps, monkeypatch):
    """Three turns in pieces of 3 rows: steps of 270 and 54 deg, which need rows between, and of 3.6 deg."""
    monkeypatch.setattr(gimcli.library.trace, "PIECE", 3)
    found = gimcli.trace(drag_link(3), steps, derivatives=1, measure=["angle:rod/crank", "angle:arm"])
    crank, rod, arm = closed_form(3, steps)
    for name, expected in (("crank", crank), ("rod", rod), ("arm", arm)):
        np.testing.assert_allclose(found[f"{name}.angle"], expected, atol=1e-9)
        np.testing.assert_array_equal(found[f"{name}.angle"], found.angle[name])
    assert found["arm.angle"][-1] - found["arm.angle"][0] == pytest.approx(1080.0)
    np.testing.assert_allclose(found["angle:rod/crank"], rod - crank, atol=1e-9)
    np.testing.assert_array_equal(found["angle:arm"], found["arm.angle"])


def test_the_written_angles_are_those_of_the_result(tmp_path, monkeypatch):
    monkeypatch.setattr(gimcli.library.trace, "PIECE", 3)
    gim("trace", MODELS / "crank_rocker.yaml", "-n", 20, "-d", 1, "-o", tmp_path / "m.csv")
    rows = read_rows(tmp_path / "m.csv")
    found = gimcli.trace(gimcli.load(MODELS / "crank_rocker.yaml"), 20)
    for name in ("crank", "coupler", "rocker"):
        assert [float(row[f"{name}.angle"]) for row in rows] == found.angle[name].tolist()
    assert list(rows[0]).index("rocker.angle") + 1 == list(rows[0]).index("rocker.omega")


def test_an_angle_relative_to_another_member_starts_within_half_a_turn():
    """-170 - 170 deg is +20 deg; with the frame it is the direction itself."""
    first, second = np.exp(1j * np.radians([-170.0, 170.0]))
    m = gimcli.load(
        {
            "nodes": {"O": [0, 0], "A": [first.real, first.imag], "P": [5, 0], "B": [5 + second.real, second.imag]},
            "ground": ["O", "P"],
            "links": {"one": ["O", "A"], "two": ["P", "B"]},
            "actuators": {
                "m1": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"by": 720}},
                "m2": {"type": "rotary", "pivot": "P", "arm": "B", "law": {"by": 90}},
            },
        }
    )
    t = gimcli.trace(m, 8, measure=["angle:one/two", "angle:one/frame", "angle:frame/two"])
    np.testing.assert_allclose(t["angle:one/two"], 20.0 + 630.0 * np.arange(9) / 8, atol=1e-9)
    np.testing.assert_allclose(t["angle:one/frame"], -170.0 + 90.0 * np.arange(9), atol=1e-9)
    np.testing.assert_allclose(t["angle:frame/two"], -170.0 - 90.0 * np.arange(9) / 8, atol=1e-9)


def test_angles_of_circuits_and_of_reversed_inputs_are_counted():
    """Along the circuit of a crank-rocker the crank turns once; where the input reverses, its angle does too."""
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    turned = gimcli.trace(m, 3, circuit=True, measure="angle:crank")["angle:crank"]
    assert abs(turned[-1] - turned[0]) == pytest.approx(360.0, abs=1e-8)
    back = gimcli.trace(gimcli.load(MODELS / "chebyshev.yaml"), 30, at_limit="reverse", measure="angle:left")
    np.testing.assert_array_equal(back["angle:left"], back.angle["left"])


def test_an_angle_is_empty_where_a_row_is_not_solved():
    t = gimcli.trace(gimcli.load(MODELS / "gim_fig13c.yaml"), 9, method="gim", measure="angle:QU")
    bad = np.array([word != "ok" for word in t.status])
    assert bad.any()
    assert np.isnan(t["angle:QU"][bad]).all()
    assert np.isfinite(t["angle:QU"][~bad]).all()
