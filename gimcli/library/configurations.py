"""List all configurations at given inputs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from gimcli import graphs, output
from gimcli.assemblies import Configurations, all_configurations, drawn_configuration
from gimcli.library.by_name import coordinates, places
from gimcli.library.inputs import Tolerance, in_file_units, inputs_of
from gimcli.library.machines import for_each_machine
from gimcli.library.record import Records, RowField, VectorField
from gimcli.library.trace_result import Placed
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.progress import WORK, Phases, limited, no_phases
from gimcli.rounding import titled
from gimcli.table import Table

PANELS = 36
"""Largest number of configurations in one picture."""


@for_each_machine()
def configurations(
    mechanism: Mechanism, at: Mapping[str, float | str] | None = None, *, tolerance: Tolerance = 1e-10,
    progress: Phases = no_phases, seconds: float | None = None, **inputs: float,
) -> ConfigurationsResult:  # fmt: skip
    """List all configurations of a mechanism at given inputs, for example `configurations(m, motor=45)`.

    Args:
        mechanism: from `load` or `loads`.
        at: dict of inputs by name, for names that are not Python names or are names of arguments.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        seconds: the search ends after this time with what was found; by default there is a bound on its work only.
        inputs: inputs by name, in the file's units. Inputs that are not given have the value at the start of their law.

    Returns:
        A ConfigurationsResult: each configuration in it is proved to exist; `.complete` is whether the list is proved
        complete. The list is empty if the mechanism cannot be assembled at these inputs.

    Raises:
        UsageError: an unknown name or an invalid argument.
        StructureError: the mechanism is not fully driven, over-driven or contradictory.
    """
    values = inputs_of(mechanism, at, inputs, complete=False)
    with limited(WORK, seconds):
        found = all_configurations(mechanism, values, tolerance, progress("configurations"))
    own = mechanism.written
    undecided = own is not None and (own.model.open.undecided or own.model.open.coupled)
    return ConfigurationsResult(found, None if undecided else drawn_configuration(found))


class ConfigurationsResult(Placed):
    """Configurations: `count`, `xy[name]` (configurations, 2), `angle[member]` (configurations,) and `complete`.

    `drawn` is the index of the configuration that the file's coordinates show, or None. `signs` (configurations,) are
    texts such as "+-": the sides of the dyads, "(2)" the number of a group's solution.
    """

    KIND = "configurations"

    def __init__(self, found: Configurations, drawn: int | None) -> None:
        self.mechanism, self._found, self.drawn, self.limited = found.mechanism, found, drawn, found.limited
        self.count, self.signs = len(found), found.signs
        self.status, self.inputs = np.full(len(found), "ok"), in_file_units(found.mechanism, found.inputs)

    @property
    def answered(self) -> bool:
        """Whether there is at least one configuration."""
        return self.count > 0

    @property
    def complete(self) -> bool:
        """Whether the list is proved complete."""
        return bool(self._found.complete)

    @property
    def _z(self) -> ComplexArray:
        return self._found.z.T

    @cached_property
    def places(self) -> dict[str, Any]:
        """Coordinates of nodes, then of points, as complex numbers (configurations,) in the file's units."""
        return dict(places(self.mechanism, self._found.z.T, lambda z: z))

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{titled(self.mechanism, self.inputs)}: {verdict(self._found)}"

    @cached_property
    def _records(self) -> Records:
        """The configurations, one row each."""
        found, mechanism, numbers = self._found, self.mechanism, range(len(self._found))
        unit, size = mechanism.length_unit, mechanism.size * mechanism.scale
        return Records(
            RowField("number", numbers, int, head="", text=[f"{k + 1}{' *' * (k == self.drawn)}" for k in numbers],
                     key=False),
            RowField("residual", found.residual.tolist(), float, head="residual", text="{:.0e}".format),
            RowField("nodes", [self._at(mechanism.nodes, k) for k in numbers]),
            RowField("points", [self._at([p.name for p in mechanism.points], k) for k in numbers]),
            RowField("assembly", self.signs, head="signs"),
            RowField("radius", found.radius.tolist(), float, head="proved radius",
                     text=[f"{one:.0e}" if math.isfinite(one) else "multiple" for one in found.radius]),
            RowField("drawn", [k == self.drawn for k in numbers]),
            *(VectorField(f"{name}.", z, unit, size=size) for name, z in self.places.items()),
        )  # fmt: skip

    def _at(self, names: Iterable[str], k: int) -> dict[str, list[float]]:
        return coordinates({name: self.places[name][k] for name in names})

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found = self._found
        return {
            "status": self.outcome,
            "complete": found.complete,
            "bound": found.bound,
            "configurations": self._records.report(),
            "level": found.level,
            "verdict": verdict(found),
            "unaccounted": found.missing,
            "groups": [
                {
                    "nodes": list(g.nodes), "loops": g.loops, "bound": g.count, "solved": g.solved, "complex": g.roots,
                    "real": g.real, "infinite": g.infinite, "multiple": g.doubtful, "unaccounted": g.missing,
                    "level": g.level,
                }
                for g in found.groups
            ],
            "surplus": list(found.surplus),
            "inputs": self.inputs,
        }  # fmt: skip

    def table(self) -> Table:
        """Return one row for each node and point of each configuration."""
        count, names = len(self._found), list(self.places)
        z = np.array(list(self.places.values())).T.ravel()
        return Records(
            RowField("configuration", np.repeat(np.arange(1, count + 1), len(names)), int),
            RowField("node", names * count, str),
            VectorField("", z, self.mechanism.length_unit),
            RowField("residual", np.repeat(self._found.residual, len(names)), float),
        ).table()

    @property
    def undrawn(self) -> int:
        """The number of configurations that are not in the picture."""
        return max(0, self.count - PANELS)

    def picture(self) -> output.picture.Content | None:
        """Return the configurations side by side; None if there are none."""
        mechanism, shown = self.mechanism, min(self.count, PANELS)
        if not shown:
            return None
        titles = self.names()[:shown]
        count = f"{self.count} configurations" if self.count > 1 else "one configuration"
        count += f", the first {PANELS}" if self.undrawn else ""
        return output.gallery.gallery_picture(
            mechanism, mechanism.to_file(self._found.z[:shown]), titles, f"{titled(mechanism, self.inputs)}: {count}"
        )

    def animation(self) -> output.animation.Animation | None:
        """Return the configurations, one clip each; None if there are none."""
        if not self.count:
            return None
        notes = [f"assembly {k + 1}" for k in range(self.count)]
        return graphs.motion_animation.configurations_animation(
            self.mechanism, self._found.z, self.inputs, self.places, self.names(), notes, verdict(self._found)
        )

    def names(self) -> list[str]:
        """Return number and signs of each configuration, for pictures."""
        return [
            f"{k + 1}{f': {signs}' if signs not in ('', f'({k + 1})') else ''}{' (initial)' if k == self.drawn else ''}"
            for k, signs in enumerate(self.signs)
        ]


def verdict(found: Configurations) -> str:
    """Return the number of configurations, and whether the list is proved complete, with the reason."""
    spare = f"; checked redundant constraints: {', '.join(found.surplus)}" if found.surplus else ""
    if found.level <= 2 and not len(found) and not spare:
        proof = f"none of {found.bound} complex solutions is real" if found.level == 1 else "no solution is real"
        return f"cannot be assembled at these inputs (proved: {proof})"
    count = f"{len(found)} configuration{'s' * (len(found) != 1)}"
    return f"{count}, {'proved' if found.level <= 2 else 'not proved'} complete: {_reason(found)}{spare}"


def _reason(found: Configurations) -> str:
    """Return why a list is proved complete, or why not."""
    if found.searched == found.level > 1:
        agree = "agree" if found.searched == 3 else "do not agree"
        return f"two searches for the values of the inputs that follow the linkage {agree}"
    unknown = any(g.count is None for g in found.groups)
    if found.level == 1 and found.groups:
        return (
            f"all {found.bound} solutions (real and complex) were found"
            if found.bound > 1
            else "the equations are linear"
        )
    if found.level == 1:
        return "the inputs determine all nodes"
    if found.level == 2:
        return (
            "intervals contain no other real solution"
            if unknown
            else f"the other solutions of {found.bound} are not real, or at infinity"
        )
    if found.level == 3:
        largest = max((g.loops for g in found.groups), default=0)
        return "two independent searches agree, but " + (
            f"the number of solutions of a group with {largest} loops is not known"
            if unknown
            else f"{sum(g.infinite for g in found.groups)} solutions are at infinity for these dimensions"
        )
    return _open(found)


def _open(found: Configurations) -> str:
    """Return the reasons why a list is not proved complete."""
    multiple, free = sum(g.doubtful for g in found.groups), [", ".join(g.nodes) for g in found.groups if g.free]
    if found.limited:
        return "the search ended at its bound on work"
    counts = (
        (found.missing, f"{found.missing} complex solution{'s were' if found.missing != 1 else ' was'} not found"),
        (multiple, f"{multiple} multiple solution{'s' * (multiple != 1)}"),
        (found.unfit, f"{found.unfit} of the solutions violate{'s' * (found.unfit == 1)} a constraint"),
    )
    text = (
        ", ".join(reason for count, reason in counts if count)
        or "some solutions are neither proved real nor proved not real"
    )
    turning = f"; where a dyad is folded, {' and '.join(free)} can rotate freely" if free else ""
    return f"{text} (a singular position, or a motion with constant inputs){turning}"
