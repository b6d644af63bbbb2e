"""Derivatives of the positions of many designs: the operations of the nominal plan, with numbers of each design.

The plan is differentiated once, with recorded numbers as dimensions; the constants of the operations are then computed
for all designs together.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.recorded import Recording
from gimcli.families.float_tables import TableMaker
from gimcli.kernels import tape as kernels
from gimcli.kernels.lanes import WIDTH
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.positions.dispatch import choose
from gimcli.positions.newton import Run
from gimcli.progress import Notify
from gimcli.rates.derivatives import ORDERS, Differentiator, parts
from gimcli.rates.plan_rates import Differentiated
from gimcli.rates.slots import POSITION, Slot
from gimcli.rates.tape import Tape, tape_values
from gimcli.structure.plan import make_plan

TOGETHER = 16
"""Number of dimensions whose derivatives are computed together: their lanes are in the cache of a processor."""


class DesignTapes:
    """Tapes with recorded numbers, which are executed one after another for many designs."""

    def __init__(self, tapes: Sequence[Tape], recording: Recording) -> None:
        self.arrays = [tape.arrays()[:2] for tape in tapes]
        constants = [[part for _, c in tape.constants.values() for part in (c.real, c.imag)] for tape in tapes]
        factors = [[x for pair in tape.factors for x in pair] for tape in tapes]
        self.maker = TableMaker(recording, [*factors, *constants])
        self._known: tuple[Any, list[FloatArray]] = None, []  # the last designs, and their numbers
        self.first = [len(w) // WIDTH - len(own) for (w, _), own in zip(self.arrays, constants, strict=True)]

    def __call__(
        self, designs: FloatArray, z: ComplexArray, given: FloatArray, points: ComplexArray, angles: FloatArray,
        run: Run,
    ) -> None:  # fmt: skip
        """Fill points (designs, slots, points, rows) and angles (designs, slots, members, rows).

        designs (designs, dimensions) in the file's units; z (designs, nodes, rows); given (designs or 1, ., actuators,
        rows): inputs and their derivatives. NaN in rows that are not solved or singular.
        """
        key, count = (designs.shape, designs.tobytes()), len(self.arrays)
        if key != self._known[0]:
            self._known = key, self.maker.flat(designs)
        numbers = self._known[1]
        z, given = np.ascontiguousarray(z), np.array(given, order="C")
        for k, (w, heads) in enumerate(self.arrays):
            factors = numbers[k].reshape(len(designs), -1, 2)
            with np.errstate(all="ignore"):
                run(kernels.play_designs)(
                    w, heads, self.first[k], numbers[count + k], factors, parts(z), given, parts(points), angles
                )  # fmt: skip


class DesignRates:
    """Computes velocities, accelerations and jerks of nodes and members."""

    def __init__(self, order: int, recorded: Mechanism, recording: Recording) -> None:
        """Differentiate the plan of a mechanism with recorded numbers up to an order."""
        self.made = Differentiator(recorded, make_plan(recorded), ORDERS[:order], recorded.nodes)
        self.tapes = DesignTapes([self.made.tape], recording)

    def dual(self, design: FloatArray, z: Dual, given: Dual) -> tuple[Any, Any]:
        """Return points[order, node] and angles[order - 1, member - 1] (1, rows) of one design in dual numbers.

        design (dimensions,); z (nodes, rows) and given (order + 1, actuators, rows) with tangents by the dimensions
        and by the inputs.
        """
        more, numbers, maker = len(z.slopes) - len(design), list[list[Any]](), self.tapes.maker
        for values, slopes in zip(maker.flat(design[None]), maker.flat_tangents(design[None]), strict=True):
            own = np.pad(slopes, ((0, more), (0, 0))).T[..., None]
            numbers.append([Dual([x], d) if d.any() else x for x, d in zip(values[0], own, strict=True)])
        factors, constants = numbers
        w = dict(enumerate(constants, start=self.tapes.first[0]))
        found = tape_values(self.made.heads, list(zip(factors[::2], factors[1::2], strict=True)), w, z, given)
        points, angles = ({key: (x + 0.0 * z[0].real)[None] for key, x in one.items()} for one in found)
        return points, angles

    def __call__(
        self, designs: FloatArray, z: ComplexArray, given: FloatArray, jit: str = "auto", notify: Notify | None = None
    ) -> tuple[ComplexArray, FloatArray]:
        """Return nodes (designs, order + 1, nodes, rows) and omega, alpha ... (designs, order, members, rows).

        Arguments are those of a tape; inputs and their derivatives are given up to the order.
        """
        run = choose(jit, self.made.plain_seconds(z[:, 0].size), notify, ("play_designs",))
        nodes = np.empty((len(z), *self.made.points, z.shape[-1]), dtype=complex)
        angles = np.empty((len(z), *self.made.angles, z.shape[-1]))
        self.tapes(designs, z, given, nodes, angles, run)
        return nodes, angles


class PositionSlopes:
    """Computes the derivatives of nodes by the dimensions and by the inputs."""

    def __init__(self, recorded: Mechanism, recording: Recording) -> None:
        """Differentiate the plan of a mechanism with recorded numbers."""
        by = [Slot(dimension=k) for k in range(len(recording.variables))]
        by += [Slot(unit=k) for k in range(len(recorded.actuators))]
        self.count, tapes = len(by), list[Tape]()
        for k in range(0, len(by), TOGETHER):
            found = Differentiated(recorded, make_plan(recorded), [POSITION, *by[k : k + TOGETHER]])
            found.write_slopes(k)
            tapes.append(found.tape)
        self.tapes = DesignTapes(tapes, recording)

    def __call__(
        self, designs: FloatArray, z: ComplexArray, inputs: FloatArray, run: Run
    ) -> tuple[ComplexArray, BoolArray]:
        """Return the derivatives (designs, dimensions + actuators, nodes, rows), and where they are defined.

        designs (designs, dimensions); z (designs, nodes, rows), inputs (1 or designs, actuators, rows) in the normal
        frame. The derivatives by dimensions are at constant inputs; after them come those by the inputs [rad or lengths
        of the normal frame]. The mask (designs, rows) is false in rows without a position and at singular positions:
        the derivatives are NaN.
        """
        by, good = np.zeros((len(z), self.count, *z.shape[1:]), dtype=complex), np.empty((len(z), 1, 1, z.shape[-1]))
        self.tapes(designs, z, inputs[:, None], by, good, run)
        known = np.isfinite(good[:, 0, 0])
        by.transpose(0, 3, 1, 2)[~known] = np.nan
        return by, known
