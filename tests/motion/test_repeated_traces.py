"""Repeated motions of one mechanism: the start is found once, and every motion has the rows of the first."""

import numpy as np
import pytest
from bundled import MODELS

from gimcli import load, trace
from gimcli.kernels import jit
from gimcli.motion import motion
from gimcli.positions import dispatch
from gimcli.positions.options import Options
from gimcli.structure.plan import make_plan


def rows(mechanism, **options):
    found = motion.trace(mechanism, 72, **options)
    return [found.inputs, found.z, found.codes, found.residual, found.work]


@pytest.mark.parametrize("name", ["crank_rocker", "five_bar", "gim_fig13a", "parallelogram"])
def test_a_motion_after_others_has_the_same_bits(name):
    fresh = rows(load(MODELS / f"{name}.yaml"))
    used = load(MODELS / f"{name}.yaml")
    for options in ({"at_limit": "reverse"}, {"options": Options(tolerance=1e-9)}, {}):
        rows(used, **options)
    for one, other in zip(fresh, rows(used), strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_start_is_found_once(monkeypatch):
    calls = []
    monkeypatch.setattr(motion, "start_position", lambda *a, find=motion.start_position: calls.append(a) or find(*a))
    mechanism = load(MODELS / "crank_rocker.yaml")
    for steps in (72, 36, 72):
        trace(mechanism, steps)
    assert len(calls) == 1
    trace(mechanism, 72, tolerance=1e-8)
    assert len(calls) == 2


@pytest.fixture
def cached(monkeypatch):
    """The names of the kernels that are on disk."""
    names = set()
    monkeypatch.setattr(jit, "is_cached", lambda *kernels: names.issuperset(kernels))
    monkeypatch.setattr(dispatch, "_done", {})
    return names


def calls_until_compiled(work):
    kernels = ("k",)
    return next((n for n in range(1000) if chosen(dispatch.with_earlier(work, kernels)) is jit.compiled), None)


def chosen(work):
    return dispatch.choose("auto", work, None, ("k",))


def test_the_work_of_many_small_calls_is_added(cached):
    before = calls_until_compiled(0.1)
    assert (before + 1) * 0.1 == pytest.approx(dispatch.COMPILING, abs=0.11)
    dispatch._done.clear()
    cached.add("k")
    before = calls_until_compiled(0.1)
    assert (before + 1) * 0.1 == pytest.approx(dispatch.WORTH, abs=0.11)
    assert dispatch.with_earlier(0.1, ("other",)) == 0.1


def test_only_calls_of_the_library_are_added(cached):
    mechanism = load(MODELS / "stephenson_3_far.yaml")
    motion.trace(mechanism, 72, notify=print)
    assert dispatch._done == {}
    motion.trace(mechanism, 72)
    motion.trace(mechanism, 72)
    assert dispatch._done == {("march", "solve_group"): pytest.approx(2 * dispatch.plan_work(make_plan(mechanism), 90))}
