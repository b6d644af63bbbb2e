"""All configurations (assembly modes) of a mechanism at given inputs, with a proof that none is missing.

Knows: the roots of the loop equations, and how many there can be.
Asks: continuation, kernels, motion, positions, structure.
Asked by: branching, library, reach.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gimcli.assemblies.assemblies import SAME, ConfigurationFinder, Configurations, in_order
from gimcli.assemblies.configuration_sweep import RootFollower
from gimcli.assemblies.constants import FITS
from gimcli.canonical import first_least
from gimcli.errors import GimError
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.progress import Progress, no_progress, spend
from gimcli.structure.mobility import require_driven

__all__ = [
    "Configurations", "all_configurations", "configurations_over", "drawn_configuration",
]  # fmt: skip


def all_configurations(
    mechanism: Mechanism, inputs: FloatArray, tolerance: float = FITS, progress: Progress = no_progress
) -> Configurations:
    """Return every configuration at inputs (actuators,) [rad, normal frame] with a residual up to `tolerance`.

    Their order is that of `numbering`: it depends on the mechanism and the inputs only. `progress` is called with the
    number of known roots and of all roots while a structure is solved for the first time.
    Raises StructureError if the mechanism is not fully driven or over-driven.
    """
    require_driven(mechanism)
    return in_order(_row_finder(mechanism, tolerance, progress)(inputs))


def configurations_over(
    mechanism: Mechanism, inputs: FloatArray, progress: Progress = no_progress
) -> list[Configurations]:
    """Return all configurations for each column of inputs (actuators, rows) [rad, normal frame].

    At the limit of `spend` the list ends early. Raises StructureError if the mechanism is not fully driven or
    over-driven.
    """
    row_of, found = _row_finder(mechanism, FITS), []
    for row, now in enumerate(inputs.T):
        found.append(row_of(np.ascontiguousarray(now)))
        progress(row + 1, inputs.shape[1])
        if spend():
            break
    return found


def _row_finder(
    mechanism: Mechanism, tolerance: float, progress: Progress = no_progress
) -> Callable[[FloatArray], Configurations]:
    """Return a function of inputs (actuators,) that finds the configurations, faster at inputs near the last ones."""
    if mechanism.complete is None:
        return RootFollower(ConfigurationFinder(mechanism, tolerance, progress)).row
    from gimcli.assemblies.linked_configurations import LinkedFinder  # imported late: few mechanisms need it

    return LinkedFinder(mechanism, tolerance).row


def drawn_configuration(found: Configurations) -> int | None:
    """Return the index of the configuration that `gim solve` finds from the initial position; None if it finds none."""
    from gimcli.motion.linked_inputs import followed
    from gimcli.motion.solve import solve
    from gimcli.positions.options import Options
    from gimcli.status import Status

    if not len(found):
        return None
    try:
        position = solve(found.mechanism, followed(found.mechanism, found.inputs), Options())
    except GimError:
        return None
    far = np.max(found.mechanism.apart(found.z.T, position.z[:, None]), axis=0)
    nearest = first_least(far, SAME * found.mechanism.size)
    near = far[nearest] <= SAME * found.mechanism.size
    return nearest if position.status is Status.OK and near else None
