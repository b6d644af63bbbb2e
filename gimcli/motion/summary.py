"""Results of a motion: columns, paths, ranges of the inputs, events; counts of a motion that is solved in pieces."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gimcli.mechanism import ComplexArray, FloatArray, IntArray
from gimcli.motion.motion import Motion
from gimcli.positions.inputs import law_inputs
from gimcli.status import Status
from gimcli.structure.carried import carried_point
from gimcli.table import Column


def first_columns(motion: Motion, first: int) -> list[Column]:
    """Return the first columns of every motion: steps numbered from `first`, time, inputs."""
    mechanism, steps = motion.mechanism, np.arange(first, first + len(motion.time))
    inputs = [
        Column(a.name, mechanism.value_to_file(k, motion.inputs[k]), mechanism.unit_of(a))
        for k, a in enumerate(mechanism.actuators)
    ]
    return [Column("step", steps), Column("time", motion.time * mechanism.duration, "s"), *inputs]


def status_column(codes: IntArray, name: str = "status") -> Column:
    """Return the status words of rows (rows,)."""
    return Column(name, np.array([s.word for s in Status])[codes])


def traced_paths(motion: Motion, names: tuple[str, ...] | None = None) -> dict[str, ComplexArray]:
    """Return the paths of the traced points in the file's coordinates; NaN in rows that are not solved."""
    mechanism, chosen = motion.mechanism, names or motion.mechanism.traced
    return {name: np.asarray(mechanism.to_file(carried_point(mechanism, name, motion.z))) for name in chosen}


def reachable(motion: Motion) -> dict[str, list[list[float]]]:
    """Return for every actuator the range of its law that the motion reached, in the file's unit."""
    if motion.parts:
        found = {name: ranges for part in motion.parts for name, ranges in reachable(part).items()}
        return {a.name: found[a.name] for a in motion.mechanism.actuators}
    mechanism = motion.mechanism
    if motion.first_status is not Status.OK:
        return {a.name: [] for a in mechanism.actuators}
    if motion.turned_back:
        there = np.array([inputs for _, inputs in motion.turned_back]).T
        passed = np.concatenate([motion.inputs[:, motion.good], there], axis=1)
        ends = np.array([passed.min(axis=1), passed.max(axis=1)])
    else:
        end = float(motion.time[motion.good][-1]) if motion.limit is None else motion.limit
        laws = (
            law_inputs(mechanism)(np.array([motion.time[0], end])),
            law_inputs(mechanism)(motion.time[motion.time <= end]),
        )
        ends = np.reshape([_span(*pair) for pair in zip(*laws, strict=True)], (-1, 2)).T
    first, last = map(mechanism.inputs_to_file, ends)
    return {name: [[first[name], last[name]]] for name in first}


def _span(ends: FloatArray, rows: FloatArray) -> FloatArray:
    """Return the ends of a law, or its least and greatest value if it reverses beyond them."""
    least, greatest = np.min(rows, initial=ends.min()), np.max(rows, initial=ends.max())
    return ends if (least, greatest) == (ends.min(), ends.max()) else np.array([least, greatest])


def occurrences(motion: Motion) -> list[tuple[str, float, FloatArray]]:
    """Return kind, normalised time and inputs (actuators,) of meetings of branches, exchanged sequences and limits."""
    times = [("sequence exchanged", t) for t in motion.exchanged]
    if motion.limit is not None and not motion.turned_back and motion.first_status is Status.OK:
        times.append(("limit", motion.limit))
    return [
        *((met.kind, time, met.inputs) for time, met in zip(motion.bridged, motion.meetings, strict=False)),
        *((kind, time, law_inputs(motion.mechanism)(np.array([time]))[:, 0]) for kind, time in times),
        *(("limit", time, np.array(at)) for time, at in sorted((*motion.turned_back, *motion.touched))),
    ]


def events(motion: Motion) -> list[dict[str, Any]]:
    """Return the events of a motion (singular positions, changed sequences, limits), with the inputs there."""
    return [{"kind": kind, "at": motion.mechanism.inputs_to_file(at)} for kind, _, at in occurrences(motion)]


DRAWN = 4096
"""Approximate number of rows kept, greater than the resolution of a picture."""


class Summary:
    """Counts of a motion of `rows` rows, and a motion with some of these rows."""

    def __init__(self, rows: int) -> None:
        self.rows = rows
        self.seen = 0
        self.solved = 0
        self.each: list[int] = []  # solved rows of each independent machine
        self.residual = math.nan  # greatest residual of the solved rows
        self._every = -(-rows // DRAWN)
        self._pieces: list[Motion] = []
        self._bad = False

    def add(self, piece: Motion) -> IntArray:
        """Add the next piece; return which of its rows are kept."""
        keep = (self.seen + np.arange(len(piece.time))) % self._every == 0
        keep[-1] = True
        bad, good = np.flatnonzero(~piece.good), np.flatnonzero(piece.good)
        if len(bad) and not self._bad:  # the first failed row, and the one before it
            keep[bad[0]] = keep[max(0, bad[0] - 1)] = self._bad = True
        if len(good):
            keep[good[-1]] = True
            self.residual = float(np.fmax(self.residual, np.max(piece.residual[good])))
        self.solved += len(good)
        own = [part.solved for part in piece.machines]
        self.each = [done + more for done, more in zip(self.each or [0] * len(own), own, strict=True)]
        self.seen += len(piece.time)
        self._pieces.append(piece if keep.all() else piece.rows(np.flatnonzero(keep)))
        return np.flatnonzero(keep)

    @property
    def motion(self) -> Motion:
        """The kept rows as one motion, with all events."""
        return Motion.joined(self._pieces)
