"""Units of the model file: lengths, masses and turns, and the units in which speeds of inputs may be written."""

from __future__ import annotations

import math
import re

from gimcli.errors import refuse

METRES = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "km": 1e3, "in": 0.0254, "ft": 0.3048}
KILOGRAMS = {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237}
TURN = {"deg": 360.0, "rad": 2.0 * math.pi}
"""One turn in each unit of angle."""
RADIANS = {"deg": math.pi / 180.0, "rad": 1.0}
"""The units of angle [rad]."""
SPEEDS = ("rate", "speed", "idle")
"""Keys of an actuator whose values are speeds, which may have a unit."""
SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}

_SPEED = re.compile(r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)\s*((?:[^\W\d_]+|°)(?:\s*/\s*[^\W\d_]+)?)")
_ROTARY = "rpm, rev/s, deg/s or rad/s"
_LINEAR = "mm/s, m/s, in/s or mm/min"


def speed(text: str, rotary: bool, length: str, angle: str) -> float | None:
    """Return a speed such as `60 rpm` or `40 mm/s` in the file's unit of angle or length, per second.

    Args:
        text: a number and a unit.
        rotary: whether it is the speed of an angle.
        length: the file's unit of length.
        angle: the file's unit of angle.

    Returns:
        The speed; None if the text is not a number and a unit.

    Raises:
        ValueError: the unit is unknown or not one of the quantity.
    """
    match = _SPEED.fullmatch(text.strip())
    if match is None:
        return None
    number, unit = float(match[1]), "".join(match[2].split())
    unit = unit if unit.startswith("Mm") else unit.lower()  # Mm is not mm
    top, _, bottom = {"rpm": "rev/min", "°/s": "deg/s", "rps": "rev/s"}.get(unit, unit).partition("/")
    turns = {"rev": 1.0, "deg": 1.0 / TURN["deg"], "rad": 1.0 / TURN["rad"]}
    kind, known = ("rotary", _ROTARY) if rotary else ("linear", _LINEAR)
    refuse(
        (bottom not in SECONDS or top not in {**turns, **METRES}, f"expected the unit {known}"),
        (rotary != (top in turns), f"the input is {kind}: expected the unit {known}"),
        (not rotary and length not in METRES,
         "the file's length has no physical unit; write a number without a unit"),
        error=ValueError,
    )  # fmt: skip
    if rotary:
        return number * (1.0 if top == angle else TURN.get(angle, 0.0) * turns[top]) / SECONDS[bottom]
    return number * (1.0 if top == length else METRES[top] / METRES[length]) / SECONDS[bottom]
