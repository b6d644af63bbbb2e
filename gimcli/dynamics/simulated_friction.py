"""Reactions along a simulation with dry friction: the friction of the simulation acts on the bodies as known forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimcli.dynamics.body_balance import BodyBalance
from gimcli.dynamics.equilibrium_equations import directions, equilibrium
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.kinematic_history import Course
from gimcli.dynamics.physical import require_action
from gimcli.dynamics.reducer import free_inputs
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.structure.steps import NONE
from gimcli.table import Column

SOFT = 1e-12
"""Singular values below this fraction of the greatest belong to redundant constraints."""


def with_friction(forces: Forces, friction: FloatArray) -> Forces:
    """Return reactions without dry friction plus those to the friction of a simulation (contacts, rows)."""
    mechanism = forces.mechanism
    balance = BodyBalance(mechanism, free_inputs(mechanism))
    z, good = forces.course.nodes[0], np.flatnonzero(forces.good)
    table = equilibrium(balance.statics, z[:, good])
    right = np.einsum("rik,kr->ri", table[:, :, balance.columns], friction[:, good])
    own = table[:, :, : len(forces.statics.reactions)]  # the other columns are gauges and moments in pins
    unknowns = forces.unknowns.copy()
    unknowns[:, good] += np.einsum("rci,ri->cr", np.linalg.pinv(own, rcond=SOFT), right)
    unit = directions(balance.statics, z)
    for k, column in enumerate(balance.columns):
        if balance.pairs[k].slide != NONE and balance.statics.reactions[balance.contacts.place[k, 2]].on_pin:
            node = int(balance.contacts.place[k, 4])
            forces.loads.pins[node] = forces.loads.pins.get(node, 0.0) - friction[k] * unit[column]
    forces.loads.power["friction"] = np.sum(_powers(balance, forces.course, friction), axis=0)
    return replace(forces, unknowns=unknowns)


def friction_columns(mechanism: Mechanism, course: Course, friction: FloatArray) -> list[Column]:
    """Return the friction of each pair, on the member that turns or slides, and its power; friction (contacts, rows).

    A moment [N m] in a pin, a force [N] along a guide, positive from its first node to its second.
    """
    balance, metre, columns = BodyBalance(mechanism, free_inputs(mechanism)), require_action(mechanism), list[Column]()
    powers: dict[str, FloatArray] = {}
    for k, (pair, power) in enumerate(zip(balance.pairs, _powers(balance, course, friction), strict=True)):
        unit, factor = ("N m", metre) if pair.slide == NONE else ("N", 1.0)
        columns.append(Column(f"{_names(balance)[k]}.friction", -factor * friction[k], unit))
        powers[pair.name] = powers.get(pair.name, 0.0) + power
    return [*columns, *(Column(f"friction.power.{name}", power, "W") for name, power in powers.items())]


def friction_names(mechanism: Mechanism) -> list[str]:
    """Return the names of the columns of friction; no simulation is needed for them."""
    balance = BodyBalance(mechanism, free_inputs(mechanism))
    pairs = dict.fromkeys(pair.name for pair in balance.pairs)
    return [*(f"{name}.friction" for name in _names(balance)), *(f"friction.power.{name}" for name in pairs)]


def _names(balance: BodyBalance) -> list[str]:
    """Return the names of the contacts: of the pair, with the member where several turn on one pin."""
    names, members = [pair.name for pair in balance.pairs], balance.mechanism.members
    several = [names.count(name) > 1 for name in names]
    return [
        f"{pair.name}.{members[pair.member].name}" if more else pair.name
        for pair, more in zip(balance.pairs, several, strict=True)
    ]


def _powers(balance: BodyBalance, course: Course, friction: FloatArray) -> FloatArray:
    """Return the power of the friction [W] (contacts, rows)."""
    speeds = [pair.rate(balance.mechanism, course) for pair in balance.pairs]
    metre = require_action(balance.mechanism)
    return np.asarray(-friction * np.array(speeds).reshape(friction.shape) * metre)
