"""Columns of the table of forces of a motion with dry friction, and the words of its rows."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from gimcli.dynamics.coulomb import DryFriction
from gimcli.dynamics.coulomb_status import SELF_LOCKING, FrictionStatus
from gimcli.dynamics.efficiency import row_efficiency, self_locking
from gimcli.dynamics.force_columns import ForceColumn, columns_of, effort_unit
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.statics import Statics
from gimcli.mechanism import FloatArray
from gimcli.table import Column

WORDS = np.array([status.word for status in FrictionStatus])
LIMITS = ("least", "greatest")
STATE = "friction.state"
"""Name of the column with the words of the rows."""


def friction_formulas(statics: Statics) -> Iterator[ForceColumn]:
    """Yield the power lost in each pair, limits of the efforts, and the efficiency; none without dry friction."""
    mechanism = statics.mechanism
    rubbing = dict.fromkeys(friction.name for friction in mechanism.dynamics.frictions if friction.mu)
    for name in rubbing:
        yield ForceColumn(f"friction.power.{name}", "W", partial(_power, name=name), dry=True)
    for k, actuator in enumerate(mechanism.actuators if rubbing else ()):
        if k in mechanism.geared:
            continue
        for word, (i, end) in product(("effort", "hold"), enumerate(LIMITS)):
            find = partial(_limit, word=word, end=i, actuator=k)
            yield ForceColumn(f"{actuator.name}.{word}.{end}", effort_unit(mechanism, k), find, dry=True)
    if rubbing:
        yield ForceColumn("friction.efficiency", "", _efficiency, dry=True)


def _power(forces: Forces, name: str) -> FloatArray:
    dry: Any = forces.dry
    return np.where(forces.good, dry.powers[dry.names.index(name)], np.nan)


def _efficiency(forces: Forces) -> FloatArray:
    assert forces.dry is not None
    return row_efficiency(forces, forces.dry)


def _limit(forces: Forces, word: str, end: int, actuator: int) -> FloatArray:
    return np.asarray(getattr(forces.dry, word)[end, actuator])


def friction_columns(forces: Forces, dry: DryFriction) -> list[Column]:
    """Return the power lost in each pair, limits of the efforts, efficiency, and the words of the rows."""
    locked = np.where(self_locking(dry) & (dry.codes == FrictionStatus.SLIDING), SELF_LOCKING, WORDS[dry.codes])
    return [*columns_of(forces, friction_formulas(forces.statics)), Column(STATE, locked)]


def with_friction_words(status: Column, dry: DryFriction) -> Column:
    """Return the status column with the words of rows whose forces dry friction does not determine."""
    return Column(status.name, np.where(dry.codes == FrictionStatus.SLIDING, status.values, WORDS[dry.codes]))
