"""A curve that is followed point by point: the next point is predicted, corrected, and accepted or approached again.

The curve is the state: a subclass begins at a point with a first step, and determines how a step leads to the next
point. The loop and the control of its step are here. Source: Allgower & Georg, Introduction to Numerical Continuation
Methods, 2003, chapter 6.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, TypeVar

Guess = TypeVar("Guess")
Point = TypeVar("Point")


class Follower(ABC, Generic[Guess, Point]):
    """A curve with the point up to which it has been followed; a step that fails is halved until it is too short."""

    step: float  # length of the next step
    shortest: float  # least length of a step

    @abstractmethod
    def predict(self) -> Guess:
        """Return an estimate of the point after a step."""

    @abstractmethod
    def correct(self, guess: Guess) -> Point | None:
        """Return the point of the curve near an estimate; None if there is none, or the step is too long."""

    @abstractmethod
    def accept(self, there: Point) -> bool:
        """Take a point as the next one and set the step after it; return whether it is one."""

    def go(self) -> bool:
        """Move to the next point; return whether a step led to one."""
        while self.step >= self.shortest:
            there = self.correct(self.predict())
            if there is not None and self.accept(there):
                return True
            self.step *= 0.5
        return False
