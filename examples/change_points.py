"""The two branches of a parallelogram linkage at its change points, and the closed coupler curve of a double rocker.

Run from the repository: python examples/change_points.py
"""

import math
from pathlib import Path

import numpy as np

from gimcli import singularities, trace

MODELS = Path(__file__).parents[1] / "models"


def parallelogram() -> None:
    """Check both branches of the linkage 1-3-1-3 at 0 and 180 deg: parallelogram and antiparallelogram."""
    found = singularities(MODELS / "parallelogram.yaml").report()
    points = [one for one in found["singularities"] if one["kind"] == "change point"]
    assert len(points) == len(found["circuits"]) == 2, "two positions, two branches"
    for one in points:
        angle = one["at"]["motor"]
        turns = sorted(rates["members"]["follower"] for rates in one["tangents"])
        crossed = (1.0 + 3.0) / (1.0 - 3.0) if abs(math.remainder(angle, 360.0)) < 90.0 else (1.0 - 3.0) / (1.0 + 3.0)
        assert np.allclose(turns, [crossed, 1.0], rtol=0.0, atol=1e-12), (
            "Kennedy: pole on the frame line or at infinity"
        )
        print(f"change point at {angle:.12g} deg: angular velocity ratio {turns[0]:+.12g} or {turns[1]:+.12g}")


def double_rocker() -> None:
    """Check limits and coupler curve of the circuit of Chebyshev's linkage (frame 4, rockers 5, coupler 2)."""
    found = singularities(MODELS / "chebyshev.yaml").report()
    ends = [one["at"]["motor"] for one in found["singularities"] if one["kind"] == "limit"]
    limits = sorted(math.cos(math.radians(end)) for end in ends)
    assert np.allclose(limits, [-1.0 / 5.0, 4.0 / 5.0], rtol=0.0, atol=1e-14), "law of cosines"
    (circuit,) = found["circuits"]
    assert circuit["closed"]
    assert circuit["turns"] == 0.0
    path = trace(MODELS / "chebyshev.yaml", steps=3600, circuit=True).xy["P"] @ [1.0, 1.0j]
    assert abs(path[0] - path[-1]) < 1e-12, "the coupler curve closes"
    area = 0.5 * float(np.sum((path[:-1].conjugate() * path[1:]).imag))
    # Holditch 1858: the paths of A and B enclose no area and the coupler turns once, so the path of the point P between
    # them encloses the area pi AP PB.
    assert math.isclose(abs(area), math.pi, rel_tol=1e-5)
    assert abs(path.imag.min() - 4.0) < 5e-3, "the lower side of the curve is nearly straight"
    print(f"coupler curve of the double rocker: closed, area {abs(area):.6f}")


if __name__ == "__main__":
    parallelogram()
    double_rocker()
