"""Inverse dynamics: published cases, closed forms, and laws that hold for every mechanism."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import yaml
from bundled import MODELS, reference, written
from heavy_models import motion_forces, moved, on, total_on_frame, weighted
from influence_coefficients import Influence

from gimcli import load
from gimcli.dynamics.equilibrium_equations import right_side
from gimcli.dynamics.force_columns import columns_of, reactions
from gimcli.dynamics.forces import equilibrium, inverse_dynamics
from gimcli.dynamics.gear_reactions import add_across
from gimcli.dynamics.kinematic_history import Course, turning
from gimcli.dynamics.statics import statics
from gimcli.kernels.jit import compiled
from gimcli.motion.motion import trace
from gimcli.motion.solve import solve
from gimcli.positions.options import Options
from gimcli.quantities.motion_table import input_or_time
from gimcli.rates.derivatives import rates
from gimcli.structure.steps import NONE


def at(mechanism, value, speed, gain):
    """Return positions, velocities and accelerations at given values, speeds and accelerations of the only input."""
    (actuator,) = mechanism.actuators
    z = np.array([solve(mechanism, np.array([v]), Options(tolerance=1e-13)).z for v in value]).T
    scale = mechanism.duration
    orders = (value, speed * scale, gain * scale**2)
    driven = dataclasses.replace(actuator, law=lambda time, order=0: np.asarray(orders[order]))
    moved = dataclasses.replace(mechanism, actuators=(driven,))
    return Course(np.zeros(len(value)), value[None], rates(moved, np.zeros(len(value)), z, 2).nodes)


# -- published cases ----------------------------------------------------------------------------


@pytest.mark.parametrize("run", [lambda kernel: kernel, compiled], ids=["plain", "compiled"])
def test_watts_six_bar_without_driving_torque(run):
    """All pins of Durango et al. 2014, section 3.3, over 2 s; from a differential-algebraic solution in the table."""
    table, mechanism = reference("watt_six_bar_W1.csv"), load(MODELS / "watt_1.yaml")
    course = at(mechanism, table["theta2"], table["omega"], table["alpha"])
    found = inverse_dynamics(statics(mechanism), course, run)
    assert np.max(np.abs(found.effort(0))) < 1e-9  # there is no driving torque
    values = {
        "O2": "crank", "A": "link_3", "B": "link_4", "O4": "link_4", "C": "link_5", "D": "link_6", "E": "link_6",
    }  # fmt: skip
    for node, member in values.items():
        expected = table[f"F{node}x"] + 1j * table[f"F{node}y"]
        assert np.max(np.abs(on(found, node, member) - expected)) < 1e-6, node
    assert np.max(np.abs(found.loads.kinetic - table["T"])) < 1e-9
    assert np.max(np.abs(found.loads.potential - table["V"])) < 1e-9


SLIDER_CRANK = f"""\
units: {{angle: rad}}
nodes: {{A: [0, 0], B: [{math.sqrt(0.5)}, {math.sqrt(0.5)}], C: [{math.sqrt(2.0)}, 0], S: [1.6, 0], G: [3, 0]}}
ground: [A, G]
links: {{crank: {{nodes: [A, B], length: 1}}, rod: {{nodes: [B, C], length: 1}}, slider: [C, S]}}
prismatic: {{slide: {{nodes: [C, S], guide: [A, G]}}}}
actuators: {{motor: {{type: rotary, pivot: A, arm: B, law: {{from: {math.pi / 4}, to: {math.pi / 4 + 1}}}}}}}
masses:
  crank: {{mass: 1, inertia: {(1 + 1e-4) / 12}, centre: [0.5, 0]}}
  rod: {{mass: 1, inertia: {(1 + 1e-4) / 12}}}
  slider: {{mass: 1, centre: [0, 0]}}
gravity: [0, -10]
loads: {{push: {{on: slider, local: [0, 0], force: [100, 0]}}}}
"""


def test_marghitus_slider_crank(tmp_path):
    """Marghitu, Mechanisms and Robots Analysis with MATLAB, 2009, section 4.6: phi = 45 deg, 1 rad/s."""
    found = motion_forces(trace(written(tmp_path, SLIDER_CRANK), 1))
    root = math.sqrt(2.0)
    assert on(found, "B", "rod")[0] == pytest.approx(complex(-(400 + 7 * root) / 4, 5 * (84 + root) / 4), rel=1e-12)
    assert on(found, "A", "crank")[0] == pytest.approx(complex(-102.828427, 116.414214), abs=1e-6)
    assert on(found, "C", "slider")[0] == pytest.approx(complex(-101.414214, 97.121320), abs=1e-6)
    assert found.normal("slide")[0] == pytest.approx(-87.121320, abs=1e-6)
    assert found.moment("slide")[0] == pytest.approx(0.0, abs=1e-12)  # all forces meet at C
    assert found.effort(0)[0] == pytest.approx(151.492424, abs=1e-6)


def rtr():
    """R-RTR-RRT: slider 2 on bar 3 = DC, slider 5 on y = 0.35."""
    b = 0.2 * complex(math.cos(math.pi / 4), math.sin(math.pi / 4))
    along = (b + 0.4j) / abs(b + 0.4j)
    c = -0.4j + 0.7 * along
    e = complex(c.real - math.sqrt(0.09 - (0.35 - c.imag) ** 2), 0.35)
    bar, block = 8000 * 0.01 * 0.001, 8000 * 0.02 * 0.05 * 0.001
    rate = 200 * 2 * math.pi / 60

    def xy(z):
        return [float(z.real), float(z.imag)]

    def inertia(mass, length, height):
        return mass * (length**2 + height**2) / 12

    return yaml.safe_dump({
        "units": {"angle": "rad"}, "gravity": [0, -9.807],
        "nodes": {
            "A": [0, 0], "D": [0, -0.4], "B": xy(b), "P": xy(b + 0.05 * along), "C": xy(c), "E": xy(e),
            "Q": xy(e + 0.05), "G": [-1, 0.35], "H": [1, 0.35],
        },
        "ground": ["A", "D", "G", "H"],
        "links": {"link_1": ["A", "B"], "slider_2": ["B", "P"], "link_3": ["D", "C"], "link_4": ["C", "E"],
                  "slider_5": ["E", "Q"]},
        "prismatic": {"t_2": {"nodes": ["B", "P"], "guide": ["D", "C"]},
                      "t_5": {"nodes": ["E", "Q"], "guide": ["G", "H"]}},
        "actuators": {"motor": {"type": "rotary", "pivot": "A", "arm": "B",
                                "law": {"from": math.pi / 4, "to": math.pi / 4 + rate}}},
        "masses": {
            "link_1": {"mass": 0.2 * bar, "inertia": inertia(0.2 * bar, 0.2, 0.01)},
            "slider_2": {"mass": block, "inertia": inertia(block, 0.02, 0.05), "centre": [0, 0]},
            "link_3": {"mass": 0.7 * bar, "inertia": inertia(0.7 * bar, 0.7, 0.01)},
            "link_4": {"mass": 0.3 * bar, "inertia": 6.00667e-5},  # value of the published program
            "slider_5": {"mass": block, "inertia": inertia(block, 0.02, 0.05), "centre": [0, 0]},
        },
        "loads": {"external": {"on": "slider_5", "local": [0, 0], "force": [500, 0]}},
    })  # fmt: skip


def test_marghitu_and_dupacs_r_rtr_rrt(tmp_path):
    """Marghitu & Dupac, Advanced Dynamics, 2012, example 6.1: 45 deg, 200 rpm, in all printed digits."""
    mechanism = written(tmp_path, rtr())
    motion = trace(mechanism, 1)
    found = motion_forces(motion)
    nodes = rates(mechanism, motion.time, motion.z, 2).nodes[:, :, 0] * mechanism.scale
    nodes[0] += mechanism.origin
    z = dict(zip(mechanism.nodes, nodes.T, strict=True))
    printed = {
        "C": (0, 0.177 + 0.277j, 5e-4), "E": (0, -0.114 + 0.35j, 5e-4),
    }  # fmt: skip
    for name, (order, value, digit) in printed.items():
        assert abs(z[name][order].real - value.real) <= digit
        assert abs(z[name][order].imag - value.imag) <= digit
    assert z["E"][1].real == pytest.approx(-4.66, abs=5e-3)
    assert z["E"][2].real == pytest.approx(-17.464, abs=5e-4)
    names = [m.name for m in mechanism.members]
    for name, omega, alpha in (("link_3", 6.46, 30.4), ("link_4", 3.93, -82.5)):
        values = turning(mechanism, found.course, names.index(name))[:, 0]
        assert values[0] == pytest.approx(omega, abs=5e-3)
        assert values[1] == pytest.approx(alpha, abs=5e-2)
    f12, f01 = on(found, "B", "slider_2")[0], on(found, "A", "link_1")[0]
    assert (f12.real, f12.imag) == (pytest.approx(-625.61, abs=5e-3), pytest.approx(162.864, abs=5e-4))
    assert (f01.real, f01.imag) == (pytest.approx(-626.106, abs=5e-4), pytest.approx(162.525, abs=5e-4))
    assert found.effort(0)[0] == pytest.approx(111.518, abs=5e-4)


def test_with_a_third_crank_one_component_of_the_pin_forces_is_determined(tmp_path):
    """Parallelogram of three cranks at rest at 60 deg (Fraczek & Wojtyra 1.12).

    Cranks 1 kg, coupler 2 kg, all lengths 1, AD = BC = 2: the angular acceleration is -5.7225 rad/s^2 exactly; pin
    reactions are determined only normal to the cranks.
    """
    text = """\
nodes: {A: [0, 0], E: [1, 0], D: [2, 0], B: [0.5, 0.8660254037844386], F: [1.5, 0.8660254037844386],
        C: [2.5, 0.8660254037844386]}
ground: [A, E, D]
links: {left: [A, B], middle: [E, F], right: [D, C]}
elements: {coupler: [B, F, C]}
actuators: {motor: {type: rotary, pivot: A, arm: B, law: {by: 1}}}
gravity: [0, -9.81]
masses:
  left: {mass: 1, inertia: 0.08333333333333333}
  middle: {mass: 1, inertia: 0.08333333333333333}
  right: {mass: 1, inertia: 0.08333333333333333}
  coupler: {mass: 2, inertia: 0.6666666666666666}
"""
    mechanism = written(tmp_path, text)
    course = at(mechanism, np.array([math.pi / 3]), np.zeros(1), np.array([-5.7225]))
    found = inverse_dynamics(statics(mechanism), course)
    assert found.effort(0)[0] == pytest.approx(0.0, abs=1e-12)
    assert all(np.isnan(on(found, n, m)[0]) for n, m in (("B", "coupler"), ("A", "left"), ("F", "coupler")))
    some = inverse_dynamics(statics(mechanism), course, every=True)
    normal = 1j * np.exp(1j * math.pi / 3)
    values = {mechanism.nodes[pin.node]: found.pin_shared(pin, pin.members[1])[0] for pin in found.statics.pins}
    for node in ("B", "F", "C"):  # the coupler has no acceleration of its own: moment of a crank about its ground pin
        assert values[node] == pytest.approx((5.7225 / 3.0 - 9.81 / 4.0) * normal, abs=1e-12), node
    for node in ("A", "E", "D"):  # on the crank: m (g cos 60 deg + alpha / 2) minus the force of the coupler
        assert values[node] == pytest.approx(
            (9.81 / 2.0 - 5.7225 / 2.0 + 5.7225 / 3.0 - 9.81 / 4.0) * normal, abs=1e-12
        )
    for node, crank in (("B", "left"), ("F", "middle"), ("C", "right")):
        # moment of a crank about its ground pin: I alpha + m g l / 2 cos 60 deg = - F.n
        across = (on(some, node, "coupler")[0] * normal.conjugate()).real
        held = (5.7225 / 3.0 - 9.81 / 2.0 * 0.5) if node != "A" else 0.0
        assert across == pytest.approx(held, abs=1e-12), crank


# -- laws over all models -------------------------------------------------------------------------


@pytest.mark.few
def test_power_and_frame_forces_balance_on_every_model(model):
    """Power of all forces = dT/dt; the equilibrium of the whole mechanism, which the solution does not use, holds."""
    mechanism = weighted(model)
    _, forces, good = moved(mechanism)
    powers = [forces.drive_power, forces.loads.kinetic_rate, *forces.loads.power.values()]
    most = max(np.max(np.abs(p[good])) for p in powers)
    assert np.max(np.abs(forces.power_error[good])) < 1e-9 * most
    force, moment = total_on_frame(forces)
    scale = np.nanmax(np.abs(forces.unknowns[:, good]))
    assert np.max(np.abs(force - forces.shaking_force)[good]) < 1e-10 * scale
    size = mechanism.size * mechanism.dynamics.metre
    assert np.max(np.abs(moment - forces.shaking_moment)[good]) < 1e-9 * scale * size


@pytest.mark.few
def test_efforts_agree_with_virtual_work_on_every_model(model):
    """Effort = -B' (applied - inertia) for every driver, from influence coefficients without reactions."""
    mechanism = weighted(model)
    motion, forces, good = moved(mechanism)
    found = Influence(mechanism).over(motion.z, motion.inputs)
    right, scale = right_side(forces.statics, forces.loads), np.nanmax(np.abs(forces.unknowns[:, good]))
    for a, shares in zip(mechanism.drivers, mechanism.following.T, strict=True):
        work = np.zeros(len(motion.time))
        for row, body in zip(forces.statics.first_row, forces.statics.bodies, strict=True):
            move = np.tensordot(shares, found.points[body.node], 1)
            work += move.real * right[row] + move.imag * right[row + 1]
            if body.member != NONE:
                work += np.tensordot(shares, found.angles[body.member - 1], 1) * right[row + 2]
        values = forces.effort(a) / (mechanism.dynamics.metre if mechanism.actuators[a].rotary else 1.0)
        assert np.max(np.abs(work - values)[good]) < 1e-9 * max(scale, np.max(np.abs(work[good])))


@pytest.mark.few
def test_solution_by_blocks_agrees_with_the_whole_system_on_every_model(model):
    """Solution group by group in the reverse order of formation, and of all equations at once by LAPACK."""
    mechanism = weighted(model)
    _, forces, good = moved(mechanism, 12)
    table = equilibrium(forces.statics, forces.course.nodes[0][:, good])
    right = right_side(forces.statics, forces.loads)[:, good].T
    whole = np.array([np.linalg.lstsq(a, b, rcond=None)[0] for a, b in zip(table, right, strict=True)]).T
    condition = np.array([np.linalg.cond(a) for a in table])
    add_across(forces.statics, forces.course.nodes[0][:, good], whole, np.zeros((0, *whole.shape)))
    error = np.max(np.abs(whole - forces.unknowns[:, good]), axis=0) / np.max(np.abs(whole), axis=0)
    assert np.all(error < 1e-13 * condition)


def turned(angle, shift):
    """Return a change of a model's data that turns and shifts it as a whole, gravity and loads with it."""
    e = complex(math.cos(angle), math.sin(angle))

    def change(data):
        def turn(place, by=0.0):
            z = complex(*place) * e + by
            return [z.real, z.imag]

        data["nodes"] = {k: turn(v, shift) if isinstance(v, list) else v for k, v in data["nodes"].items()}
        data["gravity"] = turn(data["gravity"])
        data["loads"]["push"]["force"] = turn(data["loads"]["push"]["force"])
        by = angle if data["units"].get("angle") == "rad" else math.degrees(angle)
        for actuator in data["actuators"].values():
            own = by if "pivot" in actuator and "reference" not in actuator else 0.0
            for key in {"from", "to"} & set(actuator.get("law", {})):
                actuator["law"][key] += own
            if "phase" in actuator:  # of a follower; its leader is turned
                actuator["phase"] += own - by * actuator.get("ratio", 1.0)

    return change, e


@pytest.mark.few
def test_a_turned_and_shifted_frame_changes_nothing(model):
    mechanism = weighted(model)
    change, e = turned(0.7, 3.0 - 2.0j)
    if model.stem == "pick_and_place":
        pytest.skip("the tables of its laws are not turned")
    _, one, good = moved(mechanism, 12)
    _, two, also = moved(weighted(model, change), 12)
    both = good & also
    scale = np.max(np.abs(one.unknowns[:, both]))
    for k in set(range(len(mechanism.actuators))) - mechanism.geared:
        assert np.max(np.abs(one.effort(k) - two.effort(k))[both]) < 1e-7 * scale
    assert np.max(np.abs(one.shaking_force * e - two.shaking_force)[both]) < 1e-7 * scale
    assert (
        np.max(np.abs(one.shaking_moment - two.shaking_moment)[both]) < 1e-7 * scale * mechanism.size * mechanism.scale
    )
    for pin in one.statics.pins:
        for member in pin.members:
            a, b = one.pin(pin, member)[both], two.pin(pin, member)[both]
            assert np.nanmax(np.abs(a * e - b), initial=0.0) < 1e-7 * scale


def without_loads(data):
    data["loads"] = {}


@pytest.mark.few
def test_masses_time_and_gravity_scale_the_forces(model):
    """Masses x 3: forces x 3. A motion twice as fast under four times the gravity: forces x 4."""
    if model.stem == "pick_and_place":
        pytest.skip("the tables of its laws give its duration")
    one = moved(weighted(model, without_loads), 12)[1]

    def heavier(data):
        without_loads(data)
        for mass in data["masses"].values():
            mass["mass"] *= 3.0
            mass["inertia"] *= 3.0

    def faster(data):
        without_loads(data)
        data["duration"] = one.mechanism.duration / 2.0
        data["gravity"] = [4.0 * g for g in data["gravity"]]

    for change, factor in ((heavier, 3.0), (faster, 4.0)):
        two = moved(weighted(model, change), 12)[1]
        good = one.good & two.good
        most = np.max(np.abs(two.unknowns[:, good]))
        assert np.max(np.abs(factor * one.unknowns - two.unknowns)[:, good]) < 1e-9 * most


def test_time_reversal_leaves_all_forces(tmp_path):
    """The motion backwards: the same positions and accelerations, so the same forces; only damping changes sign."""

    def back(data):
        data["actuators"]["motor"]["law"] = {"from": 480, "to": 120}

    forward = moved(weighted(MODELS / "watt_1.yaml"), 36)[1]
    reverse = moved(weighted(MODELS / "watt_1.yaml", back), 36)[1]
    most = np.max(np.abs(forward.unknowns))
    assert np.max(np.abs(forward.unknowns - reverse.unknowns[:, ::-1])) < 1e-11 * most
    assert np.max(np.abs(forward.drive_power + reverse.drive_power[::-1])) < 1e-11 * np.max(np.abs(forward.drive_power))


def test_plain_and_compiled_kernels_give_the_same_numbers(tmp_path):
    for name in ("watt_1", "platform_3rrr", "scotch_yoke"):
        mechanism = weighted(MODELS / f"{name}.yaml")
        motion = trace(mechanism, 12)
        one, two = motion_forces(motion), motion_forces(motion, compiled)
        assert np.array_equal(one.unknowns, two.unknowns, equal_nan=True)


def test_the_second_named_member_receives_the_force(tmp_path):
    """`elements` written before `links`: at a pair of one of each, the force has the opposite sign."""
    text = (MODELS / "watt_1.yaml").read_text()
    links, elements = text.index("links:"), text.index("elements:")
    after = text.index("actuators:")
    swapped = text[:links] + text[elements:after] + text[links:elements] + text[after:]
    one, two = (reaction_table(load(MODELS / "watt_1.yaml")), reaction_table(written(tmp_path, swapped)))
    assert np.max(np.abs(one["C.fx"])) > 1.0
    for name, factor in (
        ("C.fx", -1.0),
        ("D.fy", -1.0),
        ("A.fx", -1.0),
        ("B.fx", 1.0),
        ("E.fy", 1.0),
        ("motor.effort", 1.0),
    ):
        assert two[name] == pytest.approx(factor * one[name], abs=1e-9)


def reaction_table(mechanism):
    found = motion_forces(trace(mechanism, 8))
    return {column.name: column.values for column in columns_of(found, reactions(found.statics))}


def test_efforts_of_a_law_that_reverses_or_is_constant_are_plotted_over_time():
    mechanism = load(MODELS / "watt_1.yaml")
    time = np.linspace(0.0, 1.0, 3)
    for inputs, name in (([0.0, 0.5, 1.0], "motor"), ([0.0, 0.5, 0.0], "time"), ([0.5, 0.5, 0.5], "time")):
        assert input_or_time(mechanism, time, np.array([inputs])).name == name
