"""Exact derivatives of velocities, accelerations and jerks are those of differences of changed models."""

import numpy as np
import pytest
from bundled import MODELS

import gimcli

CASES = {
    "crank_rocker": ("P.vx", "P.ay", "P.jx", "rocker.omega", "rocker.alpha", "rocker.jerk", "hypot(P.vx, P.vy)"),
    "slider_crank": ("B.vx", "B.ax", "B.jx"),
    "jansen": ("foot.vx", "foot.ay", "foot.jx"),
    "stephenson_3": ("P.vx", "P.ay", "P.jy"),
    "platform_3rrr": ("P.vx", "P.ay"),
    "five_bar": ("P.vx", "P.ay"),
    "crank_shaper": ("C.vx", "C.ax"),
    "watt_2": (),
}
"""Dyads, guides that move, coupled groups, and several inputs."""


def differences(m, texts, name, value, inputs):
    """Return the derivatives by central differences with one Richardson step, of `solve` at the same inputs."""

    def at(x):
        found = gimcli.solve(m.with_({name: x}), at=inputs)
        return np.array([float(np.ravel(found[text])[0]) for text in texts])

    h = 1e-3 * max(abs(value), 1.0)
    wide, narrow = ((at(value + d) - at(value - d)) / (2.0 * d) for d in (h, h / 2.0))
    return (4.0 * narrow - wide) / 3.0


@pytest.mark.few(4)
@pytest.mark.parametrize("name", CASES)
def test_derivatives_of_rates_are_those_of_differences(name):
    m = gimcli.load(MODELS / f"{name}.yaml")
    known = {*m.nodes, *(p.name for p in m.points), *(member.name for member in m.members)}
    texts = [t for t in CASES[name] if t.split("(")[-1].split(".")[0] in known]
    texts = texts or [f"{m.traced[0]}.{letter}" for letter in ("vx", "ay", "jx")]
    inputs = {m.actuators[k].name: float(m.value_to_file(k, u)) + (k + 1.0) * bool(m.actuators[k].rotary)
              for k, u in enumerate(m.start_inputs)}  # fmt: skip
    found = gimcli.sensitivity(m, of=texts, at=inputs)
    own = {d.name: d.value for d in m.written.dimensions.values()}
    chosen = [d for d in found.derivatives[texts[0]] if d in own][:5]
    assert chosen
    wanted = {d: differences(m, texts, d, own[d], inputs) for d in chosen}
    for k, text in enumerate(texts):
        got = found.derivatives[text]
        size = max(abs(float(v)) for v in got.values())
        for d in chosen:
            assert got[d] == pytest.approx(wanted[d][k], abs=1e-6 * size), (text, d)


def test_derivatives_of_the_greatest_speed_are_those_of_differences():
    m, text = gimcli.load(MODELS / "crank_rocker.yaml"), "max(hypot(P.vx, P.vy))"
    found = gimcli.sensitivity(m, of=text, by="coupler.length", steps=720).derivatives[text]["coupler.length"]
    values = gimcli.sweep(m, {"coupler.length": [119.99, 120.01]}, steps=720, keep=text)[text]
    assert found == pytest.approx((values[1] - values[0]) / 0.02, rel=1e-4)


def test_derivatives_by_the_input_are_velocity_over_speed():
    """At constant speed of the only input, the derivative of a rate by the input is the next rate over this speed."""
    m = gimcli.load(MODELS / "jansen.yaml")
    found = gimcli.sensitivity(m, of=["foot.vx", "foot.ay"], by="motor", steps=36)
    rates = gimcli.trace(m, 36, derivatives=3)
    speed = (rates["motor"][-1] - rates["motor"][0]) / (rates["time"][-1] - rates["time"][0])
    for text, then in (("foot.vx", "foot.ax"), ("foot.ay", "foot.jy")):
        size = np.abs(rates[then]).max()
        assert found.derivatives[text]["motor"] * speed == pytest.approx(rates[then], abs=1e-9 * size)


@pytest.mark.parametrize("name", ["belt.radii.0", "belt.radii.1", "M.y"])
def test_rates_of_inputs_that_follow_others_change_with_the_radii_of_their_belt(name):
    m, texts, inputs = gimcli.load(MODELS / "belt_drive.yaml"), ["T.x", "T.vx", "T.ax", "rod.omega"], {"motor": 30.0}
    found = gimcli.sensitivity(m, of=texts, by=name, at=inputs).derivatives
    value = next(d.value for d in m.written.dimensions.values() if d.name == name)
    for text, wanted in zip(texts, differences(m, texts, name, value, inputs), strict=True):
        assert found[text][name] == pytest.approx(wanted, rel=1e-6, abs=1e-6), text
