"""Four-bars by their lengths, and their limits by the law of cosines."""

from __future__ import annotations

import cmath
import math
from pathlib import Path
from typing import Any

from gimcli import Mechanism, load

MODEL = """\
name: four-bar
units: {{length: unit, angle: deg}}
nodes: {{O2: [0, 0], O4: [{ground!r}, 0], A: [{a.real!r}, {a.imag!r}], B: [{b.real!r}, {b.imag!r}]}}
ground: [O2, O4]
links:
  crank: {{nodes: [O2, A], length: {crank!r}}}
  coupler: {{nodes: [A, B], length: {coupler!r}}}
  follower: {{nodes: [O4, B], length: {follower!r}}}
actuators: {{motor: {{type: rotary, pivot: {pivot}, arm: {arm}{law}}}}}
trace: [B]
"""


def four_bar_text(
    crank: float, coupler: float, follower: float, ground: float, angle: float, side: float = 1.0, law: str = "",
    driven: str = "crank",
) -> str:  # fmt: skip
    """Return the text of a model drawn at a crank angle [rad]; B is left (1) or right (-1) of the line from A to O4."""
    a = cmath.rect(crank, angle)
    arm = ground - a
    along = (abs(arm) ** 2 + coupler**2 - follower**2) / (2.0 * abs(arm))
    across = math.sqrt(max(coupler**2 - along**2, 0.0))
    b = a + arm / abs(arm) * complex(along, side * across)
    pivot, end = ("O2", "A") if driven == "crank" else ("O4", "B")
    return MODEL.format(
        a=a, b=b, crank=crank, coupler=coupler, follower=follower, ground=ground, pivot=pivot, arm=end, law=law
    )


def four_bar(folder: Path, *lengths: float, **how: Any) -> Mechanism:
    """Return the mechanism with the lengths of crank, coupler, follower and ground, at a crank angle [rad]."""
    path = folder / "four_bar.yaml"
    path.write_text(four_bar_text(*lengths, **how))
    return load(path)


def cosines(crank: float, coupler: float, follower: float, ground: float) -> tuple[float, float]:
    """Return the cosines of the crank angle where coupler and follower are stretched and folded (law of cosines)."""
    square, twice = crank**2 + ground**2, 2.0 * crank * ground
    return (square - (coupler + follower) ** 2) / twice, (square - (coupler - follower) ** 2) / twice
