"""Intervals of the input without a position that are shorter than a step, against closed forms."""

from __future__ import annotations

import cmath
import math
from pathlib import Path

import pytest
from scipy.optimize import brentq

import gimcli

MODEL = Path(__file__).parents[2] / "models" / "jansen.yaml"
LEGS = (
    (15.20373807, 51.32417517, 62.64036725, 38.58622951, 39.77050777, 38.23356659),
    (15.31204231, 52.37015002, 61.89159128, 37.48271494, 39.38000457, 36.72907617),
)
"""Lengths m, j, k, c, f, g of legs whose last dyad cannot be assembled in a short interval of the crank's turn."""


def meet(a: complex, ra: float, b: complex, rb: float) -> complex:
    """Return the intersection of two circles to the left of a -> b."""
    d = b - a
    along = 0.5 * (1.0 + (ra - rb) * (ra + rb) / abs(d) ** 2)
    return a + d * (along + 1j * math.sqrt(ra * ra / abs(d) ** 2 - along * along))


def room(angle: float, lengths: tuple[float, ...]) -> float:
    """Return the distance of the centres of the last dyad less the difference of its radii: negative in the gap."""
    m, j, k, c, f, g = lengths
    pivot, crank = -38.0 - 7.8j, m * cmath.exp(1j * math.radians(angle))
    b = meet(pivot, 41.5, crank, j)
    corner = pivot + (b - pivot) / 41.5 * (2.6098795180722933 + 40.01497880670621j)
    return abs(corner - meet(crank, k, pivot, c)) - abs(f - g)


@pytest.mark.few(3)
@pytest.mark.parametrize("lengths", LEGS)
@pytest.mark.parametrize("steps", [30, 72, 90, 180, 360, 1000])
def test_a_motion_ends_at_a_gap_between_two_rows(lengths: tuple[float, ...], steps: int) -> None:
    angle = next(a / 100 for a in range(15000, 20000) if room(a / 100, lengths) < 0)
    limit = brentq(lambda a: room(a, lengths), angle - 0.01, angle)
    m = gimcli.load(MODEL).with_({f"{name}.length": value for name, value in zip("mjkcfg", lengths, strict=True)})
    found = gimcli.trace(m, steps)
    assert found.solved == math.floor(limit / 360 * steps) + 1
    (event,) = (e for e in found.events if e["kind"] == "limit")
    assert event["at"]["motor"] == pytest.approx(limit, abs=1e-6)
