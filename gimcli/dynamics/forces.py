"""Inverse dynamics: efforts and reactions for a given motion.

The equations of dynamic equilibrium of all bodies are solved block by block, in the reverse order of formation: first
the reactions of the last group, in the end the efforts of the drivers. With redundant constraints some reactions are
indeterminate; the others are given. Source: Durango, Giraldo, Calle & Mesa 2014, section 2.3 (groups of the second
class); here for any group.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.dynamics.indeterminate_reactions import Amount, joined
from gimcli.dynamics.kinematic_history import Course, Courses, Turns, reading
from gimcli.dynamics.loading import Loading, loading
from gimcli.dynamics.physical import require_action
from gimcli.dynamics.statics import Pin, Statics, statics
from gimcli.kernels.equilibrium import ALONG, COUPLE, KNOWN, TURN, balance_rows
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run

SINGULAR = 1e-10
"""Ratio of least to greatest pivot, or singular value, of a block below which its reactions are undetermined."""

WEAK = 5e-2
"""This ratio below which a dead point or change point is near, where reactions are unbounded."""

AT_ONCE = 4096
"""Rows whose redundant equations are decomposed in one call."""


@dataclass(frozen=True)
class Forces:
    """Efforts and reactions along a motion; NaN where they are undetermined."""

    statics: Statics = field(repr=False)
    course: Course = field(repr=False)
    loads: Loading = field(repr=False)
    unknowns: FloatArray = field(repr=False)  # (unknowns, rows) N; couples in N x length of the normal frame
    free: FloatArray = field(
        repr=False
    )  # (surplus, unknowns, rows) unit self-stresses, possible because of redundant constraints
    weakest: FloatArray = field(repr=False)  # (rows,) ratio of the least to the greatest pivot, or singular value

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.statics.mechanism

    @property
    def good(self) -> NDArray[np.bool_]:
        """Return for every row whether its forces are determined."""
        return np.asarray(np.all(np.isfinite(self.unknowns), axis=0) & np.isfinite(self.loads.support))

    @property
    def bounded(self) -> NDArray[np.bool_]:
        """Return for every row whether it is not near a singular position, where reactions are unbounded."""
        return np.asarray(self.good & (self.weakest >= WEAK))

    def effort(self, actuator: int) -> FloatArray:
        """Return the driving torque [N m] or force [N] of an actuator with its rotor (rows,)."""
        effort = self._unknown(self.statics.efforts[actuator]).real.determined
        effort = effort * (self._metre if self.mechanism.actuators[actuator].rotary else 1.0)
        return effort + self.loads.rotors[actuator] if actuator in self.loads.rotors else effort

    def pin(self, pin: Pin, member: int) -> ComplexArray:
        """Return the force [N] of the pin on a member, x + iy (rows,)."""
        force = self._force(pin, member)
        return joined(force.real.determined, force.imag.determined)

    def pin_shared(self, pin: Pin, member: int) -> ComplexArray:
        """Return the determined component [N] of a pin force if the whole force is indeterminate, else NaN (rows,)."""
        return self._force(pin, member).shared

    def normal(self, pair: str) -> FloatArray:
        """Return the normal force [N] on the sliding node or member, positive to the left of the guide (rows,)."""
        return self._sum([self._unknown(self.statics.normals[k]) for k in self._slides(pair)]).real.determined

    def moment(self, pair: str) -> FloatArray:
        """Return the moment [N m] on the sliding member of a prismatic pair about its first node (rows,)."""
        first, *others = self._slides(pair)
        slides, nodes, normals = self.mechanism.slides, self.course.nodes[0], self.statics.normals
        turns = []
        for k in others:
            arm = nodes[slides[k].node] - nodes[slides[first].node]
            turns.append(self._unknown(normals[k], (arm.conj() * self._direction(normals[k])).imag))
        return self._sum(turns).real.determined * self._metre

    @property
    def shaking_force(self) -> ComplexArray:
        """The force [N] on the frame (rows,), from the momentum of all bodies; it is always determined."""
        return np.asarray(np.where(self.good, self.loads.support, complex(np.nan, np.nan)))

    @property
    def shaking_moment(self) -> FloatArray:
        """The moment [N m] on the frame (rows,) about the first ground node."""
        return np.where(self.good, self.loads.support_moment * self._metre, np.nan)

    @property
    def drive_power(self) -> FloatArray:
        """The power [W] of all actuators (rows,)."""
        total = np.zeros(len(self.course.time))
        for k, actuator in enumerate(self.mechanism.actuators):
            _, rate, _ = reading(self.mechanism, actuator, self.course)
            total += self.effort(k) * rate * (1.0 if actuator.rotary else self._metre)
        return total

    @property
    def power_error(self) -> FloatArray:
        """Power of all forces minus the rate of the kinetic energy [W] (rows,): 0 except for rounding."""
        applied = np.sum(list(self.loads.power.values()), axis=0)
        return np.asarray(self.drive_power + applied - self.loads.kinetic_rate)

    @property
    def _metre(self) -> float:
        return require_action(self.mechanism)

    def _unknown(self, unknown: int, factor: Any = 1.0) -> Amount:
        """Return an unknown times a factor or a direction (rows,)."""
        return Amount(factor * self.unknowns[unknown], factor * self.free[:, unknown])

    def _sum(self, amounts: list[Amount]) -> Amount:
        rows = len(self.course.time)
        zero = Amount(np.zeros(rows, dtype=complex), np.zeros((len(self.free), rows), dtype=complex))
        return sum(amounts, zero)

    def _force(self, pin: Pin, member: int) -> Amount:
        """Return the force [N] of the pin on a member."""
        k = pin.members.index(member)
        if k:
            first = pin.first + 2 * (k - 1)
            return self._unknown(first) + self._unknown(first + 1, 1j)
        others = self._sum([self._force(pin, m) for m in pin.members[1:]])
        return self._attached(pin.node) - others

    def _slides(self, pair: str) -> list[int]:
        return [k for k, s in enumerate(self.mechanism.slides) if s.pair == pair]

    def _direction(self, unknown: int) -> ComplexArray:
        return np.asarray(directions(self.statics, self.course.nodes[0])[unknown])

    def _attached(self, node: int) -> Amount:
        """Return the sum of the forces of springs, sliding pairs and actuators on the pin of a node."""
        acting = []
        for unknown in self.statics.on_pins:
            reaction = self.statics.reactions[unknown]
            pulls = reaction.kind == ALONG and reaction.other == node
            if reaction.node == node or pulls:
                acting.append(self._unknown(unknown, (-1.0 if pulls else 1.0) * self._direction(unknown)))
        total = self._sum(acting)
        return Amount(total.value + self.loads.pins.get(node, 0.0), total.free)


def inverse_dynamics(
    statics: Statics, course: Course, run: Run = plain, turns: Turns | None = None, every: bool = False
) -> Forces:
    """Return the efforts and reactions of a motion.

    With `every`, indeterminate reactions have the values of the least-norm solution instead of NaN.
    """
    loads = loading(statics, course, turns)
    right = np.zeros((statics.equations, len(course.time)))
    for k, (body, first) in enumerate(zip(statics.bodies, statics.first_row, strict=True)):
        force = loads.inertia_force[k] - loads.force[k]
        right[first], right[first + 1] = force.real, force.imag
        if body.member >= 0:
            right[first + 2] = loads.inertia_moment[k] - loads.moment[k]
    z = course.nodes[0]
    with np.errstate(all="ignore"):  # singular rows become NaN
        if statics.surplus:
            found, free, weakest = _least(statics, z, right)
        else:
            found, weakest = Balance(statics).solve(z, right, run)
            free = np.zeros((0, *found.shape))
    found = np.where(np.isfinite(found), found, np.nan)
    return Forces(statics, course, loads, found, free * (not every), weakest)


def motion_forces(motion: Motion, run: Run = plain) -> Forces:
    """Return the efforts and reactions of a motion along its laws."""
    return inverse_dynamics(statics(motion.mechanism), Courses(motion.mechanism)(motion), run)


def directions(statics: Statics, z: ComplexArray) -> ComplexArray:
    """Return the direction of every unknown (unknowns, rows) at positions z (nodes, rows)."""
    result = np.empty((len(statics.reactions), z.shape[1]), dtype=complex)
    for k, reaction in enumerate(statics.reactions):
        vector = reaction.vector
        result[k] = vector.z * (z[vector.v] - z[vector.u] if vector.u >= 0 else 1.0)
        if reaction.kind == ALONG:
            result[k] /= np.abs(result[k])
    return result


class Balance:
    """The equations of equilibrium in the arrays of the kernel."""

    def __init__(self, statics: Statics) -> None:
        self.statics = statics
        reactions = statics.reactions
        turned = [(c, r.vector.u, r.vector.v, r.kind == ALONG) for c, r in enumerate(reactions) if r.vector.u >= 0]
        self.turned = np.array(turned, dtype=np.int64).reshape(-1, 4)
        self.vectors = np.array([(r.vector.z.real, r.vector.z.imag) for r in reactions]).reshape(-1, 2)
        blocks = statics.blocks
        self.own_rows = np.array([row for block in blocks for row in block.rows], dtype=np.int64)
        self.own_columns = np.array([column for block in blocks for column in block.columns], dtype=np.int64)
        terms, ends = self._terms()
        self.terms = np.array(terms, dtype=np.int64).reshape(-1, 7)
        self.blocks = np.array(ends, dtype=np.int64).reshape(-1, 3)

    def _terms(self) -> tuple[list[tuple[int, ...]], list[tuple[int, int, int]]]:
        statics = self.statics
        block_of = {row: (g, i) for g, block in enumerate(statics.blocks) for i, row in enumerate(block.rows)}
        own = {column: (g, j) for g, block in enumerate(statics.blocks) for j, column in enumerate(block.columns)}
        by_block: list[list[tuple[int, ...]]] = [[] for _ in statics.blocks]
        for c, reaction in enumerate(statics.reactions):
            for body, sense, node in statics.senses(reaction):
                for axis in statics.axes(reaction, body, node):
                    g, i = block_of[statics.first_row[body] + axis]
                    j = own[c][1] if own[c][0] == g else KNOWN
                    kind = TURN if reaction.kind == COUPLE else axis
                    by_block[g].append((i, j, c, kind, sense, node, statics.bodies[body].node))
        terms: list[tuple[int, ...]] = []
        ends = []
        for block, own_terms in zip(statics.blocks, by_block, strict=True):
            ends.append((len(block.rows), len(terms), len(terms) + len(own_terms)))
            terms += own_terms
        return terms, ends

    def solve(self, z: ComplexArray, right: FloatArray, run: Run) -> tuple[FloatArray, FloatArray]:
        """Return the unknowns (unknowns, rows), and the least ratio of pivots in the blocks of each row (rows,)."""
        count, widest = len(self.statics.reactions), int(max(self.blocks[:, 0], default=0))
        out, weakest = np.full((count, z.shape[1]), np.nan), np.zeros(z.shape[1])
        x, y = np.ascontiguousarray(z.real), np.ascontiguousarray(z.imag)
        run(balance_rows)(
            x, y, self.vectors, self.turned, self.terms, self.blocks, self.own_rows, self.own_columns, right, SINGULAR,
            np.zeros((widest, widest)), np.zeros(2 * widest), np.zeros(widest), self.vectors.copy(), out, weakest,
        )  # fmt: skip
        return out, weakest


def equilibrium(statics: Statics, z: ComplexArray) -> FloatArray:
    """Return the equations of equilibrium (rows, equations, unknowns) at positions z (nodes, rows)."""
    table = np.zeros((z.shape[1], statics.equations, len(statics.reactions)))
    unit = directions(statics, z)
    for c, reaction in enumerate(statics.reactions):
        for body, sense, node in statics.senses(reaction):
            arm = z[node] - z[statics.bodies[body].node]
            parts = (unit[c].real, unit[c].imag, (arm.conj() * unit[c]).imag)
            for axis in statics.axes(reaction, body, node):
                part = 1.0 if reaction.kind == COUPLE else parts[axis]
                table[:, statics.first_row[body] + axis, c] += sense * part
    return table


def _least(statics: Statics, z: ComplexArray, right: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the least-norm reactions, the unit self-stresses, and the ratio of least to greatest singular value."""
    count, rows, weakest = len(statics.reactions), z.shape[1], np.zeros(z.shape[1])
    found, free = np.full((count, rows), np.nan), np.zeros((statics.surplus, count, rows))
    good = np.flatnonzero(np.all(np.isfinite(right), axis=0) & np.all(np.isfinite(z), axis=0))
    for start in range(0, len(good), AT_ONCE):
        part = good[start : start + AT_ONCE]
        left, values, across = np.linalg.svd(equilibrium(statics, z[:, part]))
        weakest[part] = values[:, -1] / values[:, 0]
        held = weakest[part] > SINGULAR
        n = values.shape[1]
        turned = np.einsum("rij,ir->rj", left, right[:, part]) / values
        found[:, part] = np.where(held, np.einsum("rjc,rj->cr", across[:, :n], turned), np.nan)
        free[:, :, part] = np.moveaxis(across[:, n:], 0, 2)
    return found, free, weakest
