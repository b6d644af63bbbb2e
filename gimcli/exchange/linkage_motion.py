"""The motion of the inputs of Linkage: motors that turn, and motors and actuators that move out and back.

A law of a model file runs once, over one duration for all inputs. Source: Simulator.cpp of the program.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from gimcli.exchange.linkage_parts import LinkPart, PinPart

MOST_TURNS = 10.0
"""Most turns of the slowest motor until all motors are back at their start; beyond it, the slowest one turns once."""
STEP = 1000
"""Largest denominator of a rate in revolutions a minute, of which a common period is sought."""


@dataclass(frozen=True)
class LinkageDrive:
    """An input: `speed` (deg or lengths per second, with its sign), and its range if it moves out and back.

    `stroke` is the length of the range and `passed` the part of it, at the drawn position, that is passed; `back` is
    true if the input first moves back.
    """

    speed: float
    manual: bool
    stroke: float | None = None
    passed: float = 0.0
    back: bool = False

    @staticmethod
    def of_connector(connector: PinPart) -> LinkageDrive:
        """Return the drive of a motor: clockwise if its rate is positive."""
        speed = -6.0 * connector.rpm
        if connector.limit_angle <= 0.0:
            return LinkageDrive(speed, connector.manual)
        return LinkageDrive.between(speed, connector.manual, connector.limit_angle, connector.start_offset)

    @staticmethod
    def of_actuator(link: LinkPart, scale: float) -> LinkageDrive:
        """Return the drive of an actuator: it shortens first if its rate is negative."""
        a, b = (c.place for c in link.connectors)
        stroke = abs(b - a) / 2.0 if link.throw is None else link.throw
        stroke, offset = abs(stroke) * scale, link.start_offset * scale
        return LinkageDrive.between(stroke * link.cpm / 30.0, link.manual, stroke, offset)

    @staticmethod
    def between(speed: float, manual: bool, stroke: float, offset: float) -> LinkageDrive:
        """Return a drive that moves out and back, at an offset of its cycle."""
        phase = offset % (2.0 * stroke) if stroke else 0.0
        back = phase >= stroke > 0.0
        return LinkageDrive(speed, manual, stroke, 2.0 * stroke - phase if back else phase, back)

    def until_reversal(self) -> float:
        """Return the time until it reverses [s]."""
        if self.stroke is None or not self.speed or not self.stroke:
            return math.inf
        return (self.passed if self.back else self.stroke - self.passed) / abs(self.speed)

    def law(self, duration: float) -> dict[str, Any]:
        """Return the law from the drawn position over a duration without reversal."""
        return {"by": _tidy(self.speed * duration * (-1.0 if self.back else 1.0))}

    def whole(self) -> dict[str, Any]:
        """Return the law over the whole range, which starts in the direction that the input first has."""
        sign = math.copysign(1.0, self.speed)
        low, high = _tidy(-sign * self.passed), _tidy(sign * ((self.stroke or 0.0) - self.passed))
        first, last = (high, low) if self.back else (low, high)
        return {"by": last} if not first else {"over": (first, last)}


@dataclass
class LinkageInputs:
    """The inputs of one file and the law of each."""

    drives: dict[str, LinkageDrive] = field(default_factory=dict)
    laws: dict[str, dict[str, Any]] = field(default_factory=dict)
    left_out: list[str] = field(default_factory=list)

    def add(self, name: str, drive: LinkageDrive) -> None:
        """Add an input; its law is completed later."""
        self.drives[name], self.laws[name] = drive, {}

    def complete(self) -> float | None:
        """Complete the laws; return the duration of the motion [s]."""
        moving = {name: drive for name, drive in self.drives.items() if not drive.manual} or self.drives
        for name in (name for name in self.drives if name not in moving):
            self.laws[name]["by"] = 0.0
            self.left_out.append(f"{name} is moved by hand in Linkage: here it is constant")
        ranged = {name: drive for name, drive in moving.items() if drive.until_reversal() < math.inf}
        if len(ranged) == len(moving) == 1:
            [(name, drive)] = ranged.items()
            self.laws[name].update(drive.whole())
            self.left_out.append(f"{name} moves out and back in Linkage: the law is one stroke")
            return _tidy((drive.stroke or 0.0) / abs(drive.speed))
        duration = self._until_reversal(ranged) if ranged else _common_period(list(moving.values()))
        for name, drive in moving.items():
            self.laws[name].update(drive.law(duration or 0.0))
        return duration

    def _until_reversal(self, ranged: dict[str, LinkageDrive]) -> float:
        first = min(ranged, key=lambda name: ranged[name].until_reversal())
        self.left_out.append(
            f"{', '.join(ranged)} {'moves' if len(ranged) == 1 else 'move'} out and back in Linkage: "
            f"the motion ends where {first} first reverses"
        )
        return _tidy(ranged[first].until_reversal())


def _tidy(value: float) -> float:
    """Return a number without the last digits, which are errors of products and quotients."""
    return float(f"{value:.13g}")


def _common_period(drives: list[LinkageDrive]) -> float | None:
    """Return the time until all motors are back at their start, or that of the slowest one; None if none turns."""
    rates = [Fraction(abs(d.speed) / 6.0).limit_denominator(STEP) for d in drives if d.speed]
    if not rates or not all(rates):
        return 360.0 / min((abs(d.speed) for d in drives if d.speed), default=math.inf) or None
    common = Fraction(
        math.gcd(*(r.numerator for r in rates)),
        math.lcm(*(r.denominator for r in rates)),
    )  # fmt: skip
    slowest = min(rates)
    return float(60 / (common if slowest <= MOST_TURNS * common else slowest))
