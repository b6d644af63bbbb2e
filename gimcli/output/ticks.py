"""Ticks in fitting units: numbers on an axis have few digits, and no power of ten stands apart from the unit.

Where the values are large or small, the axis has another unit of the same kind (N and kN, mm and m), or a power of ten
before the unit.
"""

from __future__ import annotations

import math
import re
import textwrap
from typing import Any

import numpy as np

from gimcli.mechanism import FloatArray
from gimcli.output.picture import Picture
from gimcli.output.style import FONT, LETTER
from gimcli.rounding import round_below

SMALL, LARGE = 1e-2, 1e4
"""Greatest values on an axis from SMALL to below LARGE keep the unit."""

METRES = {"µm": -6, "mm": -3, "m": 0, "km": 3}
PREFIXES = {"µ": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9}
"""Decimal exponents of units of length, and of prefixes of other units."""

DEGREES = (5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0, 720.0, 1800.0, 3600.0)
"""Steps of the ticks of angles [deg]."""

LEAST, MOST = 3, 9
"""Least number of ticks, and the largest one of an angle."""


def set_ticks(axes: Any, picture: Picture) -> None:
    """Set ticks and labels of both axes, except logarithmic ones; equal units stay equal."""
    low, high = picture.frame.low, picture.frame.high
    ends = (low.real, high.real), (low.imag, high.imag)
    largest = [max(abs(a), abs(b)) for a, b in ends]
    if _unit(picture.labels[0]) == _unit(picture.labels[1]):
        largest = [max(largest)] * 2
    for k, axis in enumerate((axes.xaxis, axes.yaxis)):
        if (picture.logarithmic_x, picture.logarithmic)[k]:
            continue
        label, factor = fitted(picture.labels[k], largest[k])
        axis.set_label_text(
            _in_lines(label, (picture.frame.height + 0.4) / picture.frame.font) if k else label, parse_math=False
        )
        places = _places(axis, *ends[k], _unit(label))
        axis.set_ticks(places, tick_texts(places * factor))


def fitted(label: str, largest: float) -> tuple[str, float]:
    """Return the label of an axis in a unit that fits its largest value, and the factor of the numbers."""
    if not math.isfinite(largest) or largest == 0.0 or SMALL <= largest < LARGE:
        return label, 1.0
    shift = 3 * math.floor(math.log10(largest) / 3.0 + 1e-12)
    name, unit = _parted(label)
    return f"{name} [{_shifted(unit, shift)}]", 10.0**-shift


def _in_lines(label: str, room: float) -> str:
    """Return a label in at most two lines that are not longer than an axis [in]; the unit is kept."""
    letters = max(10, int(room / (LETTER * (FONT + 1))))
    name, unit = _parted(label)
    if len(label) <= letters:
        return label
    ending = f" [{unit}]" if unit else ""
    first, *more = textwrap.wrap(name, letters)
    rest, space = " ".join(more), letters - len(ending)
    return f"{first}\n{rest if len(rest) <= space else rest[: space - 1] + '…'}{ending}"


def _shifted(unit: str, shift: int) -> str:
    """Return a unit that is 10^shift times another one."""
    length = re.match(rf"({'|'.join(METRES)})(?=$|/s)", unit)
    if length:
        return _named(METRES, METRES[length[1]] + shift, unit[length.end() :]) or _power(unit, shift)
    if re.match(r"(N m|N|W|J)$", unit):
        return _named(PREFIXES, shift, unit) or _power(unit, shift)
    return _power(unit, shift)


def _named(names: dict[str, int], exponent: int, rest: str) -> str:
    return next((name + rest for name, own in names.items() if own == exponent), "")


def _power(unit: str, shift: int) -> str:
    return f"{power_of_ten(shift)} {unit}".strip()


def power_of_ten(exponent: int) -> str:
    """Return a power of ten as text."""
    return "10" + str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def short(value: float) -> str:
    """Return a number with three digits."""
    return re.sub(r"e\+?(-?)0*", r"e\1", f"{value:.3g}")


def _parted(label: str) -> tuple[str, str]:
    """Return the name and the unit of a label."""
    name, bracket, unit = label.rpartition(" [")
    return (name, unit[:-1]) if bracket and unit.endswith("]") else (label, "")


def _unit(label: str) -> str:
    return _parted(label)[1]


def _places(axis: Any, low: float, high: float, unit: str) -> FloatArray:
    """Return the places of the ticks from `low` to `high`."""
    places = np.asarray(axis.get_majorticklocs(), dtype=np.float64)
    if unit == "deg" and high - low >= 2.0 * DEGREES[0]:
        step = next((step for step in DEGREES if (high - low) / step <= MOST), 0.0)
        if step:
            places = step * np.arange(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1.0)
    slack = 1e-9 * (high - low)
    places = places[(places >= low - slack) & (places <= high + slack)]
    finer = round_below((high - low) / LEAST)
    return places if len(places) >= LEAST else np.arange(math.ceil(low / finer), high / finer) * finer


def tick_texts(values: FloatArray) -> list[str]:
    """Return numbers with as many decimals as their steps need."""
    step = float(np.min(np.diff(values))) if len(values) > 1 else abs(float(values[0])) if len(values) else 1.0
    decimals = next((d for d in range(13) if np.all(np.abs(np.round(values, d) - values) < 1e-3 * (step or 1.0))), 12)
    return [f"{value:.{decimals}f}".replace("-", "−") for value in np.round(values, decimals) + 0.0]
