"""Laws of any length from 0 on, with any number of steps, against the closed form of the four-bar."""

from __future__ import annotations

import math

import numpy as np
import pytest
from four_bars import four_bar_text

import gimcli

LENGTHS = (40.0, 120.0, 80.0, 100.0)


def pins(angles: np.ndarray, lengths: tuple[float, ...] = LENGTHS) -> np.ndarray:
    """Return B, left of the line from A to O4, at crank angles [deg]."""
    crank, coupler, follower, ground = lengths
    a = crank * np.exp(1j * np.radians(angles))
    arm = ground - a
    along = (np.abs(arm) ** 2 + coupler**2 - follower**2) / (2.0 * np.abs(arm))
    return np.asarray(a + arm / np.abs(arm) * (along + 1j * np.sqrt(coupler**2 - along**2)))


def traced(law: str, steps: int, **options):
    """Return a trace of the four-bar under a law, and its points B."""
    m = gimcli.loads(four_bar_text(*LENGTHS, math.radians(40.0), law=f", law: {law}"))
    found = gimcli.trace(m, steps, **options)
    return found, found.xy["B"] @ [1.0, 1.0j]


@pytest.mark.few(40)
@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
@pytest.mark.parametrize("steps", [1, 36, 720])
@pytest.mark.parametrize(
    ("begin", "change"),
    [(30.0, -1e-9), (30.0, 1e-9), (30.0, 1e-11), (30.0, 1e-14), (30.0, 0.0), (0.0, 1e-13), (-1e-13, 2e-13),
     (0.0, -1e-300), (3.59e6 + 30.0, 1e-8)],
)  # fmt: skip
def test_steps_of_a_few_roundings_of_the_input(begin: float, change: float, steps: int, method: str) -> None:
    found, b = traced(f"{{from: {begin!r}, to: {begin + change!r}}}", steps, method=method)
    assert found.solved == steps + 1
    angles = begin + np.arange(steps + 1) / steps * change
    assert np.max(np.abs(b - pins(angles))) <= (1e-6 if method == "gim" else 1e-14 * (abs(begin) + 100.0))


@pytest.mark.parametrize("jit", ["on", "off"])
def test_many_small_steps(jit: str) -> None:
    found, b = traced("{from: 30, to: 29.9999999}", 100_000 if jit == "on" else 5_000, jit=jit)
    assert found.solved == len(b)
    assert np.max(np.abs(b - pins(np.linspace(30.0, 29.9999999, len(b))))) <= 1e-12


@pytest.mark.parametrize("pause", [0.0, 1e-13, 1e-11, 1e-6])
def test_a_dwell_between_two_runs(pause: float, tmp_path) -> None:
    """A law at rest, or almost at rest, for a third of the time; the crank then turns on, or returns."""
    for end in (90.0, 20.0):
        (tmp_path / "law.csv").write_text(f"0,30\n1,60\n2,{60 + pause!r}\n3,{end}\n")
        found, b = traced(f"{{table: {tmp_path}/law.csv}}", 3000)
        assert found.solved == len(b)
        assert np.max(np.abs(b - pins(np.asarray(found["motor"])))) <= 1e-11


@pytest.mark.soak
def test_ten_million_steps_of_a_short_law() -> None:
    found, b = traced("{from: 30, to: 29.999999999}", 10_000_000)
    assert found.solved == len(b)
    assert np.max(np.abs(b[::1000] - pins(np.linspace(30.0, 29.999999999, len(b))[::1000]))) <= 1e-12
