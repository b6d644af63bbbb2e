"""Forward dynamics: the motion of a mechanism with free inputs under weight, loads and driving efforts."""

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
from gimcli.positions.options import TOLERANCE
from gimcli.progress import Progress, no_progress
from gimcli.status import Status
from gimcli.structure.residual import holds


def simulate(
    mechanism: Mechanism, times: FloatArray, settings: Settings | None = None, run: Run = plain,
    progress: Progress = no_progress,
) -> Simulation:  # fmt: skip
    """Simulate a mechanism from its initial state at times[0]; return the states at `times` (rows,) [s], ascending.

    Raises UsageError for an unknown method, StructureError without a free input, ModelError without masses.
    """
    settings = settings or Settings()
    if settings.method and settings.method not in INTEGRATORS:
        raise UsageError(f"integrator: expected one of {', '.join(INTEGRATORS)}, got '{settings.method}'")
    over_input = bool(settings.method) and INTEGRATORS[settings.method].over_input
    kind = EulerIntegration if over_input else Integration
    return _checked(kind(mechanism, np.asarray(times, dtype=float), settings, run, progress).simulation())


def _checked(found: Simulation) -> Simulation:
    """Return the simulation up to the last row before one that violates a constraint."""
    good = holds(found.mechanism, found.nodes[0], found.inputs[0], TOLERANCE)
    if good.all():
        return found
    rows = slice(0, int(np.argmin(good)))
    return replace(
        found, time=found.time[rows], inputs=found.inputs[:, :, rows], nodes=found.nodes[:, :, rows],
        efforts=found.efforts[:, rows], energy=found.energy[:, rows], status=Status.NOT_CONVERGED,
        friction=None if found.friction is None else found.friction[:, rows],
        end=float(found.time[rows.stop]),
    )  # fmt: skip
