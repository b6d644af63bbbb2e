"""Linkages with a limit or a change point at a known input, with closed forms of a node on each arc."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mpmath import mp, mpc, mpf

mp.dps = 30

LAW = "<law>"
"""Placeholder of the law in the text of a model."""


@dataclass(frozen=True)
class Linkage:
    """A linkage with a singular position at the input `critical`; values in the file's units (degrees, lengths)."""

    name: str
    text: Callable[[float], str]  # of the model drawn at an input, with LAW as placeholder
    node: str
    start: float
    critical: float
    interval: tuple[float, float]  # of the input on the circuit; infinite if it makes full turns
    limit: bool  # a limit, otherwise a change point
    arc: Callable[[float], complex]  # position of the node at an input, on the drawn arc
    other: Callable[[float], complex] | None  # on the other arc or branch; None: there the input rate is zero


def crank_tip(crank: float, degrees: float) -> mpc:
    return mpf(crank) * mp.expjpi(mpf(degrees) / 180)


def meeting(a: mpc, ra: float, b: mpc, rb: float, side: int) -> mpc:
    """Return the intersection of circles around a and b, to the left (1) or right (-1) of a -> b.

    Circles that miss each other by a rounding error count as tangent.
    """
    d = abs(b - a)
    x = (mpf(ra) ** 2 - mpf(rb) ** 2 + d**2) / (2 * d)
    h2 = mpf(ra) ** 2 - x**2
    assert h2 > -1e-9, "out of reach"
    return a + (b - a) / d * mpc(x, side * mp.sqrt(max(h2, mpf(0))))


def four_bar(lengths: tuple[float, float, float, float], node: Callable[[float], complex], start: float) -> str:
    """Write a four-bar of crank, coupler, follower and frame, drawn at its start."""
    crank, coupler, follower, frame = lengths
    a, b = complex(crank_tip(crank, start)), node(start)
    return f"""
nodes: {{O: [0, 0], C: [{frame}, 0], A: [{a.real}, {a.imag}], B: [{b.real}, {b.imag}]}}
ground: [O, C]
links:
  crank: {{nodes: [O, A], length: {crank}}}
  coupler: {{nodes: [A, B], length: {coupler}}}
  follower: {{nodes: [C, B], length: {follower}}}
actuators: {{m: {{type: rotary, pivot: O, arm: A, law: {LAW}}}}}
trace: [A, B]
"""


def rocker(side: int) -> Callable[[float], complex]:
    """Crank 3, coupler 1.5, follower 3.5, frame 4: stretched (length 5) at 90 deg (3-4-5), folded at acos(7/8)."""
    return lambda v: complex(meeting(crank_tip(3, v), 1.5, mpc(4), 3.5, side))


def parallel(v: float) -> complex:
    return complex(crank_tip(1, v) + 3)


def crossed(v: float) -> complex:
    """The antiparallelogram: B of the parallelogram, mirrored in the diagonal from A to the pivot of the follower."""
    a, b, c = crank_tip(1, v), crank_tip(1, v) + 3, mpc(3)
    along = (c - a) / abs(c - a)
    return complex(a + along**2 * mp.conj(b - a))


def kite(v: float) -> complex:
    """Crank and frame 2, coupler and follower 3: B is on the bisector, which turns half as fast as the crank."""
    half = mpf(v) / 360
    return complex(mp.expjpi(half) * (2 * mp.cospi(half) + mp.sqrt(9 - 4 * mp.sinpi(half) ** 2)))


def driven(crank: float, rod: float, side: int) -> Callable[[float], complex]:
    return lambda x: complex(meeting(mpc(0), crank, mpc(x), rod, side))


def driven_straight(x: float) -> complex:
    """Crank and rod 2, driven by the slider: A stays above the guide while the slider passes the pivot."""
    return complex(mpf(x) / 2, mp.sqrt(4 - mpf(x) ** 2 / 4))


def sliding(v: float) -> complex:
    """Crank and rod 2: the slider is at 4 cos v."""
    return complex(4 * mp.cospi(mpf(v) / 180))


def slider_crank(crank: float, rod: float, a: complex, b: float, drive: str) -> str:
    """Write a slider-crank with its guide along the x axis."""
    return f"""
units: {{length: unit}}
nodes: {{O: [0, 0], T: [5, 0], A: [{a.real}, {a.imag}], B: [{b}, 0]}}
ground: [O, T]
links: {{crank: {{nodes: [O, A], length: {crank}}}, rod: {{nodes: [A, B], length: {rod}}}}}
prismatic: {{s: {{node: B, guide: [O, T]}}}}
actuators: {{m: {{{drive}, law: {LAW}}}}}
trace: [A, B]
"""


FOLDED = float(mp.acos(mpf(7) / 8) * 180 / mp.pi)
ROUND = (float("-inf"), float("inf"))


def rocking(drawn: float) -> str:
    return four_bar((3, 1.5, 3.5, 4), rocker(1), drawn)


def cranked(drawn: float) -> str:
    return slider_crank(2, 2, complex(crank_tip(2, drawn)), sliding(drawn).real, "type: rotary, pivot: O, arm: A")


def parallels(drawn: float) -> str:
    return four_bar((1, 3, 1, 3), parallel, drawn)


def kites(drawn: float) -> str:
    return four_bar((2, 3, 3, 2), kite, drawn)


def slid(crank: float, rod: float) -> Callable[[float], str]:
    """Return the function that writes a slider-crank that is driven by its slider."""
    drive = "type: linear, node: B, guide: [O, T]"
    place = driven_straight if crank == rod else driven(crank, rod, 1)
    return lambda drawn: slider_crank(crank, rod, place(drawn), drawn, drive)


OVER, UNDER = driven(2, 5, 1), driven(2, 5, -1)
LINKAGES = [
    Linkage("four-bar", rocking, "B", 60.0, 90.0, (FOLDED, 90.0), True, rocker(1), rocker(-1)),
    Linkage("driven slider, r < l", slid(2, 5), "A", 6.0, 7.0, (3.0, 7.0), True, OVER, UNDER),
    Linkage("driven slider, r < l, inner", slid(2, 5), "A", 4.0, 3.0, (3.0, 7.0), True, OVER, UNDER),
    Linkage("driven slider, r = l", slid(2, 2), "A", 3.0, 4.0, (-4.0, 4.0), True, driven(2, 2, 1), driven(2, 2, -1)),
    Linkage("slider over its pivot", slid(2, 2), "A", 1.0, 0.0, (-4.0, 4.0), False, driven_straight, None),
    Linkage("parallelogram", parallels, "B", 90.0, 180.0, ROUND, False, parallel, crossed),
    Linkage("parallelogram at 0", parallels, "B", 90.0, 0.0, ROUND, False, parallel, crossed),
    Linkage("kite", kites, "B", 60.0, 0.0, ROUND, False, kite, None),
    Linkage("slider-crank, r = l", cranked, "B", 40.0, 90.0, ROUND, False, sliding, lambda v: 0j),
]  # fmt: skip
