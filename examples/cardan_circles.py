"""Cardan's circles: the bar of an elliptic trammel moves like a circle that rolls inside a circle of twice its radius.

The fixed centrode is the circle of radius L around the intersection of the guides. The moving centrode is the circle of
radius L/2 around the midpoint of the bar. Each point of the moving centrode moves on a straight line, the midpoint of
the bar on a circle, and all other points of the bar on ellipses.
This command draws the picture: gim trace models/elliptic_trammel.yaml -m centre:frame/bar -m area:bar --plot velocity

Run from the repository: python examples/cardan_circles.py
"""

from pathlib import Path

import numpy as np

from gimcli import load, trace
from gimcli.mechanism import ComplexArray, FloatArray

MODEL = Path(__file__).parents[1] / "models" / "elliptic_trammel.yaml"
LENGTH, MAJOR, MINOR = 2.5, 3.5, 1.0


def arc(z: ComplexArray) -> FloatArray:
    """Return the lengths of the arcs between successive points of a circle around 0."""
    return np.abs(np.angle(z[1:] / z[:-1])) * np.abs(z[1:])


def main() -> None:
    """Compare the centrodes and the curvature of the ellipse with their closed forms."""
    motion = trace(load(MODEL), 360, measure=["centre:frame/bar", "curvature:P"])
    x, y, along, left = (motion[f"centre:frame/bar{axis}"] for axis in (".x", ".y", ".bar.x", ".bar.y"))
    assert np.allclose(np.hypot(x, y), LENGTH, rtol=1e-12), "fixed centrode: radius L around O"
    assert np.allclose(np.hypot(along - LENGTH / 2, left), LENGTH / 2, rtol=1e-12), (
        "moving centrode: radius L/2 around the midpoint"
    )
    fixed, moving = arc(x + 1j * y), arc(along - LENGTH / 2 + 1j * left)
    assert np.allclose(fixed, moving, rtol=1e-9), "the centrodes roll on each other without slipping"
    radius = np.abs(motion["curvature:P.radius"])
    assert np.isclose(radius.max(), MAJOR**2 / MINOR, rtol=1e-12), "a^2/b at the ends of the minor axis"
    assert np.isclose(radius.min(), MINOR**2 / MAJOR, rtol=1e-3), "b^2/a at the ends of the major axis, between rows"
    print(f"centrodes of radius {np.hypot(x, y).mean():.12g} and {np.hypot(along - LENGTH / 2, left).mean():.12g}")


if __name__ == "__main__":
    main()
