"""The solved positions of many designs."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray
from gimcli.status import Status


@dataclass(frozen=True)
class Designs:
    """The positions of designs, in the normal frame of the nominal mechanism."""

    designs: FloatArray = field(repr=False)  # (designs, dimensions) in the file's units
    time: FloatArray = field(repr=False)  # (rows,) 0..1
    inputs: FloatArray = field(repr=False)  # (designs or 1, actuators, rows)
    z: ComplexArray = field(repr=False)  # (designs, nodes, rows), NaN where not solved
    codes: IntArray = field(repr=False)  # (designs, rows) of Status
    residual: FloatArray = field(repr=False)  # (designs, rows), NaN where not solved
    careful: int  # number of designs that were solved one by one

    @cached_property
    def good(self) -> BoolArray:
        """(designs, rows) whether the row is solved."""
        return np.asarray(self.codes <= Status.TANGENT)

    @cached_property
    def solved(self) -> IntArray:
        """(designs,) number of rows that are ok."""
        return np.asarray(self.good.sum(axis=1))

    @property
    def reachable(self) -> FloatArray:
        """(designs,) share of the rows that are ok."""
        return np.asarray(self.solved / self.codes.shape[1])

    @cached_property
    def status(self) -> IntArray:
        """(designs,) OK if all rows are, else the code of the first row that is not."""
        return np.asarray(self.codes[np.arange(len(self.codes)), np.argmin(self.good, axis=1)])
