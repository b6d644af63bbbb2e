"""Fixtures of all tests, and the choice of the parametrized cases that the suite runs (mark `few`)."""

from __future__ import annotations

import gc
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does; read when numpy is imported

from pathlib import Path
from unittest.mock import patch

import pytest
from bundled import CHOSEN, FILES, run_model

from gimcli.comparison import timing
from gimcli.output import FORMATS, Format

gc.disable()  # until all tests are collected: they live to the end, none of their objects is garbage


@pytest.fixture
def trace_model():
    return run_model


@pytest.fixture(params=FILES, ids=lambda path: path.stem)
def model(request):
    return request.param


@pytest.fixture
def unrendered():
    """Pictures are composed, but not rendered: that takes longer than all the rest."""
    quick = Format("picture", lambda picture, path: path.write_text(type(picture).__name__), printed=True)
    with patch.dict(FORMATS, {suffix: quick for suffix, known in FORMATS.items() if known.content == "picture"}):
        yield


@pytest.fixture(scope="session", autouse=True)
def one_round():
    """Measure computing times once: tests that need them better give their own `timing`."""
    with patch.dict(timing.TIMING.__dict__, rounds=1, fewest=1, least=0.0):
        yield


def pytest_collection_finish():
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)  # results are seldom in cycles: few collections find any
    gc.enable()


@pytest.hookimpl(tryfirst=True)  # before pytest selects by marks
def pytest_collection_modifyitems(items):
    tests = {}
    for item in items:
        tests.setdefault(item.nodeid.partition("[")[0], []).append(item)
    for cases in tests.values():
        mark = cases[0].get_closest_marker("few")
        if mark is not None:
            for case in set(cases) - set(kept(cases, *mark.args)):
                case.add_marker(pytest.mark.soak)


def kept(cases, *wanted):
    """Return a number of cases, first those that cover each value of each parameter; or the cases of some models."""
    if not wanted or isinstance(wanted[0], str):
        models = set(wanted) or CHOSEN
        return [case for case in cases if models & {_name(value) for value in case.callspec.params.values()}]
    (number,), found, seen, left = wanted, [], set(), list(cases)
    while left and len(found) < number:
        case = max(left, key=lambda case: len(set(_indices(case)) - seen))
        seen |= set(_indices(case))
        left.remove(case)
        found.append(case)
    return found


def _indices(case):
    return list(case.callspec.indices.items()) if hasattr(case, "callspec") else []


def _name(value):
    return value.stem if isinstance(value, Path) else value if isinstance(value, str) else ""
