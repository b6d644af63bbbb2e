"""Exact derivatives of goals and conditions of a fit: differences of designs; fits of forces: closed forms."""

import numpy as np
import pytest
from bundled import MODELS
from scipy.optimize import brentq

import gimcli
from gimcli.families.family import Family
from gimcli.fitting.conditions import DesignQuantities
from gimcli.quantities.state import ApartError

CASES = {
    "pump_jack": (["crank.length", "pitman.length", "crank.mass", "beam.centre.x"], [
        "max(abs(crank_angle.effort))", "rms(crank_angle.effort)", "integral(crank_angle.effort)", "max(|O.f|)",
        "min(O.fy)", "max(power.drive)", "mean(energy.kinetic)", "range(H.y) - 2*crank.length", "range(beam.angle)",
        "max(|H.v|)", "at(H.y, crank_angle=133)", "at(crank_angle.effort, crank_angle=133)", "max(beam.alpha)",
    ]),
    "engine": (["crank.length", "duration", "rod.mass", "rod.length"], [
        "max(abs(crank_angle.effort))", "max(B.vx)", "rms(O.fx)", "mean(power.drive)", "last(time)",
        "max(cylinder.normal)",
    ]),
    "toggle_clamp": (["opener.stiffness", "opener.free", "grease.damping", "handle.length"], [
        "max(abs(hand.effort))", "range(energy.potential)", "rms(P.fx)", "max(power.spring)",
    ]),
    "suspension": (["coil.stiffness", "coil.free", "S.x"], ["max(abs(wheel.effort))", "max(|B.f|)"]),
    "excavator": (["C.x", "boom.mass", "boom_ram.to"], [
        "max(abs(boom_ram.effort))", "max(|tip.v|)", "range(boom.angle)", "rms(boom_ram)", "max(boom_ram.effort)",
    ]),
    "jansen": (["m", "j"], ["range(foot.x)", "max(foot.vy)", "mean(foot.ax)", "rms(foot.y)", "min(transmission)"]),
}  # fmt: skip


def by_differences(asked, expressions, design):
    """Return the derivatives (expressions, dimensions) by central differences with one Richardson step."""
    h = np.diag(1e-4 * np.maximum(np.abs(design), 0.01))
    wide, narrow = (
        (asked.numbers(expressions, design + s * h) - asked.numbers(expressions, design - s * h))
        / (2.0 * s * np.diag(h))[:, None]
        for s in (1.0, 0.5)
    )
    return ((4.0 * narrow - wide) / 3.0).T


@pytest.mark.parametrize("name", CASES)
def test_derivatives_of_goals_are_those_of_differences(name):
    dimensions, goals = CASES[name]
    family = Family(gimcli.load(MODELS / f"{name}.yaml"), dimensions)
    for goal in goals:
        asked = DesignQuantities(family, goal=goal)
        found, wanted = (
            asked.slopes(asked.goals, family.nominal)[0],
            by_differences(asked, asked.goals, family.nominal)[0],
        )
        size = abs(asked.numbers(asked.goals, family.nominal[None])[0, 0]) / np.maximum(np.abs(family.nominal), 1e-2)
        assert np.all(np.abs(found - wanted) <= 1e-7 * (np.abs(wanted) + size)), (goal, found, wanted)


def test_derivatives_of_conditions_are_those_of_differences():
    family = Family(gimcli.load(MODELS / "pump_jack.yaml"), ["crank.length", "crank.mass"])
    asked = DesignQuantities(
        family, ["max(abs(crank_angle.effort)) < 30000", "range(H.y) >= crank.length", "solved == 361"]
    )
    assert len(asked.margins) == 2  # an equation has no margin
    found, wanted = asked.slopes(asked.margins, family.nominal), by_differences(asked, asked.margins, family.nominal)
    assert found == pytest.approx(wanted, rel=1e-7, abs=1e-9)


def test_quantities_without_exact_derivatives_say_so():
    """Measures along the path, dry friction, redundant constraints: with these one dimension alone cannot change."""
    for name, dimension, goal in (
        ("crank_rocker", "coupler.length", "max(curvature:P)"),
        ("crank_press", "crank.length", "max(crank_angle.effort)"),
        ("parallelogram_third_crank", "left.length", "range(left.angle)"),
    ):  # fmt: skip
        family = Family(gimcli.load(MODELS / f"{name}.yaml"), [dimension])
        asked = DesignQuantities(family, goal=goal)
        with pytest.raises(ApartError):
            asked.slopes(asked.goals, family.nominal)


PRESS = {
    "units": {"length": "mm"}, "nodes": {"O": [0, 0], "A": [20, 0], "B": [120, 0], "G": [200, 0]}, "ground": ["O", "G"],
    "links": {"crank": {"nodes": ["O", "A"], "length": 20}, "rod": {"nodes": ["A", "B"], "length": 100}},
    "prismatic": {"slide": {"node": "B", "guide": ["O", "G"]}}, "loads": {"push": {"on": "B", "force": [-100, 0]}},
    "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"by": 360}}},
}  # fmt: skip


def peak(r, rod=100.0):
    """Return the greatest torque [N m] of 100 N on the piston, F r (s + r s c / sqrt(l^2 - r^2 s^2))."""
    t = np.radians(np.arange(361.0))
    return 0.1 * r * np.max(np.sin(t) + r * np.sin(t) * np.cos(t) / np.sqrt(rod**2 - (r * np.sin(t)) ** 2))


def test_longest_stroke_with_a_bound_of_the_torque():
    found = gimcli.fit(
        PRESS, {"crank.length": (5, 60)}, goal="-range(B.x)", where="max(abs(motor.effort)) < 3", starts=50
    )
    assert found.dimensions["crank.length"] == pytest.approx(brentq(lambda r: peak(r) - 3.0, 5.0, 60.0), rel=1e-6)


def test_least_torque_with_a_bound_of_the_stroke():
    vary = {"crank.length": (10, 60), "rod.length": (80, 150)}
    found = gimcli.fit(PRESS, vary, goal="max(abs(motor.effort))", where="range(B.x) > 50", starts=50)
    assert found.dimensions["crank.length"] == pytest.approx(25.0, rel=1e-6)  # a stroke is twice the crank
    assert found.dimensions["rod.length"] == pytest.approx(150.0)  # a longer rod leaves less
    assert found.error == pytest.approx(peak(25.0, 150.0), rel=1e-6)


def test_a_goal_without_exact_derivatives_is_fitted_by_differences():
    """The path of the crank pin is a circle, with the crank as radius. A measure along the path has no derivatives."""
    found = gimcli.fit(PRESS, {"crank.length": (5, 60)}, goal="(max(curvature:A) - 20)**2", starts=10)
    assert found.dimensions["crank.length"] == pytest.approx(20.0, rel=1e-4)
