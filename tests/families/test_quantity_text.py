"""The text of kept quantities, on columns that are given."""

import re

import numpy as np
import pytest
from bundled import MODELS

import gimcli
from gimcli.errors import UsageError
from gimcli.families.column_names import ColumnNames
from gimcli.families.quantity_text import quantity

NAN = float("nan")


class Given:
    """Columns of two designs with three rows."""

    def __init__(self, rows=slice(None)):
        x, y = [[1.0, 2.0, 3.0], [4.0, NAN, 8.0]], [[-1.0, 0.0, 1.0], [2.0, NAN, 2.0]]
        self.columns = {name: np.array(own)[:, rows] for name, own in (("P.x", x), ("P.y", y))}
        self.columns |= {"crank.length": np.array([[5.0], [6.0]]), "type": np.array([["kite"], ["rhombus"]])}

    def __getitem__(self, name):
        return self.columns[name]

    def at(self, actuator, value):
        assert (actuator, value) == ("motor", 30.0)
        return Given(slice(0, 1))


def names():
    return ColumnNames(gimcli.load(MODELS / "crank_rocker.yaml"), ["crank.length"])


def found(text, *kinds):
    return quantity(text, names(), kinds or ("number", "text")).values(Given())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("min(P.x)", [1, 4]), ("max(P.x)", [3, 8]), ("range(P.x)", [2, 4]), ("mean(P.x)", [2, 6]),
        ("rms(P.y)", [np.sqrt(2 / 3), 2]), ("at(P.x, motor=30)", [1, 4]), ("max(P.x - P.y)", [2, 6]),
        ("max(P.x) - min(P.y) * 2", [5, 4]), ("max(abs(P.x - mean(P.x)))", [1, 2]), ("-max(P.x)**2", [-9, -64]),
        ("2**-1 * crank.length", [2.5, 3]), ("(max(P.x) + 1) / 2", [2, 4.5]), ("hypot(max(P.x), 4)", [5, 80**0.5]),
        ("max(P.x*crank.length)", [15, 48]), ("degrees(pi) * min(P.x)", [180, 720]), ("1e1 + .5*min(P.x)", [10.5, 12]),
    ],
)  # fmt: skip
def test_numbers(text, expected):
    assert found(text) == pytest.approx(np.array(expected, dtype=float))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("max(P.x) > 5", [False, True]), ("max(P.x) > 5 or min(P.y) < 0", [True, True]),
        ("not (max(P.x) > 5) and min(P.x) == 1", [True, False]), ('type == "kite"', [True, False]),
        ("type != 'kite' and max(P.x) <= 8", [False, True]), ("max(P.x)>=3 and max(P.x)<4", [True, False]),
    ],
)  # fmt: skip
def test_conditions(text, expected):
    assert found(text, "yes").tolist() == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0/0 != 1", False), ("not (0/0 > 1)", False), ("1/0 > 1", False), ("not (1/0 < 1 and 1 < 2)", False),
        ("0/0 > 1 or 1 < 2", True), ("not (0/0 > 1 and 1 > 2)", True), ("not (0/0 > 1 or 1 > 2)", False),
    ],
)  # fmt: skip
def test_a_condition_holds_only_where_what_decides_it_is_defined(text, expected):
    """Kleene's three-valued logic: unknown, if the defined sides do not decide alone."""
    assert bool(found(text, "yes")) == expected


@pytest.mark.parametrize(("text", "expected"), [("1+" * 499 + "1", 500), ("-max(P.x)" + "+min(P.x)" * 100, [97, 392])])
def test_long_texts(text, expected):
    assert found(text) == pytest.approx(np.array(expected, dtype=float))


def test_values_that_are_not_defined_are_empty():
    assert np.isnan(found("max(P.x) / 0")).all()
    assert np.isnan(found("exp(1000 * crank.length)")).all()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("P.x", "write for example min(P.x)"), ("min(P.z)", "did you mean 'P."), ("min(5)", "takes a column"),
        ("min(P.x", "expected ')'"), ("", "expected a name or number"), ("min(P.x) +", "expected a name or number"),
        ("min(P.x) min(P.y)", "expected the end or an operator"), ("least(P.x)", "no function 'least'"),
        ("at(P.x)", "expected ','"), ("at(P.x, 30)", "needs the value of an input"),
        ("at(P.x, moto=30)", "did you mean 'motor'"), ("at(P.x, motor=400)", "the law of motor is 0 to 360"),
        ("type + 1", "got a text"), ("min(P.x) > 3", "expected a number"), ("type < 'a'", "by == or !="),
        ("(" * 60 + "1" + ")" * 60, "more than 50"), ("1+" * 1500 + "1", "at most 1000"),
        ("mean(transmission:rod/rocker)", "no member, sliding pair or linear actuator 'rod'"),
        ("__import__", "no column"), ("crank", "did you mean 'crank.length'"),
        ("min(P.x) = 3", "the sign of equality is =="),
    ],
)  # fmt: skip
def test_invalid_texts_are_refused(text, message):
    with pytest.raises(UsageError) as refused:
        found(text)
    assert message in str(refused.value)


@pytest.mark.parametrize("text", ["P.x", "min(P.z)", "at(P.x, moto=30)", "min(P.x"])
def test_messages_name_the_option_and_the_text(text):
    with pytest.raises(UsageError, match=f"^goal '{re.escape(text)}': "):
        quantity(text, names(), where="goal")


def test_units():
    units = {"min(P.x)": "mm", "range(rocker.omega)": "deg/s", "max(P.x) - min(P.y)": "mm", "max(P.x)/2": ""}
    assert {text: quantity(text, names()).unit for text in units} == units
