"""Forces of designs that are computed together equal those of each changed model."""

import math

import numpy as np
import pytest
from bundled import MODELS
from random_mechanisms import Growth

import gimcli
from gimcli.errors import GimError
from gimcli.families.family import Family

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
    own = [d for d in m.written.dimensions.values() if d.given and not d.formula and AWAY.isdisjoint(d.name.split("."))]
    chosen = [own[k] for k in sorted(generator.permutation(len(own))[:12])]
    changes = 1.0 + 1e-3 * generator.uniform(-1.0, 1.0, (3, len(chosen)))
    return m, [{d.name: d.value * x for d, x in zip(chosen, row, strict=True)} for row in changes]


def names_of(m):
    """Return all columns of `gim forces` that are forces, moments, powers or energies."""
    table = gimcli.forces(m, STEPS).table()
    known = ("time", "residual", "power.error", *(a.name for a in m.actuators))
    return [c.name for c in table.columns if c.values.dtype.kind == "f" and c.name not in known]


@pytest.mark.few(12)
@pytest.mark.parametrize("name", TOGETHER + SINGLY)
def test_forces_of_designs_are_those_of_each_changed_model(name):
    m, (*chosen, _) = designs(name, 1)
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


@pytest.mark.few
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


SLIDER_CRANK = {
    "units": {"length": "m"}, "nodes": {"O": [0, 0], "A": [0.3, 0.4], "B": [1.9, 0], "G": [4, 0]}, "ground": ["O", "G"],
    "links": {"crank": {"nodes": ["O", "A"], "length": 0.5}, "rod": {"nodes": ["A", "B"], "length": 1.6}},
    "prismatic": {"guide": {"node": "B", "guide": ["O", "G"]}},
    "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"from": 30, "by": 360}}},
    "loads": {"push": {"on": "B", "force": [-100, 0]}}, "masses": {"crank": {"mass": 0, "inertia": 0}},
}  # fmt: skip


def torque(r, theta, rod=1.6, force=100.0):
    """Return the torque that holds a piston force, F r (sin t + r sin t cos t / sqrt(l^2 - r^2 sin^2 t)), and dT/dr."""
    s, c = np.sin(theta), np.cos(theta)
    q = np.sqrt(rod**2 - (r * s) ** 2)
    first = -force * (r * s + r**2 * s * c / q)
    return -first, force * (s + 2.0 * r * s * c / q + r**3 * s**3 * c / q**3)


def test_holding_torque_of_a_slider_crank_has_the_derivative_of_its_closed_form():
    m = gimcli.load(SLIDER_CRANK)
    found = gimcli.sensitivity(m, of="motor.effort", by=["crank.length", "rod.length"], steps=12)
    theta = np.radians(np.asarray(gimcli.trace(m, 12)["motor"]))
    value, slope = torque(0.5, theta)
    assert np.abs(found.value["motor.effort"]) == pytest.approx(np.abs(value), abs=1e-10)
    sense = np.sign(np.dot(found.value["motor.effort"], value))
    own = found.derivatives["motor.effort"]
    assert own["crank.length"] * sense == pytest.approx(slope, abs=1e-10)
    s, c = np.sin(theta), np.cos(theta)
    by_rod = -100.0 * 0.25 * s * c * 1.6 / (1.6**2 - (0.5 * s) ** 2) ** 1.5
    assert own["rod.length"] * sense == pytest.approx(by_rod, abs=1e-10)


def compare(m, chosen, names, limit=1e-7):
    """Compare derivatives with central differences and one Richardson step; return how many dimensions were compared.

    Dimensions that change the inputs or the time are left out: derivatives are at constant inputs.
    """
    found, compared = gimcli.sensitivity(m, of=names, by=chosen, samples=0, steps=6), 0
    own, inputs = {d.name: d.value for d in m.written.dimensions.values()}, ["time", *(a.name for a in m.actuators)]
    for name in chosen:
        h = 3e-4 * max(abs(own[name]), 0.1)
        rows = [{name: own[name] + x} for x in (h, -h, h / 2, -h / 2)]
        try:
            curves = [gimcli.sweep(m, row, steps=6, keep=[*names, *inputs], rows=True).curves for row in rows]
        except GimError:
            continue
        if any(np.abs(curves[0][a] - curves[1][a]).max() > 1e-12 * np.abs(curves[0][a]).max() for a in inputs):
            continue
        compared += 1
        for text in names:
            wide, narrow = ((curves[k][text][0] - curves[k + 1][text][0]) / step for k, step in ((0, 2 * h), (2, h)))
            wanted, got = (4.0 * narrow - wide) / 3.0, np.asarray(found.derivatives[text][name])
            size = np.nanmax(np.abs(found.value[text]), initial=0.0) / (3e3 * h) + np.nanmax(
                np.abs(wanted), initial=0.0
            )
            assert np.array_equal(np.isnan(got), np.isnan(wanted)), (text, name)
            away = np.abs(got - wanted) - 0.05 * np.abs(narrow - wide)  # less what the last step may leave
            assert np.nanmax(away, initial=0.0) <= limit * size, (text, name)
    return compared


@pytest.mark.parametrize("name", TOGETHER)
@pytest.mark.few("engine", "pump_jack")
def test_derivatives_of_forces_are_those_of_differences(name):
    m, chosen = designs(name, 3)
    names = [text for text in names_of(m) if not text.endswith(".error")]
    assert compare(m, list(chosen[0])[:5], names)


@pytest.mark.few(3)
@pytest.mark.parametrize(("kind", "drive", "seed"), [
    ("rrr", "crank", 8), ("rrp", "distance", 6), ("rpr", "travel", 3), ("prp", "crank", 2), ("triad", "crank", 4),
    ("true_pair", "distance", 1), ("nary", "elsewhere", 3),
])  # fmt: skip
def test_derivatives_of_forces_of_random_mechanisms_are_those_of_differences(kind, drive, seed):
    grown = Growth(seed, [kind, kind], None if drive == "crank" else drive)
    data, last = grown.explicit(0.0), list(grown.nodes)[-1]
    ends = [next(n for n in grown.ground if not grown.at[n] & grown.at[last]), last]
    data |= {"units": {"length": "m"}, "gravity": [0, -9.81]}
    data["masses"] = {b: {"mass": 2.0, "inertia": 0.3} for b in (*data["links"], *data["elements"])}
    data["springs"] = {"coil": {"nodes": ends, "stiffness": 50, "free": 0.7}}
    data["dampers"] = {"oil": {"nodes": ends, "damping": 3}}
    m, spread = gimcli.load(data), np.random.default_rng(seed)
    own = [d.name for d in m.written.dimensions.values() if d.given and AWAY.isdisjoint(d.name.split("."))]
    chosen = spread.choice(own, 8, replace=False).tolist()
    names = [text for text in names_of(m) if not text.endswith(".error")]
    assert compare(m, chosen, names, 1e-6) > 3


def test_a_spring_of_free_length_0_has_the_force_and_the_derivative_of_other_free_lengths():
    """Its force is -k (|a - b| - free) u: k u more for each length."""
    m = gimcli.load("balanced_lamp")
    lengths = [1.0, 2.0]
    found = gimcli.sweep(m, {"lower.free": lengths}, keep="shoulder.effort", rows=True, steps=4).curves
    for own, length in zip(found["shoulder.effort"], lengths, strict=True):
        alone = gimcli.forces(m.with_({"lower.free": length}), 4)["shoulder.effort"]
        assert own == pytest.approx(np.asarray(alone, dtype=float), abs=1e-10)
    slope = gimcli.sensitivity(m, of="shoulder.effort", by="lower.free", steps=4).derivatives["shoulder.effort"]
    base = np.asarray(gimcli.forces(m, 4)["shoulder.effort"], dtype=float)
    assert slope["lower.free"] == pytest.approx(found["shoulder.effort"][0] - base, abs=1e-10)  # linear
