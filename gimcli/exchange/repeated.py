"""Inputs of programs that repeat their motion without end: motors that turn, inputs that move out and back.

A law of a model file runs once, over one duration for all inputs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from gimcli.exchange.draft import Draft

MOST_TURNS = 10
"""Most turns of the slowest motor until all motors are back at their start; beyond it, the slowest one turns once."""
SAME = 1e-6
"""Relative error of a ratio of speeds, which files have in decimals."""


@dataclass(frozen=True)
class RepeatedInput:
    """An input: `speed` (deg or lengths per second, with its sign), and its range if it moves out and back.

    `stroke` is the length of the range and `passed` the part of it, at the drawn position, that is passed; `back` is
    true if the input first moves back. `manual`: it is moved by hand. `ahead` is added to the drawn value.
    """

    speed: float
    manual: bool = False
    stroke: float = math.inf
    passed: float = 0.0
    back: bool = False
    ahead: float = 0.0

    @staticmethod
    def between(speed: float, stroke: float, offset: float, *, manual: bool = False) -> RepeatedInput:
        """Return an input that moves out and back, at an offset of its cycle."""
        phase = offset % (2.0 * stroke) if stroke else 0.0
        back = phase >= stroke > 0.0
        return RepeatedInput(speed, manual, stroke, 2.0 * stroke - phase if back else phase, back)

    def until_reversal(self) -> float:
        """Return the time until it reverses [s]."""
        left = self.passed if self.back else self.stroke - self.passed
        return left / abs(self.speed) if self.speed and self.stroke else math.inf

    def law(self, duration: float) -> dict[str, Any]:
        """Return the law from the drawn position over a duration without reversal."""
        travel = self.speed * duration * (-1.0 if self.back else 1.0)
        return _law(self.ahead, self.ahead + travel)

    def whole(self) -> dict[str, Any]:
        """Return the law over the whole range, which starts in the direction that the input first has."""
        sign = math.copysign(1.0, self.speed)
        ends = (self.ahead - sign * self.passed, self.ahead + sign * (self.stroke - self.passed))
        return _law(*(ends[::-1] if self.back else ends))


@dataclass
class RepeatedMotion:
    """The inputs of one file, and the law of each, which is complete after `complete`."""

    draft: Draft
    inputs: dict[str, RepeatedInput] = field(default_factory=dict)
    laws: dict[str, dict[str, Any]] = field(default_factory=dict)

    def add(self, name: str, own: RepeatedInput) -> dict[str, Any]:
        """Add an input; return its law, which is completed later."""
        self.inputs[name], self.laws[name] = own, {}
        return self.laws[name]

    def rotary(self, name: str, alone: bool, pivot: str, body: str, own: RepeatedInput, arm: str = "") -> None:
        """Add an input that turns a body about a pivot on the ground, named after it unless it is `alone`."""
        motor = "motor" if alone else f"motor_{name}"
        self.draft.rotary(motor, pivot, body, arm=arm, law=self.add(motor, own))

    def complete(self) -> None:
        """Complete the laws, and set the duration of the motion [s]; None if nothing moves."""
        draft, program = self.draft, self.draft.program
        moving = {name: own for name, own in self.inputs.items() if not own.manual} or self.inputs
        by_hand = [name for name in self.inputs if name not in moving]
        for name in by_hand:
            self.laws[name]["by"] = 0.0
        draft.left_out += [f"{name} is moved by hand in {program}: here it is constant" for name in by_hand]
        ranged = [name for name, own in moving.items() if own.until_reversal() < math.inf]
        first = min(ranged, key=lambda name: moving[name].until_reversal(), default="")
        move = f"{', '.join(ranged)} {'moves' if len(ranged) == 1 else 'move'} out and back in {program}"
        if len(ranged) == len(moving) == 1:
            own = moving[first]
            self.laws[first].update(own.whole())
            draft.note(True, f"{move}: the law is one stroke")
            draft.duration = _tidy(own.stroke / abs(own.speed))
            return
        draft.note(ranged, f"{move}: the motion ends where {first} first reverses")
        draft.duration = _tidy(moving[first].until_reversal()) if ranged else _common_period(list(moving.values()))
        for name, own in moving.items():
            self.laws[name].update(own.law(draft.duration or 0.0))


def _law(first: float, last: float) -> dict[str, Any]:
    """Return the law between two values relative to the drawn one."""
    return {"over": (_tidy(first), _tidy(last))} if _tidy(first) else {"by": _tidy(last)}


def _tidy(value: float) -> float:
    """Return a number without the last digits, which are errors of products and quotients."""
    return float(f"{value:.13g}")


def _common_period(inputs: list[RepeatedInput]) -> float | None:
    """Return the time until all motors are back at their start, or that of the slowest one; None if none turns."""
    speeds = [abs(own.speed) for own in inputs if own.speed]
    if not speeds:
        return None
    ratios = [Fraction(min(speed / min(speeds), 1e6)).limit_denominator(MOST_TURNS) for speed in speeds]
    exact = all(abs(float(r) * min(speeds) - s) <= SAME * s for r, s in zip(ratios, speeds, strict=True))
    turns = math.lcm(*(r.denominator for r in ratios)) if exact else 1
    return _tidy(360.0 / min(speeds) * (turns if turns <= MOST_TURNS else 1))
