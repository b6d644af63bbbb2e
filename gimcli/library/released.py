"""The released inputs of an analysis: those that are free in the file, and those that the user names."""

from __future__ import annotations

from collections.abc import Sequence

from gimcli.errors import UsageError
from gimcli.library.inputs import near, refuse_follower, refuse_unmoved
from gimcli.mechanism import Mechanism


def released_inputs(mechanism: Mechanism, free: str | Sequence[str]) -> tuple[int, ...]:
    """Return the numbers of the released inputs, in the order of the file; inputs that follow others move with them.

    Args:
        mechanism: the mechanism.
        free: names of further inputs that are released, a list or a text with commas.

    Raises:
        UsageError: an unknown name; or several inputs of which none is free in the file or named.
        StructureError: the mechanism has no actuator.
    """
    refuse_unmoved(mechanism, "add an actuator")
    names = [mechanism.actuators[k].name for k in mechanism.drivers]
    wanted = names_of(free)
    for name in wanted:
        if name not in names:
            every = [actuator.name for actuator in mechanism.actuators]
            if name in every:
                refuse_follower(mechanism, every.index(name), f"free {name}", "release")
            raise UsageError(f"free {name}: no actuator '{name}'{near(name, names)}")
    own = {r.actuator for r in mechanism.dynamics.releases if r.free and r.actuator in mechanism.drivers}
    own |= {mechanism.drivers[names.index(name)] for name in wanted}
    if not own and len(names) == 1:
        return mechanism.drivers
    if not own:
        raise UsageError(
            f"{mechanism.name} has {len(names)} inputs and none is free: name those that are released, such as --free"
            f" {names[0]} (the others are held), or write `free: true` at one of {', '.join(names)}"
        )
    return tuple(sorted(own))


def names_of(free: str | Sequence[str]) -> list[str]:
    """Return the names of a list, or of a text with commas."""
    given = [free] if isinstance(free, str) else list(free)
    return [name.strip() for text in given for name in text.split(",") if name.strip()]
