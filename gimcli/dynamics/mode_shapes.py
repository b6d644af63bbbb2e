"""The shape of a mode in the quantities of the file, and positions of the mechanism in it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from gimcli.dynamics.modes import Mode, member_rates
from gimcli.dynamics.small_motions import Linearisation, Linearised
from gimcli.mechanism import FRAME, ComplexArray, FloatArray
from gimcli.structure.carried import carried_point

SEEN = 0.14
"""Greatest displacement of a node in pictures, relative to the size of the mechanism."""

TURNED = 0.45
"""Greatest rotation of a member in pictures [rad]."""

REAL = 1e-9
"""A shape without phases has smaller imaginary parts."""


@dataclass(frozen=True)
class ModeShape:
    """Participations of inputs and members, and displacements of the traced points."""

    scale: str  # the quantity whose participation is 1, with its unit
    columns: tuple[tuple[str, str], ...]  # name and unit
    values: ComplexArray = field(repr=False)  # (columns,) rad or m

    @property
    def has_phases(self) -> bool:
        """Whether the quantities do not all reach their extremes at the same time."""
        return bool(np.any(np.abs(self.values.imag) > REAL * np.max(np.abs(self.values), initial=0.0)))

    def report(self) -> dict[str, float | list[float]]:
        """Return the participations by name; with phases as real and imaginary part."""
        names = [name for name, _ in self.columns]
        if not self.has_phases:
            return dict(zip(names, self.values.real.tolist(), strict=True))
        return {name: [float(v.real), float(v.imag)] for name, v in zip(names, self.values, strict=True)}


def mode_shape(found: Linearised, mode: Mode) -> ModeShape:
    """Return the shape of a mode."""
    mechanism, shape = found.mechanism, mode.shape
    metre = mechanism.dynamics.metre or 1.0
    columns: list[tuple[str, str]] = []
    values: list[complex] = []
    for k, actuator in enumerate(mechanism.actuators):
        if k in found.released or np.any(found.input_rates[:, k]):
            columns.append((f"{actuator.name}.shape", "rad" if actuator.rotary else "m"))
            values.append(complex(shape @ found.input_rates[:, k]) * (1.0 if actuator.rotary else metre))
    turns = shape @ member_rates(found)
    for member, turn in zip(mechanism.members[FRAME + 1 :], turns, strict=True):
        columns.append((f"{member.name}.turn", "rad"))
        values.append(complex(turn))
    for name in mechanism.traced:
        rates = _point_rates(found, name) * metre
        columns += [(f"{name}.dx", "m"), (f"{name}.dy", "m")]
        values += [complex(shape @ rates.real), complex(shape @ rates.imag)]
    scale = f"{found.names[mode.lead]} = 1 {found.units[mode.lead]}"
    return ModeShape(scale, tuple(columns), np.array(values))


def _point_rates(found: Linearised, name: str) -> ComplexArray:
    """Return the displacements (k,) of a node or point by each coordinate; those of the frame are 0."""
    mechanism = found.mechanism
    point = next((p for p in mechanism.points if p.name == name), None)
    if point is not None and point.member == FRAME:
        return np.zeros(len(found.names), dtype=complex)
    return carried_point(mechanism, name, found.node_rates.T)


@dataclass(frozen=True)
class Swing:
    """Positions of the mechanism in a mode, with an amplitude that can be seen; they satisfy all constraints."""

    amplitude: float  # rad or m of the leading coordinate
    phases: FloatArray  # (rows,) rad, from 0 to 2 pi
    z: ComplexArray = field(repr=False)  # (rows, nodes) normal frame
    inputs: FloatArray = field(repr=False)  # (rows, actuators) normal frame


def swing(found: Linearised, mode: Mode, time: float, phases: FloatArray) -> Swing:
    """Return positions with the changes a Re(x e^(i phase)) of the coordinates, a being the amplitude.

    The amplitude is halved until all positions are reached; at the least, all are the position of equilibrium.
    """
    equations = Linearisation(found.mechanism, found.released, time)
    equations.at(found.z, found.inputs, found.gauges)
    amplitude = _visible(found, mode)
    for _ in range(20):
        places = [equations.moved(amplitude * (mode.shape * np.exp(1j * phase)).real) for phase in phases]
        reached = [place for place in places if place is not None]
        if len(reached) == len(places) and not _is_far(found, [place[0] for place in reached]):
            return Swing(amplitude, phases, np.array([z for z, _, _ in reached]), np.array([u for _, u, _ in reached]))
        amplitude *= 0.5
    rows = len(phases)
    return Swing(0.0, phases, np.tile(found.z, (rows, 1)), np.tile(found.inputs, (rows, 1)))


def _visible(found: Linearised, mode: Mode) -> float:
    """Return the amplitude of a mode for pictures."""
    far = float(np.max(np.abs(mode.shape @ found.node_rates.real) + np.abs(mode.shape @ found.node_rates.imag)))
    turn = float(np.max(np.abs(mode.shape @ member_rates(found)), initial=0.0))
    limits = [SEEN * found.mechanism.size / far] if far > 0.0 else []
    limits += [TURNED / turn] if turn > 0.0 else []
    return min(limits, default=math.inf) if limits else 0.0


def _is_far(found: Linearised, places: Sequence[ComplexArray]) -> bool:
    """Return whether a node has moved much farther than in proportion to the amplitude."""
    return bool(np.max(np.abs(np.array(places) - found.z)) > 2.0 * SEEN * found.mechanism.size)
