"""The counts of operations agree with kernels that run on numbers which count their operations."""

import numpy as np
import pytest
from bundled import MODELS
from counted import COUNT, counted_array, operations

from gimcli import load
from gimcli.comparison import operations as counts
from gimcli.comparison.bodies import AbsoluteCoordinates, frame_poses
from gimcli.comparison.coordinates import JointCoordinates, NaturalCoordinates
from gimcli.gim import sweeps
from gimcli.gim.sweeper import Sweeper
from gimcli.kernels import bodies, linear, loci, newton as kernel, points, sweep
from gimcli.kernels.linear import lu_solve, qr_solve
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Packed
from gimcli.positions.options import Options
from gimcli.structure.plan import make_plan


@pytest.mark.few
def test_sweeps(model):
    mechanism = load(model)
    values, z = mechanism.drawn_inputs, mechanism.drawn
    moves = Sweeper(mechanism, Options(method="gim"), plain).moves
    given = (z.real.copy(), z.imag.copy(), values, np.cos(values), np.sin(values), *sweeps.pack(moves))
    cost = counts.sweep_cost(mechanism, moves)
    check = operations(sweep.worst_errors, *given, mechanism.size, np.zeros(2))
    assert cost.position == check
    assert cost.iterations == (operations(sweep.sweep, *given) + check,)


def iteration(cost, rows, m, n):
    """Assert that an iteration consists of its rows, the linear algebra of a full matrix, and the correction."""
    algebra = counts.elimination(m, n) + counts.substitution(m, n) + 2 * n
    assert cost.iterations == (pytest.approx(rows + algebra, rel=1e-12),)
    assert cost.unknowns == (n,)


def empty(m, n):
    return np.zeros(m), np.zeros((m, 6)), np.zeros((m, 2), dtype=np.int64), np.zeros((m, n))


def test_absolute_coordinates(model):
    system = AbsoluteCoordinates(load(model))
    mechanism, (f, g, gb, _) = system.mechanism, empty(system.equations, system.unknowns)
    pose, q = frame_poses(1, system.bodies.count)[0], system.start(mechanism.drawn)
    rows = operations(bodies.place_bodies, q, system.layout, pose)
    bodies.place_bodies(q, system.layout, pose)
    pairs = system.bodies.arrays(system.bodies.pairs)
    rows += operations(bodies.pair_rows, mechanism.drawn_inputs, *pairs, pose, f, g, gb)
    iteration(counts.coordinates_cost(system), rows, system.equations, system.unknowns)


def test_joint_coordinates(model):
    system = JointCoordinates(load(model))
    values, (f, g, gb, j) = system.mechanism.drawn_inputs, empty(system.equations, system.unknowns)
    pose, q = frame_poses(1, system.bodies.count)[0], system.start(system.mechanism.drawn)
    (ji, jz, above), v = system.joints, np.zeros((system.unknowns, 3))
    rows = operations(bodies.place_tree, q, values, ji, jz, pose, v)
    bodies.place_tree(q, values, ji, jz, pose, v)
    pairs = system.bodies.arrays(system.equated)
    rows += operations(bodies.pair_rows, values, *pairs, pose, f, g, gb)
    bodies.pair_rows(values, *pairs, pose, f, g, gb)
    rows += operations(bodies.joint_rows, g, gb, ji, above, pose, v, j)
    iteration(counts.coordinates_cost(system), rows, system.equations, system.unknowns)


def test_natural_coordinates(model):
    system = NaturalCoordinates(load(model))
    values, z = system.mechanism.drawn_inputs, system.mechanism.drawn
    f, j = np.zeros(system.equations), np.zeros((system.equations, system.unknowns))
    given = (z.real.copy(), z.imag.copy(), values, np.cos(values), np.sin(values))
    rows = operations(points.point_rows, *given, system.heads, system.factors, system.columns, f, j)
    iteration(counts.coordinates_cost(system), rows, system.equations, system.unknowns)


@pytest.mark.parametrize(("m", "n"), [(8, 8), (27, 27), (12, 9), (40, 30)])
def test_linear_algebra_of_full_matrices(m, n):
    generator = np.random.default_rng(0)
    table, right, work = generator.random((m, n)), generator.random(m), np.zeros(2 * n)
    if m == n:
        factor, solve = (table, n, work), (n, work, right)
        factored, solved = operations(linear.lu_factor, *factor), linear.lu_solve
        linear.lu_factor(*factor)
    else:
        factor, solve = (table, m, n, work), (m, n, work, right)
        factored, solved = operations(linear.qr_factor, *factor), linear.qr_solve
        linear.qr_factor(*factor)
    assert factored == pytest.approx(counts.elimination(m, n), rel=1.2 / n)
    assert operations(solved, table, *solve) == pytest.approx(counts.substitution(m, n), rel=1.2 / n)


def test_closed_forms():
    forms = {
        loci.circle_circle: ((0.1, 0.2, 1.0, 1.1, 0.3, 0.9, 1.0), 47),
        loci.circle_line: ((0.1, 0.2, 1.0, 1.1, 0.3, 0.6, 0.8, 0.1, 1.0), 29),
        loci.line_line: ((0.1, 0.2, 1.0, 0.1, 1.1, 0.3, 0.6, 0.8, 0.1, 0.1), 25),
        loci.tilt: ((0.4, 0.5, 0.1, 1.0), 23),
    }
    for form, (given, expected) in forms.items():
        arrays = [counted_array(np.array([v])) for v in given]
        COUNT["operations"] = 0
        form(*arrays)
        assert COUNT["operations"] == expected, form.__name__


@pytest.mark.parametrize("closed_forms", [True, False])
def test_iterations_of_groups(model, closed_forms):
    """Newton-Raphson on base nodes; elimination skips zeros, and small matrices have extra terms: agreement to 30 %."""
    mechanism = load(model)
    plan, values, z = make_plan(mechanism, closed_forms), mechanism.drawn_inputs, mechanism.drawn
    for group in plan.coupled:
        g = Packed(group).arrays
        room = kernel.room([g], plan.registers, len(values))
        room.x[:], room.y[:] = z.real[g.nodes], z.imag[g.nodes]
        room.dx[:], room.dy[:], room.values[:] = 0.6, 0.8, values
        room.cos[:], room.sin[:] = np.cos(values), np.sin(values)
        kernel.clear(g, room)
        kernel.coefficients(g, room)
        assert 0.7 < operations(kernel.factor, g, room) / counts.group_factors(group) < 1.3
        kernel.factor(g, room)
        m, n = g.rows, 2 * g.base
        solve = (lu_solve, room.j, n) if m == n else (qr_solve, room.j, m, n)
        correction = operations(*solve, room.order, room.f)
        correction += sum(operations(part, g, room) for part in (kernel.carry, kernel.equations, kernel.move))
        assert 0.7 < correction / counts.group_iteration(group) < 1.3


@pytest.mark.parametrize(
    ("name", "links", "nodes"), [("gim_fig13a", 3, 1), ("gim_fig13b", 5, 3), ("gim_fig13c", 7, 5), ("ten_bar", 9, 8)]
)
def test_the_papers_counts(name, links, nodes):
    """Number of moving links and of moving nodes of table 1."""
    mechanism = load(MODELS / f"{name}.yaml")
    assert counts.paper_iteration(mechanism) == 9 * links**3
    assert counts.paper_sweep(mechanism) == 12 * nodes
