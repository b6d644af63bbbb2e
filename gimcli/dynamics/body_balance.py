"""The equations of all bodies of a simulation in the arrays of the kernel `gimcli.kernels.body_balance`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gimcli.dynamic_data import NO_NODE, AppliedLoad, Friction, Inertia
from gimcli.dynamics.friction_pairs import FrictionPair, friction_pairs
from gimcli.dynamics.load_arrays import ints, moving_loads, with_force_gauges
from gimcli.dynamics.statics import Statics, statics
from gimcli.kernels.body_balance import GUIDE, PIN, SLOT, BalancedBodies, Contacts
from gimcli.kernels.equilibrium import ALONG
from gimcli.mechanism import ANGLE, FRAME, SPAN, FloatArray, IntArray, Mechanism
from gimcli.structure.polynomials import with_gauges
from gimcli.structure.sliding_pairs import pair_of
from gimcli.structure.steps import NONE

TURNS, TRAVELS, LENGTHS = range(3)
"""Kinds of readings."""


class BodyBalance:
    """The bodies, unknowns and contacts of a mechanism; `free` are its released inputs."""

    def __init__(self, mechanism: Mechanism, free: Sequence[int]) -> None:
        read = with_force_gauges(mechanism)
        every = statics(with_gauges(read))
        self.mechanism, self.first = mechanism, 2 * len(mechanism.nodes)
        couples = [pair.reaction(every) for pair in friction_pairs(read) if pair.slide == NONE]
        self.statics: Statics = replace(every, reactions=(*every.reactions, *couples))
        self.couples = len(every.reactions) + np.arange(len(couples), dtype=np.int64)
        self.readings = np.array(every.efforts, dtype=np.int64)  # columns of actuators and gauges
        known = {*self.readings[list(free)].tolist(), *self.readings[len(mechanism.actuators) :].tolist(), NONE}
        unknown = [c for c in range(len(every.reactions)) if c not in known]
        self.unknown = np.full(len(self.statics.reactions), -1, dtype=np.int64)
        self.unknown[unknown] = np.arange(len(unknown))
        self.unknowns, self.equations = len(unknown), every.equations
        self.pairs: list[FrictionPair] = []  # of the contacts
        self.columns: list[int] = []
        self.contacts = self._contacts()
        self.bodies = self._bodies(read)

    def _bodies(self, read: Mechanism) -> BalancedBodies:
        every = self.statics
        vectors = [reaction.vector for reaction in every.reactions]
        turned = [(c, v.u, v.v, int(every.reactions[c].kind == ALONG)) for c, v in enumerate(vectors) if v.u != NONE]
        contact = np.full(len(vectors), -1, dtype=np.int64)
        contact[self.columns] = np.arange(len(self.columns))
        kinds = {ANGLE: TURNS, SPAN: LENGTHS}
        readings = [kinds.get(i.kind, TRAVELS) for i in (*read.actuators, *read.gauges)]
        inertias = [i for i in self.mechanism.dynamics.inertias if i.member != FRAME]
        terms, factors = self._terms()
        rotors, ratios = self._rotors()
        shares, share = self._shares()
        return BalancedBodies(
            terms, factors, np.array([(v.z.real, v.z.imag) for v in vectors]).reshape(-1, 2), ints(turned, 4),
            self.unknown, contact, self._acted(inertias), self._acted(moving_loads(read)),
            ints(list(zip(self.readings.tolist(), readings, strict=True)), 2), self.couples,
            rotors, ratios, shares, share, self.first,
        )  # fmt: skip

    def _terms(self) -> tuple[IntArray, FloatArray]:
        """Return the entries of the equations, as in `gimcli.dynamics.equilibrium_equations.equilibrium`."""
        every, terms, factors = self.statics, list[tuple[int, ...]](), list[float]()
        for c, reaction in enumerate(every.reactions):
            for body, axis, kind, factor, node in every.entries(reaction):
                terms.append((every.first_row[body] + axis, c, kind, node, every.bodies[body].node))
                factors.append(factor)
        return ints(terms, 5), np.array(factors)

    def _rotors(self) -> tuple[IntArray, FloatArray]:
        """Return number of the rotor and column of each actuator that turns it, and the ratios."""
        rows, ratios = list[tuple[int, int]](), list[float]()
        leaders = {coupling.follower: coupling.terms for coupling in self.mechanism.couplings}
        for k, rotor in enumerate(self.mechanism.dynamics.rotors):
            for actuator, ratio in leaders.get(rotor.actuator, ((rotor.actuator, 1.0),)):
                rows.append((k, int(self.readings[actuator])))
                ratios.append(ratio)
        return ints(rows, 2), np.array(ratios, dtype=float)

    def _shares(self) -> tuple[IntArray, FloatArray]:
        """Return columns of actuators and of their followers without gears, and the ratios."""
        rows, ratios = list[tuple[int, int]](), list[float]()
        for coupling in self.mechanism.couplings:
            if not coupling.geared:
                for actuator, ratio in coupling.terms:
                    rows.append((int(self.readings[actuator]), int(self.readings[coupling.follower])))
                    ratios.append(ratio)
        return ints(rows, 2), np.array(ratios, dtype=float)

    def _acted(self, parts: Sequence[Inertia | AppliedLoad]) -> IntArray:
        """Return first equation, node of reference, and whether there is an equation of moments, of the bodies."""
        every, rows = self.statics, list[tuple[int, int, int]]()
        for part in parts:
            body = every.body_of_pin[part.node] if part.node != NO_NODE else every.body_of_member[part.member]
            if body == NONE:
                rows.append((-1, 0, 0))
            else:
                own = every.bodies[body]
                rows.append((every.first_row[body], own.node, int(own.member != NONE)))
        return ints(rows, 3)

    # -- contacts -------------------------------------------------------------------------------------

    def _contacts(self) -> Contacts:
        """Return the pairs with dry friction: each member on a pin but the first, and the guides."""
        rows, factors, turning, sliding = list[tuple[int, ...]](), list[tuple[float, float]](), 0, 0
        travels = len(self.mechanism.actuators) + len(self.mechanism.gauges)
        pairs = friction_pairs(self.mechanism)
        for pair in pairs:
            if pair.slide == NONE:
                rows.append(self._on_pin(pair, turning))
                factors.append((pair.friction.circle, 0.0))
                self.columns.append(int(self.couples[turning]))
                turning += 1
            else:
                rows.append(self._on_guide(pair.friction, travels + sliding))
                factors.append((pair.friction.mu, pair.friction.length))
                self.columns.append(int(self.readings[travels + sliding]))
                sliding += 1
        dry = [k for k, factor in enumerate(factors) if factor[0] > 0.0]
        self.columns, self.pairs = [self.columns[k] for k in dry], [pairs[k] for k in dry]
        table = ints([rows[k] for k in dry], 8)
        return Contacts(
            table[:, 0].copy(), table[:, 1].copy(), table[:, 2:].copy(),
            np.array([factors[k] for k in dry]).reshape(-1, 2),
        )  # fmt: skip

    def _on_pin(self, pair: FrictionPair, number: int) -> tuple[int, ...]:
        """Return kind, speed, and unknowns, columns and nodes of the force of a pin on a member."""
        x, y = pair.forces(self.statics)
        return (PIN, number, int(self.unknown[x]), int(self.unknown[y]), x, y, pair.friction.node, pair.friction.node)

    def _on_guide(self, friction: Friction, reading: int) -> tuple[int, ...]:
        """Return kind, speed, and unknowns, columns and nodes of the normal forces of a guide."""
        slides = pair_of(self.mechanism, friction.slide).slides
        ends = slides[0], slides[-1]
        columns = [self.statics.normals[k] for k in ends]
        nodes = [self.mechanism.slides[k].node for k in ends]
        kind = GUIDE if len(slides) > 1 and friction.length > 0.0 else SLOT
        return (kind, self.first + reading, *(int(self.unknown[c]) for c in columns), *columns, *nodes)
