"""Sweeps of dimensions and quantities of several independent machines: each quantity has its own machine's rows."""

import math

import numpy as np
import pytest

import gimcli

ROCKER_AND_CRANK = """
units: {length: m}
nodes: {A: [0, 0], B: [0, 2], C: [3, 3], D: [4, 0], E: [10, 0], F: [11, 0]}
ground: [A, D, E]
links: {a: [A, B], b: {nodes: [B, C], length: 3.2}, c: {nodes: [C, D], length: 1.5}, e: [E, F]}
actuators: {rocker: {pivot: A, arm: B, law: {by: 15}}, crank: {pivot: E, arm: F, law: {by: 360}}}
"""
STEPS = 36
CRANKS, GROUND = (1.0, 1.5), (4.0, 4.1)


def closed_forms(crank, ground):
    """Angles of the rows, those of the rocker to its limit, where coupler and follower are in line; places of B, F."""
    limit = math.acos((2.0**2 + ground**2 - (3.2 + 1.5) ** 2) / (2.0 * 2.0 * ground))
    share = np.linspace(0.0, 1.0, STEPS + 1)
    rocker = np.radians(90.0 + 15.0 * share)
    rocker = np.where(rocker < limit, rocker, np.nan)
    return rocker, 2.0 * np.exp(1j * rocker), 10.0 + crank * np.exp(2j * np.pi * share)


def test_each_quantity_has_the_rows_of_its_own_machine(tmp_path):
    between = "max(hypot(B.x - F.x, B.y - F.y))"
    keep = [
        "mean(rocker)", "min(B.y)", "range(F.x)", "max(F.vy)", "at(F.y, crank=90)", "max(F.x - E.x) - min(B.y)",
        between, "at(F.x, rocker=95)", "solved",
    ]  # fmt: skip
    mechanism = gimcli.loads(ROCKER_AND_CRANK)
    found = gimcli.sweep(mechanism, {"F.x": "11,11.5", "D.x": "4,4.1"}, steps=STEPS, keep=keep)
    designs = [(crank, ground) for crank in CRANKS for ground in GROUND]
    for k, (crank, ground) in enumerate(designs):
        rocker, b, f = closed_forms(crank, ground)
        low = np.nanmin(b.imag)
        expected = [
            np.degrees(np.nanmean(rocker)), low, 2.0 * crank, crank * 2.0 * math.pi, crank, crank - low,
            np.nanmax(np.abs(b - f)), np.nan if ground > 4.0 else 10.0 + crank * math.cos(math.radians(120.0)),
            np.isfinite(rocker).sum(),
        ]  # fmt: skip
        assert [found[name][k] for name in keep] == pytest.approx(expected, rel=1e-9, abs=1e-9, nan_ok=True)
    assert list(found["status"]) == ["unreachable"] * 4
    found.save(tmp_path / "designs.html")


def test_many_designs_of_two_machines_in_compiled_code():
    mechanism = gimcli.loads(ROCKER_AND_CRANK)
    vary = {"F.x": "10.5:11.5:40", "D.x": "3.9:4.2:40"}
    found = gimcli.sweep(mechanism, vary, steps=STEPS, keep=["min(F.vy)", "min(B.y)"])
    assert found["min(F.vy)"] == pytest.approx(-2.0 * math.pi * (found["F.x"] - 10.0), rel=1e-9)
    lows = [np.nanmin(closed_forms(1.0, ground)[1].imag) for ground in found["D.x"]]
    assert found["min(B.y)"] == pytest.approx(lows, rel=1e-9)
