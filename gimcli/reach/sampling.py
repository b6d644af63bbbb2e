"""Random positions over all configurations, and whether a place can be reached: equations solved from many starts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gimcli.continuation.gauss_newton import Equations, GaussNewtonConstants, settle
from gimcli.mechanism import FRAME, FloatArray, IntArray
from gimcli.reach.critical_positions import Critical
from gimcli.reach.task import WorkspaceTask


@dataclass(frozen=True)
class SamplingConstants:
    """How many starts are made."""

    starts: int = 1500  # of the bank
    spread: float = 1.0  # half side of the square of random nodes, in sizes
    first: int = 3  # starts with which most places that can be reached are
    near: int = 12  # starts from the bank's positions whose point is nearest to the place asked for
    far: int = 36  # more of them where those fail
    mixed: int = 12  # and some from anywhere
    seeds: int = 240  # positions from which curves are looked for
    batch: int = 80  # of these: where a whole batch leads to no new curve, all are taken to be known
    enough: int = 400  # positions of the bank
    rounds: int = 12  # of starts, at most, until there are so many
    seed: int = 0

    def more(self, times: int) -> SamplingConstants:
        """Return the constants with so many times the starts."""
        return replace(self, starts=self.starts * times, seeds=self.seeds * times)


BRIEF = GaussNewtonConstants(iterations=30)
"""Where many starts lead nowhere and others to the same curves."""


class Bank:
    """Positions (rows, n) within the inputs' ranges, from random starts: configurations mixed."""

    def __init__(self, task: WorkspaceTask, constants: SamplingConstants | None = None) -> None:
        self.task, self.constants = task, constants or SamplingConstants()
        self.rng = np.random.default_rng(self.constants.seed)
        self.x = np.zeros((0, task.n))
        for _ in range(self.constants.rounds):
            random = _random(task, self.rng, self.constants)
            narrow = self.rng.uniform(0.0, 1.0, (len(random), len(task.limited)))
            narrow[1::2] = 1.0  # what is left of a range, lest all positions end up at its ends
            self.x = np.concatenate([self.x, self._settled(random, narrow)])
            if len(self.x) >= self.constants.enough:
                break
        self.y = task.place(self.x)

    def seeds(self, curve: Critical) -> Iterator[FloatArray]:
        """Yield places p (rows, ·) of a curve, inputs within their ranges, that the bank's positions are moved to."""
        starts = curve.starts(self.x[: self.constants.seeds])
        for first in range(0, len(starts), self.constants.batch):
            yield self._on(curve, starts[first : first + self.constants.batch])

    def _on(self, curve: Critical, starts: FloatArray) -> FloatArray:
        """Return the places of a curve, inputs within their ranges, that starts p (rows, ·) are moved to."""
        task, n = self.task, self.task.n

        def equations(p: FloatArray, which: IntArray) -> tuple[FloatArray, FloatArray]:
            over, slopes = _beyond(task, p[:, :n])
            wide = np.zeros((*slopes.shape[:2], p.shape[1]))
            wide[..., :n] = slopes
            return np.concatenate([curve.residual(p), over], axis=1), np.concatenate([curve.jacobian(p), wide], axis=1)

        p, good = settle(equations, starts, BRIEF)
        return np.asarray(p[good & task.allowed(p[:, :n])])

    def reaches(self, places: FloatArray, hints: FloatArray | None = None) -> NDArray[np.bool_]:
        """Tell of places (rows, 2) whether the point gets there; `hints` (rows, hints, n) are more starts."""
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

    def _any(self, places: FloatArray, starts: FloatArray) -> NDArray[np.bool_]:
        """Tell of places (rows, 2) whether a position is found from any of some starts (rows, starts, n)."""
        rows, count, n = starts.shape
        targets = np.repeat(places, count, axis=0)
        x, good = settle(self._equations(targets), starts.reshape(-1, n))
        good &= self.task.allowed(x)
        return np.asarray(good.reshape(rows, count).any(axis=1))

    def _settled(self, x: FloatArray, narrow: FloatArray) -> FloatArray:
        x, good = settle(self._equations(None, narrow), x)
        return np.asarray(x[good & self.task.allowed(x)])

    def _equations(self, targets: FloatArray | None, narrow: FloatArray | None = None) -> Equations:
        """Return the constraints, what the inputs are beyond their ranges, and the point's distance from a place.

        narrow (rows, limited) are the parts of the ranges that count.
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
    """Return by how much inputs are beyond some part of their ranges, 0 within, and derivatives."""
    over, slopes = task.excess(x)
    over = over + (1.0 - narrow) * np.array([r.half for r in task.limited])
    out = (over > 0.0).astype(float)
    return over * out, slopes * out[..., None]


def _random(task: WorkspaceTask, rng: np.random.Generator, constants: SamplingConstants) -> FloatArray:
    """Return random places of all nodes about the frame and about the drawn position, as x (rows, n)."""
    mechanism, n = task.mechanism, task.system.n
    centre = complex(np.mean(mechanism.members[FRAME].shape))
    spread = constants.spread * mechanism.size
    middle = np.tile([centre.real, centre.imag], n // 2)
    wide = middle + rng.uniform(-spread, spread, (constants.starts, n))
    drawn = task.system.coordinates(mechanism.drawn)
    wide[::2] = drawn + rng.normal(size=wide[::2].shape) * rng.uniform(0.0, spread, (len(wide[::2]), 1))
    return task.coordinates(wide)
