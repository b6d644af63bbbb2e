"""Random positions of all configurations, and tests whether a point can be reached, by solution from many starts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gimcli.continuation.gauss_newton import GaussNewtonConstants, settle
from gimcli.mechanism import BoolArray, FloatArray, IntArray
from gimcli.reach.critical_curves import Critical
from gimcli.reach.task import WorkspaceTask
from gimcli.structure.system import Equations


@dataclass(frozen=True)
class SamplingConstants:
    """Numbers of starts."""

    starts: int = 1500  # of the bank, per round
    spread: float = 1.0  # half side of the square of random nodes, in sizes
    first: int = 3  # starts of the first test, sufficient for most reachable points
    near: int = 12  # starts of the second test, from positions of the bank nearest to the tested point
    far: int = 36  # more of them in the last test
    mixed: int = 12  # random positions of the bank in the last test
    seeds: int = 240  # positions from which curves are searched
    batch: int = 80  # seeds per batch: the search ends after a batch without a new curve
    enough: int = 400  # positions of the bank
    rounds: int = 12  # most rounds of starts for the bank
    seed: int = 0

    def more(self, times: int) -> SamplingConstants:
        """Return the constants with `times` as many starts."""
        return replace(self, starts=self.starts * times, seeds=self.seeds * times)


BRIEF = GaussNewtonConstants(iterations=30)
"""Constants for tasks with one degree of freedom: many starts do not converge, others give the same curves."""


class Bank:
    """Positions (rows, n) of various configurations within the ranges of the inputs, from random starts."""

    def __init__(self, task: WorkspaceTask, constants: SamplingConstants | None = None) -> None:
        self.task, self.constants = task, constants or SamplingConstants()
        self.rng = np.random.default_rng(self.constants.seed)
        self.x = np.zeros((0, task.n))
        for _ in range(self.constants.rounds):
            random = _random(task, self.rng, self.constants)
            narrow = self.rng.uniform(0.0, 1.0, (len(random), len(task.limited)))
            narrow[1::2] = 1.0  # narrower ranges, so that not all positions are at their ends
            self.x = np.concatenate([self.x, self._settled(random, narrow)])
            if len(self.x) >= self.constants.enough:
                break
        self.y = task.place(self.x)

    def seeds(self, curve: Critical) -> Iterator[FloatArray]:
        """Yield points p (rows, ·) of a curve within the ranges of the inputs, solved from positions of the bank."""
        starts = curve.starts(self.x[: self.constants.seeds])
        for first in range(0, len(starts), self.constants.batch):
            yield self._on(curve, starts[first : first + self.constants.batch])

    def _on(self, curve: Critical, starts: FloatArray) -> FloatArray:
        """Return the points of a curve within the ranges of the inputs, solved from starts p (rows, ·)."""
        task, n = self.task, self.task.n

        def equations(p: FloatArray, which: IntArray) -> tuple[FloatArray, FloatArray]:
            over, slopes = _beyond(task, p[:, :n])
            wide = np.zeros((*slopes.shape[:2], p.shape[1]))
            wide[..., :n] = slopes
            value, slope = curve.linearised(p)
            return np.concatenate([value, over], axis=1), np.concatenate([slope, wide], axis=1)

        p, good = settle(equations, starts, BRIEF)
        return np.asarray(p[good & task.allowed(p[:, :n])])

    def reaches(self, places: FloatArray, hints: FloatArray | None = None) -> BoolArray:
        """Return for points (rows, 2) whether they can be reached; `hints` (rows, hints, n) are more starts."""
        found = np.zeros(len(places), dtype=bool)
        if not len(self.x):
            return found
        near, far = self.constants.near, self.constants.near + self.constants.far
        order = np.argsort(np.linalg.norm(places[:, None, :] - self.y, axis=2), axis=1)
        found |= self._any(places, self.x[order[:, : self.constants.first]])
        rest = np.flatnonzero(~found)
        first = self.x[order[rest, :near]]
        if hints is not None:
            first = np.concatenate([hints[rest], first], axis=1)
        found[rest] = self._any(places[rest], first)
        rest = np.flatnonzero(~found)
        mixed = self.rng.integers(len(self.x), size=(len(rest), self.constants.mixed))
        starts = np.concatenate([order[rest][:, near:far], mixed], axis=1)
        found[rest] = self._any(places[rest], self.x[starts])
        return found

    def _any(self, places: FloatArray, starts: FloatArray) -> BoolArray:
        """Return for points (rows, 2) whether a position is found from any of its starts (rows, starts, n)."""
        rows, count, n = starts.shape
        x, good = settle(self._equations(np.repeat(places, count, axis=0)), starts.reshape(-1, n))
        good &= self.task.allowed(x)
        return np.asarray(good.reshape(rows, count).any(axis=1))

    def _settled(self, x: FloatArray, narrow: FloatArray) -> FloatArray:
        x, good = settle(self._equations(None, narrow), x)
        return np.asarray(x[good & self.task.allowed(x)])

    def _equations(self, targets: FloatArray | None, narrow: FloatArray | None = None) -> Equations:
        """Return the function of constraints, excess of the inputs over their ranges, and difference from a point.

        `narrow` (rows, limited) are factors of the ranges.
        """
        task, table = self.task, self.task.output[0]

        def equations(x: FloatArray, which: IntArray) -> tuple[FloatArray, FloatArray]:
            over, slopes = _beyond(task, x, 1.0 if narrow is None else narrow[which])
            values, rows = [task.free.value(x), over], [task.free.slope(x), slopes]
            if targets is not None:
                values.append(task.place(x) - targets[which])
                rows.append(np.broadcast_to(table, (len(x), *table.shape)))
            return np.concatenate(values, axis=1), np.concatenate(rows, axis=1)

        return equations


def _beyond(task: WorkspaceTask, x: FloatArray, narrow: FloatArray | float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return the excess of the inputs over their narrowed ranges, 0 inside, and its derivatives."""
    over, slopes = task.excess(x)
    over = over + (1.0 - narrow) * np.array([r.half for r in task.limited])
    out = (over > 0.0).astype(float)
    return over * out, slopes * out[..., None]


def _random(task: WorkspaceTask, rng: np.random.Generator, constants: SamplingConstants) -> FloatArray:
    """Return random positions of all nodes near the frame and near the initial position, as x (rows, n)."""
    mechanism, n = task.mechanism, task.system.n
    centre = mechanism.centre
    spread = constants.spread * mechanism.size
    middle = np.resize([centre.real, centre.imag], n)
    wide = middle + rng.uniform(-spread, spread, (constants.starts, n))
    drawn = task.system.coordinates(mechanism.drawn)
    wide[::2] = drawn + rng.normal(size=wide[::2].shape) * rng.uniform(0.0, spread, (len(wide[::2]), 1))
    return task.coordinates(wide)
