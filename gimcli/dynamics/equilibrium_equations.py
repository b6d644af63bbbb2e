"""The equations of dynamic equilibrium of all bodies: their matrix, their right side, and their solution by blocks."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from gimcli.calculus.numbers import nominal
from gimcli.dynamics.loading import Loading
from gimcli.dynamics.statics import Reaction, Statics, direction
from gimcli.kernels.equilibrium import ALONG, KNOWN, MOMENT, ROWS, TURN, BalanceScratch, X, balance_rows
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.positions.newton import Run
from gimcli.structure.steps import NONE

SINGULAR = 1e-10
"""Ratio of least to greatest pivot, or singular value, of a scaled block below which its reactions are undetermined."""

EquilibriumTerm = tuple[int, int, int, int, int, int, float]
"""Row, column, unknown, kind, node of action, node of reference, factor; as in the kernel."""


def right_side(statics: Statics, loads: Loading) -> Any:
    """Return the right side of the equations of equilibrium (equations, rows): inertia less applied forces."""
    z, right = loads.course.nodes[0], [0.0 * loads.course.time] * statics.equations
    for part in loads.parts:
        body = part.body(statics)
        if body != NONE:
            first, own = statics.first_row[body], statics.bodies[body]
            right[first], right[first + 1] = right[first] - part.force.real, right[first + 1] - part.force.imag
            if own.member != NONE:
                moment = ((part.point() - z[own.node]).conjugate() * part.force).imag + part.couple
                right[first + MOMENT] = right[first + MOMENT] - moment
    for known in loads.efforts:
        for row, coefficient in coefficients(statics, known.reaction, z):
            right[row] = right[row] - coefficient * known.effort
    return np.stack(right)


def directions(statics: Statics, z: ComplexArray) -> ComplexArray:
    """Return the direction of every unknown (unknowns, rows) at positions z (nodes, rows)."""
    return np.stack([direction(reaction, z) for reaction in statics.reactions])


def coefficients(statics: Statics, reaction: Reaction, z: Any) -> Iterator[tuple[int, Any]]:
    """Yield the equations that a reaction enters, and its coefficients there (rows,), at positions z (nodes, rows)."""
    unit = direction(reaction, z)
    for body, axis, kind, factor, node in statics.entries(reaction):
        part = 1.0
        if kind == MOMENT:
            part = ((z[node] - z[statics.bodies[body].node]).conjugate() * unit).imag
        elif kind != TURN:
            part = unit.real if kind == X else unit.imag
        yield statics.first_row[body] + axis, factor * part


class Balance:
    """The equations of equilibrium in the arrays of the kernel, scaled by `Statics.scales`."""

    def __init__(self, statics: Statics) -> None:
        self.statics = statics
        reactions = statics.reactions
        turned = [(c, r.vector.u, r.vector.v, r.kind == ALONG) for c, r in enumerate(reactions) if r.vector.u >= 0]
        self.turned = np.array(turned, dtype=np.int64).reshape(-1, 4)
        z = np.broadcast_arrays(*(np.atleast_1d(nominal(r.vector.z)) for r in reactions))
        self.vectors = np.stack([np.real(z), np.imag(z)], axis=-1).swapaxes(0, 1).copy()
        blocks = statics.blocks
        self.own_rows = np.array([row for block in blocks for row in block.rows], dtype=np.int64)
        self.own_columns = np.array([column for block in blocks for column in block.columns], dtype=np.int64)
        self.rows, self.columns = statics.scales
        terms, ends = self._terms()
        self.terms = np.array([t[:-1] for t in terms], dtype=np.int64).reshape(-1, 6)
        self.factors = np.array([t[-1] for t in terms], dtype=float)
        self.blocks = np.array(ends, dtype=np.int64).reshape(-1, 3)

    def _terms(self) -> tuple[list[EquilibriumTerm], list[tuple[int, int, int]]]:
        """Return the terms of all equations, block after block, and size, first and end of the terms of each block."""
        statics = self.statics
        block_of = {row: (g, i) for g, block in enumerate(statics.blocks) for i, row in enumerate(block.rows)}
        own = {column: (g, j) for g, block in enumerate(statics.blocks) for j, column in enumerate(block.columns)}
        by_block: list[list[EquilibriumTerm]] = [[] for _ in statics.blocks]
        for c, entered in enumerate(statics.entered):
            for body, axis, kind, factor, node in entered:
                g, i = block_of[statics.first_row[body] + axis]
                j = own[c][1] if own[c][0] == g else KNOWN
                scaled = factor * self.rows[statics.first_row[body] + axis] * self.columns[c]
                by_block[g].append((i, j, c, kind, node, statics.bodies[body].node, scaled))
        terms: list[EquilibriumTerm] = []
        ends = []
        for block, own_terms in zip(statics.blocks, by_block, strict=True):
            ends.append((len(block.rows), len(terms), len(terms) + len(own_terms)))
            terms += own_terms
        return terms, ends

    def solve(self, z: ComplexArray, right: FloatArray, run: Run) -> tuple[FloatArray, FloatArray]:
        """Return the unknowns (unknowns, rows), and the least ratio of pivots in the blocks of each row (rows,)."""
        count, widest = len(self.statics.reactions), int(max(self.blocks[:, 0], default=0))
        out, weakest = np.full((count, z.shape[1]), np.nan), np.zeros(z.shape[1])
        x, y, scaled = np.ascontiguousarray(z.real), np.ascontiguousarray(z.imag), right * self.rows[:, None]
        scratch = BalanceScratch(
            np.zeros((count, 2, ROWS)), np.zeros((widest, widest, ROWS)), np.zeros((widest, ROWS)), np.zeros(ROWS),
            np.zeros((widest, widest)), np.zeros(2 * widest), np.zeros(widest),
        )  # fmt: skip
        run(balance_rows)(
            x, y, self.vectors, self.turned, self.terms, self.factors, self.blocks, self.own_rows, self.own_columns,
            scaled, SINGULAR, scratch, out, weakest,
        )  # fmt: skip
        return out * self.columns[:, None], weakest


def equilibrium(statics: Statics, z: ComplexArray) -> FloatArray:
    """Return the equations of equilibrium (rows, equations, unknowns) at positions z (nodes, rows)."""
    table = np.zeros((z.shape[1], statics.equations, len(statics.reactions)))
    for c, reaction in enumerate(statics.reactions):
        for row, coefficient in coefficients(statics, reaction, z):
            table[:, row, c] += coefficient
    return table
