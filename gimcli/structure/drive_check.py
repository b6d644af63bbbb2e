"""Whether the actuators fit the mechanism: asked only where the structure or its start leaves room for doubt."""

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
    """Let the mobility explain an error of the structure, where it can."""
    try:
        yield
    except StructureError:
        from gimcli.structure.mobility import refuse_unfit

        refuse_unfit(mechanism)
        raise


def refuse_doubtful(mechanism: Mechanism, plan: Plan, regular: bool) -> None:
    """Raise StructureError where a mechanism is over-driven or not driven.

    It is asked where constraints are to spare or no regular position was solved: else the plan drives all.
    """
    if plan.surplus > 0 or not regular:
        from gimcli.structure.mobility import refuse_unfit

        refuse_unfit(mechanism)


def refuse_contradiction(
    mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, status: Status, tolerance: float
) -> None:
    """Raise StructureError where surplus constraints contradict the others at a position z (nodes,) of some status."""
    if status is Status.CONTRADICTORY:
        check = residual(mechanism, z[:, None], inputs[:, None], names=True)
        raise StructureError(
            f"constraint '{check.worst[0]}' is surplus and contradicts the others (relative error"
            f" {check.total[0]:.1e}, tolerance {tolerance:.0e}); correct its dimension, remove it or loosen --tolerance"
        )
