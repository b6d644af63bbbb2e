"""The picture of modes: the mechanism at rest, and in both extreme positions of each mode."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gimcli.dynamics.modes import DECAY, RIGID, VIBRATION, Mode
from gimcli.dynamics.small_motions import Linearised
from gimcli.library.mode_shapes import Swing, swing
from gimcli.library.rounding import number

if TYPE_CHECKING:
    from gimcli.output.picture import Content

PANELS = 12
"""Greatest number of modes in the picture."""


def modes_picture(found: Linearised, modes: Sequence[Mode], time: float, headline: str) -> Content:
    """Return one panel for each mode, at most PANELS."""
    from gimcli.output.extremes import extremes_gallery

    mechanism, shown = found.mechanism, modes[:PANELS]
    swings = [swing(found, mode, time, np.array([0.0, math.pi])) for mode in shown]
    extremes = np.array([mechanism.to_file(one.z) for one in swings])
    titles = [f"{k}: {spoken(mode)}" for k, mode in enumerate(shown, start=1)]
    more = f", the first {PANELS}" if len(modes) > PANELS else ""
    title = f"{headline}{more}; solid and dashed: both extremes, grey: equilibrium"
    return extremes_gallery(mechanism, mechanism.to_file(found.z), extremes, titles, title)


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
