"""Newton-Raphson on the base nodes of a coupled group: its constants, and the group as arrays."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gimcli.kernels.newton import GroupArrays, StopLimits
from gimcli.structure.steps import NONE, Coupled, Vector

Run = Callable[[Callable[..., Any]], Callable[..., Any]]
"""Returns the function to call for a kernel: the kernel itself or its compiled form."""


@dataclass(frozen=True)
class Accuracy:
    """The requested tolerance and its reference lengths, in the normal frame."""

    tolerance: float  # relative to the size
    size: float
    shortest: float  # shortest length of a member
    singular: float = 0.0  # error of the nodes above which a position is singular, if greater than the tolerance


@dataclass(frozen=True)
class NewtonConstants:
    """Constants of the method. Contraction 1/4: Deuflhard, Newton Methods, 2011, section 2.1."""

    iterations: int = 24  # greatest number for a row that starts from the one before
    far: int = 100  # the same for an arbitrary start
    contraction: float = 0.25
    first_step: float = 0.2  # of the size: a longer first correction may lead to another branch
    rounding: float = 4.0 * float(np.finfo(float).eps)  # error of an equation, relative to the size
    relative: float = 0.1  # of the shortest length: relative errors are then below the tolerance too
    serving: float = 0.05  # of shortest length times least pivot: displacement up to which factors are reused

    def limits(self, accuracy: Accuracy, iterations: int, near: bool) -> StopLimits:
        """Return the stopping criteria for the kernel; `near`: the solution must be on the branch of the start."""
        size, tolerance = accuracy.size, accuracy.tolerance
        first, contraction = (self.first_step * size, self.contraction) if near else (1e6, 1e6)
        finest = max(self.relative * tolerance * accuracy.shortest, self.rounding * size)
        pivot = self.rounding / max(tolerance, accuracy.singular)
        reach = self.serving * accuracy.shortest
        return StopLimits(finest, iterations, first, contraction, pivot, self.rounding * size, reach)


@dataclass(frozen=True)
class Packed:
    """A coupled group in the arrays of the kernel; its nodes are numbered in the order base, carried, known."""

    group: Coupled

    @cached_property
    def nodes(self) -> tuple[int, ...]:
        """The number in the mechanism of each local node."""
        own = list(self.group.nodes)
        for place in self.group.places:
            own += [place.anchor, *place.vector.nodes]
        for equation in self.group.equations:
            own += [equation.p, equation.q, *(equation.vector.nodes if equation.vector else ())]
        return tuple(dict.fromkeys(own))

    @cached_property
    def arrays(self) -> GroupArrays:
        """The arrays for the kernel."""
        places, equations, heads, factors, values = self.tables
        return GroupArrays(
            len(self.group.base),
            sum(e.rows for e in self.group.equations),
            any(p.vector.actuator != NONE for p in self.group.places),
            np.array(self.nodes, dtype=np.int64),
            np.array(heads, dtype=np.int64).reshape(-1, 5),
            np.array(factors, dtype=float).reshape(-1, 2),
            np.array(places, dtype=np.int64).reshape(-1, 3),
            np.array(equations, dtype=np.int64).reshape(-1, 5),
            np.array(values, dtype=float).reshape(-1, 2),
        )

    @cached_property
    def tables(self) -> tuple[list[Any], ...]:
        """Places, equations, vectors, factors of the vectors and values of the equations, as lists of rows."""
        local = {n: k for k, n in enumerate(self.nodes)}
        vectors: list[Vector] = []

        def index(vector: Vector | None) -> int:
            if vector is None:
                return NONE
            vectors.append(vector)
            return len(vectors) - 1

        places = [(local[p.node], local[p.anchor], index(p.vector)) for p in self.group.places]
        equations = [(e.kind, local[e.p], local[e.q], index(e.vector), e.value.actuator) for e in self.group.equations]
        values = [(e.value.constant, e.value.gain) for e in self.group.equations]
        heads = [(local.get(v.u, NONE), local.get(v.v, NONE), v.register, v.actuator, v.turn) for v in vectors]
        return places, equations, heads, [(v.z.real, v.z.imag) for v in vectors], values
