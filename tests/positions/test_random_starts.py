"""From random starts `auto` converges at least as often, to as many configurations, as sweeps or Newton-Raphson.

The same measurement as tests/benchmarks/random_starts.py, with fewer starts: mechanisms of dyads (some sides of which
cannot be assembled), of one coupled group, with three inputs, and with a redundant constraint.
"""

import numpy as np
import pytest
import random_starts
import yaml
from random_mechanisms import Growth

from gimcli import load
from gimcli.motion.solve import random_guess, solve
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options
from gimcli.status import Status

STARTS = range(60)


@pytest.mark.few(2)
@pytest.mark.parametrize(
    "name", ["crank_rocker", "klann", "stephenson_3_far", "platform_3rrr", "parallelogram_third_crank"]
)
def test_auto_is_at_least_as_good_as_either(name):
    mechanism = load(random_starts.MODELS / f"{name}.yaml")
    found = {m: random_starts.attempt(mechanism, m, STARTS, plain) for m in random_starts.METHODS}
    for other in ("gim", "newton"):
        assert found["auto"].settled >= found[other].settled, other
        assert found["auto"].configurations(mechanism.size) >= found[other].configurations(mechanism.size), other
    assert found["auto"].settled == len(STARTS)  # an assembled position exists for each


@pytest.mark.parametrize("name", ["klann", "stephenson_1"])
def test_a_side_that_cannot_be_assembled_is_exchanged(name):
    """Some random starts have sides that cannot be assembled; `gim solve --start random` tries the other sides."""
    mechanism = load(random_starts.MODELS / f"{name}.yaml")
    inputs = mechanism.drawn_inputs
    for seed in range(20):
        position = solve(mechanism, inputs, Options(seed=seed))
        assert position.status is Status.OK
        assert position.residual.total[0] <= 1e-10


def test_a_start_that_does_not_converge_is_replaced():
    """Newton-Raphson converges from none of sixty perturbations of this start, but from other random starts."""
    mechanism = load(random_starts.MODELS / "gim_fig11.yaml")
    position = solve(mechanism, mechanism.drawn_inputs, Options(seed=159))
    assert position.status is Status.OK
    assert position.residual.total[0] <= 1e-10


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", [*range(8), 24, 28, 37, 59])
def test_random_mechanisms_are_assembled_from_every_start(seed, tmp_path):
    """Each can be assembled; in the last four, a group has configurations with which the rest cannot be assembled."""
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(Growth(seed, 1 + seed % 5).model()))
    mechanism = load(path)
    found = {m: random_starts.attempt(mechanism, m, range(20), plain) for m in ("newton", "auto")}
    assert found["auto"].settled == 20 >= found["newton"].settled


def test_a_group_with_redundant_constraints_is_solved_with_all_satisfied():
    """Least squares may converge to a minimum with a residual; then another start is used."""
    mechanism = load(random_starts.MODELS / "plantigrade.yaml")
    assert random_starts.attempt(mechanism, "auto", range(5), plain).settled == 5


def test_drawn_sides_are_kept_without_a_random_start():
    """From given coordinates no side is exchanged: if these sides cannot be assembled, the status says so."""
    mechanism = load(random_starts.MODELS / "klann.yaml")
    solver = random_starts.solver(mechanism, "newton", plain)
    inputs = mechanism.drawn_inputs
    lost = next(s for s in STARTS if not solver(inputs, random_guess(mechanism, s))[0])
    from gimcli.motion.assemble import Assembler
    from gimcli.structure.plan import make_plan

    guess = random_guess(mechanism, lost)
    drawn, anywhere = (Assembler(mechanism, make_plan(mechanism), plain, 1e-10, free) for free in (False, True))
    assert drawn.assemble(inputs, guess).status is not Status.OK
    done = anywhere.assemble(inputs, guess)
    assert done.status is Status.OK
    assert np.all(np.isfinite(done.row.x))
