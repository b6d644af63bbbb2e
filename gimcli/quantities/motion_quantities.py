"""Quantities of a motion with their exact derivatives: speeds, angles, travels, quality of transmission."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gimcli.canonical import beside, phase
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, PairRow
from gimcli.quantities.extremes import RateRows, TimedQuantity
from gimcli.quantities.state import ForceLine
from gimcli.quantities.transmission import TransmissionJoint
from gimcli.structure.residual import pose


def _inner(a: ComplexArray, b: ComplexArray) -> FloatArray:
    return np.asarray((np.conj(a) * b).real)


@dataclass(frozen=True)
class Speed(TimedQuantity):
    """Magnitude of the velocity (order 1) or acceleration (order 2) of a node or point."""

    point: str
    order: int = 1

    def of(self, rows: RateRows) -> tuple[FloatArray, FloatArray]:
        """Return the magnitude [normal length/s or /s^2] and its derivative."""
        vector, change = rows.rates.point(self.point)[self.order : self.order + 2]
        size = np.abs(vector)
        with np.errstate(all="ignore"):
            return size, np.where(size > 0.0, _inner(vector, change) / size, 0.0)


@dataclass(frozen=True)
class AngularSpeed(TimedQuantity):
    """Magnitude of the angular velocity (order 1) or angular acceleration (order 2) of a member."""

    member: int
    order: int = 1

    def of(self, rows: RateRows) -> tuple[FloatArray, FloatArray]:
        """Return the magnitude [rad/s or rad/s^2] and its derivative."""
        value, change = rows.rates.angular(self.member)[self.order - 1 : self.order + 1]
        return np.abs(value), np.sign(value) * change


@dataclass(frozen=True)
class MemberRotation(TimedQuantity):
    """Angle of a member, full turns counted from the rows of the motion."""

    least = True
    member: int
    time: FloatArray = field(repr=False)  # (rows,) of the motion
    angle: FloatArray = field(repr=False)  # (rows,) [rad], continuous

    def of(self, rows: RateRows) -> tuple[FloatArray, FloatArray]:
        """Return the angle [rad] and the angular velocity."""
        own = direction(rows, self.member)
        near = np.interp(rows.time, self.time, self.angle)
        return beside(own, near), rows.rates.angular(self.member)[0]


def rotation(rows: RateRows, member: int) -> MemberRotation:
    """Return the angle of a member as a quantity, from rows in which it turns by less than half a turn a row."""
    own = direction(rows, member)
    good = np.isfinite(own)
    return MemberRotation(member, rows.time[good], np.unwrap(own[good]))


def direction(rows: RateRows, member: int) -> FloatArray:
    """Return the direction (rows,) of a member from its first node to its second, in (-pi, pi]."""
    first, second = rows.mechanism.members[member].nodes[:2]
    return np.asarray(phase(rows.rates.nodes[0, second] - rows.rates.nodes[0, first]))


@dataclass(frozen=True)
class Travel(TimedQuantity):
    """Position of a slider along its guide."""

    least = True
    slide: PairRow

    def of(self, rows: RateRows) -> tuple[FloatArray, FloatArray]:
        """Return the position along the guide [normal length] and the sliding velocity."""
        mechanism, nodes, slide = rows.mechanism, rows.rates.nodes, self.slide
        z, v = nodes[0], nodes[1]
        if slide.guide == FRAME:
            return _inner(np.array(slide.along), z[slide.node]), _inner(np.array(slide.along), v[slide.node])
        along = slide.along * pose(mechanism, slide.guide, z)[1]
        origin = mechanism.members[slide.guide].nodes[0]
        away, speed = z[slide.node] - z[origin], v[slide.node] - v[origin]
        turn = rows.rates.angular(slide.guide)[0] * (np.conj(along) * away).imag
        return _inner(along, away), _inner(along, speed) + turn


@dataclass(frozen=True)
class Flatness(TimedQuantity):
    """Magnitude of the cosine of a transmission angle: 0 at 90 degrees, 1 at 0 and 180 degrees."""

    joint: TransmissionJoint

    def of(self, rows: RateRows) -> tuple[FloatArray, FloatArray]:
        """Return the cosine and its derivative."""
        with np.errstate(all="ignore"):
            first, one = self._line(rows, self.joint.first)
            second, two = self._line(rows, self.joint.second)
            product = np.conj(first) * second
            cosine, sine = product.real / np.abs(product), product.imag / np.abs(product)
            turn = (two / second - one / first).imag
            return np.abs(cosine), -np.sign(cosine) * sine * turn

    def _line(self, rows: RateRows, line: ForceLine) -> tuple[ComplexArray, ComplexArray]:
        """Return the direction (rows,) of a line and its derivative."""
        nodes, joint = rows.rates.nodes, self.joint.node
        along = line.direction(rows.mechanism, joint, nodes[0])
        if line.slide is None:
            return along, np.asarray(nodes[1, line.node] - nodes[1, joint])
        return along, np.asarray(1j * rows.rates.angular(line.slide.guide)[0] * along)
