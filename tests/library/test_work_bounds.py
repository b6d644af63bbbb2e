"""Searches end at their bound on work, counted in positions, or after `seconds`, with what was found until then."""

from __future__ import annotations

import numpy as np
import pytest
from in_process import gim

import gimcli
from gimcli.assemblies import start_cache
from gimcli.continuation import circuit
from gimcli.progress import limited, spend

SEARCHES = {
    "circuits": ("ten_bar", gimcli.circuits),
    "configurations": ("ten_bar", gimcli.configurations),
    "workspace": ("excavator", gimcli.workspace),
    "paths": ("jansen", lambda m, **more: gimcli.workspace(m, every=True, **more)),
    "equilibrium": ("snap_hinge", gimcli.equilibrium),
    "equilibria": ("double_pendulum", gimcli.equilibrium),
}


@pytest.mark.parametrize("name", SEARCHES)
def test_a_search_without_time_reports_its_end(name):
    model, search = SEARCHES[name]
    found = search(gimcli.load(model), seconds=0)
    assert found.limited
    assert not found.complete
    assert found.report()["status"] == "work-limit"
    found.table()


@pytest.mark.parametrize(("model", "search"), [("jansen", gimcli.circuits), ("five_bar", gimcli.workspace)])
def test_the_bound_is_a_count(model, search):
    mechanism = gimcli.load(model)
    with limited(200) as first:
        one = search(mechanism)
    with limited(200) as second:
        other = search(mechanism)
    assert first.reached
    assert first.spent == second.spent
    assert one.report() == other.report()
    assert one.limited
    assert len(next(iter(one.values()))) > 0


def test_an_outer_bound_holds_too():
    with limited(3) as outer, limited(1000) as inner:
        assert [spend(1) for _ in range(5)] == [False, False, False, True, True]
        assert outer.reached
        assert inner.reached
    with limited(1000) as outer, limited(3) as inner:
        assert [spend(1) for _ in range(5)] == [False, False, False, True, True]
        assert not outer.reached
    assert not spend(10**9)


def test_a_circuit_has_a_greatest_number_of_points(monkeypatch):
    monkeypatch.setitem(circuit.CIRCUIT.__dict__, "points", 10)
    (curve,) = gimcli.circuits(gimcli.load("crank_rocker"), values=4).report()["curves"][:1]
    assert curve["ended"] == "work limit"
    assert not curve["closed"]


def test_a_start_that_was_not_finished_is_not_kept(monkeypatch):
    """The roots of the generic linkage that an ended search did not find would be missing in the next one."""
    monkeypatch.setattr(start_cache, "_STARTS", {})
    monkeypatch.setattr(start_cache, "_path", lambda name: None)
    mechanism = gimcli.load("plantigrade")
    with limited(3) as limit:
        ended = gimcli.configurations(mechanism)
    assert limit.reached
    assert ended.limited
    whole = gimcli.configurations(mechanism)
    assert whole.complete
    assert np.isfinite([one["radius"] for one in whole.report()["configurations"]]).all()
    assert ended.count <= whole.count


def test_the_commands_end_with_5(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for command in ("circuits jansen", "solve ten_bar --all", "workspace jansen --no-png", "equilibrium snap_hinge"):
        asked = gim(*command.split(), "--seconds", 0)
        assert asked.code == 5, command
        assert "bound on work" in asked.text, command
    assert "--all" in gim("solve", "jansen", "--seconds", 1).error
