"""Single positions as animations: one solved position, or all configurations, each a clip of one row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gimcli.library.rounding import titled
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output.animation import Animation, Clip
from gimcli.rates.instant import Instant
from gimcli.table import Column, Table, xy_columns

STILL = "a single position: velocities need --velocities"

NO_RATES = "configurations have no velocities: use `gim solve --velocities` or trace the motion"


def position_animation(
    mechanism: Mechanism, z: ComplexArray, inputs: Mapping[str, float], places: Mapping[str, complex],
    moving: Instant | None,
) -> Animation:  # fmt: skip
    """Return a solved position z (nodes,) with its velocities, if these are known.

    `places` are the coordinates of nodes and points in the file's units.
    """
    rates, without = None, STILL
    if moving is not None and not moving.singular:
        vectors = [moving.of_points(order) for order in (1, 2)]
        rates, without = np.array([[[of[name] for name in mechanism.nodes]] for of in vectors]), ""
    clip = _clip("position", mechanism, z, inputs, places, rates, without)
    return Animation(titled(mechanism, inputs), mechanism, (clip,))


def configurations_animation(
    mechanism: Mechanism, z: ComplexArray, inputs: Mapping[str, float], places: Mapping[str, ComplexArray],
    names: Sequence[str], notes: Sequence[str], verdict: str,
) -> Animation:  # fmt: skip
    """Return all configurations z (configurations, nodes), one clip each with a name and a note."""
    clips = []
    for k, (name, note) in enumerate(zip(names, notes, strict=True)):
        own = {point: complex(values[k]) for point, values in places.items()}
        clips.append(_clip(name, mechanism, z[k], inputs, own, None, NO_RATES, note))
    return Animation(titled(mechanism, inputs), mechanism, tuple(clips), notes=(verdict,), choice="Configuration")


def _clip(
    name: str, mechanism: Mechanism, z: ComplexArray, inputs: Mapping[str, float], places: Mapping[str, complex],
    rates: ComplexArray | None, without: str, note: str = "",
) -> Clip:  # fmt: skip
    """Return a clip of one row with the inputs and the coordinates of nodes and points."""
    own = [Column(a.name, np.array([inputs[a.name]]), mechanism.unit_of(a)) for a in mechanism.actuators]
    points = [c for n, at in places.items() for c in xy_columns(f"{n}.", np.array([at]), mechanism.length_unit)]
    at, table = mechanism.to_file(z)[None], Table((*own, *points))
    return Clip(name, at, np.zeros(1), ("ok",), table, rates=rates, without=without, note=note)
