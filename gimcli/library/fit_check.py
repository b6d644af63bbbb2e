"""Check fitted designs on their real motion: all rows are solved, and the targets are passed in order on one branch."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gimcli.errors import GimError
from gimcli.families.family import Family
from gimcli.fitting.least_squares import FitProblem, Trials
from gimcli.library.fit_motion import FitMotion, fit_motion
from gimcli.library.fit_targets import FittedTask
from gimcli.mechanism import FRAME, FloatArray, Mechanism

AGREEMENT = 1e-6
"""Largest distance, relative to the size, of the real motion from the positions of the fit."""


@dataclass(frozen=True, eq=False)
class FittedDesign:
    """A design whose real motion was traced."""

    mechanism: Mechanism
    changes: dict[str, float]  # dimensions that differ from the model file: those that vary, and initial coordinates
    design: FloatArray  # (dimensions,)
    inputs: FloatArray  # (targets,) rad, or length in the normal frame
    motion: FitMotion
    error: float  # sum of squares on the real motion, with its constant


class DesignChecker:
    """Checks designs on their real motion, with other dimensions in the model."""

    def __init__(self, family: Family, problem: FitProblem, task: FittedTask) -> None:
        self.family, self.problem, self.task = family, problem, task

    def checked(self, trial: Trials) -> FittedDesign | None:
        """Return a fitted design; None if its motion does not pass the targets in order on one branch."""
        inputs = self.problem.inputs(trial.designs, trial.own)
        if trial.sense[0] and not self.task.targets.ordered(inputs, trial.sense).all():
            return None
        own = dict(zip(self.family.names, (trial.designs[0] + 0.0).tolist(), strict=True))  # no -0.0
        expected = self.problem.quantity.values(trial.designs, inputs)[0]
        for changes in (own, own | self._coordinates(trial.designs)):
            try:
                mechanism = self.family.mechanism.with_(changes)
                motion = fit_motion(mechanism, self.task, inputs[0])
            except GimError:
                continue
            if motion.trace.complete and self._agree(motion.values, expected):
                residual = self.task.targets.residuals(motion.values)
                error = float(np.sum(residual**2)) + self.task.targets.constant
                return FittedDesign(mechanism, changes, trial.designs[0], inputs[0], motion, error)
        return None

    def _agree(self, values: FloatArray, expected: FloatArray) -> bool:
        """Return whether the real motion is on the branch of the fit."""
        targets, size = self.task.targets, self.family.mechanism.size * self.family.mechanism.scale
        turns = np.rint((values - expected) / (2.0 * math.pi)) * 2.0 * math.pi
        distance = np.abs(values - expected - np.where(targets.circular > 0.0, turns, 0.0))
        return bool(np.all(distance <= AGREEMENT * np.where(targets.circular > 0.0, 1.0, size)))

    def _coordinates(self, design: FloatArray) -> dict[str, float]:
        """Return the coordinates, at the start of the law, of moving nodes whose coordinates are plain numbers."""
        mechanism = self.family.mechanism
        start = self.family.solve(design, inputs=mechanism.start_inputs[None, :, None]).z[0, :, 0]
        file = mechanism.to_file(start)
        own: dict[str, float] = {}
        for k, node in enumerate(mechanism.nodes):
            if k in mechanism.members[FRAME].nodes or not np.isfinite(file[k]):
                continue
            for axis, value in (("x", file[k].real), ("y", file[k].imag)):
                name = f"{node}.{axis}"
                if name not in self.family.names and not mechanism.written.dimension(name).formula:
                    own[name] = float(value)
        return own
