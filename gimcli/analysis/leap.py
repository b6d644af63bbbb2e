"""One long step across a change point, where short ones lead nowhere.

At a distance d from a change point accelerations are known to about eps / d^2, so that an integrator which comes to
rest beside it, or whose stages fall beside it, takes ever shorter steps. The motion itself is smooth there: one step
from farther away, none of whose stages falls near, is as good as any other.
"""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.analysis.simulation import Policy
from gimcli.kernels.influence import Place
from gimcli.mechanism import FloatArray

if TYPE_CHECKING:
    from gimcli.analysis.integration import Integration

REACHES = (2.0, 1.37, 5.0)
"""Steps beside the way to the change point: it falls between stages of DOP853."""

KEPT = 8
"""States from which a step may begin."""


class Leap:
    """Remembers states of a piece, and steps from one of them to beyond a change point."""

    def __init__(self) -> None:
        self.anchors: deque[tuple[float, FloatArray, Place]] = deque(maxlen=KEPT)
        self.greatest, self.creeping = 0.0, 0

    def begin(self) -> None:
        """Forget: another piece, or an event that is not to be told again."""
        self.anchors.clear()
        self.greatest, self.creeping = 0.0, 0

    def keep(self, time: float, y: FloatArray, base: Place, step: float, policy: Policy) -> None:
        """Take an accepted step; those beside a change point are not begun from, much shorter ones are counted."""
        self.greatest = max(self.greatest, step)
        if not np.min(np.abs(base.sign), initial=1.0) < policy.near:
            self.creeping = 0
            self.anchors.append((time, np.array(y), copied(base)))
        elif step < policy.creep * self.greatest:
            self.creeping += 1
        else:
            self.creeping = 0

    def across(self, integration: Integration, time: float) -> Any:
        """Return a solver that has stepped from before to well beyond a time, None where no such step is good."""
        from scipy.integrate import DOP853

        base, settings = integration.reducer.base, integration.settings
        here = copied(base)
        for begin, y, place in reversed(self.anchors):
            for reach in REACHES:
                end = begin + reach * (time - begin)
                step = end - begin
                if not (0.0 < step <= 2.0 * self.greatest and end <= integration.times[-1]):
                    continue
                base.v[:], base.b[:], base.sign[:] = place
                solver = DOP853(
                    integration.equations.slopes, begin, y, end, first_step=step, rtol=settings.rtol,
                    atol=integration.tolerances,
                )  # fmt: skip
                solver.step()
                if solver.status != "finished" or not integration.equations.move(end, solver.y):
                    continue
                weakest = int(np.argmin(np.abs(place.sign)))
                passed = integration.reducer.at.sign[weakest] * place.sign[weakest] < 0.0  # else on another branch
                integration.search.stand(y)
                if passed and not integration.search.crossed(solver):  # an event is landed on by short steps
                    return solver
        base.v[:], base.b[:], base.sign[:] = here
        return None


def copied(place: Place) -> Place:
    """Return a copy of a place."""
    return Place(place.v.copy(), place.b.copy(), place.sign.copy())
