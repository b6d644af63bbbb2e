"""Columns of designs of several independent machines: each with the rows that its own machine reaches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from gimcli.families.column_names import ColumnNames
from gimcli.families.design_columns import ColumnsAtRow, DesignColumns
from gimcli.families.design_motions import DesignMotions
from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.mechanism import FRAME, FloatArray


class MachineColumns(DesignColumns):
    """The columns of a file with several machines; those of no machine alone have the rows that all of them reach."""

    def __init__(self, parts: Sequence[DesignColumns], motions: DesignMotions, names: ColumnNames) -> None:
        super().__init__(motions, names)
        self.parts = parts

    def __getitem__(self, name: str) -> Any:
        """Return values in the shapes of `DesignColumns`; NaN if the machine is not solved."""
        own = [part[name] for part in self.parts if part.names.kind(name).what == "rows"]
        if not own:
            return super().__getitem__(name)
        if self.names.kind(name).columns == 1:
            return np.fmax.reduce(own)
        return np.concatenate([one.reshape(-1, *one.shape[-2:]) for one in own])

    def at(self, actuator: str, value: float) -> Any:
        """Return the columns at the first position at which an input has a value [file's unit]."""
        own = next(part for part in self.parts if actuator in part.names.rows)
        whole = DesignColumns(self.motions, self.names)
        return _ColumnsAt(own, partial(own.at, actuator, value), partial(whole.at, actuator, value))


class _ColumnsAt:
    """The columns where an input of one machine has a value; those of other machines where all are solved."""

    def __init__(self, own: DesignColumns, *at: partial[DesignColumns | ColumnsAtRow]) -> None:
        self._own, self._at = own, at

    def __getitem__(self, name: str) -> Any:
        """Return a column (designs, 1), or the columns of a measure (columns, designs, 1)."""
        return self._at[not self._own.names.kind(name).what]()[name]


def joined_designs(family: Family, designs: FloatArray, parts: Sequence[Designs]) -> Designs:
    """Return the positions of all machines; the status of a row is the worst one."""
    mechanism, time, frame = family.mechanism, parts[0].time, family.mechanism.members[FRAME]
    z = np.full((len(designs), len(mechanism.nodes), len(time)), complex(math.nan, math.nan))
    tables = family.tables(designs)
    ground = tables.shapes[:, : len(frame.nodes)]  # the frame is the first member
    z[:, list(frame.nodes)] = ground[..., :1] + 1j * ground[..., 1:]
    for machine, part in zip(mechanism.machines, parts, strict=True):
        placed, nodes = (machine.mechanism.to_file(part.z) - mechanism.origin) / mechanism.scale, list(machine.nodes)
        z[:, nodes] = np.where(np.isfinite(placed), placed, z[:, nodes])
    codes = np.max([part.codes for part in parts], axis=0)
    residual = np.max([part.residual for part in parts], axis=0)  # NaN where a machine is not solved
    inputs = family.law_inputs(time, tables)
    return Designs(designs, time, inputs, z, codes, residual, max(part.careful for part in parts))
