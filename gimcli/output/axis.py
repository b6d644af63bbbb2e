"""An axis of a graph: the part of the values that it shows, and ticks in fitting units.

A pole does not determine the axis, a finite peak does. A pole is a place where a curve goes to infinity: a limit or
change point, or a gap, towards which the values grow as a negative power of the distance in rows; or a place between
two rows where the reciprocal of the curve, or of its magnitude, passes through zero on a straight line. The values that
rise towards a pole are set aside; where the others are much closer together than all values, the window ends a little
beyond them.

Numbers on an axis have few digits, and no power of ten stands apart from the unit. Where the values are large or small,
the axis has another unit of the same kind (N and kN, mm and m), or a power of ten before the unit.
"""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from gimcli.mechanism import BoolArray, FloatArray
from gimcli.output.picture import Picture
from gimcli.output.style import FONT, LETTER
from gimcli.rounding import round_below

BESIDE = 0.1
"""Largest part of the rows of a curve that is set aside on each side of a pole."""

SPIKE, BEYOND = 4.0, 0.4
"""The window is cut where all values spread over more than SPIKE times the others; it ends BEYOND of these further."""

LEAST_POWER, KEPT = 0.3, 0.8
"""Towards a pole values grow at least as distance^-LEAST_POWER, with a power that does not fall below KEPT of that of
the rows before: at a limit of an input rates grow as distance^(-1/2)."""

POWERS = (1.0, 3.0)
"""Orders of poles with a change of sign."""

SIGNED, UNSIGNED = 2.0, 1.2
"""Largest ratio of the differences of the reciprocal on both sides of a pole to their median: with a change of sign,
and without, where a finite peak is similar."""

ROUNDING = 1e-9
"""A spread of the others below this, relative to their largest, is rounding: all values are shown."""

LEAST = 8
"""With fewer finite values all are shown."""


def value_window(curves: Iterable[FloatArray], events: Sequence[FloatArray] = ()) -> tuple[float, float]:
    """Return the least and the greatest value that are shown; (0, 1) if there is none.

    `events` are rows, with fractions between them, of limits and change points (for each curve, or none).
    """
    every = list(curves)
    rows = events or [np.zeros(0)] * len(every)
    spans = [span for span in map(_span, every, rows) if span is not None]
    if not spans:
        return 0.0, 1.0
    whole = min(s[0] for s in spans), max(s[1] for s in spans)
    inner = min(s[2] for s in spans), max(s[3] for s in spans)
    spread = inner[1] - inner[0]
    if spread <= ROUNDING * max(map(abs, inner)) or whole[1] - whole[0] <= SPIKE * spread:
        return whole
    return max(whole[0], inner[0] - BEYOND * spread), min(whole[1], inner[1] + BEYOND * spread)


def _span(values: FloatArray, events: FloatArray) -> tuple[float, float, float, float] | None:
    """Return the range of a curve, and the range without the values that rise to poles; None without finite values."""
    y = values[np.isfinite(values)]
    if not len(y):
        return None
    low, high = float(y.min()), float(y.max())
    calm = y if len(y) < LEAST else values[np.isfinite(values) & ~_rises(values, events, int(BESIDE * len(y)))]
    return (low, high, low, high) if len(calm) < LEAST else (low, high, float(calm.min()), float(calm.max()))


def _rises(values: FloatArray, events: FloatArray, most: int) -> BoolArray:
    """Return for every row whether the curve rises there to a pole at most `most` rows away."""
    found, size = np.zeros(len(values), dtype=bool), np.abs(values)
    crossed = _crossed(values)
    for pole in np.unique([*crossed, *events, *_gaps(values)]):
        for side in (-1, 1):
            rows = np.arange(len(values))
            rows = rows[rows <= pole][::-1] if side < 0 else rows[rows >= pole]
            rows = rows[np.isfinite(values[rows])][: most + 1]
            if len(rows) > 3 and (pole in crossed or _diverges(size[rows], np.abs(rows - pole))):
                falls = (np.diff(size[rows]) < 0.0) & (np.diff(rows) == side)
                found[rows[: int(np.argmin(np.append(falls, False))) + 1][:most]] = True
    return found


def _diverges(size: FloatArray, away: FloatArray) -> bool:
    """Return whether magnitudes, the nearest first, grow towards a place as a power of the distances in rows."""
    start = int(away[0] < ROUNDING)  # a row on the event
    y, distance = size[start : start + 3], away[start : start + 3]
    if len(y) < 3 or not y[0] > y[1] > y[2] > 0.0:
        return False
    near, far = -np.diff(np.log(y)) / np.diff(np.log(distance))
    return bool(near >= LEAST_POWER and near >= KEPT * far)


def _gaps(values: FloatArray) -> FloatArray:
    """Return the middle of every gap between values, and the row beside the first and the last value."""
    known = np.flatnonzero(np.isfinite(values))
    before, after = known[:-1], known[1:]
    ends = [known[0] - 1] * bool(known[0]) + [known[-1] + 1] * bool(known[-1] + 1 < len(values))
    return np.asarray(np.append(0.5 * (before + after)[after - before > 1], ends), dtype=np.float64)


def _crossed(values: FloatArray) -> FloatArray:
    """Return the places between two rows where the reciprocal passes through zero on a straight line (poles,)."""
    near = np.lib.stride_tricks.sliding_window_view(values, min(6, len(values)))
    if near.shape[1] < 6:
        return np.zeros(0)
    change = np.array([1, 1, 1, -1, -1, -1])
    with np.errstate(all="ignore"):
        found = np.zeros(len(near), dtype=bool)
        for power in POWERS:
            found |= _straight(np.sign(near) * np.abs(near) ** (-1.0 / power), SIGNED)
        found |= _straight(change / np.abs(near), UNSIGNED)
    return np.asarray(np.flatnonzero(found) + 2.5, dtype=np.float64)


def _straight(rows: FloatArray, most: float) -> BoolArray:
    """Return whether values (places, 6) change sign in the middle only, with differences within a ratio `most`."""
    steps = np.diff(rows) * np.sign(rows[:, 5:] - rows[:, :1])
    middle = np.median(steps, axis=1, keepdims=True)
    alike = np.all((steps * most >= middle) & (steps <= most * middle) & (middle > 0.0), axis=1)
    return np.asarray(alike & (rows[:, 2] * rows[:, 3] < 0.0))


SMALL, LARGE = 1e-2, 1e4
"""Greatest values on an axis from SMALL to below LARGE keep the unit."""

METRES = {"µm": -6, "mm": -3, "m": 0, "km": 3}
PREFIXES = {"µ": -6, "m": -3, "": 0, "k": 3, "M": 6, "G": 9}
"""Decimal exponents of units of length, and of prefixes of other units."""

DEGREES = (5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0, 720.0, 1800.0, 3600.0)
"""Steps of the ticks of angles [deg]."""

FEWEST, MOST = 3, 9
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
    names, own, rest = (METRES, METRES[length[1]], unit[length.end() :]) if length else (PREFIXES, 0, unit)
    known = length or re.fullmatch(r"N m|N|W|J", unit)
    found = (name + rest for name, exponent in names.items() if known and exponent == own + shift)
    return next(found, "") or f"{power_of_ten(shift)} {unit}".strip()


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
    finer = round_below((high - low) / FEWEST)
    return places if len(places) >= FEWEST else np.arange(math.ceil(low / finer), high / finer) * finer


def tick_texts(values: FloatArray) -> list[str]:
    """Return numbers with as many decimals as their steps need."""
    step = float(np.min(np.diff(values))) if len(values) > 1 else abs(float(values[0])) if len(values) else 1.0
    decimals = next((d for d in range(13) if np.all(np.abs(np.round(values, d) - values) < 1e-3 * (step or 1.0))), 12)
    return [f"{value:.{decimals}f}".replace("-", "−") for value in np.round(values, decimals) + 0.0]
