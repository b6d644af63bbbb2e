"""A motion that goes on where its input cannot: along the circuit, by the way of the parameter.

The way of the parameter from the start, told without its turning back (the sum of |dq|), is what a law asks for. At a
limit the motion then turns back on the other side of it, as a rocker driven through its dead point does, and it goes
back on the way it came where the law does. Between two limits the parameter alone tells the position.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import FloatArray
from gimcli.motion.circuit import Circuit, Policy, rolled
from gimcli.motion.folds import folded
from gimcli.motion.stations import beside, between
from gimcli.solvers.arclength import correct

HALVINGS = 60
"""Of a step, until the parameter asked for is met."""


class Track:
    """A circuit with the way of its parameter."""

    def __init__(self, circuit: Circuit) -> None:
        self.circuit = _inside(folded(circuit))
        self.places, self.policy = self.circuit.places, Policy()
        q = self.circuit.p[-1]
        self.way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(q)))])
        self.way -= self.way[self.circuit.start]

    @property
    def lap(self) -> float:
        """Way of one round of a closed circuit."""
        return float(self.way[-1] - self.way[0])

    def at(self, way: float) -> FloatArray | None:
        """Return position and parameter (n + 1,) at a way; None beyond the ends of an open circuit."""
        rounds = 0.0
        if self.circuit.closed and self.lap > 0.0:
            rounds = math.floor((way - self.way[0]) / self.lap)
            way -= rounds * self.lap
        if not self.way[0] <= way <= self.way[-1]:
            return None
        k = int(np.clip(np.searchsorted(self.way, way, side="right") - 1, 0, len(self.way) - 2))
        here, there = float(self.places[k].p[-1]), float(self.places[k + 1].p[-1])
        found = self._met(k, here + (way - self.way[k]) * (1.0 if there > here else -1.0)).copy()
        found[-1] += rounds * 2.0 * math.pi * self.circuit.turns
        return found

    def on_arc(self, q: float) -> FloatArray | None:
        """Return position and parameter at a parameter on the arc between limits that the start is on."""
        low, high = self.arc
        values = self.circuit.p[-1, low : high + 1]
        if not values.min() <= q <= values.max():
            return None
        rising = values[-1] > values[0]
        k = int(np.searchsorted(values if rising else -values, q if rising else -q, side="right")) - 1
        return self._met(low + min(max(k, 0), high - low - 1), q)

    @property
    def turns_back(self) -> FloatArray:
        """Ways from the start, in the first round, at which the parameter turns back."""
        step = np.sign(np.diff(self.circuit.p[-1]))
        return np.asarray(self.way[1:-1][step[1:] * step[:-1] < 0.0])

    @property
    def arc(self) -> tuple[int, int]:
        """First and last place of the arc between limits that the start is on."""
        step = np.sign(np.diff(self.circuit.p[-1]))
        start = min(self.circuit.start, len(step) - 1)
        low = high = start
        while low > 0 and step[low - 1] == step[start]:
            low -= 1
        while high + 1 < len(step) and step[high + 1] == step[start]:
            high += 1
        return low, high + 1

    def _met(self, k: int, q: float) -> FloatArray:
        """Return the position with a parameter between place k and the next."""
        here, there = self.places[k], self.places[k + 1]
        low, high = 0.0, 1.0
        rising = there.p[-1] > here.p[-1]
        for _ in range(HALVINGS):
            part = 0.5 * (low + high)
            low, high = (part, high) if (between(here, there, part)[0][-1] < q) == rising else (low, part)
        guess = between(here, there, 0.5 * (low + high))[0]
        guess[-1] = q
        if beside(self.circuit, k, guess, self.policy):
            return guess
        pin = np.append(np.zeros(len(guess) - 1), 1.0)
        exact = correct(self.circuit.curve, guess, self.policy.steps, pin)
        return guess if exact is None else exact


def _inside(circuit: Circuit) -> Circuit:
    """Return the circuit with its start inside: an arc may run on both sides of it."""
    half = len(circuit.places) // 2
    return rolled(circuit, half, len(circuit.places) - 1 - half) if circuit.closed else circuit


@dataclass(frozen=True)
class Route:
    """A track up to a change point, and the track of the branch chosen there."""

    first: Track
    then: Track | None = None
    at: float = math.inf  # way of the first at which the other begins

    def place(self, way: float) -> FloatArray | None:
        """Return position and parameter at a way from the start."""
        if self.then is not None and way > self.at:
            return self.then.at(way - self.at)
        return self.first.at(way)

    def limit(self) -> float:
        """Return the way ahead at which the parameter first turns back; infinite where it never does."""
        ways = [w for w in self.first.turns_back.tolist() if 0.0 < w < self.at]
        if self.then is not None:
            ways += [self.at + w for w in self.then.turns_back.tolist() if w > 0.0]
        return min(ways, default=math.inf)

    def crossings(self, end: float) -> list[float]:
        """Return the ways ahead, up to an end, at which branches meet."""
        return self._met(end, lambda track: [float(track.way[k]) for k in track.circuit.crossings])

    def turns_back(self, end: float) -> list[float]:
        """Return the ways ahead, up to an end, at which the parameter turns back."""
        return self._met(end, lambda track: track.turns_back.tolist())

    def _met(self, end: float, marks: Callable[[Track], list[float]]) -> list[float]:
        """Return the ways of some marks of the tracks, in every round."""
        parts = [(self.first, 0.0, min(self.at, end))]
        if self.then is not None:
            parts.append((self.then, self.at, end))
        found = []
        for track, begin, until in parts:
            for own in marks(track) if track.lap > 0.0 else ():
                w = begin + own
                while w <= until:
                    found += [w] * (w >= begin)
                    w += track.lap if track.circuit.closed else math.inf
        return sorted({round(w, 12): w for w in found}.values())
