"""The picture of modes: the mechanism at rest, and in both extreme positions of each mode.

The animation has one oscillation of each.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from gimcli.dynamics.modes import DECAY, RIGID, VIBRATION, Mode, Swing, swing
from gimcli.dynamics.small_motions import Linearised
from gimcli.output import style
from gimcli.output.animation import Animation, Clip, Graph
from gimcli.output.gallery import panels_of
from gimcli.output.picture import LAYOUT, PictureLayout, Sheet, composition
from gimcli.output.pose import Drawing, part_names
from gimcli.output.scene import Scene
from gimcli.output.style import Mark, Pen
from gimcli.rounding import number
from gimcli.structure.carried import carried_point
from gimcli.table import Column, Table, xy_columns

PANELS = 12
"""Greatest number of modes in the picture."""


OTHER = Pen(1.5, style.PALETTE[1], (3.0, 1.5), layer=5)
"""Members in the second extreme position."""

OTHER_PIN = Mark(size=3.6, face=style.PAPER, edge=style.PALETTE[1], width=0.9, layer=6)


@composition
def modes_picture(
    found: Linearised, modes: Sequence[Mode], time: float, headline: str, *, layout: PictureLayout = LAYOUT
) -> Sheet:
    """Return one panel for each mode, at most PANELS: the equilibrium and both extreme positions."""
    mechanism, shown = found.mechanism, modes[:PANELS]
    rest = mechanism.to_file(found.z)
    swings = (swing(found, mode, time, np.array([0.0, math.pi])) for mode in shown)
    ends = (mechanism.to_file(one.z) for one in swings)
    scenes = [Scene(mechanism, np.array([one, rest, other])) for one, other in ends]
    titles = [f"{k}: {spoken(mode)}" for k, mode in enumerate(shown, start=1)]
    more = f", the first {PANELS}" if len(modes) > PANELS else ""
    title = f"{headline}{more}; solid and dashed: both extremes, grey: equilibrium"

    def draw(drawing: Drawing, number: int) -> None:
        with drawing.picture.named("at-rest"):
            drawing.ghost(scenes[number], 1)
        with drawing.picture.named("other-extreme"):
            drawing.lines(scenes[number], scenes[number].poses[2], OTHER, OTHER_PIN)

    colours = dict.fromkeys(part_names(Scene(mechanism, rest[None])), style.PALETTE[0])
    return panels_of(scenes, titles, title, draw, layout, colours=colours)


def spoken(mode: Mode) -> str:
    """Return the frequency and the damping of a mode in a few words."""
    if mode.kind == VIBRATION:
        text = f"{number(mode.damped / (2.0 * math.pi))} Hz"
        return text + (f", damping ratio {number(mode.damping_ratio)}" if mode.decay else "")
    if mode.kind == RIGID:
        return "rigid body, no stiffness"
    return f"{'decays at' if mode.kind == DECAY else 'unstable, grows at'} {number(abs(mode.decay))} 1/s"


def amplitude_text(found: Linearised, mode: Mode, shown: Swing) -> str:
    """Return the amplitude of positions that are shown."""
    name, unit = found.names[mode.lead], found.units[mode.lead]
    value, word = shown.amplitude, unit
    if unit == "rad" and found.mechanism.angle_unit == "deg":
        value, word = math.degrees(value), "deg"
    return f"shown with an amplitude of {number(value)} {word} of {name}"


ROWS = 49
"""Number of positions of an oscillation, the last one is the first."""

ROUND = 2.0
"""Time in which an oscillation is shown [s]."""

GRAPHED = 3
"""Greatest number of inputs with a graph."""

PHASE = "phase"

NO_TIME = "a mode is shown without velocities: its amplitude is chosen so that it can be seen"


def modes_animation(found: Linearised, modes: Sequence[Mode], time: float) -> Animation:
    """Return one clip for each mode; damped ones are shown without their decay."""
    clips = tuple(_clip(found, k, mode, time) for k, mode in enumerate(modes, start=1))
    mechanism = found.mechanism
    graphs = tuple(Graph((mechanism.actuators[k].name,), PHASE) for k in found.released[:GRAPHED])
    note = "Positions satisfy all constraints; the amplitude of each mode is chosen so that it can be seen."
    return Animation(f"{mechanism.name}: modes", mechanism, clips, graphs, (note,), "Mode")


def _clip(found: Linearised, k: int, mode: Mode, time: float) -> Clip:
    mechanism = found.mechanism
    shown = swing(found, mode, time, np.linspace(0.0, 2.0 * math.pi, ROWS))
    z = mechanism.to_file(shown.z)
    phase = shown.phases if mechanism.angle_unit == "rad" else np.degrees(shown.phases)
    inputs = (
        Column(a.name, mechanism.value_to_file(j, shown.inputs[:, j]), mechanism.unit_of(a))
        for j, a in enumerate(mechanism.actuators)
    )
    paths = {name: mechanism.to_file(carried_point(mechanism, name, shown.z.T)) for name in mechanism.traced}
    points = (column for n, path in paths.items() for column in xy_columns(f"{n}.", path, mechanism.length_unit))
    table = Table((Column(PHASE, phase, mechanism.angle_unit), *inputs, *points))
    pace = (
        f"; an oscillation of {number(mode.period)} s lasts {ROUND:g} s at speed × 1" if mode.kind == VIBRATION else ""
    )
    return Clip(
        f"{k}: {spoken(mode)}", z, ROUND * shown.phases / (2.0 * math.pi), ("ok",) * len(z), table, PHASE,
        closed=True, without=NO_TIME, note=f"{amplitude_text(found, mode, shown)}{pace}",
    )  # fmt: skip
