"""The variables, equations and forces of a mechanism in the arrays of the kernels that reduce its motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gimcli.dynamics.kinematic_history import read_at
from gimcli.dynamics.load_arrays import acting, with_force_gauges
from gimcli.kernels import influence, reduction
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.structure.coordinate_partitioning import Choice, make_chart
from gimcli.structure.polynomials import continue_linked, coupled_terms, with_gauges, with_linked_gauges


class ReducedEquations:
    """The equations of a mechanism in variables: x and y of nodes, inputs, gauges, 1; normal frame and rad.

    The gauges are those of the mechanism, then those of gears turned by the linkage and of forces.
    """

    def __init__(self, mechanism: Mechanism, released: Sequence[int], metre: float) -> None:
        self.mechanism = mechanism
        self.read = with_force_gauges(with_linked_gauges(mechanism)).nearby
        self.terms = coupled_terms(with_gauges(self.read))
        self.acting = acting(self.read, released, metre)
        first = self.terms.first_reading
        self.input_variables = slice(first, first + len(mechanism.actuators))

    def variables(self, z: ComplexArray, inputs: FloatArray, gauges: FloatArray | None = None) -> FloatArray:
        """Return the variables at a position; angles are near those of the gauges given, or the initial ones."""
        terms, own, near = self.terms, self.input_variables, self.mechanism.near(z)
        v = np.zeros(terms.variables)
        v[0 : own.start : 2], v[1 : own.start : 2], v[own], v[-1] = near.real, near.imag, inputs, 1.0
        read = terms.mechanism.actuators[len(inputs) :]
        angles = [gauge.drawn for gauge in read]
        if gauges is not None:
            angles[: len(gauges)] = gauges.tolist()
        v[own.stop : -1] = [read_at(terms.mechanism, g, near, last) for g, last in zip(read, angles, strict=True)]
        continue_linked(terms, v)
        return v

    def choose(self, choice: Choice) -> None:
        """Set independent variables: make the chart, scratch arrays and results."""
        self.chart = make_chart(self.terms, choice)
        size, variables = len(choice.independent), self.terms.variables
        widest = max([1, size, *(b[2] - b[1] for b in self.chart.blocks)])
        self.room = influence.InfluenceScratch(
            np.zeros((3, self.terms.functions)), np.zeros((widest, widest)), np.zeros(2 * widest), np.zeros(widest),
            np.zeros(variables), np.zeros(variables), np.zeros(size), np.zeros(2, dtype=np.int64), np.zeros(3),
        )  # fmt: skip
        self.room.f[0, 0] = 1.0
        self.out = reduction.Reduced(
            np.zeros((size, size)), np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(reduction.ENERGIES)
        )

    def place(self, v: FloatArray) -> influence.InfluencePosition:
        """Return the arrays of a position with these variables."""
        size, variables = len(self.chart.independent), self.terms.variables
        return influence.InfluencePosition(v.copy(), np.zeros((size, variables)), np.zeros(len(self.chart.blocks)))

    def nodes(self, v: FloatArray) -> ComplexArray:
        """Return x + iy of the nodes from variables (..., variables)."""
        first = self.terms.first_reading
        return self.mechanism.whole(v[..., 0:first:2] + 1j * v[..., 1:first:2], -1)

    def inputs(self, v: FloatArray) -> FloatArray:
        """Return the values of the actuators from variables (..., variables)."""
        return np.asarray(v[..., self.input_variables])
