"""Forces of designs that are computed together equal those of each changed model."""

import math

import numpy as np
import pytest
from bundled import MODELS

import gimcli
from gimcli.errors import GimError
from gimcli.families.family import Family
from gimcli.model.dimensions import dimensions

STEPS = 24

TOGETHER = (
    "balanced_lamp", "double_pendulum", "engine", "excavator", "garage_door", "hatch", "knuckle_press", "lift_table",
    "pick_and_place", "pump_jack", "punch", "shaper", "snap_hinge", "strandbeest", "suspension", "swing",
    "toggle_clamp", "watt_1", "watt_durango", "wiper",
)  # fmt: skip
"""Models with masses, springs, dampers, loads over the time and over an input, rotors, several inputs, guides."""

SINGLY = ("crank_press", "planetary_gear", "rack_lift", "spring_block")
"""Models with dry friction, gears or redundant constraints: each design is computed by itself."""


AWAY = {"from", "to", "start", "effort", "polynomial", "teeth"}
"""Parts of the names of dimensions that cannot change alone or a little, or have the name of a column."""


def designs(name, seed):
    """Return a model and values near its own of some of its dimensions (3 designs)."""
    m, generator = gimcli.load(MODELS / f"{name}.yaml"), np.random.default_rng(seed)
    own = [d for d in dimensions(m) if d.given and not d.formula and AWAY.isdisjoint(d.name.split("."))]
    chosen = [own[k] for k in sorted(generator.permutation(len(own))[:12])]
    changes = 1.0 + 1e-3 * generator.uniform(-1.0, 1.0, (3, len(chosen)))
    return m, [{d.name: d.value * x for d, x in zip(chosen, row, strict=True)} for row in changes]


def names_of(m):
    """Return all columns of `gim forces` that are forces, moments, powers or energies."""
    table = gimcli.forces(m, STEPS).table()
    known = ("time", "residual", "power.error", *(a.name for a in m.actuators))
    return [c.name for c in table.columns if c.values.dtype.kind == "f" and c.name not in known]


@pytest.mark.parametrize("name", TOGETHER + SINGLY)
def test_forces_of_designs_are_those_of_each_changed_model(name):
    m, chosen = designs(name, 1)
    names = names_of(m)
    assert (Family(m, list(chosen[0])).forces is not None) == (name in TOGETHER)
    found = gimcli.sweep(m, chosen, steps=STEPS, keep=names, rows=True)
    for k, design in enumerate(chosen):
        f = gimcli.forces(m.with_(design), STEPS)
        for column in names:
            wanted = np.asarray(f[column], dtype=float)
            size = np.nanmax(np.abs(wanted), initial=1e-6)
            assert found.curves[column][k] == pytest.approx(wanted, abs=1e-10 * size, nan_ok=True), (column, k)


def test_friction_acts_along_the_guide_of_each_design():
    """The guide of the engine's piston is on the ground, and its direction is a number of the design."""
    heights, effort = [0.0, 1.0, 2.0], "crank_angle.effort"
    found = gimcli.sweep("engine", {"H.y": heights}, steps=STEPS, keep=[effort], rows=True)
    for own, height in zip(found.curves[effort], heights, strict=True):
        alone = gimcli.forces(gimcli.load("engine").with_({"H.y": height}), STEPS)[effort]
        assert own == pytest.approx(alone, rel=1e-10)


@pytest.mark.parametrize("name", TOGETHER)
def test_power_of_all_forces_of_designs_is_the_rate_of_the_kinetic_energy(name):
    m, chosen = designs(name, 2)
    powers = ["drive", "load", "gravity", "spring", "damping", "error"]
    found = gimcli.sweep(m, chosen, steps=STEPS, keep=[f"max(abs(power.{word}))" for word in powers])
    *parts, error = (found[f"max(abs(power.{word}))"] for word in powers)
    size = np.nanmax(parts, initial=0.0)
    assert np.nanmax(error) <= 1e-9 * size


def test_forces_are_undetermined_in_the_same_rows():
    """A slider-crank that is driven by its slider has a dead point where rod and crank are in line."""
    m = gimcli.load({
        "units": {"length": "m"}, "nodes": {"O": [0, 0], "A": [0, 1], "B": [2, 0], "G": [4, 0]}, "ground": ["O", "G"],
        "links": {"crank": {"nodes": ["O", "A"], "length": 1}, "rod": {"nodes": ["A", "B"], "length": 2}},
        "prismatic": {"guide": {"node": "B", "guide": ["O", "G"]}},
        "actuators": {"push": {"node": "B", "guide": ["O", "G"], "law": {"from": 2, "to": 3}}},
        "masses": {"crank": {"mass": 1, "inertia": 1}, "rod": {"mass": 2, "inertia": 1}},
    })  # fmt: skip
    found = gimcli.sweep(m, {"rod.length": [1.9, 2.0, 2.1], "crank.mass": [1.0, 2.0]}, steps=10, keep="A.fx", rows=True)
    for k in range(6):
        own = {name: float(found[name][11 * k]) for name in ("rod.length", "crank.mass")}
        f = gimcli.forces(m.with_(own), 10)
        assert found.curves["A.fx"][k] == pytest.approx(np.asarray(f["A.fx"], dtype=float), rel=1e-9, nan_ok=True)
    assert 0 < np.isnan(found.curves["A.fx"]).sum() < found.curves["A.fx"].size


def test_designs_that_a_file_may_not_give_have_no_forces():
    m = gimcli.load(MODELS / "watt_durango.yaml")
    masses = np.linspace(-0.5, 1.5, 401)  # so many that their positions are solved together
    found = gimcli.sweep(m, {"crank.mass": masses.tolist()}, steps=4, keep="max(abs(O2.fy))")["max(abs(O2.fy))"]
    assert np.array_equal(np.isnan(found), masses < 0.0)
    for k in (100, 400):
        f = gimcli.forces(m.with_({"crank.mass": float(masses[k])}), 4)
        assert found[k] == pytest.approx(np.max(np.abs(f["O2.fy"])), rel=1e-10)


def test_effort_of_a_crank_with_a_mass_has_the_derivatives_of_the_closed_form():
    """m g r cos(theta) at constant speed: by m, r and theta, of a mass at the end."""
    model = {
        "units": {"length": "m"}, "nodes": {"O": [0, 0], "A": [0.5, 0]}, "ground": ["O"],
        "links": {"crank": ["O", "A"]},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"by": 360, "rate": 60}}},
        "gravity": [0, -9.81], "masses": {"A": 3},
    }  # fmt: skip
    m = gimcli.load(model)
    found = gimcli.sensitivity(m, of="motor.effort", by=["A.mass", "A.x", "motor"], motor=40.0)
    theta = math.radians(40.0)
    assert found.value["motor.effort"] == pytest.approx(3 * 9.81 * 0.5 * math.cos(theta), rel=1e-12)
    derivatives = found.derivatives["motor.effort"]
    assert derivatives["A.mass"] == pytest.approx(9.81 * 0.5 * math.cos(theta), rel=1e-12)
    assert derivatives["A.x"] == pytest.approx(3 * 9.81 * math.cos(theta), rel=1e-12)
    assert derivatives["motor"] == pytest.approx(-3 * 9.81 * 0.5 * math.sin(theta) * math.pi / 180.0, rel=1e-12)


def test_forces_that_depend_on_more_than_one_design_have_no_derivatives():
    with pytest.raises(GimError, match=r"of 'crank_angle.effort': forces have exact derivatives without dry friction"):
        gimcli.sensitivity(gimcli.load(MODELS / "crank_press.yaml"), of="crank_angle.effort")
