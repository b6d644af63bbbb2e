"""Motions that begin close to a limit keep all their rows, against the closed form of the four-bar."""

from __future__ import annotations

import math

import numpy as np
import pytest
from four_bars import four_bar_text

import gimcli
from gimcli.families.family import Family

NAMES = ("crank.length", "coupler.length", "follower.length", "O4.x")
TURN = ", law: {from: 0, to: 360}"


def designs(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return lengths (count, 4) with a limit (coupler and follower folded) 1e-12 to 1e-3 rad before a row; the row."""
    rng, found = np.random.default_rng(seed), []
    while len(found) < count:
        crank, coupler, follower = rng.uniform(0.3, 3.0, 3)
        row, reach = int(rng.integers(3, 30)), abs(coupler - follower)
        along = crank * math.cos(2.0 * math.pi * row / 72 - 10.0 ** rng.uniform(-12.0, -3.0))
        square = along**2 - crank**2 + reach**2
        if square > 0.0:
            both = (along - math.sqrt(square), along + math.sqrt(square))
            found += [(crank, coupler, follower, ground, row) for ground in both if ground > 0.2]
    table = np.array(found[:count])
    return table[:, :4], table[:, 4].astype(int)


def solvable(design: np.ndarray) -> np.ndarray:
    """Return whether the rows (73,) from 0 to 360 deg can be assembled, up to the end of the first arc."""
    crank, coupler, follower, ground = design
    arm = np.abs(crank * np.exp(2j * np.pi * np.arange(73) / 72) - ground)
    good = (arm >= abs(coupler - follower)) & (arm <= coupler + follower)
    first = int(good.argmax())
    good[first + int((~good[first:]).argmax()) if not good[first:].all() else 73 :] = False
    return good


def check_sweep(count: int, seed: int) -> None:
    many, _ = designs(count, seed)
    nominal = gimcli.loads(four_bar_text(1.9, 1.5, 0.61, 1.66, math.radians(60.0), law=TURN))
    found = Family(nominal, NAMES).solve(many, 72, reachable=True)
    expected = np.array([solvable(design) for design in many])
    wrong = np.flatnonzero(np.any(found.good != expected, axis=1))
    assert not len(wrong), many[wrong[:3]].tolist()
    assert np.nanmax(found.residual) <= 1e-10


def check_traces(count: int, seed: int) -> None:
    for design, row in zip(*designs(count, seed), strict=True):
        good = solvable(design)
        rows = int(good.sum())
        if good.argmax() != row or rows < 5:
            continue
        law = f", law: {{from: {5 * row}, to: {5 * (row + rows - 1)}}}"
        text = four_bar_text(*design.tolist(), math.radians(5 * (row + rows // 2)), law=law)
        assert gimcli.trace(gimcli.loads(text), rows - 1).solved == rows, design.tolist()


def test_the_rows_from_a_limit_on() -> None:
    """The limit is 7e-8 rad before the row of 30 deg; the arc ends behind 70 deg."""
    lengths = 1.940879495268608, 1.5869884231344988, 0.6163414722597622, 1.6607903648106455
    m = gimcli.loads(four_bar_text(*lengths, math.radians(60.0), law=TURN))
    assert gimcli.sweep(m, {"crank.length": [lengths[0]]}, keep=["solved", "reachable"])["solved"].tolist() == [9.0]


def test_sweeps_that_begin_near_a_limit() -> None:
    check_sweep(100, 1)


def test_traces_that_begin_near_a_limit() -> None:
    check_traces(30, 2)


@pytest.mark.soak
def test_ten_thousand_motions_that_begin_near_a_limit() -> None:
    check_sweep(10_000, 3)
    check_traces(2_000, 4)
