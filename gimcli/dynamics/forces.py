"""Inverse dynamics: efforts and reactions for a given motion.

The equations of dynamic equilibrium of all bodies are solved block by block, in the reverse order of formation: first
the reactions of the last group, in the end the efforts of the drivers. With redundant constraints some reactions are
indeterminate; the others are given. Source: Durango, Giraldo, Calle & Mesa 2014, section 2.3 (groups of the second
class); here for any group.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gimcli.calculus.numbers import RuleNumber
from gimcli.dynamics.equilibrium_equations import equilibrium, right_side, solved
from gimcli.dynamics.kinematic_history import Course, Courses, Turns, reading
from gimcli.dynamics.loading import Loading
from gimcli.dynamics.physical import effort_shares, input_units
from gimcli.dynamics.statics import Pin, Statics, direction
from gimcli.kernels.equilibrium import SINGULAR
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run

if TYPE_CHECKING:
    from gimcli.dynamics.coulomb import DryFriction

POSITION = 1e-13
"""Relative error of positions and their rates. It grows with the condition of the scaled equations near a singular
position, and the error of reactions grows with both: it is about POSITION * condition**2."""

MOST = 1e-2
"""Greatest estimated relative error of the forces in a summary and a picture."""

AT_ONCE = 4096
"""Rows whose redundant equations are decomposed in one call."""

UNIQUE = 1e-8
"""Greatest component of a reaction in a unit self-stress for which the reaction counts as determined."""


@dataclass(frozen=True)
class Forces:
    """Efforts and reactions along a motion; NaN where they are undetermined."""

    statics: Statics = field(repr=False)
    course: Course = field(repr=False)
    loads: Loading = field(repr=False)
    unknowns: FloatArray = field(repr=False)  # (unknowns, rows) N; couples in N x length of the normal frame
    free: FloatArray = field(repr=False)  # (surplus, unknowns, rows) unit self-stresses of redundant constraints
    weakest: FloatArray = field(
        repr=False
    )  # (rows,) ratio of the least to the greatest pivot, or singular value, of the scaled equations
    dry: DryFriction | None = field(default=None, repr=False)  # of a motion with dry friction

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.statics.mechanism

    @cached_property
    def good(self) -> BoolArray:
        """Return for every row whether its forces are determined."""
        return np.asarray(np.all(np.isfinite(self.unknowns), axis=0) & np.isfinite(self.loads.support))

    @cached_property
    def bounded(self) -> BoolArray:
        """Return for every row whether the estimated relative error of its forces is at most `MOST`."""
        return np.asarray(self.good & (MOST * self.weakest**2 >= POSITION))

    def effort(self, actuator: int) -> FloatArray:
        """Return the driving torque [N m] or force [N] of an actuator with its rotor (rows,).

        The effort of an actuator includes those that its followers need; that of a follower is what it transmits.
        """
        effort = self._own_effort(actuator)
        for leader, follower, share in effort_shares(self.mechanism):
            if leader == actuator:
                effort = effort + share * self._own_effort(follower)
        return effort

    def _own_effort(self, actuator: int) -> FloatArray:
        """Return the effort that an actuator exerts on the members, and its rotor on it [N m or N] (rows,)."""
        effort = determined(self._solutions[:, self.statics.efforts[actuator]])
        effort = effort * (self.loads.metre if self.mechanism.actuators[actuator].rotary else 1.0)
        return effort + self.loads.rotors[actuator].effort if actuator in self.loads.rotors else effort

    def unknown(self, number: int) -> FloatArray:
        """Return an unknown [N, or N x length of the normal frame] where it is determined, else NaN (rows,)."""
        return determined(self._solutions[:, number])

    def direction(self, number: int) -> ComplexArray:
        """Return the direction of the force of an unknown (rows,)."""
        found: ComplexArray = direction(self.statics.reactions[number], self.course.nodes[0])
        return found

    def pin(self, pin: Pin, member: int) -> ComplexArray:
        """Return the force [N] of the pin on a member, x + iy (rows,)."""
        force = self._force(pin, member)
        return joined(determined(force.real), determined(force.imag))

    def pin_shared(self, pin: Pin, member: int) -> ComplexArray:
        """Return the determined component [N] of a pin force if the whole force is indeterminate, else NaN (rows,)."""
        return shared(self._force(pin, member))

    def normal(self, pair: str) -> FloatArray:
        """Return the normal force [N] on the sliding node or member, positive to the left of the guide (rows,)."""
        return determined(sum(self._solutions[:, self.statics.normals[k]] for k in self._slides(pair)))

    def moment(self, pair: str) -> FloatArray:
        """Return the moment [N m] on the sliding member of a prismatic pair about its first node (rows,)."""
        first, *others = self._slides(pair)
        slides, nodes, normals = self.mechanism.slides, self.course.nodes[0], self.statics.normals
        turns = []
        for k in others:
            arm = nodes[slides[k].node] - nodes[slides[first].node]
            turns.append((arm.conjugate() * self.direction(normals[k])).imag * self._solutions[:, normals[k]])
        return determined(sum(turns)) * self.loads.metre

    @property
    def shaking_force(self) -> ComplexArray:
        """The force [N] on the frame (rows,), from the momentum of all bodies; it is always determined."""
        return self.only(self.loads.support)

    @property
    def shaking_moment(self) -> FloatArray:
        """The moment [N m] on the frame (rows,) about the first ground node."""
        return self.only(self.loads.support_moment * self.loads.metre)

    def only(self, values: Any) -> NDArray[Any]:
        """Return values (rows,), NaN in rows without determined forces."""
        found: NDArray[Any] = np.where(self.good, values, values * np.nan)
        return found

    @cached_property
    def drive_power(self) -> FloatArray:
        """The power [W] of the actuators that follow no others (rows,); the others only transmit power."""
        return sum((self.power(k) for k in self.mechanism.drivers), 0.0 * self.course.time)

    def power(self, actuator: int) -> FloatArray:
        """Return the power [W] of an actuator (rows,)."""
        rate = reading(self.mechanism, self.mechanism.actuators[actuator], self.course)[1]
        return self.effort(actuator) * rate * float(input_units(self.mechanism)[actuator])

    @property
    def power_error(self) -> FloatArray:
        """Power of all forces minus the rate of the kinetic energy [W] (rows,): 0 except for rounding."""
        found: FloatArray = self.drive_power + sum(self.loads.power.values()) - self.loads.kinetic_rate
        return found

    @cached_property
    def _solutions(self) -> Any:
        """The unknowns in one solution, and in each self-stress (1 + surplus, unknowns, rows).

        Solutions differ by combinations of self-stresses.
        """
        return np.concatenate([self.unknowns[None], self.free]) if len(self.free) else self.unknowns[None]

    def _force(self, pin: Pin, member: int) -> Any:
        """Return the force [N] of the pin on a member, as `_solutions` (1 + surplus, rows)."""
        held = {m: self._solutions[:, x] + 1j * self._solutions[:, y] for m, (x, y) in pin.unknowns.items()}
        return held[member] if member in held else self._attached(pin.node) - sum(held.values())

    def _slides(self, pair: str) -> list[int]:
        return [k for k, s in enumerate(self.mechanism.slides) if s.pair == pair]

    def _attached(self, node: int) -> Any:
        """Return the sum of the forces of springs, sliding pairs and actuators on the pin of a node."""
        acting = [
            sense * self.direction(unknown) * self._solutions[:, unknown]
            for unknown, reaction in enumerate(self.statics.reactions) if reaction.on_pin
            for end, sense in reaction.ends if end == node
        ]  # fmt: skip
        return sum(acting, self._in_one(self.loads.pins.get(node, 0.0)))

    def _in_one(self, force: Any) -> Any:
        """Return a known force as `_solutions`: it is in one solution, not in the self-stresses."""
        return np.eye(1 + len(self.free), 1) * force


def inverse_dynamics(
    statics: Statics, course: Course, run: Run = plain, turns: Turns | None = None, every: bool = False
) -> Forces:
    """Return the efforts and reactions of a motion.

    With `every`, indeterminate reactions have the values of the least-norm solution instead of NaN.
    """
    loads = Loading(statics, course, turns)
    right, z = right_side(statics, loads), course.nodes[0]
    with np.errstate(all="ignore"):  # singular rows become NaN
        if statics.surplus:
            found, free, weakest = _least(statics, z, right)
        else:
            found, weakest = solved(statics, z, right, run)
            free = np.zeros((0, *found.shape))
    found = np.where(np.isfinite(found), found, np.nan)
    return Forces(statics, course, loads, *_with_gears(statics, z, found, free * (not every)), weakest)


def _with_gears(
    statics: Statics, z: ComplexArray, found: FloatArray, free: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return reactions and self-stresses with the forces of gears that pass through the pivots, added in place."""
    if statics.mechanism.gears:
        from gimcli.dynamics.gear_reactions import add_across  # imported late: only for models with gears

        add_across(statics, z, found, free)
    return found, free


def piece_forces(
    statics: Statics, courses: Courses, motion: Motion, run: Run = plain, turns: Turns | None = None
) -> Forces:
    """Return the efforts and reactions of a piece of a motion, with dry friction if the mechanism has it."""
    if not any(friction.mu for friction in statics.mechanism.dynamics.frictions):
        return inverse_dynamics(statics, courses(motion), run, turns)
    from gimcli.dynamics.coulomb import sliding_forces  # imported late: only for models with dry friction

    if statics.mechanism.gears:
        from gimcli.dynamics.gear_reactions import refuse_dry_friction

        refuse_dry_friction(statics)
    drivers = statics.mechanism.drivers
    single = len(drivers) == 1 and statics.mechanism.complete is None
    course, unit = courses(motion), (lambda: courses.by_input(motion, drivers[0])) if single else None
    loads, found, weakest, dry = sliding_forces(statics, course, run, turns, unit)
    both = _with_gears(statics, course.nodes[0], found, np.zeros((0, *found.shape)))
    return Forces(statics, course, loads, *both, weakest, dry)


def _least(statics: Statics, z: ComplexArray, right: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the least-norm reactions, the unit self-stresses, and the ratio of least to greatest singular value."""
    count, weakest, (rows, columns) = len(statics.reactions), np.zeros(z.shape[1]), statics.scales
    found, free = np.full((count, len(weakest)), np.nan), np.zeros((statics.surplus, count, len(weakest)))
    good = np.flatnonzero(np.all(np.isfinite(right), axis=0) & np.all(np.isfinite(z), axis=0))
    for start in range(0, len(good), AT_ONCE):
        part = good[start : start + AT_ONCE]
        table = equilibrium(statics, z[:, part])
        left, values, across = np.linalg.svd(table)
        scaled = np.linalg.svd(rows[:, None] * table * columns, compute_uv=False)
        weakest[part] = scaled[:, -1] / scaled[:, 0]
        held = weakest[part] > SINGULAR
        n = values.shape[1]
        turned = np.einsum("rij,ir->rj", left, right[:, part]) / values
        found[:, part] = np.where(held, np.einsum("rjc,rj->cr", across[:, :n], turned), np.nan)
        free[:, :, part] = np.moveaxis(across[:, n:], 0, 2)
    return found, free, weakest


def determined(amount: Any) -> FloatArray:
    """Return a real amount of `Forces._solutions` (1 + surplus, rows) if it is the same in all solutions, else NaN."""
    value: FloatArray = amount[0] if np.ndim(amount) else amount  # a number of a tape is the only one
    if not np.ndim(amount) or len(amount) == 1:
        return value
    return np.where(np.linalg.norm(amount[1:], axis=0) < UNIQUE, value, np.nan)


def shared(force: Any) -> ComplexArray:
    """Return the component of a force that is the same in all solutions if exactly one component is, else NaN (rows,).

    The force is one of `Forces._solutions` (1 + surplus, rows).
    """
    if len(force) == 1:
        return np.full(force[0].shape, np.nan + 1j * np.nan)
    open_ones = np.stack([force[1:].real, force[1:].imag]).transpose(2, 0, 1)  # rows, axis, stress
    axes, parts, _ = np.linalg.svd(open_ones)
    across = axes[:, 0, 1] + 1j * axes[:, 1, 1]
    least = parts[:, 1] if parts.shape[1] > 1 else np.zeros(len(parts))
    one = (least < UNIQUE) & (parts[:, 0] >= UNIQUE)
    return np.where(one, across * (across.conj() * force[0]).real, np.nan + 1j * np.nan)


def joined(x: FloatArray, y: FloatArray) -> ComplexArray:
    """Return x + iy; NaN in x does not make y NaN."""
    if isinstance(x, RuleNumber) or isinstance(y, RuleNumber):
        return x + 1j * y
    force = np.empty(len(x), dtype=complex)
    force.real, force.imag = x, y
    return force
