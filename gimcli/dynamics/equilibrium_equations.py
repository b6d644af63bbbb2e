"""The equations of dynamic equilibrium of all bodies: their matrix, their right side, and their solution by blocks."""

from __future__ import annotations

import numpy as np

from gimcli.dynamics.loading import Loading
from gimcli.dynamics.statics import Statics
from gimcli.kernels.equilibrium import ALONG, KNOWN, MOMENT, ROWS, TURN, BalanceScratch, X, Y, balance_rows
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.positions.newton import Run

SINGULAR = 1e-10
"""Ratio of least to greatest pivot, or singular value, of a scaled block below which its reactions are undetermined."""

EquilibriumTerm = tuple[int, int, int, int, int, int, float]
"""Row, column, unknown, kind, node of action, node of reference, factor; as in the kernel."""


def right_side(statics: Statics, loads: Loading) -> FloatArray:
    """Return the right side of the equations of equilibrium (equations, rows): inertia less applied forces."""
    right = np.zeros((statics.equations, len(loads.kinetic)))
    for k, (body, first) in enumerate(zip(statics.bodies, statics.first_row, strict=True)):
        force = loads.inertia_force[k] - loads.force[k]
        right[first], right[first + 1] = force.real, force.imag
        if body.member >= 0:
            right[first + 2] = loads.inertia_moment[k] - loads.moment[k]
    return right


def directions(statics: Statics, z: ComplexArray) -> ComplexArray:
    """Return the direction of every unknown (unknowns, rows) at positions z (nodes, rows)."""
    result = np.empty((len(statics.reactions), z.shape[1]), dtype=complex)
    for k, reaction in enumerate(statics.reactions):
        vector = reaction.vector
        result[k] = vector.z * (z[vector.v] - z[vector.u] if vector.u >= 0 else 1.0)
        if reaction.kind == ALONG:
            with np.errstate(divide="ignore", invalid="ignore"):  # rows without a position become NaN
                result[k] /= np.abs(result[k])
    return result


class Balance:
    """The equations of equilibrium in the arrays of the kernel, scaled by `Statics.scales`."""

    def __init__(self, statics: Statics) -> None:
        self.statics = statics
        reactions = statics.reactions
        turned = [(c, r.vector.u, r.vector.v, r.kind == ALONG) for c, r in enumerate(reactions) if r.vector.u >= 0]
        self.turned = np.array(turned, dtype=np.int64).reshape(-1, 4)
        z = np.broadcast_arrays(*(np.atleast_1d(r.vector.z) for r in reactions))
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
    unit = directions(statics, z)
    for c, entered in enumerate(statics.entered):
        for body, axis, kind, factor, node in entered:
            arm = z[node] - z[statics.bodies[body].node]
            part = {X: unit[c].real, Y: unit[c].imag, MOMENT: (arm.conj() * unit[c]).imag, TURN: 1.0}[kind]
            table[:, statics.first_row[body] + axis, c] += factor * part
    return table
