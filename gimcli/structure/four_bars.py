"""Types of four-bar linkages by Grashof's rule: which links make full turns.

s and l are the shortest and the longest length, p and q the two others. If s + l < p + q, the shortest link makes full
turns relative to all others; if s + l > p + q, no link does; if they are equal, all links can be in line (change
point). Sources: Grashof 1883; Barker, A complete classification of planar four-bar linkages, Mech. Mach. Theory 20
(1985) 535-554, for the codes; Norton, Design of Machinery, section 2.12 and table 2-4.
"""

from __future__ import annotations

from dataclasses import dataclass

EQUAL = 1e-9
"""Lengths, and sums of lengths, that differ by less than this part of the perimeter are equal."""

NEAR = 1e-3
"""A linkage is near a change point if s + l - p - q is less than this part of the perimeter."""

FRAME, INPUT, COUPLER, OUTPUT = range(4)

GRASHOF = {
    FRAME: ("double-crank (drag link)", "GCCC"), INPUT: ("crank-rocker", "GCRR"),
    COUPLER: ("double-rocker", "GRCR"), OUTPUT: ("crank-rocker driven at the rocker", "GRRC"),
}  # fmt: skip
CHANGE = {FRAME: "SCCC", INPUT: "SCRR", COUPLER: "SRCR", OUTPUT: "SRRC"}


@dataclass(frozen=True)
class FourBar:
    """The lengths of frame, input, coupler and output link, in this order."""

    lengths: tuple[float, float, float, float]
    crossed: bool = False  # whether the coupler crosses the frame, which distinguishes antiparallelograms

    @property
    def excess(self) -> float:
        """Return p + q - s - l: positive for Grashof linkages, 0 at a change point."""
        s, p, q, longest = sorted(self.lengths)
        return p + q - s - longest if abs(p + q - s - longest) > EQUAL * sum(self.lengths) else 0.0

    @property
    def grashof(self) -> bool:
        """Whether at least one link can make full turns: s + l <= p + q."""
        return self.excess >= 0.0

    @property
    def assembles(self) -> bool:
        """Whether the other links together are as long as the longest one."""
        return 2.0 * max(self.lengths) <= sum(self.lengths) * (1.0 + EQUAL)

    @property
    def near_change_point(self) -> bool:
        """Whether a small change of the lengths gives a linkage with change points."""
        return 0.0 < abs(self.excess) < NEAR * sum(self.lengths)

    @property
    def shortest(self) -> int:
        """The place of the shortest length."""
        return self.lengths.index(min(self.lengths))

    @property
    def longest(self) -> int:
        """The place of the longest length."""
        return self.lengths.index(max(self.lengths))

    @property
    def kind(self) -> str:
        """The type in words."""
        if not self.assembles:
            return "cannot be assembled, the longest link is longer than the others together"
        if self.excess < 0.0:
            return "triple-rocker (not Grashof)"
        if self.excess > 0.0:
            return GRASHOF[self.shortest][0]
        return self._of_change_point()

    @property
    def code(self) -> str:
        """Barker's code."""
        if self.excess < 0.0:
            return f"RRR{self.longest + 1}"
        if self.excess > 0.0:
            return GRASHOF[self.shortest][1]
        return "S3X" if self._rhombus else "S2X" if self._opposite or self._adjacent else CHANGE[self.shortest]

    def _of_change_point(self) -> str:
        if self._rhombus:
            return "rhombus (change points)"
        if self._opposite:
            return "antiparallelogram (change points)" if self.crossed else "parallelogram (change points)"
        return "kite (change points)" if self._adjacent else "linkage with change points"

    @property
    def _rhombus(self) -> bool:
        return self._same(*self.lengths)

    @property
    def _opposite(self) -> bool:
        frame, first, coupler, second = self.lengths
        return self._same(frame, coupler) and self._same(first, second)

    @property
    def _adjacent(self) -> bool:
        frame, first, coupler, second = self.lengths
        return (self._same(frame, first) and self._same(coupler, second)) or (
            self._same(first, coupler) and self._same(second, frame)
        )

    def _same(self, *lengths: float) -> bool:
        return max(lengths) - min(lengths) <= EQUAL * sum(self.lengths)
