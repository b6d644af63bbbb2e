"""Solve one position."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.library.inputs import in_file_units, inputs_of, refuse_choice, refuse_count
from gimcli.library.places import angles, coordinates, places
from gimcli.library.result import ByName, Result
from gimcli.library.rounding import titled
from gimcli.mechanism import Mechanism
from gimcli.motion.solve import solve as solve_position
from gimcli.positions.options import Options
from gimcli.positions.position import Position
from gimcli.structure.drive_check import explained, refuse_contradiction
from gimcli.table import Column, Table, xy_columns

if TYPE_CHECKING:
    from gimcli.gim.convergence import ErrorLaw
    from gimcli.output.picture import Content
    from gimcli.rates.instant import Instant


STARTS = ("drawn", "random")


def solve(
    mechanism: Mechanism, at: Mapping[str, float | str] | None = None, *, method: str = "auto",
    strategy: str = "spectral", tolerance: float = 1e-10, start: str = "drawn", seed: int = 0, history: bool = False,
    velocities: bool = False, jit: str = "auto", sequence: str = "", **inputs: float,
) -> SolveResult:  # fmt: skip
    """Solve one position: at the start of the laws, or at inputs by name, as in `solve(m, motor=45)`.

    `at` holds inputs whose names are no Python names, or are those of options. `start` is "drawn", or "random" with a
    `seed`; `history` keeps the error of every sweep (method "gim"), `velocities` adds velocities and accelerations.
    A position that was not solved has a status; raises UsageError and StructureError.
    """
    refuse_count("seed", seed, 0, 2**63)
    refuse_choice("start", start, STARTS)
    if history and method != "gim":
        raise UsageError("--history tells the error per sweep: add --method gim")
    chosen = Options.checked(method, strategy, tolerance, jit, sequence, seed if start == "random" else None)
    values = inputs_of(mechanism, {**(at or {}), **inputs}, "--at ")
    with explained(mechanism):
        position = solve_position(mechanism, values, chosen, history)
    if start == "drawn":
        refuse_contradiction(mechanism, position.z, position.inputs, position.status, tolerance)
    law = moving = None
    if history:
        from gimcli.gim.convergence import fit_history

        law = fit_history(position)
    if velocities and not position.status.value:
        from gimcli.rates.instant import instant

        moving = instant(mechanism, position.inputs, position.z)
    return SolveResult(position, law, moving)


class SolveResult(Result):
    """A position: `status`, `xy[name]` (2,) of nodes and points, `angle[member]`, `inputs`, `residual`."""

    KIND = "solve"

    def __init__(self, position: Position, law: ErrorLaw | None, moving: Instant | None) -> None:
        self.mechanism, self.position, self.law, self.moving = position.mechanism, position, law, moving

    @property
    def answered(self) -> bool:
        """Tell whether the position was found, and its velocities where they were asked for."""
        return not self.position.status.value and not (self.moving is not None and self.moving.singular)

    @property
    def status(self) -> str:
        """The status word: "ok" where the position is solved."""
        return self.position.status.word

    @property
    def residual(self) -> float:
        """The greatest error of a constraint, relative to the mechanism's size."""
        return float(self.position.residual.total[0])

    @property
    def inputs(self) -> dict[str, float]:
        """The inputs in the file's units."""
        return in_file_units(self.mechanism, self.position.inputs)

    @cached_property
    def xy(self) -> ByName:
        """Places (2,) of nodes and points in the file's length unit; NaN where nothing was solved."""
        return places(self.mechanism, self._z, lambda z: np.array([z[0].real, z[0].imag]))

    @cached_property
    def angle(self) -> ByName:
        """Directions of the members, from their first node to their second, in the file's angle unit."""
        return angles(self.mechanism, self._z, lambda a: float(a[0]))

    @property
    def _z(self) -> Any:
        bad = bool(self.position.status.value)
        return np.full((len(self.mechanism.nodes), 1), complex(np.nan, np.nan)) if bad else self.position.z[:, None]

    def places(self) -> tuple[dict[str, complex], dict[str, complex]]:
        """Return what was found, solved or not: nodes and points as complex numbers."""
        found = places(self.mechanism, self.position.z[:, None], lambda z: complex(z[0]))
        nodes = {name: found[name] for name in self.mechanism.nodes}
        return nodes, {p.name: found[p.name] for p in self.mechanism.points}

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{titled(self.mechanism, self.inputs)}: {self.status}, residual {self.residual:.1e}"

    def report(self) -> dict[str, Any]:
        """Return what --json prints."""
        position = self.position
        nodes, points = self.places()
        good = position.status.value == 0
        report: dict[str, Any] = {
            "status": position.status.word,
            "residual": self.residual,
            "sweeps": position.sweeps,
            "nodes": coordinates(nodes) if good else {},
            "points": coordinates(points) if good else {},
            "inputs": self.inputs,
        }
        if not good:
            report |= {"worst": position.worst, "reason": position.status.text}
        if self.law is not None:
            law = self.law
            report |= {
                "history": law.errors.tolist(), "C1": law.c1, "C2": law.c2, "rate": law.rate, "radius": law.radius,
            }  # fmt: skip
        return report | (velocities_report(self.moving) if self.moving is not None else {})

    def table(self) -> Table:
        """Return one row a node, then one a point: node, x, y, status."""
        nodes, points = self.places()
        found, unit = nodes | points, self.mechanism.length_unit
        bad = complex(np.nan, np.nan)
        z = np.array(list(found.values()) if not self.position.status.value else [bad] * len(found))
        return Table(
            (
                Column("node", np.array(list(found))), *xy_columns("", z, unit),
                Column("status", np.array([self.status] * len(z))),
            )
        )  # fmt: skip

    def picture(self) -> Content | None:
        """Return the drawing of the position, or of its errors; None where there is nothing to draw."""
        from gimcli.output.drawing import history_picture, position_picture

        if self.law is not None:
            errors, fit = self.law.errors.max(axis=1), (self.law.c1, self.law.c2)
            return history_picture(errors, fit, f"{self.mechanism.name}: error per sweep", self.law.radius, 0)
        if self.position.status.value:
            return None
        nodes, points = self.places()
        moving = self.moving
        arrows = velocity_arrows(moving, nodes | points) if moving is not None and not moving.singular else []
        z = self.mechanism.to_file(self.position.z)
        return position_picture(self.mechanism, z, self.mechanism.name, points, arrows)


def velocities_report(found: Instant) -> dict[str, Any]:
    """Return velocities and accelerations by the user's names, in the file's units per second."""
    report: dict[str, Any] = {
        "velocity_status": "singular" if found.singular else "ok", "input_rates": input_rates(found),
    }  # fmt: skip
    for order, (linear, angular) in enumerate((("velocities", "omega"), ("accelerations", "alpha")), start=1):
        report[linear] = {} if found.singular else coordinates(found.of_points(order))
        report[angular] = {} if found.singular else dict(found.of_members(order))
    return report


def input_rates(found: Instant) -> dict[str, dict[str, float]]:
    """Return rate, acceleration and time [s] of the inputs; NaN as time where a unit rate was taken."""
    mechanism = found.mechanism
    rates, accelerations = (in_file_units(mechanism, v) for v in (found.input_rate, found.input_acceleration))
    return {
        name: {"rate": rates[name], "acceleration": accelerations[name], "time": float(t) * mechanism.duration}
        for name, t in zip(rates, found.time, strict=True)
    }


def velocity_arrows(found: Instant, at: Mapping[str, complex]) -> list[Any]:
    """Return the vectors for the picture."""
    from gimcli.output.vectors import Arrows

    length = "1" if found.mechanism.length_unit == "unit" else found.mechanism.length_unit
    kinds = []
    for order, name, unit in ((1, "velocity", f"{length}/s"), (2, "acceleration", f"{length}/s²")):
        vectors = found.of_points(order)
        kinds.append(Arrows(name, unit, {n: (z, vectors[n]) for n, z in at.items()}))
    return kinds
