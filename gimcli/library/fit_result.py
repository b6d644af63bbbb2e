"""The result of a fit."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.fitting.motion_quantity import ANGLE
from gimcli.fitting.search import SearchResult
from gimcli.library.fit_targets import FittedTask
from gimcli.library.result import Result
from gimcli.library.rounding import number
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.library.fit_check import FittedDesign
    from gimcli.output.animation import Animation
    from gimcli.output.model import ModelText
    from gimcli.output.picture import Content


class FitResult(Result):
    """A fitted mechanism: `mechanism`, `dimensions`, `error` (sum of squares), and one row for each target."""

    KIND = "fit"

    def __init__(
        self, nominal: Mechanism, task: FittedTask, names: tuple[str, ...], found: FittedDesign | None,
        search: SearchResult, checked: int, zero: float, seed: int,
    ) -> None:  # fmt: skip
        self.nominal, self.task, self.names, self.found = nominal, task, names, found
        self.search, self.checked, self._zero, self.seed = search, checked, zero, seed
        self.mechanism = nominal if found is None else found.mechanism

    @property
    def feasible(self) -> bool:
        """Whether a design was found whose real motion passes the targets in order on one branch."""
        return self.found is not None

    @property
    def complete(self) -> bool:
        """Whether a feasible design was found."""
        return self.feasible

    @property
    def dimensions(self) -> dict[str, float]:
        """The fitted dimensions by name, in the file's units; empty if no design is feasible."""
        return {} if self.found is None else {name: self.found.changes[name] for name in self.names}

    @property
    def error(self) -> float:
        """The sum of squares on the real motion; of an angle in the file's unit. NaN if no design is feasible."""
        return math.nan if self.found is None else self.found.error * self._unit**2

    @property
    def rms(self) -> float:
        """The root of the mean over the targets (of pairs: over all places) of the squared differences."""
        return math.sqrt(self.error / (len(self.task.targets.values) * max(1, self.task.points.shape[1])))

    @property
    def hits(self) -> int:
        """The number of starts that ended at this error."""
        if self.found is None:
            return 0
        return int(self.search.same(self.found.error - self.task.targets.constant, self._zero).sum())

    @property
    def _unit(self) -> float:
        """The file's unit of angle per rad, if the output of a function is an angle; otherwise 1."""
        angle = self.task.kind == "function" and self.task.components[0].kind == ANGLE
        return math.degrees(1.0) if angle and self.nominal.angle_unit == "deg" else 1.0

    def headline(self) -> str:
        """Return the result in one line."""
        name = self.nominal.name
        if self.found is None:
            return (
                f"{name}: no feasible design was found from {self.search.drawn} random designs ({self.checked} fitted"
                " designs were traced): widen the bounds, use more starts, or relax the conditions"
            )
        return f"{name}: sum of squares {self.error:.9g}, root mean square {number(self.rms)}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        counts = {"drawn": self.search.drawn, "started": self.search.started, "hits": self.hits}
        report: dict[str, Any] = {"feasible": self.feasible, "kind": self.task.kind, "starts": counts}
        if self.found is None:
            return report | {"reason": self.headline()}
        motion = self.found.motion
        return report | {
            "error": self.error, "rms": self.rms, "largest": float(np.max(self._distances)),
            "dimensions": self.dimensions, "changes": self.found.changes,
            "inputs": self._inputs.tolist(), "sense": self.sense, "transmission": motion.worst_transmission,
        }  # fmt: skip

    @property
    def sense(self) -> str:
        """Whether the input increases or decreases from target to target; "" with given inputs."""
        if self.found is None or self.task.targets.unknown == 0:
            return ""
        return "increasing" if self.found.inputs[-1] > self.found.inputs[0] else "decreasing"

    @property
    def _inputs(self) -> FloatArray:
        """The inputs (targets,) in the file's unit, of a turning input from the start of its law."""
        assert self.found is not None
        limits, inputs = self.task.targets.range, self.found.inputs
        if limits.turning:
            inputs = limits.low + (inputs - limits.low) % (limits.high - limits.low)
        return np.asarray(self.nominal.value_to_file(0, inputs))

    @property
    def _distances(self) -> FloatArray:
        """The root of the squared differences (targets,) of each target."""
        assert self.found is not None
        residual = self.task.targets.residuals(self.found.motion.values)
        return np.asarray(np.sqrt(np.sum(residual**2, axis=1)) * self._unit)

    def table(self) -> Table:
        """Return one row for each target: its input, its values, those of the motion, and their distance."""
        if self.found is None:
            return Table(())
        actuator, targets = self.nominal.actuators[0], self.task.targets
        columns = [
            Column("target", np.arange(1, len(targets.values) + 1)),
            Column(actuator.name, self._inputs, self.nominal.unit_of(actuator)),
        ]
        for head, values in (("target.", targets.values), ("", self.found.motion.values)):
            for k in range(len(self.task.components)):
                name, unit, factor = self.labelled(k)
                columns.append(Column(head + name, values[:, k] * factor, unit))
        columns.append(Column("distance", self._distances, self.labelled(0)[1]))
        return Table(tuple(columns))

    def checks(self) -> list[str]:
        """Return what was checked on the real motion, as sentences."""
        assert self.found is not None
        worst, unit = self.found.motion.worst_transmission, self.nominal.angle_unit
        order = f"in order, with the input {self.sense}, " if self.sense else ""
        lines = [f"the traced motion passes all targets {order}on one branch, over the whole law of the input"]
        if worst is not None:
            lines.append(f"worst transmission angle {number(worst)} {unit} (from 0 and from a straight angle)")
        return lines

    def labelled(self, k: int) -> tuple[str, str, float]:
        """Return the name of a component, its unit, and the factor to that unit."""
        one = self.task.components[k]
        if one.kind == ANGLE:
            return f"{one.name}.angle", self.nominal.angle_unit, math.degrees(1.0) if self._degrees else 1.0
        return f"{one.name}.{'xy'[one.kind]}", self.nominal.length_unit, 1.0

    @property
    def _degrees(self) -> bool:
        return self.nominal.angle_unit == "deg"

    def picture(self) -> Content | None:
        """Return the mechanism, the curve of its point and the targets; for a function its graph too."""
        from gimcli.library.fit_picture import fit_picture

        return None if self.found is None else fit_picture(self.found.motion, self.task, self.table())

    def animation(self) -> Animation | None:
        """Return the motion of the fitted mechanism; None if no design is feasible."""
        return None if self.found is None else self.found.motion.trace.animation()

    def model(self) -> ModelText | None:
        """Return the text of the model file with the fitted dimensions; None if no design is feasible.

        Raises UsageError if the mechanism was not read from a file.
        """
        if self.found is None:
            return None
        from gimcli.library.model_text import changed_text

        return changed_text(self.nominal, self.found.changes)
