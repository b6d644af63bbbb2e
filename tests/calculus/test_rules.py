"""Recorded, dual, series and jet numbers: every rule against differences and the Taylor series of mpmath."""

import mpmath
import numpy as np
import pytest

from gimcli.calculus.dual import Dual
from gimcli.calculus.jet import Jet
from gimcli.calculus.numbers import FUNCTIONS, nominal
from gimcli.calculus.recorded import Recorded, Recording
from gimcli.calculus.rules import RULES
from gimcli.calculus.series import Series
from gimcli.canonical import phase
from gimcli.language.arrays import ARRAYS

STEP = 1e-5
OF_TWO = [name for name, rule in RULES.items() if len(rule.parts) == 2]
ANALYTIC = ["add", "subtract", "multiply", "divide", "power", "sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos",
            "atan", "atan2", "hypot"]  # fmt: skip
COMPLEX = ["add", "subtract", "multiply", "divide", "power", "negative", "conjugate", "real", "imag", "abs", "phase",
           "sqrt", "exp", "log", "sin", "cos"]  # fmt: skip
SPEEDS = np.array([[0.7, -1.3], [0.4, 0.9]])  # (tangents, operands)


def operands(name, numbers):
    """Return the operands of an operation: a condition comes first in `where`."""
    count = len(RULES[name].parts) or 1
    return (numbers[0] < numbers[1], *numbers[:2]) if name == "where" else tuple(numbers[:count])


def check(name, values, speeds=SPEEDS):
    """Compare value and derivatives along two tangents with central differences."""
    operation = RULES[name].value
    own = operands(name, [Dual(v, s) for v, s in zip(values, speeds.T, strict=True)])
    found, plain = operation(*own), operation(*operands(name, values))
    assert isinstance(found, Dual)
    assert found.value == pytest.approx(plain, rel=1e-14)
    for tangent, slope in zip(speeds, found.slopes, strict=True):
        high, low = (operation(*operands(name, values + h * tangent)) for h in (STEP, -STEP))
        assert slope == pytest.approx((high - low) / (2 * STEP), rel=1e-7, abs=1e-9)


@pytest.mark.parametrize("values", [(0.3, 0.8), (0.8, 0.4), (0.6, 1.7)])
@pytest.mark.parametrize("name", RULES)
def test_dual_numbers(name, values):
    check(name, np.array(values))


@pytest.mark.parametrize("name", COMPLEX)
def test_complex_dual_numbers(name):
    check(name, np.array([0.3 + 0.4j, -0.8 + 1.1j]), SPEEDS * (1.0 - 0.6j))


@pytest.mark.parametrize("value", [-0.8, 0.8])
def test_amounts_of_real_numbers(value):
    check("abs", np.array([value, 1.0]))


def test_least_and_greatest_of_equal_numbers_have_one_derivative():
    one, two = Dual(0.5, [1.0]), Dual(0.5, [3.0])
    assert np.minimum(one, two).slopes == [1.0]
    assert np.maximum(one, two).slopes == [1.0]


@pytest.mark.parametrize("name", OF_TWO)
def test_constants_on_either_side(name):
    number, operation = Dual(0.8, [1.0]), RULES[name].value
    for find in (
        lambda x: operation(x, 2.5),
        lambda x: operation(2.5, x),
        lambda x: operation(np.array([2.5, 3.0]), x),
    ):
        found = find(number)
        difference = (find(0.8 + STEP) - find(0.8 - STEP)) / (2 * STEP)
        assert found.slopes[0] == pytest.approx(difference, rel=1e-7, abs=1e-9)


def test_operators_are_those_of_the_table():
    one, two = Dual(0.8, [0.7]), Dual(0.3, [-1.3])
    pairs = [(one + two, "add"), (one - two, "subtract"), (one * two, "multiply"), (one / two, "divide"),
             (one**two, "power")]  # fmt: skip
    for found, name in pairs:
        assert found.slopes == RULES[name].value(one, two).slopes
    assert ((1.0 + one).value, (1.0 - one).value, (2.0 * one).value) == (1.8, 1.0 - 0.8, 1.6)
    assert ((1.0 / one).value, (2.0**one).value, (-one).value, abs(-one).value) == (1.25, 2.0**0.8, -0.8, 0.8)
    assert (one > two, one >= two, one < two, one <= 0.8, one == 0.8, one != two) == (
        True,
        True,
        False,
        True,
        True,
        True,
    )


def test_powers_of_zero():
    zero = Dual(0.0, [1.0])
    assert ((zero**2).slopes, (zero**1).slopes, (zero**0).slopes) == ([0.0], [1.0], [0.0])


def test_undefined_values_are_no_errors():
    zero, one = Dual(0.0, [1.0]), Dual(1.0, [1.0])
    with np.errstate(all="ignore"):
        for undefined in (one / zero, np.sqrt(-one), np.log(-one), (-one) ** 0.5, np.arcsin(one + one)):
            assert not np.isfinite(undefined.value)
        for steep in (np.sqrt(zero), np.arccos(one), np.arctan2(zero, 0.0), np.hypot(zero, 0.0)):
            assert np.isfinite(steep.value)
            assert not np.isfinite(steep.slopes).any()


# -- arrays ------------------------------------------------------------------------------------------------


def rows():
    """Return a number with two tangents over (designs, rows), and a function that returns it elsewhere."""
    angle, factor = np.linspace(0.1, 5.9, 7), np.array([[1.0], [1.7], [0.4]])
    at = lambda s: (factor + s) * np.exp(1j * (angle + 0.3 * s))  # noqa: E731
    return at, Dual(at(0.0), np.array([(at(h) - at(-h)) / (2 * h) for h in (STEP, 2 * STEP)]))


@pytest.mark.parametrize(
    "find",
    [
        lambda z: z.real * z[:1].imag,  # (designs, rows) with (1, rows)
        lambda z: np.abs(z[:, ::2]) + z[..., ::2].real,
        lambda z: np.hypot(z[0].real, z.imag),  # (rows,) with (designs, rows)
        lambda z: np.where(z.real > 0.0, np.angle(z), 0.0),
        lambda z: z[:, None, 2].real * np.ones((3, 4)),
        lambda z: z.real.sum(axis=-1, keepdims=True),
        lambda z: np.mean(z.imag, axis=0),
        lambda z: np.diff(z.imag, axis=-1),
        lambda z: np.stack([z.real, z.imag * 2.0, np.ones(z.shape)]),
        lambda z: np.concatenate([z.real, z.imag], axis=1),
        lambda z: np.fmin.reduce(z.real, axis=-1, keepdims=True),
        lambda z: np.maximum.reduce(z.imag, axis=0),
        lambda z: np.broadcast_to(z[:, :1].real, z.shape),
        lambda z: np.take_along_axis(z.real, np.array([[3], [1], [0]]), -1),
        lambda z: phase(z),
        lambda z: np.unwrap(phase(z) * 2.0, axis=-1, period=2.0),
        lambda z: ARRAYS["rms of rows"](z.real),
        lambda z: ARRAYS["range of rows"](np.stack([z.real, z.imag])),
        lambda z: ARRAYS["integral of rows"](z.real, z.imag),
        lambda z: ARRAYS["last of rows"](z.real),
        lambda z: ARRAYS["argmax of rows"](z.real, z.imag),
    ],
)
def test_functions_of_arrays(find):
    at, z = rows()
    found = find(z)
    assert found.value == pytest.approx(find(at(0.0)))
    assert found.shape == found.slopes.shape[1:]
    difference = (find(at(STEP)) - find(at(-STEP))) / (2 * STEP)
    for slope in found.slopes:
        assert slope == pytest.approx(difference, rel=1e-6, abs=1e-8)


def test_what_has_no_derivatives_is_plain():
    number = Dual([0.3, np.nan], np.ones((2, 2)))
    for found in (
        number > 0.1,
        np.isfinite(number),
        np.ceil(number),
        np.sign(number),
        np.argmin(number),
        number < number,
    ):
        assert not isinstance(found, Dual)


def test_no_derivative_is_lost():
    with pytest.raises(TypeError):
        np.asarray(Dual(0.3, [1.0]))
    for function in (np.cosh, np.median, np.multiply.accumulate):
        with pytest.raises(TypeError):
            function(Dual([0.3], [[1.0]]))


def test_no_tangents():
    assert np.sum(Dual(np.ones(3), np.ones((0, 3))) * 2.0).slopes.shape == (0,)


# -- second and higher derivatives ---------------------------------------------------------------------------


TWO = {
    "add": lambda a, b: a + b, "subtract": lambda a, b: a - b, "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b, "power": lambda a, b: a**b, "atan2": lambda a, b: mpmath.atan(a / b),
}  # fmt: skip


def taylor(name, orders):
    """Return the coefficients along the curves a(t), b(t)."""
    operation = TWO.get(name) or getattr(mpmath, name)
    a, b = (lambda t: 0.6 + 0.2 * t - 0.4 * t**2 + 0.1 * t**3), (lambda t: 0.8 - 0.3 * t + 0.2 * t**2)
    along = (lambda t: operation(a(t), b(t))) if len(RULES[name].parts) > 1 else (lambda t: operation(a(t)))
    with mpmath.workdps(40):
        return [float(one) for one in mpmath.taylor(along, 0, orders - 1)]


CURVES = ([0.6, 0.2, -0.4, 0.1], [0.8, -0.3, 0.2, 0.0])


@pytest.mark.parametrize("name", ANALYTIC)
def test_series(name):
    own = [Series(np.array(c)[:, None]) for c in CURVES]
    found = RULES[name].value(*operands(name, own))
    assert found.c[:, 0] == pytest.approx(taylor(name, 4), rel=1e-12)


@pytest.mark.parametrize("name", ANALYTIC)
def test_jets(name):
    own = [Jet(np.array([c[0]]), np.array([[c[1]]]), np.array([[[2.0 * c[2]]]])) for c in CURVES]
    found = RULES[name].value(*operands(name, own))
    value, first, half = taylor(name, 3)
    assert (found.value[0], found.first[0, 0], found.second[0, 0, 0]) == pytest.approx((value, first, 2.0 * half))


@pytest.mark.parametrize("name", [name for name in COMPLEX if name not in ("power", "add", "subtract", "multiply")])
def test_jets_along_two_directions(name):
    """Of a(s, t) = a + p s + q t + r s t the mixed derivative is that of the series along s at each t."""
    a, p, q, r = 0.6 + 0.3j, 0.2 - 0.5j, -0.7 + 0.1j, 0.3 + 0.4j
    jet = Jet(np.array([a]), np.array([[p], [q]]), np.array([[[0.0], [r]], [[r], [0.0]]]))
    other = Jet(np.array([1.0 + 1.0j]), np.zeros((2, 1)), np.zeros((2, 2, 1)))
    operation = RULES[name].value
    mixed = operation(*operands(name, [jet, other])).second
    assert mixed[0, 1] == pytest.approx(mixed[1, 0], rel=1e-14)
    high, low = (
        operation(*operands(name, [Dual(a + q * t, [p + r * t]), Dual(1.0 + 1.0j, [0.0])])).slopes[0]
        for t in (STEP, -STEP)
    )
    assert mixed[0, 1, 0] == pytest.approx((high - low) / (2 * STEP), rel=1e-6)


# -- recorded numbers --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in RULES if name != "where"])
def test_recorded_numbers(name):
    recording = Recording()
    own = [recording.variable(value) for value in (0.6, 0.8)]
    found = recording.apply(name, *operands(name, own))
    if name in ("real", "imag", "conjugate"):
        found = found + 0.0
    assert found.value == pytest.approx(RULES[name].value(*operands(name, (0.6, 0.8))), rel=1e-14)
    values = np.array([[0.3, 0.5], [0.4, 0.7]])  # (variables, designs)
    assert recording.evaluate(values, [found.place])[found.place] == pytest.approx(
        RULES[name].value(*operands(name, values))
    )
    slopes = recording.tangents(values, [found.place])[found.place].slopes
    dual = RULES[name].value(*operands(name, [Dual(v, np.eye(2)[k][:, None]) for k, v in enumerate(values)]))
    assert slopes == pytest.approx(np.array(dual.slopes))


def test_what_the_nominal_design_decides():
    recording = Recording()
    number = recording.variable(0.6)
    assert (number > 0.5, number < 0.5, number == 0.6, bool(number)) == (True, False, True, True)
    assert number + 1.0 is number + 1.0  # recorded once
    with pytest.raises(TypeError):
        float(number)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_of_plain_and_recorded_numbers(name):
    own = (0.6, 0.8)[: 2 if name in ("atan2", "hypot", "min", "max") else 1]
    plain = FUNCTIONS[name](*own)
    assert isinstance(plain, float)
    found = FUNCTIONS[name](Recording().variable(own[0]), *own[1:])
    assert isinstance(found, Recorded)
    assert nominal(found) == pytest.approx(plain, rel=1e-14)
