"""Roots and interpolation against zeros of Bessel functions, roots of Wallis's cubic and polynomials themselves."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.special import jn_zeros, jnp_zeros, jv, jvp

from gimcli.numerics import along


def test_bisection_ends_at_neighbouring_numbers() -> None:
    low, high = along.bisected(lambda x: x * x >= 2.0, 1.0, 2.0)
    assert low * low < 2.0 <= high * high
    assert high == np.nextafter(low, 2.0)


def test_bisection_of_several_pairs_in_either_sense() -> None:
    wanted = np.array([2.0, 3.0, 5.0])
    _, first = along.bisected(lambda x: x * x >= wanted, np.ones(3), np.full(3, 4.0))
    assert first == pytest.approx(np.sqrt(wanted), rel=1e-15)
    last, _ = along.bisected(lambda x: x * x < 7.0, 4.0, 1.0)
    assert last == pytest.approx(np.sqrt(7.0), rel=1e-15)


def test_zeros_of_a_bessel_function() -> None:
    found = along.sign_changes(lambda x: jv(0, x), np.linspace(0.0, 40.0, 41))
    assert found == pytest.approx(jn_zeros(0, 12), rel=1e-14)
    assert not len(along.sign_changes(np.exp, np.linspace(0.0, 1.0, 5)))


def test_the_root_of_wallis_is_found_by_few_points() -> None:
    """x^3 - 2x - 5 = 0 at 2.09455148154232659...; a steep and a flat curve need more points, but lose nothing."""
    tried: list[float] = []

    def found(value, low: float, high: float) -> float:
        tried.clear()
        return along.root(lambda x: tried.append(x) or x, value, (low, low), (high, high), 1e-15)

    assert found(lambda x: x**3 - 2.0 * x - 5.0, 2.0, 3.0) == pytest.approx(2.0945514815423266, rel=1e-15)
    assert len(tried) <= 8
    assert found(lambda x: np.expm1(20.0 * x), -1.0, 1.0) == pytest.approx(0.0, abs=1e-15)
    assert found(lambda x: (x - 0.25) ** 3, -1.0, 2.0) == pytest.approx(0.25, abs=1e-12)
    assert found(lambda x: np.sign(x - np.pi), 3.0, 4.0) == pytest.approx(np.pi, rel=1e-15)


class Extreme(along.Bracket):
    """The search of an extreme of a Bessel function, from the zeros of its derivative."""

    def __init__(self, order: int, low: float, high: float) -> None:
        super().__init__([low, high], [jvp(order, low), jvp(order, high)])
        self.quantity, self.shift = order, 1.0

    def next(self) -> float | None:
        return self.guess() if self.shift > 1e-14 else None

    def take(self, place: float, found: float) -> None:
        self.replace(place, float(found))
        self.shift = abs(self.guess() - place)


def test_extremes_of_several_functions_are_searched_together() -> None:
    """Zeros of the derivatives of J_1 and J_2; each round asks once, at increasing places, of those not found yet."""
    searches = [Extreme(order, z - 1.0, z + 1.0) for order in (1, 2) for z in jnp_zeros(order, 3)]
    asked: list[int] = []

    def evaluate(places: np.ndarray) -> Callable[[int], np.ndarray]:
        assert np.all(np.diff(places) > 0.0)
        asked.append(len(places))
        return lambda order: jvp(order, places)

    along.search_together(searches, evaluate, 40)
    assert len(asked) < 20
    assert asked[0] == 6
    assert asked == sorted(asked, reverse=True)
    assert [s.guess() for s in searches] == pytest.approx([*jnp_zeros(1, 3), *jnp_zeros(2, 3)], rel=1e-14)


@pytest.mark.parametrize("t", [0.0, 0.3, 1.0, 1.7])
def test_a_cubic_is_its_own_interpolation(t: float) -> None:
    cubic, begin, length = np.polynomial.Polynomial([0.3, -1.1, 0.7, 2.0]), -0.4, 1.5
    end = begin + length
    data = cubic(begin), length * cubic.deriv()(begin), cubic(end), length * cubic.deriv()(end)
    assert along.hermite(*data, t) == pytest.approx(cubic(begin + t * length), abs=1e-13)
    assert along.hermite_slope(*data, t) == pytest.approx(length * cubic.deriv()(begin + t * length), abs=1e-13)
    nodes = [-1.0, 0.1, 0.9, 2.0]
    assert np.dot(along.lagrange(nodes, t), cubic(np.array(nodes))) == pytest.approx(cubic(t), abs=1e-13)
