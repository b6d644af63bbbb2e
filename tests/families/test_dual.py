"""Dual numbers: every function of expressions against central differences."""

import numpy as np
import pytest

from gimcli.families.dual import duals
from gimcli.language.arrays import ARRAYS
from gimcli.language.expression import FUNCTIONS, OPERATORS

ARITHMETIC = ("+", "-", "*", "/", "**")
STEP = 1e-6


def along(find, *values):
    """Compare value and derivative of a function whose arguments have the derivatives 0.7 and -1.3."""
    slopes = (0.7, -1.3)[: len(values)]
    found = find(*(duals(np.array([v]), np.array([[s]])) for v, s in zip(values, slopes, strict=True)))[0]
    high, low = (find(*(v + h * s for v, s in zip(values, slopes, strict=True))) for h in (STEP, -STEP))
    assert found.value == pytest.approx(find(*values), rel=1e-12)
    assert found.slopes[0] == pytest.approx((high - low) / (2 * STEP), rel=1e-7)


@pytest.mark.parametrize("value", [0.3, 0.8])
@pytest.mark.parametrize("name", [name for name, count in FUNCTIONS.items() if count == 1])
def test_functions(name, value):
    along(ARRAYS[name], value)


@pytest.mark.parametrize("values", [(0.3, 1.7), (2.5, 0.4)])
@pytest.mark.parametrize("find", [ARRAYS["atan2"], ARRAYS["hypot"], *(OPERATORS[sign] for sign in ARITHMETIC)])
def test_functions_of_two_numbers(find, values):
    along(find, *values)


@pytest.mark.parametrize("sign", ARITHMETIC)
def test_constants_on_either_side(sign):
    along(lambda x: OPERATORS[sign](x, 2.5), 0.8)
    along(lambda x: OPERATORS[sign](2.5, x), 0.8)


def test_minus_and_the_absolute_value_of_negative_numbers():
    along(np.negative, 0.8)
    along(np.abs, -0.8)


def test_undefined_values_are_no_errors():
    zero, one = duals(np.array([0.0, 1.0]), np.array([[1.0, 1.0]]))
    with np.errstate(all="ignore"):
        for undefined in (one / zero, (-one).sqrt(), (-one).log(), (-one) ** 0.5, (one + one).arcsin()):
            assert not np.isfinite(undefined.value)
        for steep in (zero.sqrt(), one.arccos(), zero.arctan2(0.0), zero.hypot(0.0)):
            assert np.isfinite(steep.value)
            assert not np.isfinite(steep.slopes).any()
