"""Forward dynamics: the motion that loads, weight and drives give a mechanism whose inputs are free."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gimcli.dynamics.euler import EulerIntegration
from gimcli.dynamics.integration import Integration
from gimcli.dynamics.integrators import INTEGRATORS
from gimcli.dynamics.simulation_types import Settings, Simulation
from gimcli.errors import UsageError
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run
from gimcli.progress import Progress, no_progress
from gimcli.status import Status
from gimcli.structure.residual import holds

TOLERANCE = 1e-10
"""Residual up to which a row is written."""


def simulate(
    mechanism: Mechanism, times: FloatArray, settings: Settings | None = None, run: Run = plain,
    progress: Progress = no_progress,
) -> Simulation:  # fmt: skip
    """Let a mechanism move from its start; return it at `times` (rows,) [s], ascending from the start's."""
    settings = settings or Settings()
    if settings.method not in INTEGRATORS:
        raise UsageError(f"method '{settings.method}': choose {', '.join(INTEGRATORS)}")
    kind = EulerIntegration if INTEGRATORS[settings.method].over_input else Integration
    return _checked(kind(mechanism, np.asarray(times, dtype=float), settings, run, progress).simulation())


def _checked(found: Simulation) -> Simulation:
    """Return a simulation up to the first row that does not satisfy every constraint."""
    good = holds(found.mechanism, found.nodes[0], found.inputs[0], TOLERANCE)
    if good.all():
        return found
    rows = slice(0, int(np.argmin(good)))
    return replace(
        found, time=found.time[rows], inputs=found.inputs[:, :, rows], nodes=found.nodes[:, :, rows],
        efforts=found.efforts[:, rows], energy=found.energy[:, rows], status=Status.NOT_CONVERGED,
        end=float(found.time[rows.stop]),
    )  # fmt: skip
