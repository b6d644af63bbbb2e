"""Numbers for people are rounded relative to the mechanism's size; files have all digits."""

from __future__ import annotations

import math
import re

import pytest
from bundled import MODELS
from in_process import gim

import gimcli
from gimcli.model.source import read_source
from gimcli.rounding import input_value, interval, length, number


@pytest.mark.parametrize(
    ("value", "size", "text"),
    [
        (2.755e-15, 1.0, "0"), (-1.597e-29, 3.3, "0"), (-0.0, 1.0, "0"), (0.0, 0.0, "0"), (2e-9, 1.0, "2e-09"),
        (136.66666666666669, 200.0, "136.667"), (71.1024300257, 200.0, "71.102"), (0.00123456, 200.0, "0.001235"),
        (140000012.345678, 200.0, "140000012.346"), (3.14159265e-9, 2e-9, "3.14159e-09"),
        (12345678.0, 1e7, "1.23457e+07"),
        (1234.5678, 0.0, "1234.57"), (math.nan, 1.0, "-"), (math.inf, 1.0, "-"), (2.755e-15, 0.0, "2.755e-15"),
    ],
)  # fmt: skip
def test_number(value, size, text):
    assert number(value, size) == text


def scaled(factor):
    """Return the crank-rocker with every length multiplied by a factor."""
    data = read_source(MODELS / "crank_rocker.yaml").data
    data["nodes"] = {name: [factor * x for x in place] for name, place in data["nodes"].items()}
    data["links"] = {
        name: link | {"length": factor * link["length"]} if isinstance(link, dict) else link
        for name, link in data["links"].items()
    }
    data["points"] = {
        name: {key: [factor * x for x in value] if key in ("at", "local") else value for key, value in point.items()}
        for name, point in data["points"].items()
    }
    return data


@pytest.mark.parametrize("power", [-12, -9, -6, -3, 3, 6])
def test_the_digits_do_not_depend_on_the_unit_of_length(power):
    """Of a mechanism in units of 1e-12 nothing is shown as zero that is not, and no digits are added."""
    here, there = gimcli.load(scaled(1.0)), gimcli.load(scaled(10.0**power))
    for value in (136.66666666666669, 71.10243002567181, 0.07, 1e-12, -40.0):
        one, other = length(here, value), length(there, value * 10.0**power)
        assert float(other) == pytest.approx(float(one) * 10.0**power, rel=1e-12)


def test_units_and_full_turns():
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    assert interval(m, "motor", 1.909830056, 361.9098301) == "full turn"
    assert interval(m, "motor", 0.0, 720.0) == "full turn"
    assert interval(m, "motor", 0.0, 359.9) == "0 to 359.9 deg"
    assert input_value(m, "motor", 1e-13) == "0"
    jack = gimcli.load(MODELS / "excavator.yaml")
    assert interval(jack, "boom_ram", 119.02888843, 191.46347391) == "119.029 to 191.463 cm"
    assert interval(jack, "boom_ram", 0.0, 400.0) == "0 to 400 cm"


@pytest.mark.few(4)
@pytest.mark.parametrize(
    "arguments",
    [
        ("solve", "crank_rocker", "--velocities", "--at", "motor=45"), ("solve", "double_butterfly", "--all"),
        ("trace", "chebyshev", "--circuit"), ("trace", "crank_rocker", "-m", "transmission", "-m", "curvature:P"),
        ("circuits", "excavator"), ("singularities", "crank_shaper"), ("forces", "watt_1"), ("reduce", "watt_durango"),
        ("workspace", "crank_rocker"), ("simulate", "watt_durango", "--time", "4"),
    ],
)  # fmt: skip
def test_reports_have_at_most_six_digits_and_no_rounding_noise(arguments, tmp_path, monkeypatch):
    """Residuals and errors, which are small by nature, are outside the tables' cells: they have two digits."""
    monkeypatch.chdir(tmp_path)
    command, model, *more = arguments
    found = gim(command, MODELS / f"{model}.yaml", *more)
    assert found.code == 0
    for text in re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])", found.text):
        mantissa = text.lstrip("-").partition("e")[0].replace(".", "").lstrip("0")
        assert len(mantissa) <= 6, text
        assert abs(float(text)) > 1e-9 or len(mantissa) <= 2, text


def test_the_circuit_of_the_drawing_is_marked():
    lines = gim("circuits", MODELS / "excavator.yaml").text.splitlines()
    assert [line.split()[:2] for line in lines if " * " in line[:5]] == [["1", "*"]]
