"""Slider-cranks and their inversions: which links make full turns, in closed form.

Slider-crank: a crank of length a on the frame, a rod of length b, and a slider whose pin is at the height e over the
line of sliding through the crank's pivot. The height of the crank pin is between -a and a, and the rod reaches the line
e from it if the difference is at most b: the crank makes full turns if a + |e| <= b. The rod does if b + |e| <= a.

Inverted slider-crank: the frame is a link with two pins, of length d; the crank of length a carries a block that slides
along a link hinged to the frame, at the distance e from its pivot. The crank pin must stay outside the circle of radius
|e| about that pivot: the crank makes full turns if |d - a| >= |e|. The sliding link does if a >= d + |e|.

Source: elementary geometry; Norton, Design of Machinery, sections 2.13 (inversions) and 3.12 (quick return).
"""

from __future__ import annotations

from dataclasses import dataclass

EQUAL = 1e-9
"""Lengths that differ by less than this part of their sum are equal."""


@dataclass(frozen=True)
class SliderCrank:
    """A slider-crank whose frame carries the slider."""

    crank: float
    rod: float
    offset: float

    @property
    def inline(self) -> bool:
        """Whether the slider's pin moves on a line through the crank's pivot."""
        return abs(self.offset) <= EQUAL * (self.crank + self.rod)

    @property
    def name(self) -> str:
        """The name with or without an offset."""
        return "slider-crank, inline" if self.inline else "slider-crank, offset"

    @property
    def excess(self) -> float:
        """Return b - a - |e|: positive if the crank makes full turns, 0 at a change point."""
        return _excess(self.rod, self.crank + abs(self.offset))

    @property
    def kind(self) -> str:
        """Which links make full turns."""
        if self.excess == 0.0:
            return "the crank makes full turns, with a change point"
        if self.excess > 0.0:
            return "the crank makes full turns"
        if _excess(self.crank, self.rod + abs(self.offset)) >= 0.0:
            return "the rod makes full turns, the crank swings"
        return "the crank and the rod swing"


@dataclass(frozen=True)
class InvertedSliderCrank:
    """A slider-crank whose frame is a link with two pins."""

    frame: float
    crank: float
    offset: float

    @property
    def crank_excess(self) -> float:
        """Return |d - a| - |e|: not negative if the crank makes full turns."""
        return _excess(abs(self.frame - self.crank), abs(self.offset))

    @property
    def guide_excess(self) -> float:
        """Return a - d - |e|: not negative if the sliding link makes full turns."""
        return _excess(self.crank, self.frame + abs(self.offset))

    @property
    def kind(self) -> str:
        """Which links make full turns."""
        if self.guide_excess >= 0.0:
            return "the crank and the sliding link make full turns (Whitworth)"
        if self.crank_excess >= 0.0:
            return "the crank makes full turns, the sliding link swings"
        return "the crank and the sliding link swing"


def _excess(large: float, small: float) -> float:
    return large - small if abs(large - small) > EQUAL * (large + small) else 0.0
