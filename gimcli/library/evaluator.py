"""A function of designs for optimisers: quantities and statuses of arrays of designs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.errors import refuse
from gimcli.library.machines import names_of
from gimcli.library.sweep import sweep
from gimcli.mechanism import Mechanism
from gimcli.status import Status


class Evaluator:
    """Computes `quantities` (texts) for values of `dimensions` (names); see `evaluator`."""

    def __init__(
        self, mechanism: Mechanism, dimensions: str | Sequence[str], keep: str | Sequence[str], steps: int
    ) -> None:
        nominal = {name: [mechanism.written.dimension(name).value] for name in names_of(dimensions)}
        verb: Any = sweep
        self._job = verb.begin(mechanism, nominal, steps=steps, keep=keep).job
        self.dimensions, self.quantities = self._job.table.names, tuple(one.text for one in self._job.kept)
        other = any(one.kind.what != "number" for one in self._job.kept)
        refuse((other, "keep: expected numbers, such as range(P.y)"))

    def __call__(self, designs: Any) -> tuple[NDArray[np.float64], NDArray[np.str_]]:
        """Return quantities (designs, quantities) and status words (designs,) of designs (designs, dimensions).

        All are in the file's units. A design that is not solved has a status word other than "ok", and the quantities
        of its solved rows, NaN without any. One design (dimensions,) gives arrays of one design.
        """
        values = np.atleast_2d(np.asarray(designs, dtype=np.float64))
        wanted = f"(designs, {len(self.dimensions)}) of {', '.join(self.dimensions)}"
        wrong = values.shape[1:] != (len(self.dimensions),)
        refuse((wrong, f"designs: expected an array {wanted}, got {np.shape(designs)}"))
        columns = self._job.columns(values, self._job.steps, {"jit": "auto"})
        found = [np.broadcast_to(columns.of(one), len(values)) for one in self._job.kept]
        return np.stack(found, axis=1), np.array([status.word for status in Status])[columns.status]


def evaluator(
    mechanism: Mechanism, dimensions: str | Sequence[str], keep: str | Sequence[str], steps: int = 72
) -> Evaluator:
    """Return a function of designs for an optimiser: `values, statuses = evaluate([[40, 70], [42, 69]])`.

    Args:
        mechanism: from `load` or `loads`.
        dimensions: names of the dimensions that vary, a text or a list, such as ["crank.length", "rod.length"].
        keep: quantities of each design, as in `sweep`: numbers such as "range(P.y)" or "max(motor.effort)".
        steps: number of steps of each motion, 1 to 10 000 000.

    Returns:
        An Evaluator. Called with designs (designs, dimensions), it returns quantities (designs, quantities) and status
        words (designs,).

    Raises:
        UsageError: an unknown name or an invalid argument; a quantity that is not a number.
        StructureError: the mechanism has no actuator, or is not fully driven, over-driven or contradictory.
    """
    return Evaluator(mechanism, dimensions, keep, steps)
