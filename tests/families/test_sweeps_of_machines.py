"""Sweeps of dimensions and quantities of several independent machines: each quantity has its own machine's rows."""

import math

import numpy as np
import pytest
from side_by_side import ROCKER_AND_CRANK

import gimcli

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


SHARED = """
units: {length: m}
parameters: {r: 1}
nodes: {E: [0, 0], F: [1, 0], A: [10000, 0], B: [10001, 0], O: [5, 0], U: [6, 0], S: [5, 0], L: [0, 9]}
ground: [E, A, O, U, L]
links: {e: {nodes: [E, F], length: r}, a: {nodes: [A, B], length: 2*r}}
prismatic: {s: {node: S, guide: [O, U]}}
actuators:
  m: {pivot: E, arm: F, law: {by: 360}}
  n: {pivot: A, arm: B, law: {by: 180}}
  x: {node: S, guide: [O, U], law: {by: 2}}
"""


def test_parameters_laws_and_ground_nodes_of_several_machines_vary():
    """Cranks r and 2 r, a slider that moves by 2 from its place, and a node of the ground that no machine has."""
    keep = ["range(F.x)", "range(B.x)", "at(F.y, m=95)", "max(S.x)", "max(x)", "max(L.x)", "solved"]
    vary = {"r": "1,2", "S.x": "5,5.5", "x.by": "2,3", "L.x": "0,1"}
    found = gimcli.sweep(gimcli.loads(SHARED), vary, steps=STEPS, keep=keep)
    r, place, by, left = (found[name] for name in ("r", "S.x", "x.by", "L.x"))
    expected = 2.0 * r, 4.0 * r, r * math.sin(math.radians(95.0)), place + by, place - 5.0 + by, left, 37.0 + 0.0 * r
    for name, values in zip(keep, expected, strict=True):
        assert found[name] == pytest.approx(values, rel=1e-9, abs=1e-9), name
