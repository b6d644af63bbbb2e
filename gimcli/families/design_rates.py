"""Derivatives of the positions of many designs: the operations of the nominal plan, with numbers of each design.

The plan is differentiated once, with recorded numbers as dimensions; the constants of the operations are then computed
for all designs together.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import nominal
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
from gimcli.rates.tangents import Tangents, Varying
from gimcli.rates.tape import Tape
from gimcli.structure.plan import make_plan

TOGETHER = 16
"""Number of dimensions whose derivatives are computed together: their lanes are in the cache of a processor."""


class DesignTapes:
    """Tapes with recorded numbers, which are executed one after another for many designs."""

    def __init__(self, tapes: Sequence[Tape], recording: Recording) -> None:
        self.arrays = [tape.operations() for tape in tapes]
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


class DesignFormulas:
    """Results of one tape for many designs, also in dual numbers: then its tangents are recorded, once for each set."""

    def __init__(self, tape: Tape, recording: Recording, points: tuple[int, int], angles: tuple[int, int]) -> None:
        """Take the numbers of slots of points and of angles, and how many the tape writes in each."""
        self.tape, self.recording, self.points, self.angles = tape, recording, points, angles
        self._tapes = {b"": DesignTapes([tape], recording)}

    def __call__(self, designs: FloatArray, z: Any, given: Any, run: Run) -> tuple[Any, Any]:
        """Return points (designs, slots, points, rows) and angles (designs, slots, angles, rows).

        Arguments are those of `DesignTapes`; z and given may be dual numbers whose first tangents are the dimensions.
        """
        tapes, parts = self._tapes[b""], 1
        if isinstance(z, Dual):
            tapes, parts = self._with_tangents(z, given), 1 + len(z.slopes)
            z, given = _in_one(z, parts), _in_one(given, parts)
        points, angles = (
            np.zeros((len(z), parts * slots, count, z.shape[-1]), kind)
            for (slots, count), kind in ((self.points, complex), (self.angles, float))
        )
        tapes(designs, z, given, points, angles, run)
        return (points, angles) if parts == 1 else (_divided(points, parts), _divided(angles, parts))

    def _with_tangents(self, z: Dual, given: Any) -> DesignTapes:
        """Return tapes with the tangents along which the given numbers change."""
        count = len(z.slopes)
        inputs = given.slopes if isinstance(given, Dual) else np.zeros((count, *given.shape))
        varying = Varying(np.any(np.abs(z.slopes) > 0.0, axis=(1, 3)), np.any(np.abs(inputs) > 0.0, axis=(1, 4)))
        key = b" ".join(np.packbits(own).tobytes() for own in varying)
        if key not in self._tapes:
            results = self.points[0], self.angles[0]
            self._tapes[key] = DesignTapes([
                Tangents(self.tape, self.recording, varying, range(k, min(k + TOGETHER, count)), results).made
                for k in range(0, count, TOGETHER)
            ], self.recording)  # fmt: skip
        return self._tapes[key]


def _in_one(number: Any, parts: int) -> Any:
    """Return the derivatives of dual numbers (designs, slots, ...) after their values, in one axis of slots."""
    if not isinstance(number, Dual):
        number = Dual(number, np.zeros((parts - 1, *number.shape)))
    found = np.moveaxis(np.concatenate([number.value[None], number.slopes]), 0, 1)
    return found.reshape(len(found), parts * found.shape[2], *found.shape[3:])


def _divided(found: Any, parts: int) -> Dual:
    """Return dual numbers from their values and derivatives in one axis of slots."""
    own = np.moveaxis(found.reshape(len(found), parts, found.shape[1] // parts, *found.shape[2:]), 1, 0)
    return Dual(own[0], own[1:])


class DesignRates:
    """Computes velocities, accelerations and jerks of nodes and members."""

    def __init__(self, order: int, recorded: Mechanism, recording: Recording) -> None:
        """Differentiate the plan of a mechanism with recorded numbers up to an order."""
        self.made = Differentiator(recorded, make_plan(recorded), ORDERS[:order], recorded.nodes)
        self.formulas = DesignFormulas(self.made.tape, recording, self.made.points, self.made.angles)

    def __call__(
        self, designs: FloatArray, z: Any, given: Any, jit: str = "auto", notify: Notify | None = None
    ) -> tuple[Any, Any]:
        """Return nodes (designs, order + 1, nodes, rows) and omega, alpha ... (designs, order, members, rows).

        Arguments are those of `DesignFormulas`; inputs and their derivatives are given up to the order.
        """
        run = choose(jit, self.made.plain_seconds(len(z) * z.shape[-1]), notify, ("play_designs",))
        return self.formulas(designs, z, given, run)


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

    def moving(self, designs: FloatArray, z: ComplexArray, inputs: Any, run: Run) -> tuple[Dual, BoolArray]:
        """Return nodes in dual numbers (designs, nodes, rows), whose first tangents are the dimensions, and the mask.

        Arguments as above; the inputs may be dual numbers, with further tangents.
        """
        by, good = self(designs, z, nominal(inputs), run)
        count = designs.shape[1]
        slopes = np.moveaxis(by[:, :count], 1, 0)
        if isinstance(inputs, Dual):
            slopes = np.concatenate([slopes, np.zeros((len(inputs.slopes) - count, *z.shape))])
            along = np.flatnonzero(inputs.slopes.any(axis=(1, 2, 3)))  # the tangents along which inputs change
            slopes[along] += np.einsum("danr,kdar->kdnr", by[:, count:], inputs.slopes[along])
        return Dual(z, slopes), good
