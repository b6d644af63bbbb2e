"""Structures that are driven, over-driven, free or out of the ordinary: what every analysis says of them."""

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from gimcli.cli import app
from gimcli.model import load
from gimcli.motion.motion import trace

COMMANDS = ("mobility", "solve", "singularities", "circuits", "workspace", "trace", "groups", "sequence")
"""All that need no masses."""


def written(tmp_path, data):
    path = tmp_path / "model.yaml"
    path.write_text(data if isinstance(data, str) else yaml.safe_dump(data))
    return path


def run(*arguments, folder=None):
    extra = ["-o", str(folder), "--no-png"] if folder is not None else []
    return CliRunner().invoke(app, [*map(str, arguments), *extra])


RAMS_IN_A_PIN = """
nodes: {A: [0, 0], B: [4, 0], P: [2, 2]}
ground: [A, B]
actuators:
  left: {type: linear, nodes: [A, P], law: {by: 1}}
  right: {type: linear, nodes: [B, P], law: {by: 0.5}}
"""


def test_two_rams_that_meet_in_a_pin_need_no_link(tmp_path):
    """P is where two circles meet: x = (l^2 - r^2 + 16) / 8, y = sqrt(l^2 - x^2)."""
    motion = trace(load(written(tmp_path, RAMS_IN_A_PIN)), 20)
    t = np.linspace(0.0, 1.0, 21)
    left, right = np.sqrt(8.0) + t, np.sqrt(8.0) + 0.5 * t
    x = (left**2 - right**2 + 16.0) / 8.0
    p = motion.mechanism.to_file(motion.z)[motion.mechanism.nodes.index("P")]
    assert np.max(np.abs(p - (x + 1j * np.sqrt(left**2 - x**2)))) < 1e-14


@pytest.mark.parametrize("command", COMMANDS)
def test_two_rams_that_meet_in_a_pin_are_a_mechanism_for_every_command(tmp_path, command):
    folder = tmp_path if command in ("workspace", "trace") else None
    done = run(command, written(tmp_path, RAMS_IN_A_PIN), folder=folder)
    assert done.exit_code == 0, done.output


COINCIDENT = {
    "nodes": {"O": [0, 0], "G": [0, 0], "H": [5, 0], "A": [0.6, 0.8], "P": [3.6, 0], "Q": [4.6, 0]},
    "links": {"crank": ["O", "A"], "rod": {"nodes": ["A", "P"], "length": 3}, "block": ["P", "Q"]},
    "prismatic": {"s": {"nodes": ["P", "Q"], "guide": ["G", "H"]}},
    "actuators": {"m": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"from": 0, "to": 360}}},
}


@pytest.mark.parametrize("ground", [["O", "G", "H"], ["G", "O", "H"], ["O", "H", "G"], ["H", "G", "O"]])
def test_frame_nodes_may_coincide_where_a_member_slides_by_two_pins(tmp_path, ground):
    """A slider-crank, x = cos + sqrt(9 - sin^2), whose pivot and guide begin at one place."""
    motion = trace(load(written(tmp_path, COINCIDENT | {"ground": ground})), 72)
    angle = np.linspace(0.0, 2.0 * np.pi, 73)
    z = dict(zip(motion.mechanism.nodes, motion.mechanism.to_file(motion.z), strict=True))
    x = np.cos(angle) + np.sqrt(9.0 - np.sin(angle) ** 2)
    assert np.max(np.abs(z["P"] - x)) < 1e-14
    assert np.max(np.abs(z["Q"] - x - 1.0)) < 1e-14


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_takes_coincident_frame_nodes(tmp_path, command):
    folder = tmp_path if command in ("workspace", "trace") else None
    done = run(command, written(tmp_path, COINCIDENT | {"ground": ["O", "G", "H"]}), folder=folder)
    assert done.exit_code == 0, done.output


def test_a_point_of_the_ground_is_measured_along_its_first_two_nodes_that_are_apart(tmp_path):
    data = COINCIDENT | {"ground": ["O", "G", "H"], "points": {"X": {"on": "ground", "local": [2, 1]}}}
    point = load(written(tmp_path, data)).points[0].local
    assert point * load(written(tmp_path, data)).scale == pytest.approx(2 + 1j)


PENDULUM = """
nodes: {O: [7, 5], A: [7, 2], S: [9, 5], T: [9.5, 5], R: [10, 5]}
ground: [O, R]
links: {bob: [O, A], block: [S, T]}
prismatic: {rail: {nodes: [S, T], guide: [O, R]}}
actuators:
  swing: {type: rotary, pivot: O, arm: A, free: true, start: -90, speed: 0}
  push: {type: linear, node: S, guide: [O, R], law: {by: 0.1}}
masses: {bob: {mass: 2, centre: [3, 0]}, block: {mass: 1}}
gravity: [0, -9.81]
"""


def test_energy_of_weights_is_measured_from_the_first_ground_node(tmp_path):
    """2 kg hang 3 m below O, the block slides at its height: V = -2 g 3."""
    done = run("simulate", written(tmp_path, PENDULUM), "--time", "0.1", folder=tmp_path)
    assert done.exit_code == 0, done.output
    table = np.genfromtxt(tmp_path / "model.simulation.csv", delimiter=",", names=True)
    assert table["energypotential"] == pytest.approx(-6 * 9.81, rel=1e-12)


@pytest.mark.parametrize("command", ["simulate", "forces", "reduce"])
def test_a_missing_inertia_is_said_where_the_member_turns(tmp_path, command):
    """The block has none either, but its guide holds it from turning; `inertia: 0` is an answer."""
    more = ["--time", "0.1"] if command == "simulate" else ["--input", "swing"] if command == "reduce" else []
    said = "no `inertia` for bob:"
    assert said in run(command, written(tmp_path, PENDULUM), *more, folder=tmp_path).output
    stated = PENDULUM.replace("mass: 2,", "mass: 2, inertia: 0,")
    assert "no `inertia`" not in run(command, written(tmp_path, stated), *more, folder=tmp_path).output
