"""Derivatives of inputs that follow the linkage itself by the dimensions and by the inputs of the drivers.

Such an input is a function U of the dimensions, the positions and the drivers' inputs. Its derivatives while all inputs
are independent, W, give those of the coupled inputs: du = W + W_F du, where W_F is that by these inputs. The same holds
for each derivative by the time, whose part that depends on itself has the same W_F.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import nominal
from gimcli.calculus.series import Series
from gimcli.families.design_rates import DesignRates, PositionSlopes
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.newton import Run
from gimcli.structure.carried import measured


class LinkedSlopes:
    """The inputs that follow the linkage, as functions of dimensions, positions and the inputs of the drivers."""

    def __init__(
        self, mechanism: Mechanism, names: tuple[str, ...], slopes: PositionSlopes, rates: Callable[[int], DesignRates]
    ) -> None:  # fmt: skip
        """Take the dimensions, and what computes nodes of designs and their derivatives by the time up to an order."""
        recorded, self.recording = mechanism.written.recorded(mechanism, names)
        self._slopes, self._rates = slopes, rates
        x, y, u = (
            [self.recording.variable(value) for value in values]
            for values in (mechanism.drawn.real, mechanism.drawn.imag, mechanism.drawn_inputs)
        )
        z = [a + 1j * b for a, b in zip(x, y, strict=True)]
        linked = [coupling for coupling in recorded.couplings if coupling.reads]
        self.followers = [coupling.follower for coupling in linked]
        turned = [self.recording.variable(0.0) for _ in linked]  # what is added to the first reading: full turns
        self.formulas = [
            sum((ratio * u[k] for k, ratio in one.terms), one.phase)
            + sum((ratio * measured(recorded, row, z) for row, ratio in one.reads), one.reads[0][1] * turn)
            for one, turn in zip(linked, turned, strict=True)
        ]  # fmt: skip
        self.ratios = np.array([[nominal(one.reads[0][1])] for one in linked])

    def __call__(self, design: FloatArray, z: ComplexArray, own: Dual, run: Run) -> Dual:
        """Return inputs with derivatives (orders, actuators, rows) in dual numbers, with the tangents of the followers.

        design: (dimensions,). z: its nodes (nodes, rows). own: the inputs with tangents, of which the dimensions are
        the first.
        """
        linked, count = self.followers, len(own.slopes)
        slopes = np.concatenate([own.slopes, np.zeros((len(linked), *own.shape))])
        tangents = [*range(count, count + len(linked))]
        slopes[:, :, linked] = 0.0
        slopes[tangents, 0, linked] = 1.0
        turns = np.zeros((len(linked), own.shape[-1]))
        for order in range(len(own)):
            found = Dual(own.value, slopes)
            nodes = self._nodes(design, z, found[: order + 1], run)
            if order == 0:
                near = [one.value for one in self._derivatives(design, nodes, found[:1], turns)]
                turns = (own.value[0, linked] - near) / self.ratios
            every = self._derivatives(design, nodes, found[: order + 1], turns)
            w = np.moveaxis(np.array([one.slopes for one in every]), (0, 1, 2), (2, 1, 0))
            if order == 0:
                freed = np.linalg.inv(np.eye(len(linked)) - w[:, tangents])
                slopes[tangents] = w[:, tangents] = 0.0
            slopes[:, order, linked] = np.moveaxis(w @ freed, 0, -1)
        return Dual(own.value, slopes[:count])

    def _nodes(self, design: FloatArray, z: ComplexArray, own: Dual, run: Run) -> Any:
        """Return the nodes with their derivatives by the time (orders, nodes, rows) in dual numbers."""
        at, order = self._slopes.moving(design[None], z[None], own[:1], run)[0], len(own) - 1
        return self._rates(order)(design[None], at, own[None], "off")[0][0] if order else at

    def _derivatives(self, design: FloatArray, nodes: Dual, own: Dual, turns: FloatArray) -> list[Any]:
        """Return the derivative of an order by the time (rows,) of each follower.

        nodes (order + 1, nodes, rows), inputs (order + 1, actuators, rows) with derivatives by the time, and the full
        turns (followers, rows) of the first angle that each follows.
        """
        order, tangents = len(own) - 1, len(own.slopes)
        factors = np.array([[1.0 / math.factorial(k)] for k in range(order + 1)])
        start = np.eye(order + 1, 1)
        designs = [
            Series(Dual(start * value, np.eye(tangents)[k][:, None, None] * start))
            for k, value in enumerate(design.tolist())
        ]
        x, y = ([Series(part(nodes[:, n]) * factors) for n in range(nodes.shape[1])] for part in (np.real, np.imag))
        inputs = [Series(own[:, k] * factors) for k in range(own.shape[1])]
        more = [Series(Dual(start * turn, np.zeros((tangents, 1, 1)))) for turn in turns]
        values = [*designs, *x, *y, *inputs, *more]
        found = self.recording.evaluate(values, [one.place for one in self.formulas])
        return [found[one.place].c[order] / factors[order] for one in self.formulas]
