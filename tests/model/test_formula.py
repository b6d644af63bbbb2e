"""Formulas against Python's own arithmetic, and what is no formula."""

from __future__ import annotations

import math
import random

import pytest

from gimcli.language.expression import CONSTANTS, FUNCTIONS, ExpressionError
from gimcli.language.reader import DEEPEST, LONGEST
from gimcli.model.arithmetic import parsed

NAMES = {"a": 1.5, "b_2": -0.25, "größe": 7.0}
PYTHON = {**{name: getattr(math, name, None) for name in FUNCTIONS}, "abs": abs, "min": min, "max": max, **NAMES}
PYTHON |= {"pi": math.pi, "deg": math.radians(1.0), "__builtins__": {}}


def some_formula(draw: random.Random, depth: int) -> str:
    """Return a random text of the grammar; numbers are floats, as integers of Python have no overflow."""
    kind = draw.randrange(9) if depth else draw.randrange(2)
    if kind == 0:
        return draw.choice(["2.0", ".5", "3.", "1e-1", "1.25E+1", "0.1"])
    if kind == 1:
        return draw.choice([*NAMES, "pi", "deg"])
    one, other = some_formula(draw, depth - 1), some_formula(draw, depth - 1)
    if kind < 6:
        return one + draw.choice(["+", " - ", "*", " / ", "**", " ** "]) + other
    if kind == 6:
        return draw.choice("+-") + one
    if kind == 7:
        return f"( {one} )"
    name = draw.choice(list(FUNCTIONS))
    return f"{name}({one}, {other})" if name in ("atan2", "hypot", "min", "max") else f"{name}({one})"


def test_formulas_have_the_values_of_python():
    draw, compared = random.Random(1), 0
    for _ in range(3000):
        text = some_formula(draw, 4)
        try:
            expected = eval(text, PYTHON)
        except (ValueError, ArithmeticError, TypeError):
            expected = 1j
        if len(text) > LONGEST or ("**" in text and "abs" in text):  # abs of a complex number is real in Python
            continue
        if isinstance(expected, complex) or not math.isfinite(expected):
            with pytest.raises(ExpressionError):
                parsed(text, NAMES).number(NAMES)
        else:
            assert parsed(text, NAMES).number(NAMES) == expected, text
            compared += 1
    assert compared > 1500


@pytest.mark.parametrize(("text", "value"), [
    ("-2**2", -4.0), ("2**-1", 0.5), ("2**3**2", 512.0), ("8/2/2", 2.0), ("1-2-3", -4.0), ("--3", 3.0),
    (" 2 * a\n + 3 ", 6.0), ("sin(30*deg)", math.sin(math.pi / 6)), ("max(1, 2, a)", 2.0),
])  # fmt: skip
def test_precedence(text, value):
    assert parsed(text, NAMES).number(NAMES) == value


def test_the_parameters_of_a_formula():
    assert parsed("a + sin(b_2*pi) - a", NAMES).names == {"a", "b_2"}


@pytest.mark.parametrize("text", [
    "(" * 5000 + "1" + ")" * 5000, "-" * (DEEPEST + 1) + "1", "2**" * (DEEPEST + 1) + "1", "1+" * 600 + "1",
    "(" * (DEEPEST + 1) + "1" + ")" * (DEEPEST + 1),
])  # fmt: skip
def test_size_and_depth_are_bounded(text):
    with pytest.raises(ExpressionError):
        parsed(text, {})


def test_the_longest_formula_is_read():
    text = "+".join(["1"] * (LONGEST // 2))
    assert parsed(text, {}).number({}) == LONGEST // 2


def test_any_objects_with_operators_are_evaluated():
    class Recorded(str):
        """A number that records what is done with it."""

        def __add__(self, other):
            return Recorded(f"({self}+{other})")

        def __rmul__(self, other):
            return Recorded(f"({other}*{self})")

    functions = {"sin": lambda value: Recorded(f"sin {value}")}
    assert parsed("2*sin(a) + 3", {"a": 0}).value({"a": Recorded("A")}, functions) == "((2.0*sin A)+3.0)"


def test_no_constant_has_the_name_of_a_function():
    assert not CONSTANTS.keys() & FUNCTIONS.keys()
