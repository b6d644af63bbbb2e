"""Choice of independent variables, and the order in which the equations determine the others.

Usually the inputs are independent. Near a dead point of an input, the variable that changes most in the motion of the
mechanism is used instead. Among redundant equations, the most independent ones are used. The dependent variables are
solved in blocks; if the inputs are independent, these are the Assur groups.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.canonical import ROUNDING
from gimcli.kernels import influence
from gimcli.mechanism import FloatArray
from gimcli.structure.dulmage_mendelsohn import split
from gimcli.structure.terms import ONE, Term, Terms

SINGULAR = 1e-9
"""Ratio of least to greatest singular value below which equations are dependent."""


@dataclass(frozen=True)
class Choice:
    """The equations used, the independent variables (the free ones first), and the unknowns."""

    rows: tuple[int, ...]
    independent: tuple[int, ...]
    unknown: tuple[int, ...]


def free_choice(
    terms: Terms, v: FloatArray, given: Sequence[int], count: int, singular: float = SINGULAR
) -> Choice | None:
    """Return the best-conditioned choice of independent variables; None at a singular position.

    given: actuators that follow laws. count: number of the other freedoms. singular: as SINGULAR.
    """
    from scipy.linalg import qr, svd

    active = [*terms.moving, *range(terms.first_reading, terms.variables - 1)]
    known = [terms.first_reading + r for r in given]
    open_ones = [k for k in active if k not in known]
    _, values, across = svd(terms.arrays.slopes(v)[:, open_ones])
    rank = len(open_ones) - count
    if rank > len(values) or (rank and not values[rank - 1] > singular * values[0]):
        return None
    # of equally good variables the first
    chosen = qr(across[rank:] * (1.0 - ROUNDING * np.arange(len(open_ones))), mode="r", pivoting=True)[1][:count]
    return _choice(terms, v, (*sorted(open_ones[k] for k in chosen), *known), active)


def input_choice(terms: Terms, v: FloatArray, free: Sequence[int], given: Sequence[int]) -> Choice | None:
    """Return the choice of the inputs as independent variables; None if they do not determine the position."""
    active = [*terms.moving, *range(terms.first_reading, terms.variables - 1)]
    return _choice(terms, v, tuple(terms.first_reading + r for r in (*free, *given)), active)


def _choice(terms: Terms, v: FloatArray, independent: tuple[int, ...], active: Sequence[int]) -> Choice | None:
    from scipy.linalg import qr

    unknown = tuple(k for k in active if k not in independent)
    table = terms.arrays.slopes(v)[:, unknown]
    rows: Sequence[int] = range(len(table))
    if len(table) < len(unknown):
        return None
    scale = np.linalg.norm(table, axis=1)
    table = table / np.where(scale > 0.0, scale, 1.0)[:, None]
    if len(table) > len(unknown):
        rows = sorted(int(k) for k in qr(table.T, mode="r", pivoting=True)[1][: len(unknown)])
    values = np.linalg.svd(table[list(rows)], compute_uv=False)
    if len(values) and not values[-1] > SINGULAR * values[0]:
        return None
    return Choice(tuple(rows), independent, unknown)


def make_chart(terms: Terms, choice: Choice) -> influence.Chart:
    """Return a choice in the form that the kernels use."""
    column = {variable: k for k, variable in enumerate(choice.unknown)}
    entered: list[list[int]] = [[] for _ in choice.unknown]
    for k, row in enumerate(choice.rows):
        equation = terms.equations[row]
        own_variables = {k for t in equation for k in (t.first, t.second)}
        own_variables |= {terms.owner(t.function) for t in equation if t.function != ONE}
        for variable in sorted(own_variables):
            if variable in column:
                entered[column[variable]].append(k)
    heads, unknown, rounds = [], list[int](), list[float]()
    ints, floats = list[tuple[int, ...]](), list[float]()
    for block in split(len(choice.rows), entered):
        own = [choice.unknown[k] for k in block.columns]
        equations = [terms.equations[choice.rows[k]] for k in block.rows]
        kind, circles = _kind(terms, equations, own)
        first = len(ints)
        for row, equation in enumerate(equations):
            for t in equation:
                ints.append(_numbers(terms, t, row, own))
                floats.append(t.factor)
        heads.append((kind, len(unknown), len(unknown) + len(own), first, len(ints)))
        unknown += own
        rounds += circles
    return influence.Chart(
        np.array(heads, dtype=np.int64).reshape(-1, 5), np.array(unknown, dtype=np.int64), np.array(rounds),
        np.array(ints, dtype=np.int64).reshape(-1, 8), np.array(floats), np.array(choice.independent, dtype=np.int64),
        np.array([int(terms.is_rotary(r)) for r in range(terms.readings)], dtype=np.int64), terms.first_reading,
    )  # fmt: skip


def _numbers(terms: Terms, t: Term, row: int, own: Sequence[int]) -> tuple[int, ...]:
    def at(variable: int) -> int:
        return own.index(variable) if variable in own else -1

    owner = terms.owner(t.function)
    return row, t.function, owner, t.first, t.second, at(owner) if t.function != ONE else -1, at(t.first), at(t.second)


def _kind(terms: Terms, equations: Sequence[Sequence[Term]], own: Sequence[int]) -> tuple[int, list[float]]:
    """Return the method for a block, and the factors of x^2 + y^2 in its equations (0 for a line)."""
    flat = [0.0] * len(own)
    turned = any(t.function != ONE and terms.owner(t.function) in own for e in equations for t in e)
    turned = turned or (len(own) == 2 and max(own) >= terms.first_reading)  # of coupled inputs
    curved = [[t for t in e if t.first in own and t.second in own] for e in equations]
    if turned or (len(own) != 2 and any(curved)):
        return influence.NEWTON, flat
    if not any(curved):
        return (influence.PAIR if len(own) == 2 else influence.LINEAR), flat
    circles = []
    for terms_of_row in curved:
        factors = {(t.first, t.second): t.factor for t in terms_of_row if t.function == ONE}
        x, y = (factors.get((k, k), 0.0) for k in own)
        if len(factors) != len(terms_of_row) or len(factors) not in (0, 2) or x != y:
            return influence.NEWTON, flat
        circles.append(x)
    return influence.PAIR, circles
