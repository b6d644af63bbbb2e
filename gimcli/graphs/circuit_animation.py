"""The animations of circuits: rows at equal distances along each, with its limits, dead points and change points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from gimcli.branching.resampling import along, as_motion
from gimcli.branching.singularities import Singularity
from gimcli.continuation.circuit import Circuit, nearby
from gimcli.graphs.extras import Extras
from gimcli.graphs.motion_animation import event_text, first_graphs, motion_clip, thinning
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.output.animation import Animation, Clip
from gimcli.positions.options import TOLERANCE
from gimcli.quantities.motion_table import motion_table
from gimcli.table import Column, Table

ROUND = 6.0
"""Time in which a circuit, which has no time of its own, is shown [s]."""

ROWS = 361
"""Number of rows of a circuit, without those of its events."""

PART = "part of the length"

NO_TIME = "a circuit has no time, so no velocities: trace the motion along the law"


@dataclass(frozen=True)
class SingularPlace:
    """A singular position on a circuit that is shown."""

    part: float  # of the length of the circuit, 0..1
    kind: str
    text: str
    p: FloatArray | None = field(default=None, repr=False)  # (n + 1,) position and parameter, for a row of its own


@dataclass(frozen=True)
class ShownCircuit:
    """A circuit with its name, a note and its singular positions."""

    name: str
    circuit: Circuit = field(repr=False)
    note: str
    places: tuple[SingularPlace, ...]


def circuits_animation(
    mechanism: Mechanism, title: str, circuits: Sequence[ShownCircuit], choice: str
) -> Animation | None:
    """Return the animation of circuits, one clip each, with a row at each singular position; None without circuits."""
    clips = []
    for one in circuits:
        marks = one.circuit.lengths
        first, last = (float(marks[k] / marks[-1]) for k in nearby(one.circuit))  # not far outside, towards infinity
        moved = [replace(place, part=(place.part - first) / (last - first)) for place in one.places]
        places = [place for place in moved if 0.0 <= place.part <= 1.0]
        motion = _motion(one.circuit, places)
        clips.append(_clip(one.name, motion, motion_table(motion), places, one.circuit.closed, one.note))
    if not clips:
        return None
    over = mechanism.actuators[mechanism.drivers[0]].name if len(mechanism.drivers) == 1 else PART
    return Animation(title, mechanism, tuple(clips), first_graphs(clips[0].table, None, over), choice=choice)


def circuit_trace_animation(
    motions: Sequence[Motion], circuits: Sequence[Mapping[str, Any]], extras: Sequence[Extras]
) -> Animation:
    """Return the animation of a trace of circuits, one clip each.

    Args:
        motions: the rows of each circuit; their time is the part of its length.
        circuits: the report of each: number of its branch, whether it is closed, events.
        extras: the measures and graphs of each.
    """
    mechanism, clips = motions[0].mechanism, []
    for motion, circuit, own in zip(motions, circuits, extras, strict=True):
        table = own.with_expressions(own.apart(motion))
        places = [
            SingularPlace(one["way"], one["kind"], event_text(mechanism, one["kind"], one["at"]))
            for one in circuit["events"]
        ]
        name = f"branch {circuit['branch']}" if len(motions) > 1 else "circuit"
        clips.append(_clip(name, motion, table, places, circuit["closed"]))
    notes = thinning(max(len(clip.time) for clip in clips), max(len(motion.time) for motion in motions))
    first = first_graphs(clips[0].table, extras[0], PART)
    return Animation(f"{mechanism.name}: circuit", mechanism, tuple(clips), first, notes, "Circuit")


def part_of(circuit: Circuit, number: int, what: Singularity) -> float:
    """Return the part of the length of circuit `number` at which a singular position is."""
    if what.circuit == number:
        return what.fraction
    marks = circuit.lengths
    apart = [float(np.linalg.norm(circuit.curve.apart(place.p, what.p))) for place in circuit.places]
    return float(marks[int(np.argmin(apart))] / marks[-1])


def _motion(circuit: Circuit, places: Sequence[SingularPlace]) -> Motion:
    """Return rows at equal distances along a circuit, with further rows at singular positions."""
    time, p = np.linspace(0.0, 1.0, ROWS), along(circuit, ROWS)
    for place in places:
        if place.p is not None and place.part not in time:
            k = int(np.searchsorted(time, place.part))
            own = _wound(circuit, place.p, float(p[-1, k]))
            time, p = np.insert(time, k, place.part), np.insert(p, k, own, axis=1)
    return as_motion(circuit, time, p, TOLERANCE)


def _wound(circuit: Circuit, p: FloatArray, near: float) -> FloatArray:
    """Return a position whose parameter is moved by whole turns to the turn of another parameter."""
    turn = circuit.curve.period
    if not (circuit.curve.single and circuit.curve.periodic):
        return p
    return np.append(p[:-1], near + (p[-1] - near + 0.5 * turn) % turn - 0.5 * turn)


def _clip(
    name: str, motion: Motion, table: Table, places: Sequence[SingularPlace], closed: bool, note: str = ""
) -> Clip:  # fmt: skip
    """Return the clip of a circuit; the time of the motion is the part of its length."""
    columns = (Column(PART, motion.time), *(c for c in table.columns if c.name not in ("time", "sweeps")))
    events = [(place.part, place.kind, place.text) for place in places]
    return motion_clip(name, motion, Table(columns), ROUND, PART, events, closed, NO_TIME, note)
