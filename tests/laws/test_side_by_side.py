"""Models side by side in one file: each verb finds of each machine what it finds of the model alone."""

import copy
import math
import random

import numpy as np
import pytest
from side_by_side import beside, data_of, renamed

import gimcli

FAR = 1e3
"""Distance of the two machines, in sizes of the second."""

SAME = 1e-9
"""Differences of numbers, relative to the size of a machine or to the number."""

COSTS = ("evaluations", "integrator_steps", "seconds", "warnings", "text")
"""Keys of reports about the computation or the whole file."""

WORK = ("residual", "sweeps")

KINEMATIC = {
    "check": gimcli.check, "circuits": lambda m: gimcli.circuits(m, values=12), "singularities": gimcli.singularities,
    "configurations": gimcli.configurations, "sequence": gimcli.sequence, "groups": gimcli.groups,
    "sensitivity": lambda m: gimcli.sensitivity(m, steps=4, samples=0), "solve": gimcli.solve,
}  # fmt: skip

DYNAMIC = {
    "forces": lambda m: gimcli.forces(m, steps=8), "holding": gimcli.holding_forces,
    "reduce": lambda m: gimcli.reduce(m, steps=4), "simulate": lambda m: gimcli.simulate(m, duration=0.1, dt=0.05),
    "modes": lambda m: gimcli.modes(m, free=[a.name for a in m.actuators], settle=True),
}  # fmt: skip

PLAIN = [
    "antiparallelogram", "chebyshev", "crank_rocker", "crank_shaper", "deltoid", "double_butterfly", "double_crank",
    "elliptic_trammel", "five_bar", "galloway_kite", "gim_fig11", "gim_fig13b", "innocenti_group", "jansen", "klann",
    "pantograph", "parallelogram", "peaucellier", "plantigrade", "platform_3rpr", "platform_3rrr", "scissor_lift",
    "scotch_yoke", "slider_crank", "stephenson_1", "stephenson_3_far", "ten_bar", "watt_straight_line", "whitworth",
]  # fmt: skip
LOADED = ["double_pendulum", "excavator", "rack_lift", "spring_block", "watt_1", "watt_durango", "wiper"]


def assert_same(found, expected, size, path):
    if isinstance(expected, dict):
        keys = [key for key in expected if key not in COSTS]
        assert set(keys) <= set(found), path
        for key in keys:
            assert_same(found[key], expected[key], size, f"{path}.{key}")
    elif isinstance(expected, list | tuple):
        assert len(found) == len(expected), path
        for k, one in enumerate(expected):
            assert_same(found[k], one, size, f"{path}[{k}]")
    elif isinstance(expected, float) and found is not None:
        assert found == pytest.approx(expected, rel=SAME, abs=SAME * max(size, 1.0), nan_ok=True), path
    else:
        assert found == expected, path


def assert_same_columns(found, expected, size, path):
    for column in expected.table().columns:
        own, values = found[column.name], column.values
        if column.name in WORK or column.name in ("step", "status"):
            continue
        if values.dtype.kind == "f":
            allowed = SAME * max(size, float(np.nanmax(np.abs(values), initial=0.0)))
            assert np.allclose(own, values, rtol=0, atol=allowed, equal_nan=True), f"{path} {column.name}"
        else:
            assert list(own) == list(values), f"{path} {column.name}"


def answer(verb, mechanism):
    try:
        return verb(mechanism)
    except gimcli.GimError:
        return None


def pair(first, second, gravity):
    """Return the mechanism of two models, and those of each alone, with the same units and weight."""
    parts = [{**data_of(name), "gravity": [0, -9.81]} if gravity else data_of(name) for name in (first, second)]
    for data in parts:
        data |= {"units": parts[0].get("units", {})}
        data.pop("duration", None)
        if not gravity:
            data.pop("gravity", None)
    alone = gimcli.load(copy.deepcopy(parts[1]))
    parts[1] = renamed(parts[1], FAR * alone.size * alone.scale)
    return gimcli.load(beside(*parts)), [gimcli.load(copy.deepcopy(data)) for data in parts]


def hold(first, second, verbs, gravity=False):
    """Compare all verbs on two models in one file with those on each alone."""
    together, each = pair(first, second, gravity)
    names, sizes = [one.name for one in together.driven_machines], [m.size * m.scale for m in each]
    assert len(names) == 2
    for at_limit in ("stop", "skip", "reverse"):
        found = gimcli.trace(together, steps=12, at_limit=at_limit)
        for k, name in enumerate(names):
            expected = gimcli.trace(each[k], steps=12, at_limit=at_limit)
            assert list(found[f"{name}.status"]) == list(expected["status"]), name
            assert_same_columns(found, expected, sizes[k], f"trace {name}")
            for key in ("reachable", "solved"):
                assert_same(found.machines[k][key], expected.report()[key], sizes[k], f"trace {name} {key}")
            kinds = [[event["kind"] for event in events] for events in (found.machines[k]["events"], expected.events)]
            assert kinds[0] == kinds[1]
    for verb, find in verbs.items():
        found, alone = answer(find, together), [answer(find, one) for one in each]
        if None in alone:
            assert (found is None) or verb in ("modes", "simulate", "reduce", "forces", "holding")
            continue
        if verb == "solve":
            for k, one in enumerate(alone):
                assert found.status == one.status == "ok"
                assert all(
                    np.allclose(found.xy[n], one.xy[n], rtol=0, atol=SAME * sizes[k] + 1e-15 * abs(one.xy[n][0]))
                    for n in each[k].nodes
                )
            continue
        for k, name in enumerate(names):
            own = found.each[name]
            assert_same(own.report(), alone[k].report(), sizes[k], f"{verb} {name}")
            if verb != "check":  # its warnings about the file are not those of a machine
                assert_same_columns(own, alone[k], sizes[k], f"{verb} {name}")


@pytest.mark.few(1)
@pytest.mark.parametrize(("first", "second"), [("crank_rocker", "scotch_yoke"), ("gim_fig13b", "slider_crank")])
def test_two_models_in_one_file_are_what_each_is_alone(first, second):
    hold(first, second, {k: verb for k, verb in KINEMATIC.items() if k != "circuits"})


def test_two_loaded_models_in_one_file_are_what_each_is_alone():
    hold("watt_durango", "wiper", {k: DYNAMIC[k] for k in ("forces", "holding", "reduce")}, gravity=True)


@pytest.mark.soak
@pytest.mark.parametrize("number", range(30))
def test_random_pairs_of_models_are_what_each_is_alone(number):
    hold(*random.Random(number).sample(PLAIN, 2), KINEMATIC)


@pytest.mark.soak
@pytest.mark.parametrize("number", range(12))
def test_random_pairs_of_loaded_models_are_what_each_is_alone(number):
    hold(*random.Random(number).sample(LOADED, 2), DYNAMIC, gravity=True)


SLIDERS = """
nodes: {{O: [0, 0], U: [1, 0], A: [1, 0], P: [5, 0], Q: [6, 0], B: [3, 0]}}
ground: [O, U, P, Q]
prismatic: {{s: {{node: A, guide: [O, U]}}, t: {{node: B, guide: [P, Q]}}}}
actuators: {{x: {{node: A, guide: [O, U], free: true}}, y: {{node: B, guide: [P, Q], free: true}}}}
masses: {{A: 2, B: 2}}
springs: {{a: {{nodes: [O, A], stiffness: 50, free: {free}}}, b: {{nodes: [B, P], stiffness: 50, free: 2}}{joint}}}
"""


def test_a_spring_between_two_machines_joins_them_for_vibrations():
    """Two equal masses m, three equal springs k: sqrt(k / m) and sqrt(3 k / m); two alone sqrt(k / m) each."""
    joint = ", c: {nodes: [A, B], stiffness: 50, free: 2}"
    joined = gimcli.loads(SLIDERS.format(free=1, joint=joint))
    assert (len(joined.machines), len(joined.loaded_machines)) == (2, 1)
    assert gimcli.modes(joined)["omega"] == pytest.approx([5.0, 5.0 * math.sqrt(3.0)], rel=1e-12)
    apart = gimcli.modes(gimcli.loads(SLIDERS.format(free=1, joint="")))
    assert {name: list(one["omega"]) for name, one in apart.each.items()} == {
        "x": pytest.approx([5.0], rel=1e-12), "y": pytest.approx([5.0], rel=1e-12)
    }  # fmt: skip


def test_free_machines_without_a_spring_between_them_move_alone():
    found = gimcli.simulate(gimcli.loads(SLIDERS.format(free=0.9, joint="")), duration=1.0, dt=0.25)
    time = found.each["x"]["time"]
    assert found.each["x"]["x"] == pytest.approx(0.9 + 0.1 * np.cos(5.0 * time), abs=1e-8)
    assert np.ptp(found.each["y"]["y"]) == 0.0


TWO_LOADED = """
units: {length: m}
nodes: {A: [0, 0], B: [0, 2], C: [3, 3], D: [4, 0], E: [10, 0], F: [11, 0]}
ground: [A, D, E]
links: {a: [A, B], b: {nodes: [B, C], length: 3.2}, c: {nodes: [C, D], length: 1.5}, e: [E, F]}
actuators: {rocker: {pivot: A, arm: B, law: {by: 300}}, crank: {pivot: E, arm: F, law: {by: 360}}}
masses: {C: 1, F: 2}
gravity: [0, -10]
"""


def test_a_limit_of_one_machine_leaves_the_forces_of_the_other():
    """A mass m on a crank r that turns at the rate w: torque m g r cos(q), pin force at most m g + m r w^2."""
    found, rate = gimcli.forces(gimcli.loads(TWO_LOADED), steps=36), 2.0 * math.pi
    assert not found.answered
    assert list(found["crank.status"]) == ["ok"] * 37
    assert list(found["rocker.status"]) == list(found["status"]) == ["ok"] + ["unreachable"] * 36
    angle = np.radians(np.linspace(0.0, 360.0, 37))
    assert found["crank.effort"] == pytest.approx(20.0 * np.cos(angle), abs=1e-9)
    crank = found.each["crank"]
    assert crank.statistics["E"].greatest.value == pytest.approx(20.0 + 2.0 * rate**2, rel=1e-9)
    assert crank.statistics["crank.effort"].part == 1.0
    report = found.report()
    assert [(one["name"], one["solved"]) for one in report["machines"]] == [("rocker", 1), ("crank", 37)]
    assert report["solved"] == 1
    assert report["statistics"]["E"] == crank.report()["statistics"]["E"]


def test_graphs_of_several_machines_are_drawn_in_the_picture_of_each():
    mechanism = gimcli.loads(TWO_LOADED)
    found = gimcli.forces(mechanism, steps=4, plot=["A.fx+E.fy, rocker.effort", "shaking.fy"])
    curves = {name: [[c.name for c in graph.curves] for graph in one.graphs()] for name, one in found.each.items()}
    assert curves == {"rocker": [["A.fx"], ["rocker.effort"], ["shaking.fy"]], "crank": [["E.fy"], ["shaking.fy"]]}
    with pytest.raises(gimcli.UsageError, match=r"plot crank\.effort/rocker\.effort: no machine has these columns"):
        gimcli.forces(mechanism, steps=4, plot="E.fx,crank.effort/rocker.effort")


def test_the_shaking_force_of_several_machines_is_their_sum_about_the_first_ground_node():
    """Two masses on cranks: the weights at their places, and centrifugal forces."""
    text = """
units: {length: m}
nodes: {O: [1, 1], A: [2, 1], P: [7, 3], Q: [7, 5]}
ground: [O, P]
links: {a: [O, A], b: [P, Q]}
actuators: {s: {pivot: O, arm: A, law: {by: 0.001}}, t: {pivot: P, arm: Q, law: {by: 0.001}}}
masses: {A: 3, Q: 5}
gravity: [0, -10]
"""
    found = gimcli.forces(gimcli.loads(text), steps=1)
    assert found["shaking.fy"] == pytest.approx([-80.0] * 2, rel=1e-4)
    assert found["shaking.moment"] == pytest.approx([-30.0 * 1.0 - 50.0 * 6.0] * 2, rel=1e-4)
    assert found["s.shaking.fy"] == pytest.approx([-30.0] * 2, rel=1e-4)


def test_a_sweep_of_one_machine_is_not_limited_by_the_other():
    """The mass point F of the crank reaches E.x + crank in every design, whatever the limit of the rocker."""
    found = gimcli.sweep(gimcli.loads(TWO_LOADED), {"F.x": "11,11.5"}, steps=36, keep="max(F.x)")
    assert found["max(F.x)"] == pytest.approx([11.0, 11.5], rel=1e-12)
    assert list(found["status"]) == ["ok", "ok"]


def test_dry_friction_of_two_machines_on_one_held_member():
    """Massless cranks with a force at the end: the effort is F (L cos t + rho), rho: radius of the friction circle."""
    nodes = {"O": [0, 0], "P": [3, 0], "Q": [1, 2], "A": [1, 0], "B": [4, 0]}
    model = gimcli.load({
        "units": {"length": "m"}, "nodes": nodes, "ground": {"member": "base"}, "elements": {"base": ["O", "P", "Q"]},
        "links": {"one": ["O", "A"], "two": ["P", "B"]},
        "actuators": {
            "first": {"pivot": "O", "arm": "A", "law": {"by": 60}},
            "second": {"pivot": "P", "arm": "B", "law": {"by": 60}},
        },
        "loads": {"left": {"on": "A", "force": [0, -10]}, "right": {"on": "B", "force": [0, -20]}},
        "friction": {"O": {"mu": 0.2, "radius": 0.1}, "P": {"mu": 0.1, "radius": 0.1}},
    })  # fmt: skip
    found, cosine = gimcli.forces(model, steps=4), np.cos(np.radians(np.linspace(0, 60, 5)))
    for name, force, mu in (("first", 10.0, 0.2), ("second", 20.0, 0.1)):
        circle = 0.1 * mu / math.sqrt(1.0 + mu**2)
        assert found[f"{name}.effort"] == pytest.approx(force * (cosine + circle), rel=1e-12)
