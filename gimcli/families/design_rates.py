"""Velocities, accelerations and jerks of many designs: the operations of the nominal plan, with numbers of each design.

The plan is differentiated once, with recorded numbers as dimensions; the constants of the operations are then computed
for all designs together.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.recorded import Recording
from gimcli.families.float_tables import TableMaker
from gimcli.kernels import tape as kernels
from gimcli.kernels.lanes import WIDTH
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.dispatch import choose
from gimcli.progress import Notify
from gimcli.rates.derivatives import ORDERS, Differentiator, parts
from gimcli.rates.tape_values import tape_values
from gimcli.structure.plan import make_plan


class DesignRates:
    """Computes the derivatives of all nodes and members by the time, up to an order."""

    def __init__(self, order: int, recorded: Mechanism, recording: Recording) -> None:
        """Differentiate the plan of a mechanism with recorded numbers."""
        self.made = Differentiator(recorded, make_plan(recorded), ORDERS[:order], recorded.nodes)
        constants = [part for _, c in self.made.tape.constants.values() for part in (c.real, c.imag)]
        self.maker = TableMaker(recording, [[x for pair in self.made.tape.factors for x in pair], constants])

    def dual(self, design: FloatArray, z: Dual, given: Dual) -> tuple[Any, Any]:
        """Return points[order, node] and angles[order - 1, member - 1] (1, rows) of one design in dual numbers.

        design (dimensions,); z (nodes, rows) and given (order + 1, actuators, rows) with tangents by the dimensions
        and by the inputs.
        """
        more, numbers = len(z.slopes) - len(design), list[list[Any]]()
        for values, slopes in zip(self.maker.flat(design[None]), self.maker.flat_tangents(design[None]), strict=True):
            own = np.pad(slopes, ((0, more), (0, 0))).T[..., None]
            numbers.append([Dual([x], d) if d.any() else x for x, d in zip(values[0], own, strict=True)])
        factors, constants = numbers
        w = dict(enumerate(constants, start=len(self.made.w) // WIDTH - len(constants)))
        found = tape_values(self.made.heads, list(zip(factors[::2], factors[1::2], strict=True)), w, z, given)
        points, angles = ({key: (x + 0.0 * z[0].real)[None] for key, x in one.items()} for one in found)
        return points, angles

    def __call__(
        self, designs: FloatArray, z: ComplexArray, given: FloatArray, jit: str = "auto", notify: Notify | None = None
    ) -> tuple[ComplexArray, FloatArray]:
        """Return nodes (designs, order + 1, nodes, rows) and omega, alpha ... (designs, order, members, rows).

        designs (designs, dimensions) in the file's units; z (designs, nodes, rows); given (designs or 1, order + 1,
        actuators, rows): inputs and their derivatives. NaN in rows that are not solved or singular.
        """
        made, (count, _, rows) = self.made, z.shape
        run = choose(jit, made.plain_seconds(z[:, 0].size), notify, ("play",))(kernels.play)
        factors, constants = self.maker.flat(designs)
        factors, constants = factors.reshape(count, -1, 2), constants.reshape(count, -1, 2, 1)
        nodes = np.empty((count, *made.points, rows), dtype=complex)
        angles = np.empty((count, *made.angles, rows))
        given = np.ascontiguousarray(given)
        own: Any
        with np.errstate(all="ignore"):
            for k, own in enumerate(np.ascontiguousarray(z)):
                made.tape.fixed[:] = constants[k]
                run(made.w, made.heads, factors[k], parts(own), given[k % len(given)], parts(nodes[k]), angles[k])
        return nodes, angles
