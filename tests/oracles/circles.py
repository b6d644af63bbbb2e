"""Positions of dyadic linkages by intersections of circles, for many designs and input values at once."""

import numpy as np


def dyad(p, to_p, q, to_q, side):
    """Return the point at two distances from p and q, left (1) or right (-1) of p -> q, and whether it exists."""
    d = np.abs(q - p)
    along = (d**2 + to_p**2 - to_q**2) / (2 * d)
    square = to_p**2 - along**2
    return p + (q - p) / d * (along + side * 1j * np.sqrt(np.maximum(square, 0))), square >= 0


def four_bar(ground, crank, rod, rocker, u, v, angles):
    """Return A, B and the coupler point (u, v) at crank angles (rad); B is left of A -> O4."""
    a = crank * np.exp(1j * angles)
    b, _ = dyad(a, rod, ground + 0 * a, rocker, 1)
    return a, b, a + (u + 1j * v) * (b - a) / rod


def four_bar_rows(ground, crank, rod, rocker, angles):
    """Return the number of rows that are reached from the first one."""
    if not closes(ground, crank, rod, rocker, angles[0], angles[0]):
        return 0
    rows = 1
    while rows < len(angles) and closes(ground, crank, rod, rocker, angles[rows - 1], angles[rows]):
        rows += 1
    return rows


def closes(ground, crank, rod, rocker, first, last):
    """Return whether the dyad closes between two crank angles; the distance A-O4 is extreme at multiples of pi."""
    turns = np.arange(np.floor(first / np.pi), np.ceil(last / np.pi) + 1) * np.pi
    angles = np.array([first, last, *turns[(turns > first) & (turns < last)]])
    d = np.abs(ground - crank * np.exp(1j * angles))
    return bool(np.all((d <= rod + rocker) & (d >= abs(rod - rocker))))
