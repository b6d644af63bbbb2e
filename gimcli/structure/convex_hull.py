"""The convex hull of points in the plane. Source: A. M. Andrew, 1979."""

from __future__ import annotations

import numpy as np

from gimcli.mechanism import ComplexArray


def convex_hull(z: ComplexArray, thin: float) -> list[int]:
    """Return the numbers of the corner points, counter-clockwise; the two end points if all points are in line.

    Points are in line if the width of their outline is below `thin` times its length.
    """
    far = int(np.argmax(np.abs(z - z[0])))
    ends = [int(np.argmax(np.abs(z - z[far]))), far]
    along = z[far] - z[ends[0]]
    if len(z) < 3 or not along or np.ptp(((z - z[ends[0]]) / along).imag) < thin:
        return ends
    places = z.tolist()
    ordered = sorted(range(len(z)), key=lambda k: (places[k].real, places[k].imag))
    return _lower(places, ordered)[:-1] + _lower(places, ordered[::-1])[:-1]


def _lower(places: list[complex], ordered: list[int]) -> list[int]:
    """Return the lower half of a hull."""
    chain: list[int] = []
    for k in ordered:
        while len(chain) > 1:
            before, last = places[chain[-2]], places[chain[-1]]
            if ((last - before).conjugate() * (places[k] - before)).imag > 0.0:
                break
            chain.pop()
        chain.append(k)
    return chain
