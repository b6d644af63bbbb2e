"""Find the mobility of a mechanism, and the Jacobian of its constraints with names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Annotated, Any

import numpy as np

from gimcli.errors import UnassembledError, refuse
from gimcli.library.inputs import OneOf, checked
from gimcli.library.record import Records, RowField, fact
from gimcli.library.result import Result
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.rounding import number
from gimcli.structure.branch_mobility import Branch
from gimcli.structure.constraint_jacobian import RANK, constraint_jacobian, dependent, full_pivoting
from gimcli.structure.mobility import Mobility, assembled, mobility as mobility_at, of_machines
from gimcli.table import Column, Table

NATURAL = "natural"
COORDINATES = ("joint", "absolute", NATURAL)

SHOWN = (
    "gruebler", "rank", "mobility", "redundant", "instead", "actuators", "coupled", "undriven", "overdriven", "branch",
)  # fmt: skip
"""Facts of the table and the terminal, in their order."""

REGULAR = "regular"
"""The kind of an initial configuration that is not singular."""


@checked
def mobility(mechanism: Mechanism, *, coordinates: Annotated[str, OneOf(COORDINATES)] = NATURAL) -> MobilityResult:
    """Find mobility, redundant constraints and undriven nodes at the assembled position nearest to the drawn one.

    Args:
        mechanism: from `load` or `loads`.
        coordinates: of `.jacobian`: "joint", "absolute" or "natural".

    Returns:
        A MobilityResult: `.mobility`, `.status`, `report()` with Grübler's count, the rank and the names, and
        `.jacobian` with names of rows and columns, values and ranks, computed when it is asked for.

    Raises:
        UsageError: unknown coordinates.
        UnassembledError: no assembled position was found near the drawn one.
    """
    parts = {one.name: MobilityResult(mechanism, *_of_machine(mechanism, one.mechanism)) for one in mechanism.machines}
    start = next((part.start for part in parts.values() if part.start != REGULAR), REGULAR)
    return MobilityResult(mechanism, of_machines([part._found for part in parts.values()]), start, parts, coordinates)


def _of_machine(whole: Mechanism, mechanism: Mechanism) -> tuple[Mobility, str]:
    """Return the mobility of a machine, and what its initial configuration is."""
    z = assembled(mechanism)
    if z is None:
        raise UnassembledError(
            f"{whole.name} cannot be assembled near its initial configuration: correct the coordinates or lengths;"
            " `gim solve` reports the constraint with the largest error"
        )
    found = mobility_at(mechanism, z)
    if not found.stuck:
        return found, REGULAR
    from gimcli.branching.singularities import SINGULAR, singular_start

    return found, SINGULAR if found.undriven else singular_start(mechanism, z)


class MobilityResult(Result):
    """Mobility, Grübler's count, rank, and the names of redundant constraints, undriven nodes and surplus actuators.

    `mobility` is the number of freedoms: confirmed by the rank at neighbouring positions where it is singular.
    """

    KIND = "mobility"

    def __init__(
        self, mechanism: Mechanism, found: Mobility, start: str, each: Mapping[str, MobilityResult] | None = None,
        coordinates: str = NATURAL,
    ) -> None:  # fmt: skip
        self.mechanism, self._found, self.mobility, self.each = mechanism, found, found.mobility, each or {}
        self.status = self.start = start  # the kind of the drawn position: "regular", or that of a singular position
        self.coordinates, self.shows_jacobian = coordinates, False  # whether report and table are those of the matrix

    @cached_property
    def jacobian(self) -> JacobianMatrix:
        """The Jacobian of the constraints."""
        return jacobian_matrix(self.mechanism, self.coordinates)

    def headline(self) -> str:
        """Return the result in one line."""
        found = self._found
        return f"{self.mechanism.name}: mobility {found.mobility}, Grübler's count {found.gruebler}, rank {found.rank}"

    @cached_property
    def _records(self) -> Records:
        """What is known of the mechanism, as a single row."""
        found, branches = self._found, self._found.branches
        choices = list(zip(found.redundant, found.alternatives, strict=True))
        choice = " (one of several choices)" * any(found.alternatives)
        followers = [self.mechanism.actuators[coupling.follower].name for coupling in self.mechanism.couplings]
        return Records(
            fact("gruebler", found.gruebler, head="Grübler's count"),
            fact("rank", found.rank, head="rank of the constraint Jacobian"),
            fact("mobility", found.mobility, head="mobility"),
            fact("redundant", list(found.redundant), _names(found.redundant) + choice, head="redundant constraints"),
            fact("undriven", list(found.undriven), _names(found.undriven), head="undriven nodes"),
            fact("actuators", len(found.actuators), _names(found.actuators), head="actuators"),
            fact("start", self.start),
            fact("overdriven", list(found.overdriven), _names(found.overdriven), head="over-driven by"),
            fact("apparent", found.apparent),
            fact("singular", found.singular),
            fact("branches", [{"mobility": one.mobility, "undriven": list(one.undriven),
                               "over_driven": list(one.overdriven)} for one in branches]),
            fact("alternatives", [{"constraint": name, "instead": list(own)} for name, own in choices]),
            *(fact("instead", own, ", ".join(own), head=f"instead of {name}", key=False) for name, own in choices),
            fact("coupled", followers, ", ".join(followers), head="coupled to them" if followers else None, key=False),
            *(fact("branch", one, _text(one), head=f"branch {k}", key=False)
              for k, one in enumerate(branches, 1) if len(branches) > 1),
        )  # fmt: skip

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints; of several independent machines also that of each."""
        shown = {"jacobian": self.jacobian._records.entry()} if self.shows_jacobian else {}
        parts = [{"name": name, **one.report()} for name, one in self.each.items()]
        return self._records.entry() | shown | ({"machines": parts} if len(parts) > 1 else {})

    def table(self) -> Table:
        """Return the quantities and their values as text, or the Jacobian if it is shown."""
        if self.shows_jacobian:
            return self.jacobian._equations.table()
        columns = zip(("quantity", "value"), zip(*self._records.pairs(*SHOWN), strict=True), strict=True)
        return Table(tuple(Column(name, np.array(texts)) for name, texts in columns))


def _names(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"


def _text(branch: Branch) -> str:
    """Return what moves on a branch, and what its actuators do."""
    undriven = f"; undriven nodes: {', '.join(branch.undriven)}" if branch.undriven else ""
    return f"mobility {branch.mobility}{undriven}" + (
        f"; over-driven by {', '.join(branch.overdriven)}" if branch.overdriven else ""
    )


@dataclass(frozen=True)
class JacobianMatrix:
    """Gradients of the constraint equations at the assembled position nearest to the drawn one."""

    coordinates: str  # joint, absolute or natural
    rows: tuple[str, ...]  # equations
    columns: tuple[tuple[str, str], ...]  # coordinates and their units
    values: FloatArray  # (rows, columns) file's unit of length, rad
    size: float = 1.0  # reference length of the machine, file's unit: 1 rad counts as much as this length

    @property
    def scaled(self) -> FloatArray:
        """The rows scaled to length 1, angles by the size, so that no unit matters; rows of 0 are unchanged."""
        table = self.values / np.array([self.size if unit == "rad" else 1.0 for _, unit in self.columns])
        norm = np.linalg.norm(table, axis=1, keepdims=True)
        return np.asarray(table / np.where(norm > 0.0, norm, 1.0))

    @property
    def rank(self) -> int:
        """The rank by elimination with full pivoting."""
        return full_pivoting(self.scaled)[0] if self.values.size else 0

    @property
    def singular_values(self) -> FloatArray:
        """The singular values of the scaled rows, the greatest first."""
        return np.asarray(np.linalg.svd(self.scaled, compute_uv=False)) if self.values.size else np.zeros(0)

    @property
    def rank_by_singular_values(self) -> int:
        """The number of singular values that are not 0, relative to the greatest."""
        values = self.singular_values
        return int(np.sum(values > RANK * values.max(initial=0.0)))

    @property
    def dependent(self) -> dict[str, list[str]]:
        """The equations without a pivot, each with the others that could take its place."""
        return {self.rows[k]: [self.rows[j] for j in others] for k, others in dependent(self.scaled).items()}

    @property
    def _records(self) -> Records:
        """The matrix and its ranks, as a single row."""
        return Records(
            fact("coordinates", self.coordinates),
            fact("rows", list(self.rows)),
            fact("columns", [name for name, _ in self.columns]),
            fact("units", [unit for _, unit in self.columns]),
            fact("values", self.values.tolist()),
            fact("rank", self.rank),
            fact("rank_by_singular_values", self.rank_by_singular_values),
            fact("singular_values", self.singular_values.tolist()),
            fact("dependent", [{"equation": name, "instead": own} for name, own in self.dependent.items()]),
        )

    @property
    def _equations(self) -> Records:
        """The equations, one row each, with their derivatives."""
        return Records(
            RowField("equation", self.rows, str, head="equation"),
            *(RowField(name, column, float, unit, head=f"{name} [{unit}]", text=partial(number, size=1.0))
              for (name, unit), column in zip(self.columns, self.values.T, strict=True)),
        )  # fmt: skip


def jacobian_matrix(mechanism: Mechanism, coordinates: str = NATURAL) -> JacobianMatrix:
    """Return the Jacobian of the constraints in one kind of coordinates.

    Raises:
        UsageError: unknown coordinates, or inputs that follow others, which only natural coordinates have.
        UnassembledError: no assembled position was found near the drawn one.
    """
    OneOf(COORDINATES).refuse("coordinates", coordinates)
    names = ", ".join(mechanism.actuators[coupling.follower].name for coupling in mechanism.couplings)
    refuse(
        (
            coordinates != NATURAL and names,
            f"coordinates: {names} follow other inputs; only natural coordinates have such equations",
        )
    )
    z = assembled(mechanism)
    if z is None:
        raise UnassembledError(f"{mechanism.name} cannot be assembled near its initial configuration")
    length = mechanism.length_unit
    if coordinates == NATURAL:
        own = constraint_jacobian(mechanism)
        columns = tuple((f"{mechanism.nodes[n]}.{axis}", length) for n in own.free for axis in "xy")
        return JacobianMatrix(coordinates, tuple(own.names), columns, own.slopes(z))
    from gimcli.comparison.bodies import AbsoluteCoordinates
    from gimcli.comparison.coordinates import JointCoordinates

    kind = JointCoordinates if coordinates == "joint" else AbsoluteCoordinates
    system = kind(mechanism, drivers=False)
    pairs = system.equated
    lengths = np.array([mechanism.scale if part != "angle" else 1.0 for pair in pairs for part in pair.parts])
    units = np.array([1.0 if angle else mechanism.scale for _, angle in system.names])
    columns = tuple((name, "rad" if angle else length) for name, angle in system.names)
    values = system.jacobian(z) * lengths[:, None] / units
    return JacobianMatrix(coordinates, tuple(system.bodies.equations(pairs)), columns, values, mechanism.scale)
