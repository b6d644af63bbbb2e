"""The arc of four-bars that cannot be assembled at the first row, by the law of cosines."""

import math

import numpy as np
import pytest

import gimcli

FOUR_BAR = """
units: {length: mm, angle: deg}
nodes: {A: [0, 0], D: [6, 0], B: [1.7320508, 1], C: [2.5, 8]}
ground: [A, D]
links: {crank: {nodes: [A, B], length: 2}, rod: {nodes: [B, C], length: 7}, rocker: {nodes: [C, D], length: 9}}
actuators: {motor: {type: rotary, pivot: A, arm: B, law: {from: 30, to: 390}}}
"""
LENGTHS = ("D.x", "crank.length", "rod.length", "rocker.length")


def ends_of_the_arc(ground, crank, rod, rocker):
    """Return the first and last angle (deg), above 0 and up to 180, at which a dyad closes."""

    def angle(distance):
        cosine = (ground**2 + crank**2 - distance**2) / (2 * ground * crank)
        return math.degrees(math.acos(max(-1.0, min(1.0, cosine))))

    return angle(abs(rod - rocker)), angle(rod + rocker)


def swept(designs, keep=("solved", "reachable")):
    m = gimcli.loads(FOUR_BAR)
    return [gimcli.sweep(m, dict(zip(LENGTHS, [[x] for x in design], strict=True)), keep=keep) for design in designs]


def test_a_few_designs_have_the_arcs_of_the_law_of_cosines():
    designs = [(2.013, 3.0, 1.0, 4.0), (3.1, 5.0, 1.0, 6.05), (5.0, 5.2, 1.1, 4.0), (6.1, 6.0, 1.0, 5.0)]
    for design, found in zip(designs, swept(designs), strict=True):
        low, high = ends_of_the_arc(*design)
        assert low > 30  # it cannot be assembled at the first row
        rows = np.arange(30, 390.1, 5)
        count = np.count_nonzero((rows > low) & (rows < high))
        assert found["solved"][0] == count > 0
        assert found["reachable"][0] == pytest.approx(count / 73)
        assert found.status[0] == "not-assembled"


def test_an_arc_that_begins_at_a_row():
    """Lengths 1, 1, 1, 2 close from 60 to 300 degrees; both ends are rows and dead points."""
    (found,) = swept([(1.0, 1.0, 1.0, 2.0)])
    assert 47 <= found["solved"][0] <= 49


def test_an_arc_continues_through_a_change_point():
    """Lengths 2, 3, 1, 4 close from 70.5 to 289.5 degrees; at 180 degrees all links are on one line."""
    (found,) = swept([(2.0, 3.0, 1.0, 4.0)], ("solved", "reachable", "min(transmission)"))
    assert found["solved"][0] == len(range(75, 290, 5))
