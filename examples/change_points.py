"""The two branches of a parallelogram linkage at its change points, and the closed coupler curve of a double rocker.

Run from the repository: python examples/change_points.py
"""

import math
from pathlib import Path

import numpy as np

from gimcli import load
from gimcli.branching.resampling import circuit_motion
from gimcli.branching.singular_positions import survey
from gimcli.branching.singularities import LIMIT, rates
from gimcli.motion.summary import traced_paths
from gimcli.status import CHANGE

MODELS = Path(__file__).parents[1] / "models"


def parallelogram() -> None:
    """Check both branches of the linkage 1-3-1-3 at 0 and 180 deg: parallelogram and antiparallelogram."""
    found = survey(load(MODELS / "parallelogram.yaml"))
    points = [one for one in found.found if one.what.kind == CHANGE]
    assert len(points) == len(found.branches.circuits) == 2, "two positions, two branches"
    for one in points:
        angle = math.degrees(one.what.p[-1])
        turns = sorted(rates(found.curve, one.what.p, v).members["follower"] for v in one.what.branches)
        crossed = (1.0 + 3.0) / (1.0 - 3.0) if abs(math.remainder(angle, 360.0)) < 90.0 else (1.0 - 3.0) / (1.0 + 3.0)
        assert np.allclose(turns, [crossed, 1.0], rtol=0.0, atol=1e-12), (
            "Kennedy: pole on the frame line or at infinity"
        )
        print(f"change point at {angle:.12g} deg: angular velocity ratio {turns[0]:+.12g} or {turns[1]:+.12g}")


def double_rocker() -> None:
    """Check limits and coupler curve of the circuit of Chebyshev's linkage (frame 4, rockers 5, coupler 2)."""
    found = survey(load(MODELS / "chebyshev.yaml"))
    limits = sorted(math.cos(one.what.p[-1]) for one in found.found if one.what.kind == LIMIT)
    assert np.allclose(limits, [-1.0 / 5.0, 4.0 / 5.0], rtol=0.0, atol=1e-14), "law of cosines"
    (circuit,) = found.branches.circuits
    assert circuit.closed
    assert circuit.turns == 0.0
    path = traced_paths(circuit_motion(circuit, 3601, 1e-10))["P"]
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
