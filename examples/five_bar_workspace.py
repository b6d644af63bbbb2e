"""The workspace of a five-bar is the intersection of the rings that its two arms reach: a lens with two round holes.

Run from the repository: python examples/five_bar_workspace.py
"""

from pathlib import Path

import numpy as np

from gimcli import workspace

MODEL = Path(__file__).parents[1] / "models" / "five_bar.yaml"


def main() -> None:
    """Find the boundary, and check its area, arcs and holes (base 4, links 5 and 6)."""
    found = workspace(MODEL, "P")
    report = found.report()
    base, far, near = 4.0, 5.0 + 6.0, 6.0 - 5.0
    half = 0.5 * base
    lens = 2.0 * far**2 * np.arccos(half / far) - half * np.sqrt(4.0 * far**2 - base**2)
    exact = lens - 2.0 * np.pi * near**2
    area, holes = report["area"], report["holes"]
    assert found.complete, "the boundary is complete"
    assert abs(area / exact - 1.0) < 1e-7, "area in closed form"
    z = found["x"] + 1j * found["y"]
    for curve in set(found["curve"]):
        edge = z[found["curve"] == curve]
        off = min(np.abs(np.abs(edge - pivot) - r).max() for pivot in (-half, half) for r in (far, near))
        assert off < 1e-11, "every curve is an arc around a pivot, whose arm is stretched or folded"
    assert holes == 2, "one hole around each pivot"
    print(f"area {area:.9g}, in closed form {exact:.9g}; {holes} holes")


if __name__ == "__main__":
    main()
