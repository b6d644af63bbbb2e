"""Inverse dynamics: published cases, closed forms, and laws that hold for every mechanism."""

from __future__ import annotations

import csv
import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import MODELS, changed

from gimcli.analysis.derivatives import rates
from gimcli.analysis.forces import inverse_dynamics, motion_forces
from gimcli.analysis.loading import Course
from gimcli.errors import UsageError
from gimcli.kernels.jit import compiled
from gimcli.model import load
from gimcli.motion.motion import trace
from gimcli.motion.options import Options
from gimcli.motion.position import solve
from gimcli.structure.statics import statics

TABLES = Path(__file__).parent / "tables"


def written(folder, text):
    path = folder / "m.yaml"
    path.write_text(text)
    return load(path)


def at(mechanism, value, speed, gain):
    """Return positions, velocities and accelerations at given values, speeds and accelerations of the only input."""
    (actuator,) = mechanism.actuators
    z = np.array([solve(mechanism, np.array([v]), Options(tolerance=1e-13)).z for v in value]).T
    scale = mechanism.duration
    orders = (value, speed * scale, gain * scale**2)
    driven = dataclasses.replace(actuator, law=lambda time, order=0: np.asarray(orders[order]))
    moved = dataclasses.replace(mechanism, actuators=(driven,))
    return Course(np.zeros(len(value)), value[None], rates(moved, np.zeros(len(value)), z, 2).nodes)


def on(forces, node, member):
    """Return the force that a member receives at a node."""
    mechanism = forces.mechanism
    names = [m.name for m in mechanism.members]
    pin = next(p for p in forces.statics.pins if mechanism.nodes[p.node] == node)
    return forces.pin(pin, names.index(member))


# -- published cases ----------------------------------------------------------------------------


def watt_table():
    with (TABLES / "watt_six_bar_W1.csv").open() as handle:
        rows = list(csv.DictReader(handle))
    return {key: np.array([float(row[key]) for row in rows]) for key in rows[0]}


@pytest.mark.parametrize("run", [lambda kernel: kernel, compiled], ids=["plain", "compiled"])
def test_watts_six_bar_falling_freely(run):
    """All pins of Durango et al. 2014, section 3.3, over 2 s; from a differential-algebraic solution in the table."""
    table, mechanism = watt_table(), load(MODELS / "watt_1.yaml")
    course = at(mechanism, table["theta2"], table["omega"], table["alpha"])
    found = inverse_dynamics(statics(mechanism), course, run)
    assert np.max(np.abs(found.effort(0))) < 1e-9  # it falls freely
    told = {
        "O2": "crank", "A": "link_3", "B": "link_4", "O4": "link_4", "C": "link_5", "D": "link_6", "E": "link_6",
    }  # fmt: skip
    for node, member in told.items():
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
            "link_4": {"mass": 0.3 * bar, "inertia": 6.00667e-5},  # the published program's, see the reference
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
    f12, f01 = on(found, "B", "slider_2")[0], on(found, "A", "link_1")[0]
    assert (f12.real, f12.imag) == (pytest.approx(-625.61, abs=5e-3), pytest.approx(162.864, abs=5e-4))
    assert (f01.real, f01.imag) == (pytest.approx(-626.106, abs=5e-4), pytest.approx(162.525, abs=5e-4))
    assert found.effort(0)[0] == pytest.approx(111.518, abs=5e-4)


def test_a_third_crank_leaves_one_component_of_the_pins(tmp_path):
    """Parallelogram of three cranks at rest at 60 deg (Fraczek & Wojtyra 1.12; reference/dynamics.md, section 5).

    Cranks 1 kg, coupler 2 kg, all lengths 1, AD = BC = 2: the angular acceleration is -5.7225 rad/s2 exactly; pin
    reactions are unique only normal to the cranks.
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
    for node, crank in (("B", "left"), ("F", "middle"), ("C", "right")):
        # moment of a crank about its ground pin: I alpha + m g l / 2 cos 60 deg = - F.n
        across = (on(some, node, "coupler")[0] * normal.conjugate()).real
        held = (5.7225 / 3.0 - 9.81 / 2.0 * 0.5) if node != "A" else 0.0
        assert across == pytest.approx(held, abs=1e-12), crank


def test_what_is_never_told():
    with pytest.raises(UsageError, match="add `masses:`"):
        motion_forces(trace(load(MODELS / "crank_rocker.yaml"), 2))
