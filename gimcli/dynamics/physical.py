"""Requirements of dynamics on the model file, physical units of inputs, and shares of their efforts."""

from __future__ import annotations

import numpy as np

from gimcli.errors import ModelError
from gimcli.mechanism import FRAME, FloatArray, Mechanism

SHOWN = 8
"""Most members that a message names."""


def require_action(mechanism: Mechanism) -> float:
    """Return m per unit of the normal frame.

    Raises ModelError if no masses, loads or springs are defined, or the unit of length is not physical.
    """
    if mechanism.dynamics.empty:
        raise _no_masses(mechanism, "masses, loads or springs")
    return _metre(mechanism)


def require_masses(mechanism: Mechanism) -> float:
    """Return m per unit of the normal frame.

    Raises ModelError if no masses are defined, or the unit of length is not physical.
    """
    moved = any(part.mass > 0.0 or part.moment > 0.0 for part in mechanism.dynamics.inertias)
    if not moved and not any(rotor.inertia > 0.0 for rotor in mechanism.dynamics.rotors):
        raise _no_masses(mechanism, "masses")
    return _metre(mechanism)


def input_units(mechanism: Mechanism) -> FloatArray:
    """Return one unit of each input (actuators,) in rad or m."""
    metre = mechanism.dynamics.metre or 1.0
    return np.array([1.0 if actuator.rotary else metre for actuator in mechanism.actuators])


def effort_shares(mechanism: Mechanism) -> list[tuple[int, int, float]]:
    """Return inputs that others follow without gears, the followers, and the shares of their efforts [N m or N]."""
    units = input_units(mechanism).tolist()
    return [
        (leader, coupling.follower, ratio * units[coupling.follower] / units[leader])
        for coupling in mechanism.couplings if not coupling.geared for leader, ratio in coupling.terms
    ]  # fmt: skip


def _metre(mechanism: Mechanism) -> float:
    if mechanism.dynamics.metre is None:
        raise ModelError(
            [f"{mechanism.name}: the unit of length is not physical; set m, mm, cm, um, km, in or ft, for example\n"
             "units: {length: m}"]
        )  # fmt: skip
    return mechanism.dynamics.metre


def _no_masses(mechanism: Mechanism, missing: str) -> ModelError:
    """Return the error, with lines that can be copied to the model file."""
    names = [member.name for member in mechanism.members[FRAME + 1 :]][:SHOWN]
    lines = [f"  {_quoted(name)}: {{mass: 1, inertia: 0.1}}" for name in names]
    text = f"{mechanism.name}: no {missing} defined; add the masses of the members to the model file, for example"
    return ModelError(["\n".join([text, "masses:", *lines])])


def _quoted(name: str) -> str:
    """Return a name as a YAML key."""
    return name if name.isidentifier() else "'" + name.replace("'", "''") + "'"
