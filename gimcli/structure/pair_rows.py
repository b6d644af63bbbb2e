"""The constraints of all pairs and actuators, with their values."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from gimcli.mechanism import ANGLE, Mechanism, PairRow
from gimcli.structure.derived import derived
from gimcli.structure.rotation import rotation_classes
from gimcli.structure.steps import NONE, Value


@dataclass(frozen=True, eq=False)
class ImposedRow(PairRow):
    """A constraint and its value; `implied`: the rotation classes and the other rows already ensure it."""

    value: Value = field(default=Value(0.0))
    implied: bool = False


@derived
def pair_rows(mechanism: Mechanism) -> tuple[ImposedRow, ...]:
    """Return the constraints of all pairs, then those of all actuators."""
    implied = rotation_classes(mechanism).implied
    pairs = [_imposed(row, NONE, row.kind == ANGLE or row in implied) for row in mechanism.pairs]
    return (*pairs, *(_imposed(actuator, k, False) for k, actuator in enumerate(mechanism.actuators)))


def _imposed(row: PairRow, actuator: int, implied: bool) -> ImposedRow:
    own = {part.name: getattr(row, part.name) for part in fields(PairRow)}
    return ImposedRow(**own, value=Value(0.0, actuator), implied=implied)
