"""What the reducer knows of a position, against other means: the plan's derivatives, System, a walk round a branch."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bundled import MODELS
from heavy_models import let_go
from influence_coefficients import Influence

from gimcli.dynamics.reducer import Reducer
from gimcli.motion.solve import solve
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.coordinate_partitioning import free_choice, gradients, residuals
from gimcli.structure.plan import make_plan
from gimcli.structure.polynomials import make_terms
from gimcli.structure.system import System

NAMES = sorted(path.stem for path in MODELS.glob("*.yaml"))


def standing(stem, share=0.3):
    """Return a reducer a part of the way along the laws of a model, the position and the inputs there."""
    mechanism = let_go(stem)
    start = mechanism.start_inputs
    inputs = np.array([float(a.law(np.array([share]))[0]) for a in mechanism.actuators])
    for values in (inputs, start):
        position = solve(mechanism, values, Options(tolerance=1e-13))
        if position.status is Status.OK:
            reducer = Reducer(mechanism, tuple(range(len(values))))
            reducer.start(position.z, values)
            if reducer.on_inputs:
                return reducer, position.z, values
    raise AssertionError(f"{stem} is singular there")


@pytest.mark.parametrize("stem", NAMES)
def test_terms_are_the_system(stem):
    """Equations and gradients of the sparse terms against the dense ones, at places far from assembled."""
    mechanism = let_go(stem)
    terms, system, rng = make_terms(mechanism), System(mechanism), np.random.default_rng(3)
    x, u = rng.normal(size=system.n), rng.normal(size=len(mechanism.actuators))
    z = system.nodes(x)
    v = np.zeros(terms.variables)
    v[0 : terms.first_reading : 2], v[1 : terms.first_reading : 2], v[-1] = z.real, z.imag, 1.0
    v[terms.first_reading : -1] = u
    assert np.allclose(residuals(terms, v), system.residual(x, u), atol=1e-12)
    table = gradients(terms, v)
    assert np.allclose(table[:, list(terms.moving)], system.jacobian(x, u), atol=1e-12)
    assert np.allclose(table[:, terms.first_reading : -1], system.by_inputs(x, u), atol=1e-12)


@pytest.mark.few
@pytest.mark.parametrize("stem", NAMES)
def test_influence_is_that_of_the_plan(stem):
    """B and the accelerations without those of the inputs, by two programs that share no line."""
    reducer, z, inputs = standing(stem)
    mechanism = reducer.mechanism
    rates = np.random.default_rng(11).normal(size=len(inputs))
    assert reducer.move(inputs, rates, np.zeros(len(inputs)))
    state = reducer.state()
    told = Influence(mechanism, make_plan(mechanism), points=mechanism.nodes).at(z, inputs, rates)
    free = [k for k, name in enumerate(mechanism.nodes) if np.all(np.isfinite(told.points[k]))]
    b, bias = reducer.nodes(state.b), reducer.nodes(state.bias)
    scale = 1.0 + np.abs(told.points[free]).max()
    assert np.abs(reducer.nodes(state.v) - z)[free].max() < 1e-11
    assert np.abs(b.T - told.points)[free].max() < 1e-9 * scale
    assert np.abs(bias - told.points_bias)[free].max() < 1e-8 * scale**3


@pytest.mark.parametrize("stem", ["watt_durango", "whitworth", "five_bar", "double_butterfly"])
def test_other_independent_variables_tell_the_same(stem):
    """Accelerations of all nodes do not depend on the choice; nor do energies."""
    reducer, _, inputs = standing(stem)
    count = len(inputs)
    rates = 0.5 + np.random.default_rng(5).random(count)
    assert reducer.move(inputs, rates, np.zeros(count))
    before = reducer.state()
    reducer.accept()
    choice = free_choice(reducer.terms, before.v, (), count)
    assert choice is not None
    assert reducer.stand(before.v, choice)
    assert reducer.move(before.v[reducer.own], before.velocity[reducer.own], np.zeros(count))
    after = reducer.state()
    scale = np.abs(before.acceleration).max()
    assert np.abs(after.velocity - before.velocity).max() < 1e-10 * np.abs(before.velocity).max()
    assert np.abs(after.acceleration - before.acceleration).max() < 1e-9 * scale
    assert np.abs(after.energy - before.energy).max() < 1e-10 * np.abs(before.energy).max()


@pytest.mark.parametrize("stem", ["watt_durango", "crank_rocker", "whitworth", "slider_crank", "jansen", "klann"])
def test_a_branch_is_kept_round_a_turn_in_large_steps(stem):
    """Back at the start after a turn, in any step: no dyad has turned over."""
    reducer, z, inputs = standing(stem, 0.0)
    for steps in (3, 7, 24):
        for turned in np.linspace(0.0, 2.0 * math.pi, steps + 1)[1:]:
            assert reducer.move(inputs + turned, np.ones(1), np.zeros(1))
            reducer.accept()
        assert np.abs(reducer.nodes(reducer.base.v) - z).max() < 1e-11
        reducer.start(z, inputs)


def test_two_sides_of_a_dead_point_are_not_joined():
    """A crank asked beyond its reach: there is no position, and where it stands it still stands."""
    reducer, z, inputs = standing("double_butterfly", 0.1)
    assert not reducer.move(inputs + 30.0, np.ones(1), np.zeros(1))
    assert np.abs(reducer.nodes(reducer.base.v) - z).max() < 1e-11
