"""The reducer compared with other methods: derivatives of the plan, System, and a full turn on a branch."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bundled import MODELS
from heavy_models import released
from influence_coefficients import Influence

from gimcli.dynamics.reducer import Reducer
from gimcli.motion.solve import solve
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.coordinate_partitioning import free_choice
from gimcli.structure.plan import make_plan

NAMES = sorted(path.stem for path in MODELS.glob("*.yaml"))


def reducer_of(stem, share=0.3):
    """Return a reducer at the fraction `share` of the laws of a model, and the position and inputs there."""
    mechanism = released(stem)
    start = mechanism.start_inputs
    inputs = np.array([float(a.law(np.array([share]))[0]) for a in mechanism.actuators])
    for values in (inputs, start):
        position = solve(mechanism, values, Options(tolerance=1e-13))
        if position.status is Status.OK:
            reducer = Reducer(mechanism, mechanism.drivers)
            reducer.start(position.z, values)
            if reducer.on_inputs:
                return reducer, position.z, values
    raise AssertionError(f"{stem} is singular there")


@pytest.mark.few
@pytest.mark.parametrize("stem", NAMES)
def test_influence_coefficients_agree_with_those_of_the_plan(stem):
    """B and the accelerations at constant input speeds, compared with an independent program."""
    reducer, z, inputs = reducer_of(stem)
    mechanism = reducer.mechanism
    drivers, follow = list(mechanism.drivers), mechanism.following
    rates = np.random.default_rng(11).normal(size=len(drivers))
    assert reducer.move(inputs[drivers], rates, np.zeros(len(drivers)))
    expected = Influence(mechanism, make_plan(mechanism), points=mechanism.nodes).at(z, inputs, follow @ rates)
    free = [k for k, name in enumerate(mechanism.nodes) if np.all(np.isfinite(expected.points[k]))]
    b, bias = reducer.nodes(reducer.at.b), reducer.nodes(reducer.room.acceleration)
    scale = 1.0 + np.abs(expected.points[free]).max()
    assert np.abs(reducer.nodes(reducer.at.v) - z)[free].max() < 1e-11
    assert np.abs(b.T - expected.points @ follow)[free].max() < 1e-9 * scale
    assert np.abs(bias - expected.points_bias)[free].max() < 1e-8 * scale**3


@pytest.mark.parametrize("stem", ["watt_durango", "whitworth", "five_bar", "double_butterfly"])
def test_results_do_not_depend_on_the_independent_variables(stem):
    """Velocities, accelerations and energies are the same for another choice of independent variables."""
    reducer, _, inputs = reducer_of(stem)
    count = len(inputs)
    rates = 0.5 + np.random.default_rng(5).random(count)
    assert reducer.move(inputs, rates, np.zeros(count))
    v, velocity, energy = reducer.at.v.copy(), reducer.room.velocity.copy(), reducer.out.energy.copy()
    acceleration = reducer.acceleration
    reducer.accept()
    choice = free_choice(reducer.terms, v, (), count)
    assert choice is not None
    assert reducer.set_base(v, choice)
    assert reducer.move(v[reducer.own], velocity[reducer.own], np.zeros(count))
    assert np.abs(reducer.room.velocity - velocity).max() < 1e-10 * np.abs(velocity).max()
    assert np.abs(reducer.acceleration - acceleration).max() < 1e-9 * np.abs(acceleration).max()
    assert np.abs(reducer.out.energy - energy).max() < 1e-10 * np.abs(energy).max()


@pytest.mark.few(3)
@pytest.mark.parametrize("stem", ["watt_durango", "crank_rocker", "whitworth", "slider_crank", "jansen", "klann"])
def test_a_full_turn_in_large_steps_returns_to_the_start(stem):
    """For every step size no dyad changes its configuration."""
    reducer, z, inputs = reducer_of(stem, 0.0)
    for steps in (3, 7, 24):
        for turned in np.linspace(0.0, 2.0 * math.pi, steps + 1)[1:]:
            assert reducer.move(inputs + turned, np.ones(1), np.zeros(1))
            reducer.accept()
        assert np.abs(reducer.nodes(reducer.base.v) - z).max() < 1e-11
        reducer.start(z, inputs)


def test_a_target_beyond_a_dead_point_is_not_reached():
    """A crank angle out of reach has no position, and the base position does not change."""
    reducer, z, inputs = reducer_of("double_butterfly", 0.1)
    assert not reducer.move(inputs + 30.0, np.ones(1), np.zeros(1))
    assert np.abs(reducer.nodes(reducer.base.v) - z).max() < 1e-11
