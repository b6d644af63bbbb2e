"""The Jacobian of the constraints, without actuators, in joint, absolute or natural coordinates, and its rank.

Natural coordinates are those of the nodes; their equations are the constraints that `mobility` names. Sources: Fraczek
& Wojtyra, lecture notes on multibody methods, section 1.3; Garcia de Jalon & Bayo 1994, chapter 2.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gimcli.errors import UnassembledError, UsageError
from gimcli.library.inputs import OneOf
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.structure.constraint_jacobian import RANK, constraint_jacobian, dependent, full_pivoting
from gimcli.structure.mobility import assembled
from gimcli.table import Column, Table

NATURAL = "natural"
COORDINATES = ("joint", "absolute", NATURAL)


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

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        return {
            "coordinates": self.coordinates, "rows": list(self.rows), "columns": [name for name, _ in self.columns],
            "units": [unit for _, unit in self.columns], "values": self.values.tolist(), "rank": self.rank,
            "rank_by_singular_values": self.rank_by_singular_values,
            "singular_values": self.singular_values.tolist(),
            "dependent": [{"equation": k, "instead": own} for k, own in self.dependent.items()],
        }  # fmt: skip

    def table(self) -> Table:
        """Return one row for each equation."""
        own = [Column(name, column, unit) for (name, unit), column in zip(self.columns, self.values.T, strict=True)]
        return Table((Column("equation", np.array(self.rows, dtype=object)), *own))


def jacobian_matrix(mechanism: Mechanism, coordinates: str = NATURAL) -> JacobianMatrix:
    """Return the Jacobian of the constraints in one kind of coordinates.

    Raises:
        UsageError: unknown coordinates, or inputs that follow others, which only natural coordinates have.
        UnassembledError: no assembled position was found near the drawn one.
    """
    OneOf(COORDINATES).refuse("coordinates", coordinates)
    if coordinates != NATURAL and mechanism.couplings:
        names = ", ".join(mechanism.actuators[coupling.follower].name for coupling in mechanism.couplings)
        raise UsageError(f"coordinates: {names} follow other inputs; only natural coordinates have such equations")
    z = assembled(mechanism)
    if z is None:
        raise UnassembledError(f"{mechanism.name} cannot be assembled near its initial configuration")
    length = mechanism.length_unit
    if coordinates == NATURAL:
        own = constraint_jacobian(mechanism)
        columns = tuple((f"{mechanism.nodes[n]}.{axis}", length) for n in own.free for axis in "xy")
        values = own.slopes(own.constraints, z, mechanism.drawn_inputs)
        return JacobianMatrix(coordinates, tuple(r.name for r in own.constraints), columns, values)
    from gimcli.comparison.absolute import AbsoluteCoordinates
    from gimcli.comparison.joint import JointCoordinates

    kind = JointCoordinates if coordinates == "joint" else AbsoluteCoordinates
    system = kind(mechanism, drivers=False)
    pairs, values = system.jacobian(z)
    lengths = np.array([mechanism.scale if part != "angle" else 1.0 for pair in pairs for part in pair.parts])
    units = np.array([1.0 if angle else mechanism.scale for _, angle in system.names])
    columns = tuple((name, "rad" if angle else length) for name, angle in system.names)
    values = values * lengths[:, None] / units
    return JacobianMatrix(coordinates, tuple(system.bodies.equations(pairs)), columns, values, mechanism.scale)
