"""Choose the configuration in which a mechanism is assembled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.assemblies import Configurations, all_configurations, drawn_configuration
from gimcli.assemblies.assemblies import SAME
from gimcli.canonical import beside
from gimcli.errors import GimError, UnassembledError, UsageError, refuse
from gimcli.library.inputs import Tolerance, checked, inputs_of
from gimcli.library.sides import with_sides_of
from gimcli.mechanism import ComplexArray, FloatArray, Input, Mechanism
from gimcli.motion.side_by_side import whole_inputs, whole_positions
from gimcli.nearest import guess
from gimcli.progress import Phases, no_phases
from gimcli.rounding import titled
from gimcli.structure.carried import measured, read_inputs

LISTED = 16
"""Number of configurations that a message lists."""


@checked
def assembled(
    mechanism: Mechanism, at: Mapping[str, float | str] | None = None, assembly: int | str = "", *,
    tolerance: Tolerance = 1e-10, progress: Phases = no_phases, **inputs: float,
) -> Mechanism:  # fmt: skip
    """Return the mechanism with one of its configurations as the initial one, for example `assembled(m, assembly=2)`.

    All functions then start from this configuration; dimensions and laws are unchanged. The model file is not changed.

    Args:
        mechanism: from `load` or `loads`.
        at: dict of inputs by name, for names that are not Python names or are names of arguments.
        assembly: number of the configuration in the list of `configurations` (from 1), or its signs, such as "+-" or
            "-(2)"; of several independent machines also "MACHINE=2,OTHER=+-" as `configurations` lists them. Without
            names a number or signs count the combinations of all machines.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        inputs: inputs by name, in the file's units, at which the list is made. Inputs that are not given have the value
            at the start of their law.

    Returns:
        The mechanism with other initial coordinates.

    Raises:
        UsageError: there is no such configuration, or an unknown name or an invalid argument.
        UnassembledError: the mechanism cannot be assembled at these inputs.
        StructureError: the mechanism is not fully driven, over-driven or contradictory.
    """
    values = inputs_of(mechanism, at, inputs, complete=False)
    if "=" in str(assembly):
        return _of_machines(mechanism, str(assembly), {**(at or {}), **inputs}, tolerance, progress)
    found = all_configurations(mechanism, values, tolerance, progress("configurations"))
    if not len(found):
        where = titled(mechanism, mechanism.inputs_to_file(values))
        raise UnassembledError(f"{where}: no configuration was found, so that assembly {assembly} does not exist")
    z = found.z[_index(found, assembly)]
    return with_sides_of(drawn_at(mechanism, z, values), mechanism, z)


def _of_machines(
    mechanism: Mechanism, text: str, given: Mapping[str, float | str], tolerance: float, progress: Phases
) -> Mechanism:
    """Return the mechanism with the configurations of some machines, such as "crank=2,rocker=+-"."""
    wanted = {name.strip(): own for name, _, own in (part.partition("=") for part in text.split(","))}
    names = [one.name for one in mechanism.driven_machines]
    refuse(*((n not in names, f"assembly {text}: no machine '{n}'; {guess(n, names, 'machines')}") for n in wanted))
    drawn, inputs = [], mechanism.drawn_inputs
    for one in mechanism.driven_machines:
        own = one.mechanism
        if one.name in wanted:
            at = {a.name: given[a.name] for a in own.actuators if a.name in given}
            own = assembled(own, at, wanted[one.name], tolerance=tolerance, progress=progress)
            inputs[list(one.actuators)] = whole_inputs(mechanism, one, own.drawn_inputs)
        drawn.append(own.drawn)
    z = whole_positions(mechanism, drawn, mechanism.driven_machines)
    return with_sides_of(drawn_at(mechanism, z, inputs), mechanism, z)


def drawn_at(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> Mechanism:
    """Return a mechanism with the initial position z (nodes,) at inputs (actuators,); its dimensions are unchanged."""

    def there(row: Input) -> Input:
        return replace(row, drawn=float(measured(mechanism, row, z)))

    def read(row: Input) -> Input:
        return replace(row, drawn=float(beside(there(row).drawn, row.drawn))) if row.rotary else there(row)

    values = read_inputs(mechanism, z, inputs).tolist()
    actuators = (replace(a, drawn=u) for a, u in zip(mechanism.actuators, values, strict=True))
    couplings = (replace(c, reads=tuple((read(row), ratio) for row, ratio in c.reads)) for c in mechanism.couplings)
    drawn = replace(
        mechanism, drawn=z, actuators=tuple(actuators), gauges=tuple(map(there, mechanism.gauges)),
        couplings=tuple(couplings),
    )  # fmt: skip
    return drawn if drawn.complete is None else drawn.complete(drawn)


@dataclass(frozen=True)
class ListedPosition:
    """A position in the list of all configurations at its inputs."""

    found: Configurations = field(repr=False)
    number: int  # from 1

    @property
    def elsewhere(self) -> bool:
        """Whether `solve` finds another configuration there."""
        return self.number - 1 != drawn_configuration(self.found)


def listed_position(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray) -> ListedPosition | None:
    """Return a position z (nodes,) with its number; None if it is not in the list, such as a limit of an input."""
    with suppress(GimError):  # a mechanism whose configurations cannot be listed
        found = all_configurations(mechanism, inputs)
        far = np.max(mechanism.apart(found.z.T, z[:, None]), axis=0)
        if len(found) and far.min() <= SAME * mechanism.size:
            return ListedPosition(found, int(np.argmin(far)) + 1)
    return None


def _index(found: Configurations, assembly: int | str) -> int:
    """Return the index of a configuration given by its number or its signs."""
    text, signs = str(assembly).strip(), found.signs
    if text.isdecimal() and 1 <= int(text) <= len(found):
        return int(text) - 1
    if text in signs and text:
        return signs.index(text)
    same = [own for own in signs if text and own.startswith(text)]
    refuse((same, f"assembly {text}: is not unique: it begins {_listed(same)}; give all signs, or the number"))
    raise UsageError(f"assembly {text}: expected a number from 1 to {len(found)}, or the signs {_listed(signs)}")


def _listed(signs: Sequence[str]) -> str:
    shown = [own or "(none)" for own in signs[:LISTED]]
    return f"{', '.join(shown)}{', ...' * (len(signs) > LISTED)}"
