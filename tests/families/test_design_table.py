"""Tables of designs: values, combinations, samples; any part of a table equals that part of the whole."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.stats import kstest, norm, qmc

from gimcli import UsageError
from gimcli.families.design_table import design_table, permuted
from gimcli.families.variation import varied


def table(vary, **options):
    return design_table(varied(vary), **options)


def test_combinations_have_the_last_dimension_first():
    one = table({"a": "10:20:3", "b": "3,4"})
    assert one.count == 6
    assert one.rows(0, 6).tolist() == [[10, 3], [10, 4], [15, 3], [15, 4], [20, 3], [20, 4]]


def test_arrays_and_numbers_are_listed_values():
    assert table({"a": np.array([1.0, 2.5]), "b": 7}).rows(0, 2).tolist() == [[1.0, 7.0], [2.5, 7.0]]


@pytest.mark.parametrize("points", ["random", "latin", "sobol"])
def test_parts_of_a_sample_equal_the_whole(points):
    one = table({"a": "uniform(-1,3)", "b": "normal(40,0.5)"}, samples=3000, points=points, seed=4)
    whole = one.rows(0, 3000)
    cuts = [0, 1, 1023, 1024, 1700, 3000]
    parts = [one.rows(i, j) for i, j in pairwise(cuts)]
    assert np.array_equal(np.concatenate(parts), whole)
    assert not np.array_equal(table({"a": "uniform(-1,3)", "b": "normal(40,0.5)"}, samples=3000, points=points,
                                    seed=5).rows(0, 3000), whole)  # fmt: skip


@pytest.mark.parametrize("points", ["random", "latin", "sobol"])
def test_samples_have_their_distributions(points):
    a, b = table({"a": "uniform(-1,3)", "b": "normal(40,0.5)"}, samples=4096, points=points).rows(0, 4096).T
    assert a.min() > -1.0
    assert a.max() < 3.0
    assert kstest((a + 1.0) / 4.0, "uniform").pvalue > 1e-3
    assert kstest(b, norm(40, 0.5).cdf).pvalue > 1e-3
    assert abs(np.corrcoef(a, b)[0, 1]) < 4.0 / np.sqrt(4096)


@pytest.mark.parametrize("count", [1, 2, 7, 1000, 1025])
def test_latin_hypercube_has_one_point_in_each_part(count):
    x = table({"a": "uniform(0,1)", "b": "uniform(0,1)"}, samples=count, points="latin", seed=9).rows(0, count)
    for axis in x.T:
        assert sorted(np.floor(axis * count)) == list(range(count))
    assert np.array_equal(np.sort(permuted(np.arange(count, dtype=np.uint64), count, 3, 0)), np.arange(count))


def test_sobol_points_are_those_of_scipy():
    x = table({"a": "uniform(0,1)", "b": "uniform(0,1)"}, samples=64, points="sobol", seed=2).rows(0, 64)
    assert np.array_equal(x, qmc.Sobol(2, seed=np.random.default_rng(2)).random_base2(6))


def test_the_last_of_ten_million_designs_costs_no_table():
    one = table({"a": "uniform(0,1)"}, samples=10_000_000, points="latin")
    assert one.rows(9_999_990, 10_000_000).shape == (10, 1)


@pytest.mark.parametrize(
    ("vary", "options", "message"),
    [
        ({"a": "10:20"}, {}, "vary a=10:20: expected values such as"),
        ({"a": "10:20:1"}, {}, "expected a number of values from 2"),
        ({"a": "10:x:3"}, {}, "'x' is not a finite number"),
        ({"a": "1,,2"}, {}, "'' is not a finite number"),
        ({"a": [1.0, np.nan]}, {}, "finite values"),
        ({"a": [1, 10**400]}, {}, "an array of values"),
        ({"a": "1_0"}, {}, "'1_0' is not a finite number"),
        ({"a": "-1e308:1e308:3"}, {}, "too large"),
        ({"a": "uniform(-1e308,1e308)"}, {"samples": 5}, "too large"),
        ({"a": "normal(0,1e308)"}, {"samples": 5}, "too large"),
        ({"a": "uniform(3,2)"}, {"samples": 5}, "the smaller value first"),
        ({"a": "normal(3,0)"}, {"samples": 5}, "standard deviation above 0"),
        ({"a": "1,2", "b": "uniform(1,2)"}, {}, "'a' has listed values and 'b' a distribution"),
        ({"a": "1,2"}, {"samples": 5}, "remove samples"),
        ({"a": "uniform(1,2)"}, {}, "needs the number of samples"),
        ({}, {}, "name at least one dimension"),
        ({"a": "0:1:10000", "b": "0:1:10000"}, {}, "100000000 designs"),
        ({"a": "uniform(1,2)"}, {"samples": 5, "points": "halton"}, "expected one of random, latin, sobol"),
    ],
)
def test_invalid_variations_are_refused(vary, options, message):
    with pytest.raises(UsageError) as refused:
        table(vary, **options)
    assert message in str(refused.value)
