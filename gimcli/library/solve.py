"""Solve one position."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray

from gimcli import graphs, output
from gimcli.errors import refuse
from gimcli.library.by_name import ByName, angles, coordinates, places
from gimcli.library.inputs import Jit, Method, OneOf, Seed, Strategy, Tolerance, checked, in_file_units, inputs_of
from gimcli.library.record import Records, RowField, VectorField, quantity_rows
from gimcli.library.result import Result
from gimcli.mechanism import Mechanism
from gimcli.motion.solve import solve as solve_position
from gimcli.positions.options import Options
from gimcli.positions.position import Position
from gimcli.rounding import greatest, titled
from gimcli.structure.drive_check import require_consistent
from gimcli.table import Table, per_second

if TYPE_CHECKING:
    from gimcli.gim.sweeper import ErrorLaw
    from gimcli.quantities.state import SeparateState
    from gimcli.rates.derivatives import Instant


STARTS = ("drawn", "random")

EXACT = 1e-9
"""Largest length error of a position, relative to the size, that is written into a model file."""


@checked
def solve(
    mechanism: Mechanism, at: Mapping[str, Any] | None = None, *, method: Method = "auto",
    strategy: Strategy = "spectral", tolerance: Tolerance = 1e-10, start: Annotated[str, OneOf(STARTS)] = "drawn",
    seed: Seed = 0, history: bool = False, velocities: bool = False, measure: str | Sequence[str] = (),
    jit: Jit = "auto", sequence: str = "", **inputs: Any,
) -> Any:  # fmt: skip
    """Solve one position, for example `solve(m, motor=45)`, or one for each value of arrays of inputs.

    Args:
        mechanism: from `load` or `loads`.
        at: dict of inputs by name, for names that are not Python names or are names of arguments.
        method: "auto", "newton" or "gim" (geometric iteration only).
        strategy: the sequence of method "gim", "spectral" or "classic"; see `sequence`.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        start: where the iteration starts: "drawn" (the coordinates of the file) or "random".
        seed: seed of a random start.
        history: keep the error after every sweep (only with method "gim").
        velocities: add velocities and accelerations; of members the angular ones, all at the input rates of the laws.
        measure: quantities of the report, of arrays in the columns; a text or a list, such as "rod.omega" or "|A.f|".
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        sequence: with method "gim": the moves of one sweep, such as "A>B O4>B": FROM>TO imposes a distance,
            ARM^VERTEX>TO an angle. By default the best sequence is searched.
        inputs: inputs by name, in the file's units, or arrays (rows,) of them. Inputs that are not given have the value
            at the start of their law.

    Returns:
        A SolveResult; `.status` is "ok" if the position is solved, otherwise coordinates and angles are NaN; of several
        machines those of machines that are not solved. With arrays a SolvedPositions: `.status`, `.xy[name]` (rows, 2),
        `.angle[member]` and all columns have one row for each value; each is solved by itself, by method "auto".

    Raises:
        UsageError: an unknown name or an invalid argument.
        StructureError: the mechanism is not fully driven, over-driven or contradictory.
    """
    refuse((history and method != "gim", "history: the error after every sweep needs method gim"))
    extras = None
    if measure:
        extras = graphs.extras.Extras(mechanism, measure)
    given = {**(at if isinstance(at, Mapping) else {}), **inputs}
    if any(np.ndim(value) for value in given.values()):
        other = (method, start, history, velocities, sequence) != ("auto", "drawn", False, False, "")
        refuse((other, "arrays of inputs are solved by method auto: remove method, start, history, velocities"))
        from gimcli.library.solved_positions import solved_positions

        return solved_positions(mechanism, given, tolerance, measure)
    chosen = Options(method, strategy, tolerance, jit, seed=seed if start == "random" else None, moves=sequence)
    values = inputs_of(mechanism, at, inputs)
    position = solve_position(mechanism, values, chosen, history)
    if start == "drawn":
        require_consistent(mechanism, position.z, position.inputs, position.status, tolerance)
    law = moving = None
    if history:
        from gimcli.gim.sweeper import fit_history

        law = fit_history(position)
    if velocities and position.status.solved:
        from gimcli.rates.derivatives import instant

        moving = instant(mechanism, position.inputs, position.z)
    return SolveResult(position, law, moving, extras)


class SolveResult(Result):
    """A position: `status`, `xy[name]` (2,) of nodes and points, `angle[member]`, `inputs`, `residual`.

    `report()` also has velocities and accelerations if they were requested.
    """

    KIND = "solve"

    def __init__(
        self, position: Position, law: ErrorLaw | None, moving: Instant | None, extras: graphs.extras.Extras | None
    ) -> None:
        self.mechanism, self._found, self._law, self._moving = position.mechanism, position, law, moving
        self.status, self.inputs = position.status.word, in_file_units(position.mechanism, position.inputs)
        self.residual = float(position.residual.total[0])  # largest error of a constraint, relative to the size
        self._measured = extras.beside(self._state, ()) if extras is not None and extras.wanted else []

    @property
    def answered(self) -> bool:
        """Whether the position was found, and its velocities if they were requested."""
        return self._found.status.solved and not (self._moving is not None and self._moving.singular)

    @cached_property
    def reason(self) -> str:
        """Why the position is not solved, with numbers where it cannot be assembled, or is tangent; else ""."""
        found, options = self._found, self._found.options
        if not found.status.value:
            return ""
        from gimcli.motion.unassembled import reason

        tried = ("random",) if options is not None and options.seed is not None else ()
        return reason(self.mechanism, found.status, found.inputs, tried, options)

    @cached_property
    def xy(self) -> ByName:
        """Coordinates (2,) of nodes and points in the file's length unit; NaN if the position is not solved."""
        return places(self.mechanism, self._z, lambda z: np.array([z[0].real, z[0].imag]))

    @cached_property
    def angle(self) -> ByName:
        """Directions of the members, from their first node to their second, -180 to 180 degrees in the file's unit.

        NaN if the position is not solved.
        """
        return angles(self.mechanism, self._z, lambda a: float(a[0]))

    @property
    def _z(self) -> Any:
        z = self._found.z if self._found.status.solved else self._found.known
        return np.full((len(self.mechanism.nodes), 1), complex(np.nan, np.nan)) if z is None else z[:, None]

    @cached_property
    def _state(self) -> SeparateState:
        """The position, of which any quantity may be asked by its name, at the rates of the laws there."""
        from gimcli.library.solved_positions import positions_state

        own = self._found
        return positions_state(self.mechanism, own.inputs[:, None], self._z, own.residual.total, [int(own.status)])

    def _asked(self, columns: list[NDArray[Any]]) -> Any:
        """Return the value of a quantity, or the values of several columns (columns,)."""
        values = [float(column[0]) for column in columns]
        return np.array(values) if len(values) > 1 else values[0]

    @cached_property
    def places(self) -> dict[str, complex]:
        """Coordinates of nodes, then of points, as complex numbers; NaN of machines that are not solved."""
        return dict(places(self.mechanism, self._z, lambda z: complex(z[0])))

    @property
    def _points(self) -> dict[str, complex]:
        return {point.name: self.places[point.name] for point in self.mechanism.points}

    @cached_property
    def _records(self) -> Records:
        """The nodes, then the points, one row each: coordinates, velocities and accelerations if asked for."""
        own, names, z = self.mechanism, list(self.places), list(self.places.values())
        return Records(
            RowField("node", names, str, head="node"),
            VectorField("", z, own.length_unit, size=own.size * own.scale),
            RowField("status", [self.status] * len(names), str),
            *(
                VectorField(letter, [self._moving.of_points(order)[name] for name in names],
                            per_second(own.length_unit, order), amount)
                for order, letter, amount in ((1, "v", "speed"), (2, "a", "acceleration")) if self._moving is not None
            ),
        )  # fmt: skip

    @cached_property
    def _members(self) -> Records:
        """The moving members, one row each: direction, angular velocity and acceleration if asked for."""
        unit, moving = self.mechanism.angle_unit, self._moving
        rates = {} if moving is None else {1: moving.of_members(1), 2: moving.of_members(2)}
        return Records(
            RowField("member", list(self.angle), head="member"),
            RowField("angle", list(self.angle.values()), float, unit, head="angle"),
            *(
                RowField(name, list(rates[order].values()), float, per_second(unit, order), head=name,
                         size=greatest(rates[order].values()))
                for order, name in zip(rates, ("omega", "alpha"), strict=False)
            ),
        )  # fmt: skip

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{titled(self.mechanism, self.inputs)}: {self.status}, residual {self.residual:.1e}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        position, law, moving = self._found, self._law, self._moving
        return {
            "status": self.status,
            "residual": self.residual,
            "sweeps": position.sweeps,
            "nodes": coordinates({name: self.places[name] for name in self.mechanism.nodes}),
            "points": coordinates(self._points),
            "angles": {name: a for name, a in self.angle.items() if not math.isnan(a)},
            "inputs": self.inputs,
            **({"worst": position.worst, "reason": self.reason} if position.status.value else {}),
            **({"measures": quantity_rows(self._measured).by("name")} if self._measured else {}),
            **({} if law is None else {
                "history": law.errors.tolist(), "C1": law.c1, "C2": law.c2, "rate": law.rate, "radius": law.radius,
            }),
            **({} if moving is None else velocities_report(moving)),
        }  # fmt: skip

    def table(self) -> Table:
        """Return one row for each node, then for each point: node, x, y, status; velocities and accelerations if asked.

        `vx`, `vy` [length/s] and `ax`, `ay` [length/s^2] are NaN where the equations do not determine them.
        """
        return self._records.table()

    def model(self) -> output.model.ModelText | None:
        """Return the text of the model file with the coordinates of this position; None if it is not solved.

        Raises UsageError if the mechanism was not read from a file, or if other coordinates would change a dimension.
        """
        return self._model if self._found.status.solved else None

    @cached_property
    def _model(self) -> output.model.ModelText:
        from gimcli.library.model_text import model_text

        text = model_text(self.mechanism, self._found.z)
        refuse(
            (
                self.residual > EXACT,
                f"the position has a length error of {self.residual:.1e} of the size; a model file with solved"
                f" coordinates needs {EXACT:.0e} or less: use a smaller tolerance",
            )
        )
        return text

    def picture(self) -> output.picture.Content | None:
        """Return the drawing of the position, or the graph of the errors; None if there is nothing to draw."""
        if self._law is not None:
            errors, fit = self._law.errors.max(axis=1), (self._law.c1, self._law.c2)
            return output.drawing.history_picture(
                errors, fit, f"{self.mechanism.name}: error per sweep", self._law.radius, 0
            )
        if not self._found.status.solved:
            return None
        moving, z = self._moving, self.mechanism.to_file(self._found.z)
        arrows = velocity_arrows(moving, self.places) if moving is not None and not moving.singular else []
        return output.drawing.position_picture(self.mechanism, z, self.mechanism.name, self._points, arrows)

    def geometry(self) -> output.geometry.Geometry | None:
        """Return the position in true size; None if it is not solved."""
        if not self._found.status.solved:
            return None
        found = output.geometry.Geometry(self.mechanism.length_unit)
        found.add_mechanism(self.mechanism, self.mechanism.to_file(self._found.z), self._points)
        return found

    def animation(self) -> output.animation.Animation | None:
        """Return the position as a clip of one row; None if it is not solved."""
        if not self._found.status.solved:
            return None
        return graphs.motion_animation.position_animation(
            self.mechanism, self._found.z, self.inputs, self.places, self._moving
        )


def velocities_report(found: Instant) -> dict[str, Any]:
    """Return velocities and accelerations by name, in the file's units per second."""
    none: tuple[Mapping[str, complex], Mapping[str, float]] = {}, {}
    (velocities, omega), (accelerations, alpha) = (
        none if found.singular else (found.of_points(order), found.of_members(order)) for order in (1, 2)
    )
    return {
        "velocity_status": "singular" if found.singular else "ok", "input_rates": input_rates(found),
        "velocities": coordinates(velocities), "omega": dict(omega),
        "accelerations": coordinates(accelerations), "alpha": dict(alpha),
    }  # fmt: skip


def input_rates(found: Instant) -> dict[str, dict[str, float]]:
    """Return rate, acceleration and time [s] of the inputs; the time is NaN where a unit rate was assumed."""
    mechanism = found.mechanism
    rates, accelerations = (in_file_units(mechanism, v) for v in found.given[1:3])
    return {
        name: {"rate": rates[name], "acceleration": accelerations[name], "time": float(t) * mechanism.duration}
        for name, t in zip(rates, found.time, strict=True)
    }


def velocity_arrows(found: Instant, at: Mapping[str, complex]) -> list[Any]:
    """Return velocities and accelerations as vectors for the picture; `at` are the coordinates where they are drawn."""
    kinds = []
    for order, name in ((1, "velocity"), (2, "acceleration")):
        vectors = found.of_points(order)
        unit = per_second(found.mechanism.length_unit, order)
        kinds.append(output.vectors.Arrows(name, unit, {n: (z, vectors[n]) for n, z in at.items()}))
    return kinds
