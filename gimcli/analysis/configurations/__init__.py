"""Every way to assemble a mechanism at given inputs, with a certificate that none is missing."""

from __future__ import annotations

from gimcli.analysis.configurations.assemblies import Assembler, Configurations, Progress
from gimcli.analysis.configurations.policy import Policy
from gimcli.analysis.configurations.sweep import configurations_over
from gimcli.mechanism import FloatArray, Mechanism

__all__ = ["Configurations", "Policy", "all_configurations", "configurations_over"]


def all_configurations(
    mechanism: Mechanism, inputs: FloatArray, policy: Policy | None = None, progress: Progress | None = None
) -> Configurations:
    """Return every configuration at inputs (actuators,).

    Raises StructureError where the mechanism is not driven or over-driven.
    """
    return Assembler(mechanism, policy).at(inputs, progress=progress)
