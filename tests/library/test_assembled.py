"""`--assembly` and `assembled`: results are those of a model file drawn in that configuration."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
import yaml
from bundled import MODELS
from in_process import gim, ran, refused

import gimcli
from gimcli.model.source import read_source

COMMANDS = {
    "trace": ("--steps", "24", "--derivatives", "2"),
    "solve": ("--velocities",),
    "singularities": (),
    "circuits": ("--samples", "8"),
    "workspace": (),
    "forces": ("--steps", "24"),
    "simulate": ("--time", "0.2", "--dt", "0.05"),
    "reduce": ("--steps", "12"),
    "sequence": (),
    "mobility": (),
}
"""Options of the commands that have --assembly; `tradeoff` measures times, `check` prints places in the file."""


def redrawn(name, k, folder):
    """Write a model whose initial coordinates are those of a configuration, with all dimensions explicit."""
    data = read_source(MODELS / f"{name}.yaml").data
    one = gim("solve", MODELS / f"{name}.yaml", "--all", "--json").json["configurations"][k - 1]
    before = {n: complex(*z) for n, z in data["nodes"].items()}
    for link, part in data.get("links", {}).items():
        part = {"nodes": part} if isinstance(part, list) else part
        a, b = part["nodes"]
        data["links"][link] = {**part, "length": part.get("length", abs(before[b] - before[a]))}
    for plate, part in data.get("elements", {}).items():
        part = {"nodes": part} if isinstance(part, list) else part
        drawn = {n: [before[n].real, before[n].imag] for n in part["nodes"]}
        data["elements"][plate] = {"shape": drawn, **part}
    data["nodes"] = one["nodes"]
    for point, at in one["points"].items():
        if "at" in data["points"][point]:
            data["points"][point]["at"] = at
    path = folder / f"{name}.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False))
    return path


def numbers(path):
    """Return the cells of a table; numbers as numbers."""

    def cell(text):
        try:
            return float(text)
        except ValueError:
            return text

    with Path(path).open(newline="") as handle:
        return [[cell(text) for text in row] for row in csv.reader(handle)]


def same(one, other, size):
    assert len(one) == len(other)
    names = one[0]
    for row, its in zip(one, other, strict=True):
        for name, a, b in zip(names, row, its, strict=True):
            if name in ("residual", "sweeps", "energy.drift", "power.error"):
                continue  # rounding errors
            if isinstance(a, str) or isinstance(b, str):
                assert a == b, name
            else:
                assert math.isclose(a, b, rel_tol=1e-6, abs_tol=1e-7 * size), (name, a, b)


@pytest.mark.parametrize(
    "command", [pytest.param(c, marks=pytest.mark.soak) if c == "circuits" else c for c in COMMANDS]
)
def test_results_are_those_of_a_file_drawn_in_the_configuration(command, tmp_path):
    """Configuration 2 of 4: neither the initial one nor the first."""
    model, options = MODELS / "watt_durango.yaml", COMMANDS[command]
    other = redrawn("watt_durango", 2, tmp_path)
    tables = [tmp_path / f"{k}.csv" for k in range(3)]
    first = gim(command, model, "--assembly", "2", *options, "-o", tables[0])
    second = gim(command, other, *options, "-o", tables[1])
    assert first.code == second.code
    found, expected = numbers(tables[0]), numbers(tables[1])
    same(found, expected, 100.0)
    gim(command, model, *options, "-o", tables[2])
    if command not in ("mobility", "sequence", "circuits"):
        assert found != numbers(tables[2])


@pytest.mark.parametrize(("name", "k"), [("double_butterfly", 3), ("excavator", 6), ("jansen", 3)])
def test_motions_of_coupled_groups_and_linear_inputs(name, k, tmp_path):
    other, tables = redrawn(name, k, tmp_path), [tmp_path / "1.csv", tmp_path / "2.csv"]
    gim("trace", MODELS / f"{name}.yaml", "--assembly", k, "--steps", "24", "-o", tables[0])
    gim("trace", other, "--steps", "24", "-o", tables[1])
    same(*map(numbers, tables), 100.0)


def test_every_command_that_solves_has_the_option():
    for command in (*COMMANDS, "check", "tradeoff", "view"):
        assert "--assembly K" in gim(command, "--help").text, command


@pytest.mark.parametrize("given", ["1", "+"])
def test_number_and_signs_choose_the_same(given):
    """Crank-rocker: the two intersections of the circles about A and O4, one on each side of the line between them."""
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    listed = gimcli.configurations(m)
    p = gimcli.solve(gimcli.assembled(m, assembly=given))
    np.testing.assert_allclose(p.xy["B"], listed.xy["B"][0], atol=1e-9)
    mirrored = listed.xy["B"][1] * [1.0, -1.0]  # A and O4 are on the x axis at the start
    np.testing.assert_allclose(p.xy["B"], mirrored, atol=1e-9)


def test_the_circuit_of_the_configuration_is_marked():
    text = gim("circuits", MODELS / "crank_rocker.yaml", "--assembly", "1").text
    assert [line.split()[:2] for line in text.splitlines() if line.startswith((" 1", " 2"))] == [
        ["1", "*"],
        ["2", "closed"],
    ]


def test_solve_takes_the_configuration_at_the_inputs_of_at():
    """The numbers count the configurations at 145 deg; the initial one has another number than at the start."""
    model = MODELS / "double_butterfly.yaml"
    listed = gim("solve", model, "--all", "--at", "motor=145", "--json").json["configurations"]
    for k, one in enumerate(listed, 1):
        found = gim("solve", model, "--at", "motor=145", "--assembly", k, "--json").json
        for node, place in one["nodes"].items():
            np.testing.assert_allclose(found["nodes"][node], place, atol=1e-8)


def test_springs_measure_in_the_configuration(tmp_path):
    """A torsion spring at O4: its angle is that of the rocker in the configuration, so its torque has another sign."""
    data = read_source(MODELS / "crank_rocker.yaml").data
    data["springs"] = {"spiral": {"pivot": "O4", "arm": "B", "stiffness": 1.0, "free": 0.0}}
    m = gimcli.load(data)
    energy = [gimcli.forces(gimcli.assembled(m, assembly=k), steps=1)["energy.potential"][0] for k in (1, 2)]
    angle = math.atan2(71.10243002567181, 136.66666666666669 - 100.0)  # of the rocker at the start
    np.testing.assert_allclose(energy, 0.5 * angle**2, rtol=1e-9)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ("5", "expected a number from 1 to 4, or the signs ++, +-, -+, --"),
        ("0", "expected a number from 1 to 4"),
        ("+", "is not unique: it begins ++, +-; give all signs, or the number"),
        ("(1)", "or the signs ++, +-, -+, --"),
        ("+-+", "or the signs"),
        ("two", "or the signs"),
    ],
)
def test_other_numbers_and_signs_are_refused(given, text):
    error = refused("solve", MODELS / "watt_1.yaml", f"--assembly={given}")
    assert f"assembly {given}: " in error
    assert text in error


def test_the_tolerance_applies_to_redundant_constraints(tmp_path):
    """A third crank that is 1e-7 too long contradicts the others, but the error is below 1e-6."""
    text = (MODELS / "parallelogram_third_crank.yaml").read_text()
    model = tmp_path / "model.yaml"
    model.write_text(text.replace("right: {nodes: [D, C], length: 1}", "right: {nodes: [D, C], length: 1.0000001}"))
    assert "does not exist" in refused("solve", model, "--assembly", "1", code=5)
    assert ran("solve", model, "--assembly", "1", "--tolerance", "1e-6").code == 0


def test_signs_that_begin_with_minus_need_no_equals_sign():
    assert ran("solve", MODELS / "watt_1.yaml", "--assembly", "--", "--json").code == 0
    assert ran("solve", MODELS / "watt_1.yaml", "--assembly", "-+", "--json").code == 0


@pytest.mark.parametrize("options", [("--all",), ("--start", "random")])
def test_options_that_exclude_it(options):
    assert "--assembly" in refused("solve", MODELS / "watt_1.yaml", "--assembly", "2", *options)
