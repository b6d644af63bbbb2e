"""Rows at even distances along a circuit, as a motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimcli.continuation.arclength import corrected, cubic, tangents
from gimcli.continuation.circuit import CIRCUIT, STEPS, Circuit, nearby
from gimcli.mechanism import BoolArray, FloatArray, IntArray
from gimcli.motion.motion import Motion
from gimcli.status import Status
from gimcli.structure.residual import holds, residual


def along(circuit: Circuit, rows: int) -> FloatArray:
    """Return positions and parameter (n + 1, rows) at even distances, including both ends."""
    return settled(circuit, *sample_places(circuit, rows))[0].T


def sample_places(circuit: Circuit, rows: int) -> tuple[IntArray, FloatArray]:
    """Return numbers of the points before and fractions (0..1) to the next points, at even distances with both ends.

    Of a curve that goes to infinity only the part nearby is used.
    """
    marks = circuit.lengths
    first, last = nearby(circuit)
    wanted = np.linspace(marks[first], marks[last], rows)
    index = np.clip(np.searchsorted(marks, wanted, side="right") - 1, 0, len(marks) - 2)
    return index, (wanted - marks[index]) / np.diff(marks)[index]


def settled(circuit: Circuit, k: IntArray, part: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return corrected positions (rows, n + 1) at fractions (0..1) from points k (rows,) to the next ones.

    Then the tangents (rows, n + 1) there, not of unit length, of the cubics between the points.
    """
    p, tangent = circuit.p.T, circuit.tangents
    guess, slope = cubic(p[k], tangent[k], p[k + 1], tangent[k + 1], part[:, None])
    open_ones = np.flatnonzero(~known(circuit, k, part, guess))
    normals = slope[open_ones] / np.linalg.norm(slope[open_ones], axis=1, keepdims=True)
    exact, good = corrected(circuit.curve, guess[open_ones], STEPS, normals)
    guess[open_ones[good]] = exact[good]
    return guess, slope


def exact_tangents(circuit: Circuit, k: IntArray, part: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the same positions with the unit tangents (rows, n + 1) of the curve."""
    p, heading = settled(circuit, k, part)
    open_ones = np.flatnonzero(~known(circuit, k, part, p))
    heading[open_ones] = tangents(circuit.curve, p[open_ones], heading[open_ones])
    return p, heading / np.linalg.norm(heading, axis=1, keepdims=True)


def known(circuit: Circuit, k: IntArray, part: FloatArray, p: FloatArray) -> BoolArray:
    """Return whether positions p (rows, n + 1) are points of a circuit, or so near to an intersection.

    There the interpolation is more accurate than the equations.
    """
    found = (part == 0.0) | (part == 1.0)
    for j in circuit.crossings:
        near = np.linalg.norm(p - circuit.places[j].p, axis=1) <= CIRCUIT.beside
        found |= ((k == j) | (k + 1 == j)) & near
    return np.asarray(found)


def circuit_motion(circuit: Circuit, rows: int, tolerance: float) -> Motion:
    """Return rows at even distances along a circuit as a motion; its time is the fraction of the length, 0..1."""
    p, headings = settled(circuit, *sample_places(circuit, rows))
    return replace(as_motion(circuit, np.linspace(0.0, 1.0, rows), p.T, tolerance), headings=headings.T)


def as_motion(circuit: Circuit, time: FloatArray, p: FloatArray, tolerance: float) -> Motion:
    """Return positions p (n + 1, rows) as a motion, with the residual of the members as written."""
    mechanism, curve = circuit.mechanism, circuit.curve
    inputs, z = curve.inputs(p), curve.nodes(p)
    error = residual(mechanism, z, inputs).total
    good = holds(mechanism, z, inputs, tolerance, error=error)
    codes = np.where(good, int(Status.OK), int(Status.SINGULAR))
    z[:, ~good] = complex(np.nan, np.nan)
    error = np.where(good, error, np.nan)
    return Motion(mechanism, time, inputs, z, codes, error, np.zeros(len(time)), z[:, 0].copy(), parameter=p[-1].copy())
