"""A range between two limits is never a full turn, however wide; the trace names what the other side of it has."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from bundled import MODELS
from four_bars import four_bar_text
from typer.testing import CliRunner

import gimcli
from gimcli.cli import app

NUMBERS = re.compile(r"(-?[\d.]+) to (-?[\d.]+)")

RANGE = "10.412 to 398.469 deg"
"""Range of the motor of this assembly, wider than a turn: its closed curve has two limits and makes no turn."""


@pytest.mark.parametrize("command", ["trace", "check", "singularities", "circuits"])
def test_a_range_between_limits_wider_than_a_turn(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    output = CliRunner().invoke(app, [command, "double_butterfly", "--assembly", "6"]).stdout
    assert RANGE in output
    assert not [line for line in output.splitlines() if RANGE in line and "full turn" in line]


def report(model: str, *more: str) -> tuple[dict[str, list[float]], dict[str, list[float]], str]:
    """Trace a model; return the unreachable values of each input, and the intervals of each line that prints one."""
    result = CliRunner().invoke(app, ["trace", model, "-n", "72", "-o", "-", *more])
    rows = list(csv.DictReader(result.stdout.splitlines()))
    names = [a.name for a in gimcli.load(model).actuators]
    unsolved = {n: [float(r[n]) for r in rows if r["status"] == "unreachable"] for n in names}
    lines = [line.partition("; its law")[0] for line in result.stderr.splitlines()]
    printed = {line: [float(x) for x in found.groups()] for line in lines if (found := NUMBERS.search(line))}
    return unsolved, printed, result.stderr


def check_ranges(model: str) -> bool:
    """Check that each unreachable value within a printed range, also whole turns away, is named; return if any is."""
    unsolved, printed, text = report(model)
    named = [ends for line, ends in printed.items() if line.startswith(("the circuit reaches", "the law returns"))]
    for name, values in unsolved.items():
        ranges = [ends for line, ends in printed.items() if line.startswith((f"range of {name} ", f"{name} reaches"))]
        for value in values:
            turns = [value + 360.0 * k for k in range(-3, 4)]
            inside = [v for v in turns if any(low + 0.01 < v < high - 0.01 for low, high in ranges)]
            assert not inside or any(low - 0.01 <= v <= high + 0.01 for v in inside for low, high in named), text
    return bool(named)


def other_way(text: str, law: str, report: str) -> None:
    """Check that the law has all its rows with the end that the report gives."""
    (end,) = re.findall(r"write `to: ([-\d.]+)`", report)
    found = gimcli.trace(gimcli.loads(text.replace(law, law.replace("by: 360", f"to: {end}"))), 72)
    assert found.solved == 73


def random_four_bar(rng: np.random.Generator) -> tuple[str, str]:
    """Return a four-bar whose law makes a turn from anywhere within its range, and the text of the law."""
    while True:
        lengths, angle = rng.uniform(0.5, 3.0, 4).tolist(), float(rng.uniform(-np.pi, np.pi))
        arm = abs(lengths[3] - lengths[0] * np.exp(1j * angle))
        if abs(lengths[1] - lengths[2]) * 1.001 < arm < 0.999 * (lengths[1] + lengths[2]):
            law = ", law: {by: 360}"
            return four_bar_text(*lengths, angle, law=law, driven=str(rng.choice(["crank", "follower"]))), law


def check_four_bars(count: int, seed: int, folder: Path) -> None:
    rng, named = np.random.default_rng(seed), 0
    for _ in range(count):
        text, law = random_four_bar(rng)
        (folder / "m.yaml").write_text(text)
        if check_ranges(str(folder / "m.yaml")):
            named += 1
            other_way(text, law, report(str(folder / "m.yaml"))[2])
    assert named > count // 5


def test_ranges_of_random_four_bars(tmp_path: Path) -> None:
    check_four_bars(16, 1, tmp_path)


@pytest.mark.soak
def test_ranges_of_two_hundred_four_bars(tmp_path: Path) -> None:
    check_four_bars(200, 2, tmp_path)


@pytest.mark.soak
@pytest.mark.parametrize("path", sorted(MODELS.glob("*.yaml")), ids=lambda path: path.stem)
def test_ranges_of_the_shipped_models(path: Path) -> None:
    if gimcli.load(path).actuators:
        check_ranges(str(path))


def test_a_law_that_returns_into_the_range(tmp_path: Path) -> None:
    """Lengths 2, 3, 1, 3: the crank swings between 41.410 and 104.478 deg (law of cosines)."""
    text = four_bar_text(2.0, 3.0, 1.0, 3.0, np.radians(60.0), law=", law: {table: law.csv}")
    (tmp_path / "law.csv").write_text("0,60\n1,130\n2,50\n")
    model = str(tmp_path / "m.yaml")
    (tmp_path / "m.yaml").write_text(text)
    assert check_ranges(model)
    assert "--at-limit skip solves these rows too" in report(model)[2]
    assert min(report(model, "--at-limit", "skip")[0]["motor"]) > 104.477
