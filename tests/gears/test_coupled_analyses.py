"""Mobility, circuits, velocities, sensitivities, sweeps and views of mechanisms whose inputs follow others."""

import numpy as np
import pytest
from coupled_models import PLANETARY, apex, five_bar, rack, sun_and_planet, with_gears

import gimcli
from gimcli.positions.inputs import turns_until_repeated
from gimcli.view.hand import sliders


@pytest.mark.parametrize(
    "data",
    [
        five_bar(2.0, 60.0), PLANETARY, rack(), sun_and_planet(),
        with_gears(five_bar(-1.0, 60.0), {"mesh": {"members": ["crank", "other"], "pivots": ["O", "Q"], "ratio": 1}}),
    ],
    ids=["following", "planetary", "rack", "sun and planet", "geared"],
)  # fmt: skip
def test_coupled_mechanisms_have_one_freedom(data):
    found = gimcli.mobility(gimcli.load(data))
    report = found.report()
    assert (found.mobility, report["gruebler"], report["actuators"]) == (1, 1, 1)
    assert not any(report[key] for key in ("redundant", "undriven", "overdriven"))


@pytest.mark.parametrize("wheel", ["crank", "other"])
def test_a_far_node_that_a_wheel_only_carries_does_not_change_the_mobility(wheel):
    data = with_gears(five_bar(-1.0, 60.0), {"mesh": {"members": ["crank", "other"], "pivots": ["O", "Q"], "ratio": 1}})
    nodes = data["links"].pop(wheel)["nodes"]
    data = {**data, "nodes": {**data["nodes"], "X": [30, 40]}, "elements": {wheel: [*nodes, "X"]}}
    report = gimcli.mobility(gimcli.load(data)).report()
    assert report["mobility"] == 1
    assert not any(report[key] for key in ("redundant", "undriven", "overdriven"))


def test_a_second_planet_is_redundant():
    data = {**PLANETARY, "nodes": {**PLANETARY["nodes"], "R": [-35, 0], "U": [-35, 5]}}
    data["links"] = {**PLANETARY["links"], "arm_2": ["O", "R"], "planet_2": ["R", "U"]}
    del data["links"]["arm"], data["links"]["arm_2"]
    data["elements"] = {"arm": ["O", "P", "R"]}
    data["gears"] = {
        **PLANETARY["gears"],
        "inner_2": {**PLANETARY["gears"]["inner"], "members": ["sun", "planet_2"], "pivots": ["O", "R"]},
        "outer_2": {**PLANETARY["gears"]["outer"], "members": ["ground", "planet_2"], "pivots": ["O", "R"]},
    }
    m = gimcli.load(data)
    assert gimcli.mobility(m).mobility == 1
    t = gimcli.trace(m, steps=12)
    assert np.max(abs(t.xy["P"] @ [1, 1j] - 35.0 * np.exp(1j * np.radians(t["motor"]) * 40.0 / 140.0))) < 1e-11


@pytest.mark.few(3)
@pytest.mark.parametrize(("ratio", "turns"), [(2.0, 1), (0.5, 2), (-1.0 / 3.0, 3), (1.4, 5), (np.sqrt(2.0), None)])
def test_circuits_close_after_the_turns_of_the_ratio(ratio, turns):
    m = gimcli.load(five_bar(ratio, 60.0))
    assert turns_until_repeated(m) == turns
    first = gimcli.circuits(m, values=12).report()["curves"][0]
    assert first["closed"] is (turns is not None)
    if first["closed"]:
        assert first["turns"] == turns


def test_limits_of_coupled_cranks_are_where_the_dyad_is_stretched():
    """At a limit the distance of the crank pins is the sum, or the difference, of the lengths of the dyad."""
    b = (2.0, 1.8)
    data = five_bar(0.5, 60.0, b=b)
    events = gimcli.singularities(gimcli.load(data)).events
    assert events
    for event in events:
        turn = np.radians(event["at"]["motor"])
        apart = abs(3.0 + 1.2 * np.exp(1j * (0.5 * turn + np.pi / 3.0)) - np.exp(1j * turn))
        assert min(abs(apart - sum(b)), abs(apart - 0.2)) < 1e-8


def test_all_configurations_at_one_input():
    found = gimcli.configurations(gimcli.load(five_bar(2.0, 60.0)), motor=45.0)
    places = found.xy["P"] @ [1, 1j]
    exact = apex(np.pi / 4.0, 2.0, 60.0)
    one, other = np.exp(1j * np.pi / 4.0), 3.0 + 1.2 * np.exp(1j * np.radians(150.0))
    mirrored = one + (other - one) * np.conj((exact - one) / (other - one))
    assert len(places) == 2
    assert max(min(abs(places - z)) for z in (exact, mirrored)) < 1e-12


@pytest.mark.parametrize("data", [five_bar(2.0, 60.0), rack(), sun_and_planet()], ids=["linear", "rack", "sun"])
def test_velocities_of_one_position_are_those_of_the_motion(data):
    m = gimcli.load(data)
    name = data["trace"][0]
    t = gimcli.trace(m, steps=16, derivatives=2)
    p = gimcli.solve(m, motor=float(t["motor"][3]), velocities=True)
    row = list(p["node"]).index(name)
    for column in ("vx", "vy", "ax", "ay"):
        along = t[f"{name}.{column}"]
        assert abs(p[column][row] - along[3]) < 1e-7 * np.max(abs(along))


@pytest.mark.parametrize("name", ["motor", "second.ratio", "second.phase", "crank", "B.x"])
def test_sensitivities_include_what_follows(name):
    m = gimcli.load(five_bar(2.0, 60.0))
    found = gimcli.sensitivity(m, of=["P.x", "P.y"], by=[name], motor=40.0)

    def place(change):
        if name == "motor":
            return gimcli.solve(m, motor=40.0 + change).xy["P"]
        return gimcli.solve(m.with_({name: m.written.dimension(name).value + change}), motor=40.0).xy["P"]

    h = 1e-5
    difference = (place(h) - place(-h)) / (2.0 * h)
    slopes = np.array([found["derivative"][list(found["quantity"]).index(f"P.{axis}")] for axis in "xy"])
    assert np.allclose(slopes, difference, atol=1e-8)


def test_a_sweep_over_the_ratio_and_the_phase():
    m = gimcli.load(five_bar(2.0, 60.0))
    found = gimcli.sweep(m, {"second.ratio": [-1.0, 0.5, 2.0], "second.phase": [50.0, 60.0]}, keep="max(P.x)", steps=36)
    for ratio, phase, value in zip(found["second.ratio"], found["second.phase"], found["max(P.x)"], strict=True):
        assert abs(value - apex(np.linspace(0.0, 2.0 * np.pi, 37), ratio, phase).real.max()) < 1e-12


def test_only_drivers_have_sliders():
    result = gimcli.trace(gimcli.load(five_bar(2.0, 60.0)), steps=8)
    assert [one["name"] for one in sliders(result)] == ["motor"]
