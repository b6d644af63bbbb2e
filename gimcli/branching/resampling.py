"""Rows at even distances along a circuit, as a motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from gimcli.continuation.arclength import correct, cubic, place
from gimcli.continuation.circuit import CIRCUIT, STEPS, Circuit, nearby
from gimcli.mechanism import FloatArray
from gimcli.motion.motion import Motion
from gimcli.status import Status
from gimcli.structure.residual import holds, residual


def along(circuit: Circuit, rows: int) -> FloatArray:
    """Return positions and parameter (n + 1, rows) at even distances, including both ends."""
    return np.array([settled(circuit, k, part)[0] for k, part in sample_places(circuit, rows)]).T


def sample_places(circuit: Circuit, rows: int) -> Iterator[tuple[int, float]]:
    """Yield number of the point before and fraction (0..1) to the next point, at even distances, including both ends.

    Of a curve that goes to infinity only the part nearby is used.
    """
    marks = circuit.lengths
    first, last = nearby(circuit)
    wanted = np.linspace(marks[first], marks[last], rows)
    index = np.clip(np.searchsorted(marks, wanted, side="right") - 1, 0, len(marks) - 2)
    for row, k in enumerate(index.tolist()):
        yield k, float((wanted[row] - marks[k]) / (marks[k + 1] - marks[k]))


def settled(circuit: Circuit, k: int, part: float) -> tuple[FloatArray, FloatArray]:
    """Return the corrected position (n + 1,) at a fraction (0..1) from point k to the next, and a vector along there.

    The vector is a tangent, between the points that of a cubic.
    """
    here, there = circuit.places[k], circuit.places[k + 1]
    if part in (0.0, 1.0):
        return (there.p, there.tangent) if part else (here.p, here.tangent)
    guess, slope = cubic(here, there, part)
    exact = None
    if not beside(circuit, k, guess):
        exact = correct(circuit.curve, guess, STEPS, slope / np.linalg.norm(slope))
    return guess if exact is None else exact, slope


def exact_tangent(circuit: Circuit, k: int, part: float) -> tuple[FloatArray, FloatArray]:
    """Return the same position with the unit tangent (n + 1,) of the curve."""
    p, along = settled(circuit, k, part)
    if part in (0.0, 1.0) or beside(circuit, k, p):
        return p, along / np.linalg.norm(along)
    return p, place(circuit.curve, p, along).tangent


def beside(circuit: Circuit, k: int, p: FloatArray) -> bool:
    """Return whether p is so near to an intersection that interpolation is more accurate than the equations."""
    ends = [circuit.places[j].p for j in (k, k + 1) if j in circuit.crossings]
    return any(float(np.linalg.norm(p - end)) <= CIRCUIT.beside for end in ends)


def circuit_motion(circuit: Circuit, rows: int, tolerance: float) -> Motion:
    """Return rows at even distances along a circuit as a motion; its time is the fraction of the length, 0..1."""
    p, headings = np.array([settled(circuit, k, part) for k, part in sample_places(circuit, rows)]).transpose(1, 2, 0)
    return replace(as_motion(circuit, np.linspace(0.0, 1.0, rows), p, tolerance), headings=headings)


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
