"""A mechanism in motion, independent of file formats: its scene, and one or more motions with their columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray, Mechanism
from gimcli.output.scene import Scene
from gimcli.rounding import Section
from gimcli.table import Table

if TYPE_CHECKING:
    from gimcli.output.printed import PictureOptions

MOST_ROWS = 2000
"""Largest number of rows of a clip that is made from a long motion."""


@dataclass(frozen=True)
class Moment:
    """An event of a motion, shown as a mark on the time bar."""

    row: float  # may be between two rows
    kind: str  # "limit", "dead point", "change point", "standstill", ...
    text: str  # what the user reads, with the inputs there


@dataclass(frozen=True)
class Clip:
    """One motion, circuit or configuration."""

    name: str
    positions: ComplexArray = field(repr=False)  # (rows, nodes) coordinates of the file, NaN in unsolved rows
    time: FloatArray = field(repr=False)  # (rows,) s, for playback
    status: tuple[str, ...] = field(repr=False)  # (rows,) status words
    table: Table = field(repr=False)  # the columns for graphs, one row each
    axis: str = "time"  # name of the column that is the abscissa of the graphs
    events: tuple[Moment, ...] = ()
    closed: bool = False  # the last position is the first one: playback goes round
    forward: bool = False  # shown only forward in time, such as a simulation; other open motions are shown to and fro
    breaks: tuple[int, ...] = ()  # rows that do not continue the row before, such as the start of another branch
    rates: ComplexArray | None = field(default=None, repr=False)  # (2, rows, nodes) velocity, acceleration
    without: str = ""  # why there are no rates
    note: str = ""  # one line about the clip
    mechanism: Mechanism | None = field(default=None, repr=False)  # of a design; None: that of the animation

    @cached_property
    def good(self) -> BoolArray:
        """(rows,) whether the rows are solved."""
        return np.array([word == "ok" for word in self.status], dtype=bool)

    @cached_property
    def scene(self) -> Scene | None:
        """What is drawn of a design of its own; None if that is the same in all clips."""
        if self.mechanism is None:
            return None
        poses = self.positions[self.good]
        return Scene(self.mechanism, poses if len(poses) else self.mechanism.to_file(self.mechanism.drawn)[None])


@dataclass(frozen=True)
class Graph:
    """A graph that is shown first: columns over a column (by default over the clip's axis)."""

    columns: tuple[str, ...]
    over: str = ""


@dataclass(frozen=True)
class DimensionSlider:
    """A dimension of a family of designs, and its values in increasing order [file's unit]."""

    name: str
    unit: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Animation:
    """A scene and its clips. The clips share the mechanism, or are its designs; their columns may differ."""

    title: str
    mechanism: Mechanism = field(repr=False)
    clips: tuple[Clip, ...]
    graphs: tuple[Graph, ...] = ()
    notes: tuple[str, ...] = ()
    choice: str = "Motion"  # the name of the list of clips
    report: tuple[Section, ...] = ()
    sliders: tuple[DimensionSlider, ...] = ()  # they choose a clip; clips are all combinations, the last slider first
    options: PictureOptions | None = None  # size, resolution, title and look of films

    @cached_property
    def scene(self) -> Scene:
        """What is drawn, with sizes that suit all solved rows; without a solved row, the initial coordinates."""
        poses = np.concatenate([clip.positions[clip.good] for clip in self.clips])
        return Scene(self.mechanism, poses if len(poses) else self.mechanism.to_file(self.mechanism.drawn))


def shown_rows(good: BoolArray, marks: Sequence[float] = (), most: int = MOST_ROWS) -> IntArray:
    """Return the numbers of at most about `most` evenly spread rows of a long motion.

    The first and the last row of each run of solved or unsolved rows are among them (of at most 100 runs), and the rows
    beside `marks`.
    """
    rows = len(good)
    every = -(-rows // most)
    keep = np.arange(rows) % every == 0
    keep[-1] = True
    changes = np.flatnonzero(good[1:] != good[:-1])[:200]
    keep[changes] = keep[changes + 1] = True
    beside = np.clip(np.array([int(mark) + k for mark in marks for k in (0, 1)], dtype=int), 0, rows - 1)
    keep[beside] = True
    return np.flatnonzero(keep)
