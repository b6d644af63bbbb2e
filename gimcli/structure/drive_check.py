"""Check that the actuators match the mobility, only if the structure or the start position leaves this open."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from gimcli.errors import StructureError
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.status import Status
from gimcli.structure.residual import residual
from gimcli.structure.steps import Plan


@contextmanager
def explained(mechanism: Mechanism) -> Iterator[None]:
    """Replace a StructureError by one that the mobility analysis explains, if it can (context manager)."""
    try:
        yield
    except StructureError:
        from gimcli.structure.mobility import require_driven

        for one in mechanism.machines:
            require_driven(one.mechanism)
        raise


def require_driven_if_doubtful(mechanism: Mechanism, plan: Plan, regular: bool) -> None:
    """Raise StructureError if a mechanism is over-driven or not fully driven.

    The check is needed only if there are redundant constraints or no regular position was solved; otherwise the plan
    shows that the actuators drive all freedoms.
    """
    if plan.surplus > 0 or not regular:
        from gimcli.structure.mobility import require_driven

        require_driven(mechanism)


def require_consistent(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, status: Status, tolerance: float
) -> None:
    """Raise StructureError, with the name of the constraint, if the status of position z (nodes,) is CONTRADICTORY."""
    if status is Status.CONTRADICTORY:
        check = residual(mechanism, z[:, None], inputs[:, None], names=True)
        raise StructureError(
            f"constraint '{check.worst[0]}' is redundant and contradicts the others (relative error"
            f" {check.total[0]:.1e}, tolerance {tolerance:.0e}); correct its dimension, remove it"
            " or loosen the tolerance"
        )
