"""The global search finds the least errors known of path problems, on four-bars in closed form."""

import numpy as np
import pytest
from four_bar_positions import FourBarPoint
from path_problems import NINE_POINT_LENGTHS, PROBLEMS, TURN

from gimcli.fitting.least_squares import FitProblem, refined, trials
from gimcli.fitting.search import search
from gimcli.fitting.starts import linear_dimensions, moves, periodic_dimensions
from gimcli.fitting.targets import FitRange, Targets

NOMINAL = np.array([4.0, 1.5, 3.5, 3.0, 1.0, 1.0, 0.0, 0.0, 0.0])


def problem(name):
    one = PROBLEMS[name]
    z = np.array(one.targets)
    inputs = np.radians(one.inputs) if one.inputs else np.zeros(len(z))
    values = np.stack((z.real, z.imag), axis=-1)
    targets = Targets(values, np.ones(2), np.zeros(2), inputs, one.timing, FitRange(0.0, TURN, True))
    quantity, (lower, upper) = FourBarPoint(), one.bounds
    periodic = periodic_dimensions(quantity, NOMINAL, lower, upper, targets.range.grid(5))
    return FitProblem(quantity, targets, lower, upper, periodic)


def least(name, count, seed=0):
    """Return the best trial of a search; one that is exact ends it."""
    fit = problem(name)
    for found in search(fit, NOMINAL, count, seed):
        if found.trials.error[0] <= fit.zero:
            break
    return fit, found.trials[:1]


@pytest.mark.parametrize(("name", "count"), [("L5", 4000), ("S6", 4000), ("C18", 8000)])
def test_least_errors(name, count):
    fit, best = least(name, count)
    assert best.error[0] == pytest.approx(PROBLEMS[name].error, rel=2e-8)
    assert moves(fit, best.designs).all()


@pytest.mark.parametrize("name", ["V6", "N9"])
def test_exact_fits(name):
    fit, best = least(name, 8000)
    inputs = fit.inputs(best.designs, best.own)
    assert best.error[0] < 1e-26
    assert fit.targets.ordered(inputs, best.sense).all()
    assert abs(inputs[0, -1] - inputs[0, 0]) < TURN


def test_nine_points():
    """The only two four-bars that meet the nine points in order on one branch are known (cognates of each other)."""
    _, best = least("N9", 8000, seed=1)
    known = np.array(NINE_POINT_LENGTHS)
    assert np.abs(known - best.designs[0, :4]).max(axis=1).min() < 1e-9


def test_same_seed_same_result():
    one, other = (least("S6", 1000, seed=5)[1] for _ in range(2))
    assert np.array_equal(one.designs, other.designs)
    assert one.error[0] == other.error[0]


def test_linear_dimensions():
    """The coupler point and the place of the frame; lengths and directions act through the loop."""
    fit = problem("V6")
    found = linear_dimensions(fit.quantity, NOMINAL, fit.lower, fit.upper, fit.targets.range.grid(7))
    assert found.tolist() == [4, 5, 7, 8]


def test_periodic_dimensions():
    """Only the direction of the frame, whose bounds are a full turn apart."""
    assert np.flatnonzero(problem("V6").periodic).tolist() == [6]
    assert not problem("L5").periodic.any()


def test_directions_pass_their_bounds():
    """From 0.05 to 6.2 rad is a short way over the bounds 0 and 2 pi."""
    own = FourBarPoint()
    known = np.array([[4.0, 1.5, 3.5, 3.0, 1.0, 1.0, 6.2, 0.0, 0.0]])
    inputs = np.linspace(0.0, 5.0, 6)
    targets = Targets(
        own.values(known, inputs[None])[0], np.ones(2), np.zeros(2), inputs, "given", FitRange(0, TURN, True)
    )
    lower, upper = known[0] - 0.1, known[0] + 0.1
    lower[6], upper[6] = 0.0, TURN
    fit = FitProblem(own, targets, lower, upper, np.arange(9) == 6)
    begin = np.where(np.arange(9) == 6, 0.05, known)
    found = refined(fit, trials(fit, begin, np.zeros((1, 0)), np.zeros(1)), 60)
    assert fit.within(found.designs) == pytest.approx(known, abs=1e-9)


def test_bounds_hold():
    """The least error of S6 is at two bounds: r1 = 50 and r2 = 5."""
    fit, best = least("S6", 4000)
    assert best.designs[0, :2] == pytest.approx([50.0, 5.0], abs=1e-9)
    assert np.all(best.designs >= fit.lower)
    assert np.all(best.designs <= fit.upper)


def test_steps_never_increase_the_error():
    fit = problem("C18")
    generator = np.random.default_rng(0)
    designs = generator.uniform(fit.lower, fit.upper, (200, 9))
    start = trials(fit, designs, generator.uniform(0.0, TURN, (200, 1)), np.zeros(200))
    before = start.error
    after = refined(fit, start, 5)
    assert np.all(after.error <= before)
    assert np.any(after.error < 0.5 * before)
    assert after.error == pytest.approx(fit.errors(after.designs, fit.inputs(after.designs, after.own)), rel=1e-12)
