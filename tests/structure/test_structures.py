"""Driven, over-driven, undriven and unusual structures: all analyses must agree on them."""

import json

import numpy as np
import pytest
import yaml
from random_structures import Structure
from typer.testing import CliRunner

from gimcli import StructureError, load
from gimcli.assemblies import all_configurations
from gimcli.branching.singular_positions import survey
from gimcli.cli import app
from gimcli.model.compile import compile_model
from gimcli.model.part import long_form
from gimcli.model.schema import Model
from gimcli.motion.motion import trace
from gimcli.motion.solve import solve
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.mobility import drawn_mobility

COMMANDS = ("mobility", "solve", "singularities", "circuits", "workspace", "trace", "groups", "sequence")
"""All commands that need no masses."""


def written(tmp_path, data):
    path = tmp_path / "model.yaml"
    path.write_text(data if isinstance(data, str) else yaml.safe_dump(data))
    return path


def run(*arguments, folder=None):
    extra = ["-o", str(folder), "--no-png"] if folder is not None else []
    return CliRunner().invoke(app, [*map(str, arguments), *extra])


def all_at_start(mechanism, _steps):
    return all_configurations(mechanism, mechanism.drawn_inputs)


RAMS_IN_A_PIN = """
nodes: {A: [0, 0], B: [4, 0], P: [2, 2]}
ground: [A, B]
actuators:
  left: {type: linear, nodes: [A, P], law: {by: 1}}
  right: {type: linear, nodes: [B, P], law: {by: 0.5}}
"""


def test_two_rams_that_meet_in_a_pin_need_no_link(tmp_path):
    """P is the intersection of two circles: x = (l^2 - r^2 + 16) / 8, y = sqrt(l^2 - x^2)."""
    motion = trace(load(written(tmp_path, RAMS_IN_A_PIN)), 20)
    t = np.linspace(0.0, 1.0, 21)
    left, right = np.sqrt(8.0) + t, np.sqrt(8.0) + 0.5 * t
    x = (left**2 - right**2 + 16.0) / 8.0
    p = motion.mechanism.to_file(motion.z)[motion.mechanism.nodes.index("P")]
    assert np.max(np.abs(p - (x + 1j * np.sqrt(left**2 - x**2)))) < 1e-14


@pytest.mark.few(4)
@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_accepts_two_rams_that_meet_in_a_pin(tmp_path, command):
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
def test_frame_nodes_may_coincide_with_a_member_that_slides_by_two_pins(tmp_path, ground):
    """A slider-crank, x = cos + sqrt(9 - sin^2), with coincident pivot and guide node."""
    motion = trace(load(written(tmp_path, COINCIDENT | {"ground": ground})), 72)
    angle = np.linspace(0.0, 2.0 * np.pi, 73)
    z = dict(zip(motion.mechanism.nodes, motion.mechanism.to_file(motion.z), strict=True))
    x = np.cos(angle) + np.sqrt(9.0 - np.sin(angle) ** 2)
    assert np.max(np.abs(z["P"] - x)) < 1e-14
    assert np.max(np.abs(z["Q"] - x - 1.0)) < 1e-14


@pytest.mark.few(4)
@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_accepts_coincident_frame_nodes(tmp_path, command):
    folder = tmp_path if command in ("workspace", "trace") else None
    done = run(command, written(tmp_path, COINCIDENT | {"ground": ["O", "G", "H"]}), folder=folder)
    assert done.exit_code == 0, done.output


def test_local_coordinates_on_the_ground_use_its_first_two_distinct_nodes(tmp_path):
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


def test_potential_energy_is_zero_at_the_first_ground_node(tmp_path):
    """A mass of 2 kg is 3 m below O, the block is at the height of O: V = -2 g 3."""
    done = run("simulate", written(tmp_path, PENDULUM), "--time", "0.1", folder=tmp_path)
    assert done.exit_code == 0, done.output
    table = np.genfromtxt(tmp_path / "model.simulation.csv", delimiter=",", names=True)
    assert table["energypotential"] == pytest.approx(-6 * 9.81, rel=1e-12)


@pytest.mark.parametrize("command", ["simulate", "forces", "reduce"])
def test_a_missing_inertia_is_reported_for_a_member_that_rotates(tmp_path, command):
    """The block has none either, but it cannot rotate on its guide; `inertia: 0` is accepted."""
    more = ["--time", "0.1"] if command == "simulate" else ["--input", "swing"] if command == "reduce" else []
    said = "no `inertia` is given for bob"
    assert said in run(command, written(tmp_path, PENDULUM), *more, folder=tmp_path).output
    stated = PENDULUM.replace("mass: 2,", "mass: 2, inertia: 0,")
    assert "without `inertia`" not in run(command, written(tmp_path, stated), *more, folder=tmp_path).output


TWO_RAMS_ON_ONE_LOOP = """
nodes: {O: [0,0], A: [1,0], B: [4,1], C: [5,4], D: [0.5,3], E: [1, 5]}
ground: [O]
links: {crank: [O, A], ab: [A, B], bc: [B, C], da: [D, A]}
elements: {cd: [C, D, E]}
actuators:
  m: {type: rotary, pivot: O, arm: A, law: {by: 90}}
  ram1: {type: linear, nodes: [A, C]}
  ram2: {type: linear, nodes: [B, D]}
"""
"""One ram makes the loop A B C D a rigid body, which can rotate about A: mobility 3, ram2 is redundant."""


def test_mobility_names_redundant_actuators_and_undriven_nodes_at_the_same_position(tmp_path):
    done = run("mobility", written(tmp_path, TWO_RAMS_ON_ONE_LOOP), "--json")
    report = json.loads(done.stdout)
    assert (report["mobility"], report["overdriven"], report["undriven"]) == (3, ["ram2"], ["B", "C", "D", "E"])


@pytest.mark.parametrize("verb", [trace, lambda m, n: solve(m, m.drawn_inputs, Options()), all_at_start])
def test_the_library_raises_the_errors_of_the_commands(tmp_path, verb):
    with pytest.raises(StructureError):
        verb(load(written(tmp_path, TWO_RAMS_ON_ONE_LOOP)), 10)


DEAD_CENTRE = """
nodes: {O: [0, 0], T: [5, 0], A: [1, 0], B: [4, 0]}
ground: [O, T]
links: {crank: [O, A], rod: [A, B]}
prismatic: {s: {node: B, guide: [O, T]}}
actuators: {m: {type: linear, node: B, guide: [O, T], law: {from: 4, to: 3}}}
"""
FLAT = """
nodes: {A: [0, 0], B: [1, 0], C: [4, 0], D: [3, 0]}
ground: [A, D]
links: {crank: [A, B], coupler: [B, C], follower: [D, C]}
actuators: {m: {type: rotary, pivot: A, arm: B}}
"""


@pytest.mark.parametrize(
    ("model", "kind"), [(DEAD_CENTRE, "limit"), (FLAT, "change point"), (RAMS_IN_A_PIN, "regular")]
)
def test_a_singular_drawn_position_is_classified_alike_by_all_commands(tmp_path, model, kind):
    path = written(tmp_path, model)
    report = json.loads(run("mobility", path, "--json").stdout)
    assert (report["overdriven"], report["undriven"], report["start"]) == ([], [], kind)
    listed = json.loads(run("singularities", path, "--json").stdout)["singularities"]
    start = json.loads(run("solve", path, "--json").stdout)["inputs"]
    at_start = [s["kind"] for s in listed if s["at"] == pytest.approx(start, abs=1e-9) and s["kind"] != "stationary"]
    assert at_start == [kind] * (kind != "regular")


# ------------------------------------------------------------------ random structures

SEEDS = 500
FULL = (10, 20, 24, 28, 50, 52, 62, 64, 70, 92, 94, 102, 116, 138, 142)
"""Correctly driven structures of few nodes: all circuits and configurations are found in a short time."""


def compiled(structure, noise):
    return compile_model(Model.model_validate(long_form(structure.data(noise))))


def expected(structure):
    """Return mobility, number of redundant constraints, over-driving actuators and undriven nodes."""
    oracle = structure.oracle()
    assert (oracle["unmatched"] == 0) or oracle["undriven"] or oracle["mobility"] == 0  # an unmatched freedom is free
    if oracle["mobility"] == 0:
        return 0, oracle["redundant"], list(structure.drives), []
    return oracle["mobility"], oracle["redundant"], oracle["overdriven"], oracle["undriven"]


def analyses(mechanism, full):
    """Yield the analyses that check the actuators; full: also those that take long for correctly driven structures."""
    start = mechanism.drawn_inputs
    yield lambda: solve(mechanism, start, Options(jit="off"))
    yield lambda: trace(mechanism, 1, Options(jit="off"))
    if full:
        yield lambda: all_configurations(mechanism, start)
        if mechanism.actuators:
            yield lambda: survey(mechanism)


def check_structure(seed, full):
    structure = Structure(seed)
    mechanism, wanted = compiled(structure, 0.002 * (seed % 2)), expected(structure)
    found = drawn_mobility(mechanism)
    loose = sorted(found.undriven, key=list(structure.place).index)
    assert (found.mobility, len(found.redundant), list(found.overdriven), loose) == wanted
    mobility, _, over, undriven = wanted
    unfit = bool(undriven or over)
    for verb in analyses(mechanism, full or unfit):
        if unfit:
            with pytest.raises(StructureError) as caught:
                verb()
            text = str(caught.value)
            assert "is a structure" in text if mobility == 0 else all(name in text for name in [*over, *undriven]), text
        else:
            done = verb()
            status = getattr(done, "first_status", getattr(done, "status", Status.OK))
            assert status is Status.OK or (
                seed % 2 and status is Status.NOT_ASSEMBLED
            )  # the drawn inputs may be beyond a limit
    return unfit, bool(over), mobility, wanted[1], len(structure.drives)


@pytest.mark.few(1)
@pytest.mark.parametrize("part", range(10))
def test_random_structures_have_the_mobility_of_rank_and_matching(part):
    """Drawn exactly, or with errors of 0.002 and all dimensions given; mobility, solve, trace and the others agree."""
    checked = [check_structure(seed, seed in FULL) for seed in range(part * SEEDS // 10, (part + 1) * SEEDS // 10)]
    unfit, over, mobility, redundant, drives = (np.array(column) for column in zip(*checked, strict=True))
    assert min(np.sum(unfit), np.sum(~unfit), np.sum(over), np.sum(redundant > 1)) > 3
    assert np.sum((drives > 1) & ~unfit) > 3
    assert np.sum(mobility > 2) > 1


@pytest.mark.soak
@pytest.mark.parametrize("part", range(20))
def test_more_random_structures(part):
    for seed in range(1000 + 100 * part, 1100 + 100 * part):
        check_structure(seed, False)
