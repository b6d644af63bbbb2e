"""Properties of random mechanisms: the known position is found, and results do not depend on the frame of reference.

A mechanism is composed group by group (dyads of all kinds, triads, members of four and five nodes, true prismatic
pairs; driven at the crank, at another pivot, or by a length) in a random position, which is therefore known. Hypothesis
chooses the structure and simplifies it when a test fails; the dimensions come from a seed.
"""

import copy
import json
import math
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings, strategies as st
from random_mechanisms import DRIVES, KINDS, Growth
from specifications import Run, errors, moved, run, shuffled, size

from gimcli import GimError, load
from gimcli.motion.solve import solve
from gimcli.positions.options import Options
from gimcli.status import Status

TOLERANCE = 1e-10
BLUNT = 1e4
"""Positions with a larger condition number count as singular and are left out."""

FEW, MANY = 18, 400
QUICK = settings(
    max_examples=FEW, deadline=None, derandomize=True, database=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)  # fmt: skip
LONG = settings(QUICK, max_examples=MANY, derandomize=False)


def grown(kinds):
    groups = st.lists(st.sampled_from(kinds), min_size=1, max_size=5)
    return st.builds(Growth, st.integers(0, 2**32 - 1), groups, st.sampled_from(DRIVES))


growths = grown(KINDS)
bounded = grown([kind for kind in KINDS if kind != "prp"])  # two lines may become parallel: see test_extremes_methods


# --- independent check of a position ---------------------------------------------------------------------


def signed(spec, z, value):
    """Return the errors (constraints, rows) of positions {node: (rows,)} at a value of the drive."""
    rows = len(next(iter(z.values())))
    m = Run(z, {"motor": np.full(rows, value)}, [], np.zeros(rows), "", None)
    return np.stack([np.real(error) * np.ones(rows) for error in errors(spec, m)])


def condition(spec, at, value, step=1e-6):
    """Return the condition number: the largest displacement per error, relative to the size, by finite differences."""
    free = [n for n in at if n not in spec["ground"]]
    big = size(spec)
    shift = np.concatenate([np.eye(2 * len(free)), -np.eye(2 * len(free))], axis=1) * step * big
    z = {n: np.full(shift.shape[1], complex(*at[n])) for n in at}
    for k, n in enumerate(free):
        z[n] = z[n] + shift[2 * k] + 1j * shift[2 * k + 1]
    e = signed(spec, z, value)
    half = e.shape[1] // 2
    gradient = (e[:, :half] - e[:, half:]) / (2 * step)
    least = np.linalg.svd(gradient, compute_uv=False)[-1] if gradient.shape[0] >= gradient.shape[1] else 0.0
    return 1.0 / max(least, 1e-300)


def regular(growth):
    """Return the complete model of a growth and its condition number; skip nearly singular positions."""
    assume(growth.bodies)
    spec = growth.explicit(0.0)
    kappa = condition(spec, growth.nodes, growth.drawn_value())
    assume(kappa < BLUNT)
    members = [*growth.bodies.values(), growth.ground]
    assume(min(abs(growth.place(a) - growth.place(b)) for m in members for a in m for b in m if a != b) > 0.02)
    return spec, kappa


def position(spec, **options):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.yaml"
        path.write_text(json.dumps(spec))
        mechanism = load(path)
        found = solve(mechanism, mechanism.start_inputs, Options(jit="on", **options))
    return found, dict(zip(mechanism.nodes, mechanism.to_file(found.z), strict=True))


def solved(solver, spec, **options):
    """Return the result of a solver; None if there is no sequence for sweeps."""
    try:
        return solver(spec, **options)
    except GimError as error:
        if options["method"] != "gim" or "no sequence" not in str(error):
            raise
        return None


# --- the known position is found -------------------------------------------------------------------------


def found_again(growth, method, noise, seed):
    """Solve from disturbed coordinates; a small disturbance must lead back to the known position."""
    spec, kappa = regular(growth)
    disturbed = growth.explicit(noise, seed)
    done = solved(position, disturbed, method=method, sweeps=3000)
    if done is None:
        return
    found, z = done
    if found.status is not Status.OK:
        assert found.status.text
        assert method == "gim" or noise * kappa > 1e-3, found.status
        return
    value, big = growth.drawn_value(), size(spec)
    at = {n: np.array([w]) for n, w in z.items()}
    assert np.max(abs(signed(spec, at, value))) <= (1e3 if method == "gim" else 2.0) * TOLERANCE
    near = max(abs(w - growth.place(n)) for n, w in z.items()) / big
    allowed = (1e3 if method == "gim" else 10.0) * TOLERANCE * max(1.0, kappa)
    if noise * kappa < 1e-2 and (method != "gim" or near < 0.01):
        assert near <= allowed


disturbances = st.sampled_from([0.0, 1e-9, 1e-6, 1e-4, 1e-2])


@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
@QUICK
@given(growth=growths, noise=disturbances, seed=st.integers(0, 1000))
def test_the_known_position_is_found(method, growth, noise, seed):
    found_again(growth, method, noise, seed)


@pytest.mark.soak
@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
@LONG
@given(growth=growths, noise=disturbances, seed=st.integers(0, 1000))
def test_the_known_position_is_found_in_many_mechanisms(method, growth, noise, seed):
    found_again(growth, method, noise, seed)


# --- methods agree ---------------------------------------------------------------------------------------


def methods_agree(growth):
    spec, _ = regular(growth)
    runs = [solved(run, spec, steps=6, method=method) for method in ("auto", "newton", "gim")]
    auto, newton, gim = runs
    assert auto.status == newton.status
    for other, near in ((newton, 1e-8), (gim or auto, 1e-4)):
        rows = [k for k, pair in enumerate(zip(auto.status, other.status, strict=True)) if set(pair) == {"ok"}]
        assert max(np.max(abs(z - auto.z[n])[rows], initial=0.0) for n, z in other.z.items()) <= near * size(spec)


@QUICK
@given(growth=bounded)
def test_methods_agree(growth):
    methods_agree(growth)


@pytest.mark.soak
@LONG
@given(growth=bounded)
def test_methods_agree_on_many(growth):
    methods_agree(growth)


# --- independence of the frame of reference --------------------------------------------------------------


reaches = st.sampled_from([1.0, 1e3, 1e6])


def invariant(growth, change, near):
    """Compare the motions of a mechanism and of the changed one; `change` returns the latter and the map of points."""
    spec, _ = regular(growth)
    other, there = change(copy.deepcopy(spec))
    here, m = run(spec, 6), run(other, 6)
    assert m.status == here.status
    rows = [k for k, word in enumerate(here.status) if word == "ok"]
    for node, z in here.z.items():
        assert np.max(abs(m.z[node] - there(z))[rows], initial=0.0) <= near * size(other)


@QUICK
@given(growth=growths, power=st.integers(-300, 300))
def test_a_power_of_two_changes_no_digit(growth, power):
    invariant(growth, lambda spec: moved(spec, scale=2.0**power), 0.0)


@QUICK
@given(growth=growths, turn=st.floats(-180, 180), mirror=st.booleans())
def test_turned_and_mirrored(growth, turn, mirror):
    invariant(growth, lambda spec: moved(spec, turn=turn, mirror=mirror), 1e-9)


@QUICK
@given(growth=growths, reach=reaches, angle=st.floats(0, 2 * math.pi))
def test_translated(growth, reach, angle):
    translated(growth, reach, angle)


def translated(growth, reach, angle):
    """The error is that of the rounded numbers in the file."""
    shift = reach * complex(math.cos(angle), math.sin(angle))
    invariant(growth, lambda spec: moved(spec, shift=shift), max(1e-9, reach * 1e-12))


@pytest.mark.soak
@QUICK
@given(growth=growths, seed=st.integers(0, 1000))
def test_in_another_order(growth, seed):
    in_another_order(growth, seed)


def in_another_order(growth, seed):
    def change(spec):
        return {"links": {}, "elements": {}, **shuffled({"points": {}, **spec}, seed)}, lambda z: z

    invariant(growth, change, 1e-9)


@pytest.mark.soak
@LONG
@given(growth=growths, power=st.integers(-300, 300), turn=st.floats(-180, 180), mirror=st.booleans())
def test_frames_of_many(growth, power, turn, mirror):
    invariant(growth, lambda spec: moved(spec, scale=2.0**power), 0.0)
    invariant(growth, lambda spec: moved(spec, turn=turn, mirror=mirror), 1e-9)


@pytest.mark.soak
@LONG
@given(growth=growths, reach=reaches, angle=st.floats(0, 2 * math.pi), seed=st.integers(0, 1000))
def test_places_and_orders_of_many(growth, reach, angle, seed):
    translated(growth, reach, angle)
    in_another_order(growth, seed)
