"""Cardan's circles: the bar of an elliptic trammel moves as a circle that rolls within one of twice its size.

The fixed centrode is the circle of radius L about the crossing of the guides, the moving one the circle of radius L/2
about the bar's middle; every point of the moving one runs straight, the middle on a circle, all others on ellipses.
The picture: gim trace models/elliptic_trammel.yaml -m centre:frame/bar -m area:bar --plot velocity

Run from the repository: python examples/cardan_circles.py
"""

from pathlib import Path

import numpy as np

from gimcli import load
from gimcli.measures import measures_of
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.motion.motion import trace
from gimcli.rates.path_derivatives import PathDerivatives

MODEL = Path(__file__).parents[1] / "models" / "elliptic_trammel.yaml"
LENGTH, MAJOR, MINOR = 2.5, 3.5, 1.0


def arc(z: ComplexArray) -> FloatArray:
    """Return the length of the arc between the points of a circle about 0."""
    return np.abs(np.angle(z[1:] / z[:-1])) * np.abs(z[1:])


def main() -> None:
    """Measure the centrodes, the ellipse's curvature and the region that the bar sweeps."""
    motion = trace(load(MODEL), 360)
    sight = PathDerivatives(motion)
    x, y, along, left = measures_of(motion.mechanism, "centre:frame/bar")[0].values(sight)
    assert np.allclose(np.hypot(x, y), LENGTH, rtol=1e-12), "the fixed centrode: radius L about O"
    assert np.allclose(np.hypot(along - LENGTH / 2, left), LENGTH / 2, rtol=1e-12), (
        "the moving one: L/2 about the middle"
    )
    fixed, moving = arc(x + 1j * y), arc(along - LENGTH / 2 + 1j * left)
    assert np.allclose(fixed, moving, rtol=1e-9), "they roll on each other without slipping"
    radius = np.abs(measures_of(motion.mechanism, "curvature:P")[0].values(sight)[0])
    assert np.isclose(radius.max(), MAJOR**2 / MINOR, rtol=1e-12), "a^2/b where the ellipse is flattest"
    assert np.isclose(radius.min(), MINOR**2 / MAJOR, rtol=1e-3), "b^2/a at its ends, which no row meets exactly"
    print(f"centrodes of radius {np.hypot(x, y).mean():.12g} and {np.hypot(along - LENGTH / 2, left).mean():.12g}")


if __name__ == "__main__":
    main()
