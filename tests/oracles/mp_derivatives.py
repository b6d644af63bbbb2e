"""Derivatives of functions with 40 digits."""

import mpmath as mp
import numpy as np


def exact(function, time, order):
    """Return the derivatives (order + 1,) of a function, with 40 digits."""
    with mp.workdps(40):
        return np.array([complex(mp.diff(function, mp.mpf(float(time)), k)) for k in range(order + 1)])
