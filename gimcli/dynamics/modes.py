"""Natural modes of the linearised equations M x'' + C x' + K x = 0 of the released inputs.

Without damping K x = omega^2 M x with real shapes. With it, or with forces that are not conservative, the motions are
x e^(lambda t) with (lambda^2 M + lambda C + K) x = 0. Source: Meirovitch, Fundamentals of Vibrations, 2001, sections
7.5 and 7.15.

The shape of a mode is given in the quantities of the file, and as positions of the mechanism.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gimcli.canonical import ranks
from gimcli.dynamics.physical import input_units
from gimcli.dynamics.small_motions import Linearisation, Linearised
from gimcli.errors import ModelError
from gimcli.mechanism import FRAME, ComplexArray, FloatArray
from gimcli.structure.carried import carried_point, turn_rates

VIBRATION, DECAY, RIGID, UNSTABLE = "vibration", "decay", "rigid body", "unstable"
"""Kinds of modes: oscillating; returning without oscillation; without stiffness; growing."""

ZERO = 1e-9
"""A stiffness below this fraction of its contributions is 0: their sum has rounding errors, and so has the position."""

MASSLESS = 1e-13
"""Least eigenvalue of M, scaled to a diagonal of 1, below which a direction of motion has no mass."""

STILL = 1e-16
"""Least mass of a coordinate relative to that of all masses if each moved as far as any node: below, it is rounding."""

SAME, MIXED = 1e-9, 1e-6
"""Difference of equal frequencies, relative to the greatest; part of a column of their shapes that is not rounding."""

REAL = 1e-7
"""An eigenvalue is real if its imaginary part is less than this fraction: a double one is known to half the digits."""


@dataclass(frozen=True)
class Mode:
    """One natural motion x e^(lambda t); SI units. The greatest participation in its shape is 1."""

    kind: str
    eigenvalue: complex  # lambda [1/s]; of a pair the one with positive imaginary part
    shape: ComplexArray = field(repr=False)  # (k,) rad or m of the coordinates
    lead: int  # the coordinate whose participation is 1
    mass: float  # x* M x: kg m^2 or kg, by the unit of the leading coordinate
    stiffness: float  # x* K x: N m/rad or N/m
    damping: float  # x* C x: N m s/rad or N s/m

    @property
    def omega(self) -> float:
        """Natural angular frequency [rad/s]: of vibrations |lambda|; 0 of a rigid body; NaN of unstable modes."""
        if self.kind == VIBRATION:
            return abs(self.eigenvalue)
        if self.kind == DECAY and self.stiffness > 0.0:
            return math.sqrt(self.stiffness / self.mass)
        return 0.0 if self.kind == RIGID else math.nan

    @property
    def period(self) -> float:
        """Time of one oscillation [s], with the damping; NaN if there is none."""
        return 2.0 * math.pi / self.damped if self.damped > 0.0 else math.nan

    @property
    def damped(self) -> float:
        """Angular frequency with the damping [rad/s]; 0 if the motion does not oscillate."""
        return abs(self.eigenvalue.imag)

    @property
    def decay(self) -> float:
        """Rate at which the amplitude decays [1/s]; negative if it grows."""
        return -self.eigenvalue.real or 0.0

    @property
    def damping_ratio(self) -> float:
        """Damping relative to the critical one: c / (2 sqrt(k m)); NaN without a natural frequency."""
        if self.kind == VIBRATION:
            return self.decay / abs(self.eigenvalue)
        return self.damping / (2.0 * self.mass * self.omega) if self.omega > 0.0 else math.nan


def natural_modes(found: Linearised) -> tuple[Mode, ...]:
    """Return the modes in the order of their frequencies, first those that are unstable or without stiffness.

    Raises ModelError if a direction of motion has no mass.
    """
    root = _root(found)
    if found.symmetric and not found.damping.any():
        return _conservative(found, root)
    return _damped(found, root)


def _root(found: Linearised) -> FloatArray:
    """Return the inverse Cholesky factor of M: L^-1 with M = L L'."""
    diagonal, dynamics = np.diag(found.mass), found.mechanism.dynamics
    whole = sum(part.mass * (dynamics.metre or 1.0) ** 2 + part.moment for part in dynamics.inertias)
    least = STILL * whole * np.max(np.abs(found.node_rates[:, list(found.mechanism.close)]), axis=1) ** 2
    bare = [name for name, m in zip(found.names, diagonal - least, strict=True) if not m > 0.0]
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    if bare or np.linalg.eigvalsh(found.mass / scale[:, None] / scale)[0] < MASSLESS:
        what = f"no mass moves with {' and '.join(bare)}" if bare else "a motion of the released inputs moves no mass"
        remedy = "add masses of these members, hold the input, or give another position"
        raise ModelError([f"{found.mechanism.name}: {what} at this position: {remedy}"])
    return np.asarray(np.linalg.inv(np.linalg.cholesky(found.mass)))


def _conservative(found: Linearised, root: FloatArray) -> tuple[Mode, ...]:
    stiffness = root @ found.stiffness @ root.T
    values, vectors = np.linalg.eigh(0.5 * (stiffness + stiffness.T))
    modes, shapes = [], (root.T @ vectors).T
    values[[_is_rigid(found, shape) for shape in shapes]] = 0.0  # one frequency, whatever the rounding
    for value, vector in zip(values, _separated(values, shapes), strict=True):
        kind = RIGID if _is_rigid(found, vector) else VIBRATION if value > 0.0 else UNSTABLE
        rate = {RIGID: 0j, VIBRATION: complex(0.0, math.sqrt(abs(value))), UNSTABLE: complex(math.sqrt(abs(value)))}
        modes.append(_mode(found, kind, rate[kind], vector))
    return tuple(modes)


def _separated(values: FloatArray, shapes: FloatArray) -> FloatArray:
    """Return shapes (k, k); those of one frequency, of which any combination is a mode, are in echelon form."""
    found, same = shapes.copy(), ranks(values, SAME * float(np.max(np.abs(values))))
    for rank in np.flatnonzero(np.bincount(same) > 1):
        rows, column = shapes[same == rank], 0
        least = MIXED * np.max(np.abs(rows), axis=0)
        for k in range(len(rows)):
            while column < len(shapes) - 1 and not np.max(np.abs(rows[k:, column])) > least[column]:
                column += 1
            i = k + int(np.argmax(np.abs(rows[k:, column])))
            rows[[k, i]] = rows[[i, k]]
            rows[k] /= rows[k, column]
            rows -= np.outer(np.where(np.arange(len(rows)) == k, 0.0, rows[:, column]), rows[k])
        found[same == rank] = rows
    return found


def _is_rigid(found: Linearised, shape: FloatArray) -> bool:
    """Return whether a shape has no stiffness, up to rounding."""
    size = np.abs(shape)
    return bool(abs(shape @ found.stiffness @ shape) <= ZERO * (size @ found.stiffness_scale @ size))


def _damped(found: Linearised, root: FloatArray) -> tuple[Mode, ...]:
    """Return the modes from the eigenvalues of the first-order system."""
    k = len(root)
    stiffness, damping = (root @ part @ root.T for part in (found.stiffness, found.damping))
    values, vectors = np.linalg.eig(np.block([[np.zeros((k, k)), np.eye(k)], [-stiffness, -damping]]))
    shapes = (root.T @ vectors[:k]).T
    rigid, order = _rigid_shapes(found, root), np.argsort(np.abs(values), kind="stable")
    still = len(rigid) + _undamped(found, rigid)
    modes = [_mode(found, RIGID, 0j, shape) for shape in rigid]
    for j in order[still:]:
        value = complex(values[j])
        if abs(value.imag) <= REAL * abs(value):
            kind = DECAY if value.real < 0.0 else UNSTABLE
            modes.append(_mode(found, kind, complex(value.real), shapes[j]))
        elif value.imag > 0.0:
            grows = value.real > REAL * abs(value)
            modes.append(_mode(found, UNSTABLE if grows else VIBRATION, value, shapes[j]))
    rank = ranks(np.array([abs(mode.eigenvalue) for mode in modes]), SAME * float(np.max(np.abs(values)))).tolist()
    keys = [(m.kind != UNSTABLE, m.kind != RIGID, own, m.lead) for m, own in zip(modes, rank, strict=True)]
    return tuple(modes[k] for k in sorted(range(len(modes)), key=keys.__getitem__))


def _rigid_shapes(found: Linearised, root: FloatArray) -> list[FloatArray]:
    """Return the shapes without stiffness."""
    stiffness = root @ found.stiffness @ root.T
    own = np.linalg.eigh(0.5 * (stiffness + stiffness.T))[1] if found.symmetric else np.linalg.svd(stiffness)[2].T
    return [shape for shape in (root.T @ own).T if _is_rigid(found, shape)]


def _undamped(found: Linearised, rigid: list[FloatArray]) -> int:
    """Return the number of shapes without stiffness that have no damping either: their eigenvalue 0 is double."""
    if not rigid:
        return 0
    shapes = np.array(rigid)
    damping = shapes @ found.damping @ shapes.T
    size = np.abs(shapes) @ np.abs(found.damping) @ np.abs(shapes).T
    return int(np.sum(np.linalg.eigvalsh(damping) <= ZERO * max(np.max(size), np.finfo(float).tiny)))


def _mode(found: Linearised, kind: str, value: complex, vector: ComplexArray | FloatArray) -> Mode:
    """Return a mode with its greatest participation, rotations compared with lengths of the mechanism, scaled to 1."""
    length = found.mechanism.size * (found.mechanism.dynamics.metre or 1.0)
    weight = np.array([1.0 if unit == "rad" else 1.0 / length for unit in found.units])
    sizes = np.abs(vector) * weight
    lead = int(np.argmax(sizes > (1.0 - 1e-9) * np.max(sizes)))  # the first of equal ones
    shape = np.asarray(vector / vector[lead], dtype=np.complex128)
    effective = [float((shape.conj() @ part @ shape).real) for part in (found.mass, found.stiffness, found.damping)]
    return Mode(kind, value, shape, lead, *effective)


SEEN = 0.14
"""Greatest displacement of a node in pictures, relative to the size of the mechanism."""

TURNED = 0.45
"""Greatest rotation of a member in pictures [rad]."""

IN_PHASE = 1e-9
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
        return bool(np.any(np.abs(self.values.imag) > IN_PHASE * np.max(np.abs(self.values), initial=0.0)))

    def report(self) -> dict[str, float | list[float]]:
        """Return the participations by name; with phases as real and imaginary part."""
        names = [name for name, _ in self.columns]
        if not self.has_phases:
            return dict(zip(names, self.values.real.tolist(), strict=True))
        return {name: [float(v.real), float(v.imag)] for name, v in zip(names, self.values, strict=True)}


def mode_shape(found: Linearised, mode: Mode) -> ModeShape:
    """Return the shape of a mode."""
    mechanism, shape = found.mechanism, mode.shape
    units, columns = input_units(mechanism), list[tuple[str, str]]()
    values: list[complex] = []
    for k, actuator in enumerate(mechanism.actuators):
        if k in found.released or np.any(found.input_rates[:, k]):
            columns.append((f"{actuator.name}.shape", "rad" if actuator.rotary else "m"))
            values.append(complex(shape @ found.input_rates[:, k]) * units[k])
    turns = shape @ turn_rates(mechanism, found.z, found.node_rates)
    for member, turn in zip(mechanism.members[FRAME + 1 :], turns, strict=True):
        columns.append((f"{member.name}.turn", "rad"))
        values.append(complex(turn))
    for name in mechanism.traced:
        rates = _point_rates(found, name) * (mechanism.dynamics.metre or 1.0)
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
        z, inputs = (np.array([place[k] for place in reached]) for k in range(2))
        far = 2.0 * SEEN * found.mechanism.size  # much farther than in proportion to the amplitude
        if len(reached) == len(places) and np.max(np.abs(z - found.z)) <= far:
            return Swing(amplitude, phases, z, inputs)
        amplitude *= 0.5
    rows = len(phases)
    return Swing(0.0, phases, np.tile(found.z, (rows, 1)), np.tile(found.inputs, (rows, 1)))


def _visible(found: Linearised, mode: Mode) -> float:
    """Return the amplitude of a mode for pictures."""
    far = float(np.max(np.abs(mode.shape @ found.node_rates.real) + np.abs(mode.shape @ found.node_rates.imag)))
    turn = float(np.max(np.abs(mode.shape @ turn_rates(found.mechanism, found.z, found.node_rates)), initial=0.0))
    limits = [SEEN * found.mechanism.size / far] if far > 0.0 else []
    limits += [TURNED / turn] if turn > 0.0 else []
    return min(limits, default=math.inf) if limits else 0.0
