"""The quantities that constraints give values, at any position, with their derivatives.

Each constraint F(x, u) = 0 has a reading u of its own: the length, the height, or the angle of p - q from the vector.
The equation determines u; its derivatives follow from those of F.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gimcli.mechanism import ANGLE, SPAN, ComplexArray, FloatArray
from gimcli.structure.equations import moving_place, written
from gimcli.structure.steps import Constraint, Value
from gimcli.structure.terms import TermArrays, coordinates

QUARTER = np.array([[0.0], [0.5 * np.pi]])
"""The readings at which equations are evaluated to find the reading at which they are 0."""


class Readings:
    """The quantities (rows,) of constraints: lengths, and angles in rad."""

    def __init__(self, rows: Sequence[Constraint], nodes: int) -> None:
        self.count, self._first = len(rows), 2 * nodes
        one, places = self._first + len(rows), list(map(moving_place, range(nodes)))
        equations = tuple(written(map(_with_reading, rows, range(len(rows))), places, one))
        self._arrays = TermArrays(equations, self._first, range(one + 1))
        self._spans, self.angles = (np.array([row.kind == kind for row in rows], dtype=bool) for kind in (SPAN, ANGLE))
        self._p, self._q = (np.array([getattr(row, end) for row in rows], dtype=np.int64) for end in "pq")

    def values(self, z: ComplexArray) -> FloatArray:
        """Return the values (rows,) at positions z (nodes,); angles are in -pi..pi."""
        zero, quarter = self._arrays.values(self._variables(z, QUARTER))
        lengths = np.where(self._spans, np.sqrt(np.maximum(zero, 0.0)), zero)
        return np.asarray(np.where(self.angles, np.arctan2(zero, -quarter), lengths))

    def arms(self, z: ComplexArray) -> FloatArray:
        """Return the lengths (rows,) that make changes of angles lengths: of p - q; 1 for lengths."""
        apart = np.abs(z[self._p] - z[self._q])
        return np.where(self.angles & (apart > 0.0), apart, 1.0)

    def slopes(self, z: ComplexArray) -> FloatArray:
        """Return the derivatives (rows, 2 nodes); in any direction where p and q coincide."""
        return self._solved(self._arrays.slopes(self._variables(z, self.values(z))))

    def slopes_along(self, z: ComplexArray, motion: ComplexArray) -> FloatArray:
        """Return the derivatives (rows, 2 nodes) of the slopes along a motion (nodes,)."""
        v, along = self._variables(z, self.values(z)), coordinates(motion)
        table = self._arrays.slopes(v)
        slopes = self._solved(table)
        change = self._arrays.slopes_along(v, np.concatenate([along, slopes @ along, [0.0]]))
        bent = change[:, : self._first] + self._by_reading(change)[:, None] * slopes
        own = self._by_reading(table)
        return -bent / np.where(own == 0.0, 1.0, own)[:, None]

    def _variables(self, z: ComplexArray, u: FloatArray) -> FloatArray:
        v = np.ones((*u.shape[:-1], self._first + self.count + 1))
        v[..., : self._first], v[..., self._first : -1] = coordinates(z), u
        return v

    def _by_reading(self, table: FloatArray) -> FloatArray:
        return np.asarray(table[:, self._first : -1].diagonal())

    def _solved(self, table: FloatArray) -> FloatArray:
        slopes, by_reading = table[:, : self._first], self._by_reading(table)
        for k in np.flatnonzero(by_reading == 0.0):
            slopes[k] = 0.0
            slopes[k, 2 * self._p[k]], slopes[k, 2 * self._q[k]] = 1.0, -1.0
        return -slopes / np.where(by_reading == 0.0, -1.0, by_reading)[:, None]


def _with_reading(row: Constraint, number: int) -> Constraint:
    """Return a constraint with a reading of its own instead of its value."""
    if row.vector is not None and row.kind == ANGLE:
        return replace(row, vector=replace(row.vector, actuator=number, turn=1))
    return replace(row, value=Value(0.0, number))
