"""The equations of dynamic equilibrium of all bodies: their matrix, their right side, and their solution by blocks."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from typing import Any

import numpy as np

from gimcli.calculus.numbers import RuleNumber
from gimcli.dynamics.loading import Loading
from gimcli.dynamics.statics import Reaction, Statics, direction
from gimcli.kernels import tape as kernels
from gimcli.kernels.equilibrium import MOMENT, TURN, X
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.positions.newton import Run
from gimcli.rates.derivatives import parts
from gimcli.rates.slots import Nodes
from gimcli.rates.tape import Lane, RealTerm, Tape
from gimcli.rates.tape_numbers import TapeNumber, given, number, product
from gimcli.structure.dulmage_mendelsohn import EquationBlock
from gimcli.structure.steps import NONE


def right_side(statics: Statics, loads: Loading) -> Any:
    """Return the right side of the equations of equilibrium (equations, rows): inertia less applied forces."""
    z, right = loads.course.nodes[0], [0.0 * loads.course.time] * statics.equations
    for part in loads.parts:
        body = statics.body_of(part.part)
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


def coefficients(
    statics: Statics, reaction: Reaction, z: Any, wanted: Collection[int] | None = None
) -> Iterator[tuple[int, Any]]:
    """Yield the equations that a reaction enters, and its coefficients there (rows,), at positions z (nodes, rows).

    Those of the `wanted` equations, by default of all.
    """
    unit = direction(reaction, z)
    for body, axis, kind, factor, node in statics.entries(reaction):
        if wanted is not None and statics.first_row[body] + axis not in wanted:
            continue
        part = 1.0
        if kind == MOMENT:
            part = ((z[node] - z[statics.bodies[body].node]).conjugate() * unit).imag
        elif kind != TURN:
            part = unit.real if kind == X else unit.imag
        yield statics.first_row[body] + axis, factor * part


class TapeBalance:
    """The unknowns of the equations of equilibrium on a tape: each block is recorded when one of its unknowns is asked.

    Equations and unknowns are scaled by `Statics.scales`.
    """

    def __init__(self, statics: Statics, tape: Tape, z: Any, right: Sequence[Any]) -> None:
        """Take positions z[node] and the right side of each equation, numbers of the tape."""
        self.statics, self.tape, self.z, self.right = statics, tape, z, right
        self.weak, self.least = tape.keep(1), 1.0  # lane and bound of the least ratio of pivots in the blocks
        tape.emit(kernels.AFFINE, self.weak, tape.constant(0.0), f=1.0, g=0.0)
        self._found: dict[int, TapeNumber] = {}
        self._block = {c: block for block in statics.blocks for c in block.columns}
        self._entering = [[c for c, rows in enumerate(statics.columns) if row in rows] for row in range(len(right))]

    def __getitem__(self, key: int | tuple[slice, int]) -> TapeNumber:
        """Return an unknown [N, or N x length of the normal frame] (rows,), also as the only one of its solutions."""
        unknown = key[1] if isinstance(key, tuple) else key
        if unknown not in self._found:
            self._solve(self._block[unknown])
        return self._found[unknown]

    def _solve(self, block: EquationBlock) -> None:
        """Record the solution of a block, in permanent lanes."""
        tape, n, (rows, columns) = self.tape, len(block.rows), self.statics.scales
        first, varied = tape.keep(n), True
        with tape.step():
            a = tape.take(n * n)
            for i, row in enumerate(block.rows):
                own: dict[int, list[RealTerm]] = {c: [] for c in block.columns}
                sides = [_term(rows[row], self.right[row])]
                for c in self._entering[row]:
                    for _, part in coefficients(self.statics, self.statics.reactions[c], self.z, (row,)):
                        if c in own:
                            own[c].append(_term(rows[row] * columns[c], part))
                        else:
                            factor, known, _ = _term(-rows[row] * self[c].factor, part)
                            sides.append((factor, known, self[c].own))
                varied = n > 1 or any(isinstance(x, (Lane, RuleNumber)) for term in own[block.columns[0]] for x in term)
                if not varied:
                    pivot = sum(factor for factor, _, _ in own[block.columns[0]])
                    self.least = min(self.least, abs(pivot))
                    sides = [(factor / pivot, p, q) for factor, p, q in sides]
                for j, terms in enumerate(own.values() if varied else ()):
                    tape.dots(a + i * n + j, [], terms)
                tape.dots(first + i, [], sides)
            if varied:
                tape.emit(kernels.ELIMINATE, first, a, tape.take(2 + n * (n - 1) // 2), self.weak, f=n)
        self._found |= {c: TapeNumber(tape, Lane(first + j), float(columns[c])) for j, c in enumerate(block.columns)}


def _term(factor: Any, number: Any) -> RealTerm:
    """Return a factor times a real number as a term of a sum of products."""
    own, lane = product(number)
    return own * float(factor), lane, 1.0


def solved(statics: Statics, z: ComplexArray, right: FloatArray, run: Run) -> tuple[FloatArray, FloatArray]:
    """Return the unknowns (unknowns, rows) for positions z (nodes, rows) and right sides (equations, rows).

    Returns the least ratio of pivots in the blocks of each row (rows,) too.
    """
    (count, rows), tape = (len(statics.reactions), z.shape[1]), Tape()
    nodes = Nodes(tape, 1)
    places = [number(tape, nodes[node][0]) for node in range(len(z))]
    found = TapeBalance(statics, tape, places, [given(tape, 0, row) for row in range(statics.equations)])
    for k in range(count):
        tape.emit(kernels.WRITE_ANGLE, tape.lane(found[k].lanes), 0, k)
    tape.emit(kernels.WRITE_ANGLE, found.weak, 0, count)
    points, out = np.empty((0, 0, rows), dtype=complex), np.empty((1, count + 1, rows))
    z, right = np.ascontiguousarray(z), np.ascontiguousarray(right)
    run(kernels.play)(*tape.arrays(), parts(z), right[None], parts(points), out)
    return out[0, :-1], np.nan_to_num(np.minimum(out[0, -1], found.least))


def equilibrium(statics: Statics, z: ComplexArray, reactions: Sequence[Reaction] = ()) -> FloatArray:
    """Return the equations of equilibrium (rows, equations, unknowns) at positions z (nodes, rows).

    reactions: the unknowns, by default those of the mechanism.
    """
    every = reactions or statics.reactions
    table = np.zeros((z.shape[1], statics.equations, len(every)))
    for c, reaction in enumerate(every):
        for row, coefficient in coefficients(statics, reaction, z):
            table[:, row, c] += coefficient
    return table
