"""Path problems of the literature, with the least errors known (families.md of the references, sections 1 and 2)."""

from dataclasses import dataclass

import numpy as np

TURN = 2.0 * np.pi


@dataclass(frozen=True)
class PathProblem:
    """Targets, bounds of lengths, of offsets and pivots, and the least error of a four-bar whose crank turns fully."""

    targets: tuple[complex, ...]
    timing: str
    lengths: tuple[float, float]
    offsets: float
    error: float
    inputs: tuple[float, ...] = ()  # deg
    fixed: bool = False  # theta0, x0 and y0 are 0
    second: tuple[complex, ...] = ()  # P has to pass both points of each pair at the same time

    @property
    def bounds(self):
        """Lower and upper bounds of r1..r4, rcx, rcy, theta0 [rad], x0, y0."""
        place = 0.0 if self.fixed else self.offsets
        angle = 0.0 if self.fixed else TURN
        upper = np.array([self.lengths[1]] * 4 + [self.offsets] * 2 + [angle, place, place])
        least = max(self.lengths[0], 1e-3 * self.lengths[1])
        lower = np.array([least] * 4 + [-self.offsets] * 2 + [0.0] + [-place] * 2)
        return lower, upper


PROBLEMS = {
    "V6": PathProblem((20 + 20j, 20 + 25j, 20 + 30j, 20 + 35j, 20 + 40j, 20 + 45j), "free", (0, 60), 60, 0.0),
    "L5": PathProblem(
        (3 + 3j, 2.759 + 3.363j, 2.372 + 3.663j, 1.890 + 3.862j, 1.355 + 3.943j), "given", (0, 50), 50, 7.4157513e-7,
        (30, 45, 60, 75, 90), fixed=True,
    ),
    "C18": PathProblem(
        (
            0.5 + 1.1j, 0.4 + 1.1j, 0.3 + 1.1j, 0.2 + 1j, 0.1 + 0.9j, 0.05 + 0.75j, 0.02 + 0.6j, 0.5j, 0.4j,
            0.03 + 0.3j, 0.1 + 0.25j, 0.15 + 0.2j, 0.2 + 0.3j, 0.3 + 0.4j, 0.4 + 0.5j, 0.5 + 0.7j, 0.6 + 0.9j, 0.6 + 1j,
        ),
        "step", (0, 50), 50, 9.02888463e-3, tuple(range(0, 360, 20)),
    ),
    "E10": PathProblem(
        (
            20 + 10j, 17.66 + 15.142j, 11.736 + 17.878j, 5 + 16.928j, 0.60307 + 12.736j, 0.60307 + 7.2638j, 5 + 3.0718j,
            11.736 + 2.1215j, 17.66 + 4.8577j, 20 + 10j,
        ),
        "free", (5, 80), 80, 4.01992054e-4,
    ),
    "P10": PathProblem(
        (
            1.768 + 2.3311j, 1.947 + 2.6271j, 1.595 + 2.7951j, 1.019 + 2.7241j, 0.479 + 2.4281j, 0.126 + 2.0521j,
            -0.001 + 1.72j, 0.103 + 1.514j, 0.442 + 1.549j, 1.055 + 1.905j,
        ),
        "free", (0, 60), 60, 0.27495838350,
        second=(
            1.9592 + 2.44973j, 2.168 + 2.675j, 1.821 + 2.804j, 1.244 + 2.720j, 0.705 + 2.437j, 0.346 + 2.104j,
            0.195 + 1.833j, 0.356 + 1.68j, 0.558 + 1.742j, 1.186 + 2.088j,
        ),
    ),
    "S6": PathProblem(
        (0j, 1.9098 + 5.8779j, 6.9098 + 9.5106j, 13.09 + 9.5106j, 18.09 + 5.8779j, 20 + 0j), "given", (5, 50), 50,
        2.58035563, (30, 60, 90, 120, 150, 180),
    ),
    "N9": PathProblem(
        (0.25 + 0j, 0.52 + 0.1j, 0.8 + 0.7j, 1.2 + 1j, 1.4 + 1.3j, 1.1 + 1.48j, 0.7 + 1.4j, 0.2 + 1j, 0.02 + 0.4j),
        "free", (0.05, 5), 5, 0.0,
    ),
}  # fmt: skip

NINE_POINT_LENGTHS = (
    (0.810913347777157, 0.612095601936486, 0.836906256433488, 0.72374684128836),
    (0.716815298389447, 0.541068281521917, 0.639763557251375, 0.739792000678997),
)
"""r1..r4 of the two answers of N9 that meet all points in order on one branch."""
