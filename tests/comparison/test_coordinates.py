"""Joint, absolute and natural coordinates agree with path following, closed forms and difference quotients."""

import math
from itertools import pairwise

import numpy as np
import pytest
import yaml
from bundled import FEWEST, MODELS, run_model
from random_mechanisms import Growth
from table1_operations import CASES, displaced

from gimcli import GimError, load
from gimcli.comparison.bodies import frame_poses
from gimcli.comparison.methods import COORDINATES, follow
from gimcli.kernels import bodies, jit, points
from gimcli.motion.motion import trace
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options

STEPS = 72
"""Steps of a bundled motion: 5 degrees per step, so that Newton-Raphson does not converge to another branch."""


def agree(motion, names=tuple(COORDINATES), tolerance=1e-11):
    mechanism = motion.mechanism
    for name in names:
        found = follow(COORDINATES[name](mechanism), motion.inputs, motion.z[:, 0], tolerance, plain)
        assert found.good.all(), name
        assert np.max(np.abs(found.z - motion.z)) < 1e-9 * mechanism.size, name


@pytest.mark.few(*FEWEST)
def test_every_model_agrees_with_path_following(model):
    motion = trace(load(model), STEPS, Options(tolerance=1e-11))
    assert motion.good.all()
    agree(motion)


@pytest.mark.parametrize("name", ["gim_fig11", "platform_3rpr", "stephenson_3_far"])
def test_compiled_and_plain_iterations_agree(name):
    motion = trace(load(MODELS / f"{name}.yaml"), STEPS, Options(tolerance=1e-11))
    for make in COORDINATES.values():
        one, other = (
            follow(make(motion.mechanism), motion.inputs, motion.z[:, 0], 1e-11, run) for run in (plain, jit.compiled)
        )
        assert np.array_equal(one.iterations, other.iterations)
        assert np.array_equal(one.good, other.good)
        assert np.max(np.abs(one.z - other.z)) < 1e-13 * motion.mechanism.size


@pytest.mark.parametrize(("seeds", "least"), [(10, 4), pytest.param(40, 15, marks=pytest.mark.soak)])
def test_random_mechanisms_agree(seeds, least, tmp_path):
    """The mechanisms include pins in slots, true prismatic pairs and drives between moving members."""
    tried = 0
    for seed in range(seeds):
        (tmp_path / "model.yaml").write_text(yaml.safe_dump(Growth(seed, 1 + seed % 5).model()))
        try:
            motion = trace(load(tmp_path / "model.yaml"), 96, Options(tolerance=1e-11))
        except GimError:
            continue
        if motion.good.all():
            agree(motion)
            tried += 1
    assert tried >= least


def written(tmp_path, text):
    (tmp_path / "model.yaml").write_text(text)
    return load(tmp_path / "model.yaml")


TABLE = """
nodes: {O: [0, 0], G: [10, 0], H: [0, 1], A: [2, 0], B: [3, 0], P: [4, 2], Q: [2.2, 3.5], R: [7, 4]}
ground: [O, G, H]
links: {base: [A, B]}
elements: {plate: [P, Q, R]}
prismatic: {rail: {nodes: [A, B], guide: [O, G]}}
actuators:
  carriage: {type: linear, node: A, guide: [G, O], law: {from: 8, to: 5}}
  x: {type: linear, node: P, guide: [O, G], law: {from: 4, to: 5}}
  y: {type: linear, node: P, guide: [O, H], law: {from: 2, to: 1}}
  turn: {type: linear, node: R, guide: [O, H], law: {from: 4, to: 3.5}}
trace: [A, P, R]
"""


def test_a_body_positioned_by_linear_inputs_only(tmp_path):
    """The plate has no joint and is a free body of the tree. R follows from its height and its distance from P."""
    mechanism = written(tmp_path, TABLE)
    motion = trace(mechanism, 12, Options(tolerance=1e-12))
    reach = abs(complex(3, 2))
    for name, make in COORDINATES.items():
        found = follow(make(mechanism), motion.inputs, motion.z[:, 0], 1e-12, plain)
        a, p, r = (mechanism.to_file(found.z[mechanism.nodes.index(n)]) for n in "APR")
        t = np.linspace(0, 1, 13)
        assert np.allclose(a, 10 - (8 - 3 * t), atol=1e-12), name
        assert np.allclose(p, 4 + t + 1j * (2 - t), atol=1e-12), name
        rise = (4 - 0.5 * t) - (2 - t)
        assert np.allclose(r, p + np.sqrt(reach**2 - rise**2) + 1j * rise, atol=1e-12), name
    assert COORDINATES["joint"](mechanism).unknowns == 3  # the travel of the carriage is an input


CYLINDERS = """
nodes: {O: [0, 0], G: [6, 0], P: [2, 3], C: [4, 6]}
ground: [O, G]
links: {arm: [P, C]}
actuators:
  left: {type: linear, nodes: [O, P], law: {from: 3.6, to: 4.4}}
  right: {type: linear, nodes: [G, P], law: {from: 5, to: 4}}
  wrist: {type: rotary, pivot: P, arm: C, law: {by: 40}}
trace: [P, C]
"""


def test_two_linear_actuators_agree_with_the_cosine_law(tmp_path):
    """One linear actuator is a joint of the tree, with its direction as variable; the other closes the triangle."""
    mechanism = written(tmp_path, CYLINDERS)
    motion = trace(mechanism, 24, Options(tolerance=1e-12))
    left, right = (motion.inputs[k] * mechanism.scale for k in (0, 1))
    turn = np.arccos((36 + left**2 - right**2) / (12 * left))
    for name, make in COORDINATES.items():
        found = follow(make(mechanism), motion.inputs, motion.z[:, 0], 1e-12, plain)
        p, c = (mechanism.to_file(found.z[mechanism.nodes.index(n)]) for n in "PC")
        assert np.allclose(p, left * np.exp(1j * turn), atol=1e-11), name
        assert np.allclose(c - p, abs(complex(2, 3)) * np.exp(1j * motion.inputs[2]), atol=1e-11), name


TRUNNION = """
nodes: {O: [0, 0], G: [10, 0], W: [0, 2], K: [1, 1], U: [-2, -2], V: [4, 4], T: [3, 5], H: [-2, 5], L: [-2, -9]}
ground: [O, G, H, L]
elements: {block: [O, W, K], rod: [T, U, V]}
prismatic:
  trunnion: {nodes: [O, K], guide: [U, V]}
  slot: {node: U, guide: [H, L]}
actuators: {motor: {type: rotary, pivot: O, arm: K, law: {from: 45, to: 80}}}
trace: [U, V, T]
"""


def test_a_guide_on_the_sliding_body(tmp_path):
    """The rod slides through a driven trunnion and ends in a slot x = -2: U = -2 (1 + i tan)."""
    mechanism = written(tmp_path, TRUNNION)
    motion = trace(mechanism, 24, Options(tolerance=1e-12))
    ray = np.exp(1j * motion.inputs[0])
    u = -2.0 / ray.real * ray
    t = u + (complex(5, 7) / complex(1, 1)) * abs(complex(1, 1)) * ray
    for name, make in COORDINATES.items():
        found = follow(make(mechanism), motion.inputs, motion.z[:, 0], 1e-12, plain)
        assert found.good.all(), name
        assert np.allclose(mechanism.to_file(found.z[mechanism.nodes.index("U")]), u, atol=1e-10), name
        assert np.allclose(mechanism.to_file(found.z[mechanism.nodes.index("T")]), t, atol=1e-10), name
    joint = COORDINATES["joint"](mechanism)
    assert (joint.unknowns, joint.equations) == (1, 1)


@pytest.mark.parametrize("name", ["parallelogram_third_crank", "plantigrade", "dixon_k33"])
def test_there_are_more_equations_than_unknowns_with_redundant_constraints(name):
    mechanism = load(MODELS / f"{name}.yaml")
    for make in COORDINATES.values():
        system = make(mechanism)
        assert system.equations > system.unknowns


@pytest.mark.parametrize(
    ("case", "links", "loops", "moving"), list(zip(CASES, (3, 5, 7, 9), (1, 2, 3, 4), (2, 4, 7, 9), strict=True))
)
def test_unknowns_of_table_1(case, links, loops, moving):
    """Absolute: three per link; joint: two per loop, because the input is no unknown; natural: two per node."""
    mechanism = displaced(case)[0]
    unknowns = {name: make(mechanism).unknowns for name, make in COORDINATES.items()}
    assert unknowns == {"joint": 2 * loops, "absolute": 3 * links, "natural": 2 * moving}


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.model)
def test_iterations_of_table_1(case):
    """Absolute coordinates, started in the previous position, stopped at 1e-5 of the length unit and 1e-5 rad."""
    mechanism, inputs, start = displaced(case)
    found = follow(
        COORDINATES["absolute"](mechanism), inputs[:, None], start, 1e-5, plain, length=1.0 / mechanism.scale
    )
    assert found.iterations[0] in case.iterations


@pytest.mark.few(6)
@pytest.mark.parametrize("name", COORDINATES)
@pytest.mark.parametrize("model_name", ["gim_fig13c", "whitworth", "platform_3rpr", "dixon_k33"])
def test_convergence_is_quadratic(name, model_name):
    traced = run_model(model_name, steps=24, tolerance=1e-14)
    mechanism, motion = traced.mechanism, traced.motion
    system, errors = COORDINATES[name](mechanism), []
    for count in range(2, 10):  # the position returned is that before the last correction
        z = system.follow(motion.inputs[:, 3:4], motion.z[:, 0], 0.0, mechanism.size, count, plain)[0]
        errors.append(float(np.max(np.abs(z[:, 0] - motion.z[:, 3]))) / mechanism.size)
    chosen = [e for e in errors if 1e-13 < e < 3e-2]
    assert len(chosen) >= 2
    order = [math.log(b) / math.log(a) for a, b in pairwise(chosen)]
    assert max(order) > 1.6
    assert errors[-1] < 1e-14


def tables(system, name, q, values, z):
    """Return residuals and Jacobian at unknowns q, computed by the kernels alone."""
    f, j = np.zeros(system.equations), np.zeros((system.equations, system.unknowns))
    if name == "natural":
        x, y = z.real.copy(), z.imag.copy()
        points.move_points(q, system.columns, x, y)
        heads = system.heads, system.factors, system.columns
        points.point_rows(x, y, values, np.cos(values), np.sin(values), *heads, f, j)
        return f, j
    g, gb = np.zeros((system.equations, 6)), np.zeros((system.equations, 2), dtype=np.int64)
    pose = frame_poses(1, system.bodies.count)[0]
    if name == "joint":
        (ji, jz, above), v = system.joints, np.zeros((system.unknowns, 3))
        bodies.place_tree(q, values, ji, jz, pose, v)
        bodies.pair_rows(values, *system.bodies.arrays(system.equated), pose, f, g, gb)
        bodies.joint_rows(g, gb, ji, above, pose, v, j)
    else:
        bodies.place_bodies(q, system.layout, pose)
        bodies.pair_rows(values, *system.bodies.arrays(system.bodies.pairs), pose, f, g, gb)
        bodies.absolute_rows(g, gb, system.layout, j)
    return f, j


@pytest.mark.few
@pytest.mark.parametrize("name", COORDINATES)
def test_jacobian_agrees_with_central_differences(name, model):
    mechanism = load(model)
    system, values, h = COORDINATES[name](mechanism), mechanism.drawn_inputs, 1e-6
    generator = np.random.default_rng(0)
    q = system.start(mechanism.drawn) + 0.1 * generator.standard_normal(system.unknowns)
    _, j = tables(system, name, q, values, mechanism.drawn)
    for k in range(system.unknowns):
        step = h * np.eye(system.unknowns)[k]
        ahead, behind = (tables(system, name, q + s * step, values, mechanism.drawn)[0] for s in (1, -1))
        assert np.max(np.abs((ahead - behind) / (2 * h) - j[:, k])) < 1e-7


def test_a_position_that_does_not_exist_fails_and_the_next_rows_are_solved(tmp_path):
    mechanism = written(tmp_path, CYLINDERS)
    motion = trace(mechanism, 8, Options(tolerance=1e-12))
    inputs = motion.inputs.copy()
    inputs[0, 4] = 100.0  # too long for a triangle
    for make in COORDINATES.values():
        found = follow(make(mechanism), inputs, motion.z[:, 0], 1e-12, plain)
        assert list(np.flatnonzero(~found.good)) == [4]
        assert np.all(np.isnan(found.z[:, 4]))
        others = np.arange(9) != 4
        assert np.max(np.abs(found.z - motion.z)[:, others]) < 1e-9 * mechanism.size


def test_a_row_that_has_not_converged_is_not_solved():
    mechanism, inputs, start = displaced(CASES[1])
    for make in COORDINATES.values():
        found = follow(make(mechanism), inputs[:, None], start, 1e-11, plain, most=3)
        assert not found.good.any()
        assert found.iterations[0] == 3
