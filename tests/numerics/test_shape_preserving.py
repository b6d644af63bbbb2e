"""Interpolation of samples against scipy."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from gimcli.numerics.shape_preserving import ShapePreservingCubic


@pytest.mark.parametrize("count", [2, 3, 4, 8])
def test_shape_preserving_cubics_and_derivatives_are_those_of_scipy(count: int) -> None:
    random = np.random.default_rng(count)
    for _ in range(50):
        at, value = np.cumsum(random.uniform(0.1, 3.0, count)), np.round(random.normal(size=count), 1)
        places = np.concatenate([random.uniform(at[0] - 1.0, at[-1] + 1.0, 20), at])
        own, theirs = ShapePreservingCubic(at, value), PchipInterpolator(at, value)
        for order in range(4):
            assert own(places, order) == pytest.approx(theirs(places, order), rel=1e-12, abs=1e-12)
