"""Inverse dynamics with dry (Coulomb) friction: exact for the given motion, whose velocities give the directions.

The friction of each pair is phi(x) = max |w . x| over one or two complex vectors w, x being the unknown reactions:

    pin            moment rho |R|                          w = rho on the x force, i rho on the y force
    pin in a slot  force mu |N|                            w = mu
    guide          force mu max(|N|, 2 |M| / length)       w = mu (1, 1); w = mu (distance of nodes / length) (-1, 1)

rho = r mu / sqrt(1 + mu^2) is the radius of the friction circle. The guide has two contacts at +-length/2 from the
middle of the two nodes: N1 + N2 = N and (N2 - N1) length/2 = M, M about the middle, so |N1| + |N2| is the maximum.
Always phi(a + b) <= phi(a) + phi(b). Moments are in N times the length unit of the normal frame.

The equations of equilibrium are linear in the reactions but for the friction of each pair, a moment or a force in
proportion to the magnitude of the reaction of that pair. They are solved row by row; the residual of the equations with
friction is checked in the end. A pair that does not slide has any friction up to its limit: both directions are then
solved, and the forces on which they agree are given.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from gimcli.calculus.numbers import nominal
from gimcli.dynamics.coulomb_solver import FrictionStatus, FrictionSystem, solve_friction
from gimcli.dynamics.equilibrium_equations import coefficients, equilibrium, right_side, solved
from gimcli.dynamics.kinematic_history import Course, Turns, reading
from gimcli.dynamics.load_arrays import FrictionPair, friction_pairs
from gimcli.dynamics.loading import Loading
from gimcli.dynamics.physical import effort_shares, input_units, require_action
from gimcli.dynamics.statics import Statics, direction
from gimcli.errors import ModelError
from gimcli.mechanism import BoolArray, ComplexArray, FloatArray, IntArray
from gimcli.positions.newton import Run

FORMS = 2
"""Most vectors w of a pair."""


def form_table(statics: Statics, pairs: Sequence[FrictionPair], unknowns: int) -> ComplexArray:
    """Return the vectors w of all pairs (FORMS, pairs, unknowns); 0 where a pair has only one."""
    table = np.zeros((FORMS, len(pairs), unknowns), dtype=complex)
    for k, pair in enumerate(pairs):
        for g, form in enumerate(pair.forms(statics)):
            for unknown, weight in form.items():
                table[g, k, unknown] = weight
    return table


AT_REST = 1e-9
"""Speed of sliding below which a pair does not slide, relative to the greatest speed of all pairs in the row."""
AGREE = 1e-9
"""Difference between solutions below which a reaction counts as determined, relative to the greatest reaction."""
CHECKED = 1e-8
"""Residual of the equations with friction above which a row is not converged, relative to the terms of an equation."""
MOST_AT_REST = 6
"""Most pairs at rest beside sliding ones for which all directions are tried."""
AT_ONCE = 1024
"""Rows whose equations are solved in one call."""


@dataclass(frozen=True)
class DryFriction:
    """What dry friction adds to the forces of a motion."""

    names: tuple[str, ...]  # entries in `friction`, with dry friction
    codes: IntArray = field(repr=False)  # (rows,) FrictionStatus
    powers: FloatArray = field(repr=False)  # (names, rows) W, not positive; NaN where the friction is not determined
    effort: FloatArray = field(repr=False)  # (2, actuators, rows) least and greatest effort over the solutions
    hold: FloatArray = field(repr=False)  # (2, actuators, rows) range of the effort that holds the position at rest
    margin: FloatArray = field(repr=False)  # (rows,) W, least power of the drive that moves either way from rest
    smooth: FloatArray = field(repr=False)  # (rows,) W, power of the drive that moves from rest without friction
    residual: FloatArray = field(repr=False)  # (rows,) of the equations with friction, relative

    @property
    def standstill(self) -> BoolArray:
        """Return for every row whether a pair at rest leaves its forces undetermined."""
        return np.asarray(self.codes == FrictionStatus.STANDSTILL)


def sliding_forces(
    statics: Statics, course: Course, run: Run, turns: Turns | None = None, unit: Callable[[], Course] | None = None
) -> tuple[Loading, FloatArray, FloatArray, DryFriction]:
    """Return the solution of the equations of equilibrium with dry friction.

    It consists of the loads with the friction on pins and its power, the unknowns (unknowns, rows) as in `Forces`, the
    least ratio of pivots of the equations without friction (rows,), and what dry friction adds.

    Args:
        statics: the unknown reactions of the mechanism.
        course: the motion.
        run: runs the kernel of the equations.
        turns: continues the angles of springs from one piece of the motion to the next.
        unit: returns the same positions with velocities of the only input at unit speed, for rows at rest.

    Raises:
        ModelError: redundant constraints leave the reactions undetermined.
    """
    if statics.surplus:
        raise ModelError(
            [f"{statics.mechanism.name}: redundant constraints leave reactions indeterminate, and dry friction depends"
             " on them; remove the redundant constraints (`gim mobility` names them), or `mu` in `friction`"]
        )  # fmt: skip
    still = np.concatenate([course.nodes[:1], np.zeros_like(course.nodes[1:])])
    resting = replace(course, nodes=still, angles=None)
    held = Loading(statics, resting, deepcopy(turns))  # weight, springs and loads at rest
    loads = Loading(statics, course, turns)
    with np.errstate(all="ignore"):  # singular rows become NaN
        right = right_side(statics, loads)
        found, weakest = solved(statics, course.nodes[0], right, run)
        rows = _Rows(statics, course, found, right_side(statics, held) - right, unit)
        unknowns, dry = rows.solved(right, {k: rotor.effort for k, rotor in loads.rotors.items()})
    rub(loads, rows.pairs, rows.senses.T * rows.moving.friction(unknowns.T).T, dry.powers)
    return loads, unknowns, weakest, dry


class _Rows:
    """The equations with friction of all rows, the directions of sliding, and the solutions."""

    def __init__(
        self, statics: Statics, course: Course, known: FloatArray, change: FloatArray,
        unit: Callable[[], Course] | None,
    ) -> None:  # fmt: skip
        """`known` are the reactions without friction, `change` (equations, rows) the right side at rest less that."""
        self.statics, self.course, self.unit = statics, course, unit
        self.pairs = [pair for pair in friction_pairs(statics.mechanism) if pair.friction.mu > 0.0]
        self.forms = form_table(statics, self.pairs, len(statics.reactions))
        self.columns = np.zeros((statics.equations, len(course.time), len(self.pairs)))
        for k, pair in enumerate(self.pairs):
            for row, part in coefficients(statics, pair.reaction(statics), course.nodes[0]):
                self.columns[row, :, k] += part
        self.rates = np.array([pair.rate(statics.mechanism, course) for pair in self.pairs])
        self.senses, self.rest = _senses(self.rates)
        moved, reach = self._reach(known, change)
        self.moving = FrictionSystem(known.T, reach, self.forms)
        self.still = FrictionSystem(known.T + moved, reach, self.forms)

    def _reach(self, known: FloatArray, change: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the reactions to a change of the right side (rows, unknowns), and to unit friction (., ., pairs)."""
        found = np.full((known.shape[1], known.shape[0], len(self.pairs) + 1), np.nan)
        good = np.flatnonzero(np.all(np.isfinite(known), axis=0) & np.all(np.isfinite(self.columns), axis=(0, 2)))
        for start in range(0, len(good), AT_ONCE):
            part = good[start : start + AT_ONCE]
            right = np.concatenate([change[:, part, None], self.columns[:, part]], axis=-1).transpose(1, 0, 2)
            found[part] = np.linalg.solve(equilibrium(self.statics, self.course.nodes[0][:, part]), right)
        return found[..., 0], found[..., 1:]

    def solved(self, right: FloatArray, rotors: dict[int, FloatArray]) -> tuple[FloatArray, DryFriction]:
        """Return the reactions (unknowns, rows), NaN where they are not determined, and what friction adds.

        `rotors` are the efforts (rows,) that the rotors of motors need besides.
        """
        least, greatest, codes = self._ranges(self.moving, [self.senses])
        if self.rest.any():
            start = self._impending()
            for found, own in zip((least, greatest, codes), self._ranges(self.moving, [start, -start]), strict=True):
                found[self.rest] = own[self.rest]
            codes[self.rest] = np.where(np.isfinite(self.moving.known[self.rest, 0]), FrictionStatus.STANDSTILL, 0)
        scale = (
            np.max(np.abs(greatest), axis=1, initial=0.0)[:, None] + np.max(np.abs(least), axis=1, initial=0.0)[:, None]
        )
        same = greatest - least <= AGREE * scale
        codes = np.where((codes == FrictionStatus.STANDSTILL) & np.all(same, axis=1), 0, codes)
        x = np.where(same & (codes <= FrictionStatus.STANDSTILL)[:, None], least, np.nan)
        residual = self._residual(x, right)
        wrong = residual > CHECKED
        x[wrong], codes = np.nan, np.where(wrong, int(FrictionStatus.NOT_CONVERGED), codes)
        hold, margin, smooth = self._holding()
        effort = self._efforts(least, greatest)
        for actuator, own in rotors.items():
            effort[:, actuator] += own
            for leader, follower, share in effort_shares(self.statics.mechanism):
                if follower == actuator:
                    effort[:, leader] += share * own
        dry = DryFriction(
            tuple(dict.fromkeys(pair.friction.name for pair in self.pairs)), codes, self._powers(x),
            effort, hold, margin, smooth, residual,
        )  # fmt: skip
        return np.ascontiguousarray(x.T), dry

    def _ranges(self, system: FrictionSystem, bases: list[FloatArray]) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return least and greatest reactions over some directions of sliding, 0 being both, and the codes (rows,)."""
        shape = system.known.shape
        least, greatest = np.full(shape, np.nan), np.full(shape, np.nan)
        codes = np.zeros(shape[0], dtype=np.int64)
        for senses in bases:
            for open_pairs in np.unique(senses == 0.0, axis=0):
                own = np.flatnonzero(np.all((senses == 0.0) == open_pairs, axis=1))
                tried = list(product((-1.0, 1.0), repeat=int(open_pairs.sum())))
                outcomes = []
                for signs in tried if len(tried) <= 2**MOST_AT_REST else ():
                    chosen = senses[own]
                    chosen[:, open_pairs] = signs
                    low, high, outcome = solve_friction(system.rows(own), chosen)
                    least[own], greatest[own] = np.fmin(least[own], low), np.fmax(greatest[own], high)
                    outcomes.append(outcome)
                if open_pairs.any():
                    outcomes = [np.full(len(own), int(FrictionStatus.STANDSTILL))]
                codes[own] = np.maximum(codes[own], np.max(outcomes, axis=0))
        return least, greatest, np.where(np.isfinite(system.known[:, 0]), codes, 0)

    def _impending(self) -> FloatArray:
        """Return the directions of sliding (rows, pairs) in which the mechanism starts from rest."""
        if self.unit is None:
            return np.zeros_like(self.senses)
        course = self.unit()
        return _senses(np.array([nominal(pair.rate(self.statics.mechanism, course)) for pair in self.pairs]))[0]

    def _holding(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the range of efforts that hold each position at rest, and powers of the drive that move it from rest.

        The powers are the lesser of those forwards and backwards, and the power forwards without friction.
        """
        senses, input_rates = self.senses.copy(), self._input_rates(self.course)
        if self.rest.any():
            senses[self.rest] = self._impending()[self.rest]
            if self.unit is not None:
                input_rates[:, self.rest] = self._input_rates(self.unit())[:, self.rest]
        ends, powers = [], []
        for way in (1.0, -1.0):
            least, greatest, codes = self._ranges(self.still, [way * senses])
            own = self._efforts(least, greatest)
            power = np.sum(np.min(way * own * input_rates, axis=0), axis=0)
            powers.append(np.where(codes == FrictionStatus.NO_SOLUTION, np.inf, power))
            ends.append(own)
        hold = np.array([np.min([end[0] for end in ends], axis=0), np.max([end[1] for end in ends], axis=0)])
        smooth = np.sum(self._efforts(self.still.known, self.still.known)[0] * input_rates, axis=0)
        return hold, np.min(powers, axis=0), smooth

    def _input_rates(self, course: Course) -> FloatArray:
        """Return the speeds of the inputs (actuators, rows) in rad/s or m/s; 0 of those that follow others."""
        mechanism = self.statics.mechanism
        rates = [nominal(reading(mechanism, actuator, course)[1]) for actuator in mechanism.actuators]
        units = input_units(mechanism)
        return np.array([r * units[k] * (k in mechanism.drivers) for k, r in enumerate(rates)])

    def _efforts(self, least: FloatArray, greatest: FloatArray) -> FloatArray:
        """Return the efforts (2, actuators, rows) in N m or N among two sets of reactions (rows, unknowns).

        Those of drivers include what their followers need; without an actuator, as with gears, they are 0.
        """
        mechanism, own = self.statics.mechanism, list(self.statics.efforts)
        units = require_action(mechanism) / input_units(mechanism)
        found = np.array([least[:, own].T, greatest[:, own].T]) * units[:, None]
        found[:, list(mechanism.geared)] = 0.0
        for leader, follower, share in effort_shares(mechanism):
            found[:, leader] += np.sort(share * found[:, follower], axis=0)
        return np.asarray(found)

    def _powers(self, x: FloatArray) -> FloatArray:
        """Return the power of dry friction (names, rows) [W] in each entry of the file."""
        power = -np.abs(self.rates) * self.moving.friction(x).T * require_action(self.statics.mechanism)
        power = np.where(self.senses.T == 0.0, 0.0, power)
        names = dict.fromkeys(pair.friction.name for pair in self.pairs)
        return np.array(
            [sum(p for p, pair in zip(power, self.pairs, strict=True) if pair.friction.name == n) for n in names]
        )

    def _residual(self, x: FloatArray, right: FloatArray) -> FloatArray:
        """Return the error of the equations with friction (rows,), relative to the greatest term; 0 where x is NaN."""
        friction = self.senses * self.moving.friction(x)
        error = np.zeros(len(x))
        sure = np.flatnonzero(np.all(np.isfinite(x), axis=1) & np.all(self.senses != 0.0, axis=1))
        for start in range(0, len(sure), AT_ONCE):
            part = sure[start : start + AT_ONCE]
            table = equilibrium(self.statics, self.course.nodes[0][:, part])
            terms = (
                np.einsum("rij,rj->ri", table, x[part]),
                np.einsum("irk,rk->ri", self.columns[:, part], friction[part]),
            )
            size = np.einsum("rij,rj->ri", np.abs(table), np.abs(x[part])) + np.abs(terms[1]) + np.abs(right[:, part].T)
            whole = np.abs(terms[0] - terms[1] - right[:, part].T)
            error[part] = np.max(whole, axis=1) / np.maximum(np.max(size, axis=1), np.finfo(float).tiny)
        return error


def _senses(rates: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return the directions of sliding (rows, pairs), 0 for a pair at rest, and the rows where all are at rest."""
    size = np.max(np.abs(rates), axis=0)
    rest = size <= AT_REST * np.nanmax(size, initial=0.0)
    senses = np.where(np.abs(rates) > AT_REST * size, np.sign(rates), 0.0)
    return np.where(rest, 0.0, senses).T, rest


def rub(loads: Loading, pairs: Sequence[FrictionPair], friction: FloatArray, powers: FloatArray) -> None:
    """Add friction (pairs, rows) on pins, and its powers [W] (any, rows), to the forces on the bodies."""
    loads.power["friction"] = np.sum(powers, axis=0)
    for pair, own in zip(pairs, friction, strict=True):
        if pair.on_pin:
            node = loads.mechanism.slides[pair.friction.slide].node
            unit = direction(pair.reaction(loads.statics), loads.course.nodes[0])
            loads.pins[node] = loads.pins.get(node, 0.0) - own * unit
