"""The nine-point problem: a four-bar whose coupler point passes nine given points.

Wampler, Morgan & Sommese 1992, problem 3. Of its 1442 classes of solutions 64 are real, and only one passes the points
in order on one branch: two cognates whose cranks turn fully.

Run from the repository: python examples/nine_points.py [FOLDER of the picture]
"""

import sys
from pathlib import Path

from gimcli import fit, load

MODEL = Path(__file__).with_name("four_bar.yaml")
POINTS = (
    (0.25, 0.0), (0.52, 0.1), (0.8, 0.7), (1.2, 1.0), (1.4, 1.3), (1.1, 1.48), (0.7, 1.4), (0.2, 1.0), (0.02, 0.4),
)  # fmt: skip
LENGTHS = (
    (0.810913347777157, 0.612095601936486, 0.836906256433488, 0.72374684128836),
    (0.716815298389447, 0.541068281521917, 0.639763557251375, 0.739792000678997),
)
"""Frame, crank, coupler and follower of the two cognates, from the complete list of solutions."""


def main(folder: Path | None = None) -> None:
    """Fit the nine dimensions of a four-bar, compare its lengths with the references, and draw it."""
    lengths = dict.fromkeys(("r1", "r2", "r3", "r4"), (0.05, 5.0))
    places = dict.fromkeys(("rcx", "rcy", "x0", "y0"), (-5.0, 5.0))
    found = fit(load(MODEL), {**lengths, **places, "theta0": (0.0, 360.0)}, POINTS)
    assert found.feasible
    assert found.error < 1e-24
    own = [found.dimensions[name] for name in lengths]
    assert min(max(abs(a - b) for a, b in zip(own, known, strict=True)) for known in LENGTHS) < 1e-9
    starts = found.report()["starts"]["started"]
    print(f"{starts} starts, sum of squares {found.error:.0e}, frame, crank, coupler, follower {own}")
    if folder is not None:
        found.save(folder / "nine_points.png", title="Nine-point problem")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 and Path(sys.argv[1]).is_dir() else None)
