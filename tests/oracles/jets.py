"""Truncated Taylor series over many rows: exact derivatives of a motion, order by order.

A jet is an array (order + 1, rows) of coefficients f^(k) / k!; products are Cauchy's. Source: Griewank &
Walther, Evaluating Derivatives, 2008, chapter 13.
"""

from __future__ import annotations

import math

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray

Jet = ComplexArray
"""Complex coefficients (order + 1, rows)."""


def constant(value: complex, order: int, rows: int) -> Jet:
    """Return the jet of a constant."""
    jet = np.zeros((order + 1, rows), dtype=complex)
    jet[0] = value
    return jet


def times(a: Jet, b: Jet) -> Jet:
    """Return the product of two jets."""
    result = np.zeros_like(a)
    for k in range(len(a)):
        for j in range(k + 1):
            result[k] += a[j] * b[k - j]
    return result


def dot(a: Jet, b: Jet) -> FloatArray:
    """Return the scalar product of two vectors, (order + 1, rows)."""
    return np.asarray(times(np.conj(a), b).real)


def turn(angle: FloatArray) -> Jet:
    """Return e^(i angle) for the real jet of an angle [rad]."""
    result = np.zeros(angle.shape, dtype=complex)
    result[0] = np.exp(1j * angle[0])
    for k in range(1, len(angle)):
        for j in range(1, k + 1):
            result[k] += 1j * j / k * angle[j] * result[k - j]
    return result


def quotient(a: Jet, b: Jet) -> Jet:
    """Return the quotient of two jets."""
    result = np.zeros_like(a)
    for k in range(len(a)):
        rest = a[k].copy()
        for j in range(k):
            rest -= result[j] * b[k - j]
        with np.errstate(invalid="ignore"):  # rows without derivatives are NaN; numpy warns about complex NaN
            result[k] = rest / b[0]
    return result


def slope(a: Jet) -> Jet:
    """Return the jet of the derivative, one order shorter."""
    return np.asarray(a[1:] * np.arange(1, len(a))[:, None])


def derivatives(a: Jet) -> Jet:
    """Return the derivatives f, f', f'' ..."""
    return np.asarray(a * np.array([math.factorial(k) for k in range(len(a))], dtype=float)[:, None])
