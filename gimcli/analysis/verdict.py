"""Whether the actuators fit the mechanism: asked only where the structure leaves room for doubt."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from gimcli.errors import StructureError
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.start import drawn_inputs
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import residual


@contextmanager
def explained(mechanism: Mechanism) -> Iterator[None]:
    """Let an error of the structure be told by its rank, which knows an idle actuator from a missing one."""
    try:
        yield
    except StructureError:
        from gimcli.analysis.mobility import assembled, check_driven, mobility

        home = assembled(mechanism)
        if home is not None:
            check_driven(mechanism, mobility(mechanism, home, drawn_inputs(mechanism)))
        raise


def refuse_unfit(mechanism: Mechanism) -> None:
    """Raise StructureError where the structure has constraints to spare and actuators are among them."""
    if make_plan(mechanism).surplus == 0:
        return
    from gimcli.analysis.mobility import assembled, check_driven, mobility

    home = assembled(mechanism)
    if home is not None:
        check_driven(mechanism, mobility(mechanism, home, drawn_inputs(mechanism)))


def verify(mechanism: Mechanism, z: ComplexArray, inputs: FloatArray, status: Status, tolerance: float) -> None:
    """Raise StructureError where the mechanism is not driven, over-driven or contradictory.

    z (nodes,) is the position found at the inputs, whatever its status.
    """
    plan = make_plan(mechanism)
    doubtful = plan.surplus > 0 or not mechanism.actuators or status is not Status.OK
    if not doubtful:
        return
    from gimcli.analysis.mobility import assembled, check_driven, mobility

    home, at = (z, inputs) if status is Status.OK else (assembled(mechanism), drawn_inputs(mechanism))
    if home is not None:
        check_driven(mechanism, mobility(mechanism, home, at))
    if status is Status.CONTRADICTORY:
        check = residual(mechanism, z[:, None], inputs[:, None], names=True)
        raise StructureError(
            f"constraint '{check.worst[0]}' is surplus and contradicts the others (relative error"
            f" {check.total[0]:.1e}, tolerance {tolerance:.0e}); correct its dimension, remove it or loosen --tolerance"
        )
