"""Derivatives of positions by dimensions and inputs: closed forms, differences, velocities, singular positions."""

import numpy as np
import pytest
import yaml
from bundled import MODELS
from changed_numbers import differences, read
from four_bars import four_bar_text

from gimcli import load
from gimcli.families.family import Family
from gimcli.kernels import jit
from gimcli.motion.motion import trace
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options
from gimcli.rates.derivatives import rates_of_inputs

LENGTHS = ["crank.length", "coupler.length", "follower.length"]

BY_B = {  # references/families.md, section 4: dt3/dp and dt4/dp of a, b, c, d and t2
    "a": (-0.01419934006980844, -0.1206967863242586),
    "b": (-0.2636714500970821, -0.2332436083100963),
    "c": (0.2998846392558381, 0.2050777945199527),
    "d": (-0.1374771537472253, 0.004733113356602814),
    "t2": (-0.5990965718586148, -0.3991734790213894),
}


def derivatives(model, names, steps, run=plain):
    """Return mechanism, positions and their derivatives by dimensions of a model and by its inputs."""
    mechanism = load(model)
    motion, family = trace(mechanism, steps, Options(tolerance=1e-13)), Family(mechanism, names)
    found, good = family.slopes(family.nominal[None], motion.z[None], motion.inputs[None], run)
    return mechanism, motion, found[0], good[0]


def four_bar(crank, angle, law):
    return yaml.safe_load(four_bar_text(crank, 7.0, 9.0, 6.0, np.radians(angle), law=law))


def test_angles_of_a_four_bar_have_the_derivatives_of_the_closed_form():
    model = four_bar(2.0, 30, law=", law: {from: 30, to: 60}")
    mechanism, motion, found, _ = derivatives(model, [*LENGTHS, "O4.x"], 1)
    a, b, o4 = (mechanism.nodes.index(name) for name in ("A", "B", "O4"))
    for slope, wanted in zip(found[:, :, 0], BY_B.values(), strict=True):
        for (u, v), angle in zip(((a, b), (o4, b)), wanted, strict=True):
            arm, change = motion.z[v, 0] - motion.z[u, 0], slope[v] - slope[u]
            assert (change / arm).imag == pytest.approx(angle, abs=1e-10)


def test_slider_crank_has_the_derivatives_of_the_closed_form():
    """r, l, e = 40, 120, 20 at 60 degrees (references/families.md, section 4)."""
    r, l, e, t = 40.0, 120.0, 20.0, np.radians(60.0)
    pin = r * np.exp(1j * t)
    s = np.sqrt(l**2 - (pin.imag - e) ** 2)
    model = {
        "nodes": {
            "O": [0, 0],
            "A": [float(pin.real), float(pin.imag)],
            "B": [float(pin.real + s), e],
            "G": [0, e],
            "H": [200, e],
        },
        "ground": ["O", "G", "H"],
        "links": {"crank": {"nodes": ["O", "A"], "length": r}, "rod": {"nodes": ["A", "B"], "length": l}},
        "prismatic": {"slide": {"node": "B", "guide": ["G", "H"]}},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"from": 60, "to": 90}}},
    }
    mechanism, _, found, _ = derivatives(model, ["crank.length", "rod.length"], 1)
    slopes = found[:, mechanism.nodes.index("B"), 0].real * mechanism.scale
    assert slopes == pytest.approx([0.3935422276034437, 1.007527175682216, -37.09955309339673], abs=1e-9)


@pytest.mark.parametrize("name", ["crank_rocker", "jansen", "platform_3rrr", "scotch_yoke", "gim_fig13c"])
@pytest.mark.few(3)
def test_derivatives_agree_with_differences_of_positions(name):
    model = read(MODELS / f"{name}.yaml")
    paths = {f"{link}.length": ("links", link, "length") for link, one in model["links"].items() if "length" in one}
    paths |= {
        f"{element}.shape.{node}.{'xy'[k]}": ("elements", element, "shape", node, k)
        for element, one in model.get("elements", {}).items() for node in one.get("shape", {}) for k in (0, 1)
    }  # fmt: skip
    chosen = list(paths)[:6]
    _, _, found, good = derivatives(model, chosen, 8)
    assert good.all()
    for k, name in enumerate(chosen):
        assert found[k] == pytest.approx(differences(model, paths[name], 8), abs=1e-9)


@pytest.mark.parametrize("name", ["five_bar", "platform_3rpr", "excavator", "whitworth"])
@pytest.mark.few(2)
def test_derivatives_by_inputs_are_velocities_at_unit_rate(name):
    ground = load(MODELS / f"{name}.yaml").nodes[0]
    mechanism, motion, found, _ = derivatives(read(MODELS / f"{name}.yaml"), [f"{ground}.x"], 12)
    for k in range(len(motion.inputs)):
        given = np.stack([motion.inputs, np.zeros_like(motion.inputs)])
        given[1, k] = 1.0
        assert found[1 + k] == pytest.approx(rates_of_inputs(mechanism, motion.z, given).nodes[1], abs=1e-12)


def test_derivatives_do_not_exist_at_a_dead_point():
    """Lengths 5, 7, 9, 6: the follower is parallel to the coupler where the distance of A and O4 is 2."""
    angle = float(np.degrees(np.arccos((25 + 36 - 4) / 60)))
    model = four_bar(5.0, angle + 1.0, law=f", law: {{from: {angle + 1.0!r}, to: {angle!r}}}")
    _, motion, found, good = derivatives(model, LENGTHS, 2)
    assert motion.good[:2].all()
    assert good.tolist() == [True, True, False]
    assert np.isnan(found[:, :, 2]).all()
    assert np.isfinite(found[:, :, :2]).all()


@pytest.mark.parametrize("name", ["jansen", "platform_3rrr"])
def test_compiled_derivatives_are_those_of_the_interpreter_also_in_a_batch(name):
    model = read(MODELS / f"{name}.yaml")
    names = [f"{link}.length" for link in list(model["links"])[:3]]
    mechanism, motion, plainly, _ = derivatives(model, names, 300)  # more rows than one block
    z = np.stack([motion.z[:, ::-1], motion.z])
    inputs, family = np.stack([motion.inputs[:, ::-1], motion.inputs]), Family(mechanism, names)
    both, _ = family.slopes(np.tile(family.nominal, (2, 1)), z, inputs, jit.compiled)
    assert both.shape == (2, 3 + len(mechanism.actuators), len(mechanism.nodes), 301)
    assert both[1] == pytest.approx(plainly, abs=1e-12)
    assert both[0] == pytest.approx(both[1][:, :, ::-1], abs=1e-12)


def test_derivatives_by_inputs_alone_are_those_of_any_number_of_designs():
    mechanism = load(MODELS / "crank_rocker.yaml")
    motion, family = trace(mechanism, 6), Family(mechanism, [])
    one, _ = family.slopes(np.empty((1, 0)), motion.z[None], motion.inputs[None], plain)
    three, good = family.slopes(np.empty((3, 0)), np.stack([motion.z] * 3), motion.inputs[None], plain)
    assert good.all()
    assert three == pytest.approx(np.concatenate([one] * 3), abs=1e-15)
