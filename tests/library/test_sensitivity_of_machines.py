"""Derivatives of quantities of several independent machines: each in the rows of its own machine."""

import math

import numpy as np
import pytest
from side_by_side import ROCKER_AND_CRANK

import gimcli

ANGLE = np.radians(np.linspace(0.0, 360.0, 37))
ROCKER = np.radians(90.0 + np.linspace(0.0, 15.0, 37))
LIMIT = math.acos((2.0**2 + 4.0**2 - (3.2 + 1.5) ** 2) / (2.0 * 2.0 * 4.0))
SOLVED = ROCKER < LIMIT


def test_a_limit_of_one_machine_leaves_the_derivatives_of_the_other():
    """Coordinates of a link's end by its length: cosine and sine of its angle, in the rows of its own machine."""
    found = gimcli.sensitivity(gimcli.loads(ROCKER_AND_CRANK), of=["F.x", "B.y"], by=["e", "a"], steps=36)
    assert found.each["crank"].derivatives["F.x"]["e.length"] == pytest.approx(np.cos(ANGLE), abs=1e-12)
    own = found.each["rocker"].derivatives["B.y"]["a.length"]
    assert own == pytest.approx(np.where(SOLVED, np.sin(ROCKER), np.nan), abs=1e-12, nan_ok=True)
    assert "F.x/a.length" not in found.table().names


def test_dimensions_of_another_machine_give_zero_in_words():
    heard = []
    mechanism = gimcli.loads(ROCKER_AND_CRANK)
    found = gimcli.sensitivity(mechanism, of=["F.x", "B.y"], by="a", steps=36, notify=heard.append)
    assert list(found.derivatives) == ["B.y"]
    assert len(heard) == 1
    with pytest.raises(gimcli.UsageError):
        gimcli.sensitivity(mechanism, of="F.x", by="a", crank=30)


def test_a_quantity_of_two_machines_has_the_rows_in_which_both_are_solved():
    found = gimcli.sensitivity(
        gimcli.loads(ROCKER_AND_CRANK), of=["angle:a/e", "F.x"], by=["rocker", "crank"], steps=36
    )
    both = found.each["rocker+crank"]
    assert both.derivatives["angle:a/e"]["crank"] == pytest.approx(np.where(SOLVED, -1.0, np.nan), nan_ok=True)
    assert found.each["crank"].derivatives["F.x"]["crank"] == pytest.approx(-np.sin(ANGLE) * math.pi / 180.0, abs=1e-12)
