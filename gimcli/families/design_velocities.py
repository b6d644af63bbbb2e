"""Velocities of all designs together: derivatives of the positions by the inputs, times the rates of the laws."""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.families.float_tables import FloatTables
from gimcli.families.sensitivity import position_derivatives
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.positions.dispatch import choose


def node_velocities(family: Family, solved: Designs, tables: FloatTables, time: FloatArray) -> ComplexArray | None:
    """Return the velocities of the nodes (designs, nodes, rows) by the real time, normal frame of the nominal design.

    `time` (designs or 1, rows) is normalised. None if the laws of the designs have no rates that are known together.
    NaN in rows that are not solved or singular.
    """
    rates = _input_rates(family, tables, time)
    if rates is None:
        return None
    none: Any = (table[:, None][:, :0] for table in tables)
    run = choose("on", 0.0, None, ("differentiate_all",))
    by, good = position_derivatives(family.mechanism, tables, FloatTables(*none), solved.z, solved.inputs, run)
    found = np.einsum("dknr,dkr->dnr", by, np.broadcast_to(rates, (len(by), *rates.shape[1:])))
    return np.where(good[:, None], found, np.nan)


def _input_rates(family: Family, tables: FloatTables, time: FloatArray) -> FloatArray | None:
    """Return the rates of the inputs (designs or 1, actuators, rows) by the real time."""
    mechanism = family.mechanism
    laws = [np.stack([actuator.law(row, 1) for row in time]) for actuator in mechanism.actuators]
    rates = np.stack(laws, axis=1) / mechanism.duration
    if not family.drawn_laws:
        return rates
    spans = tables.laws[:, :, 1] - tables.laws[:, :, 0]
    nominal = family.tables(family.nominal[None]).laws[0]
    with np.errstate(all="ignore"):
        share = np.where(np.isfinite(spans), spans / (nominal[:, 1] - nominal[:, 0]), 1.0)
    return rates * share[:, :, None] if np.isfinite(share).all() else None
