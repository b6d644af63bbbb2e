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


@pytest.mark.few(2)
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


def slider_crank_text(crank: float, rod: float, offset: float, angle: float, law: str) -> str:
    """Return a slider-crank on a line at a height, drawn at an angle of the crank at which it closes."""
    x, y = crank * np.cos(angle), crank * np.sin(angle)
    end = x + np.sqrt(rod**2 - (offset - y) ** 2)
    return f"""
nodes: {{O: [0, 0], A: [{x:.15g}, {y:.15g}], B: [{end:.15g}, {offset}], G: [0, {offset}], H: [1, {offset}]}}
ground: [O, G, H]
links: {{crank: [O, A], rod: [A, B]}}
prismatic: {{slide: {{node: B, guide: [G, H]}}}}
actuators: {{motor: {{pivot: O, arm: A{law}}}}}
"""


def random_slider_crank(rng: np.random.Generator) -> tuple[str, str]:
    """Return a slider-crank whose crank cannot turn fully, and the text of the law."""
    while True:
        (crank, rod, offset), angle = rng.uniform(0.5, 3.0, 3).tolist(), float(rng.uniform(-np.pi, np.pi))
        if abs(offset - crank * np.sin(angle)) < 0.999 * rod and rod < crank + offset:
            law = ", law: {by: 360}"
            return slider_crank_text(crank, rod, offset, angle, law), law


def random_five_bar(rng: np.random.Generator, held: bool) -> tuple[str, str]:
    """Return a five-bar of which both motors turn, or one is held, and the text of the law of the first."""
    while True:
        a, b, c, d = rng.uniform(0.5, 2.0, 4).tolist()
        one, two = rng.uniform(-np.pi, np.pi, 2).tolist()
        p, q = a * np.exp(1j * one), 2.0 + d * np.exp(1j * two)
        if not abs(b - c) * 1.001 < abs(q - p) < 0.999 * (b + c):
            continue
        along = (abs(q - p) ** 2 + b**2 - c**2) / (2.0 * abs(q - p))
        m = p + (q - p) / abs(q - p) * (along + 1j * np.sqrt(b**2 - along**2))
        law, other = ", law: {by: 360}", 0.0 if held else round(float(rng.uniform(-400.0, 400.0)), 3)
        places = ", ".join(
            f"{n}: [{z.real:.15g}, {z.imag:.15g}]" for n, z in zip("OQABM", (0j, 2 + 0j, p, q, m), strict=True)
        )
        return (
            f"""
nodes: {{{places}}}
ground: [O, Q]
links: {{a: [O, A], b: [A, M], c: [M, B], d: [Q, B]}}
actuators: {{motor: {{pivot: O, arm: A{law}}}, second: {{pivot: Q, arm: B, law: {{by: {other}}}}}}}
""",
            law,
        )


MECHANISMS = {
    "four-bar": random_four_bar, "slider-crank": random_slider_crank,
    "five-bar, one held": lambda rng: random_five_bar(rng, True),
}  # fmt: skip


def check_random(kind: str, count: int, seed: int, folder: Path) -> None:
    rng, named = np.random.default_rng(seed), 0
    for _ in range(count):
        text, law = MECHANISMS[kind](rng)
        (folder / "m.yaml").write_text(text)
        if check_ranges(str(folder / "m.yaml")):
            named += 1
            other_way(text, law, report(str(folder / "m.yaml"))[2])
    assert named > count // 5


@pytest.mark.few(2)
@pytest.mark.parametrize("kind", MECHANISMS)
def test_ranges_of_random_mechanisms(kind: str, tmp_path: Path) -> None:
    check_random(kind, 6, 1, tmp_path)


@pytest.mark.soak
@pytest.mark.parametrize("kind", MECHANISMS)
def test_ranges_of_two_hundred_mechanisms(kind: str, tmp_path: Path) -> None:
    check_random(kind, 200, 2, tmp_path)


def check_both(count: int, seed: int, folder: Path) -> None:
    """Check that no row that is called unreachable has, also whole turns away, a place within the printed ranges."""
    rng, stopped = np.random.default_rng(seed), 0
    for _ in range(count):
        (folder / "m.yaml").write_text(random_five_bar(rng, False)[0])
        unsolved, printed, text = report(str(folder / "m.yaml"))
        ranges = {n: ends for n in unsolved for line, ends in printed.items() if line.startswith(f"range of {n} ")}
        if not unsolved["motor"] or len(ranges) < 2 or ranges["second"][0] == ranges["second"][1]:
            continue
        stopped += 1
        assert "full turn" not in text
        (low, high), seconds = ranges["motor"], ranges["second"]
        law = gimcli.load(str(folder / "m.yaml")).actuators
        rate = (
            np.ptp(law[1].law(np.array([0.0, 1.0])))
            / (2.0 * np.pi)
            * np.sign(np.diff(law[1].law(np.array([0.0, 1.0]))))
        )
        for one, two in zip(unsolved["motor"], unsolved["second"], strict=True):
            for turns in range(-3, 4):
                moved = one + 360.0 * turns
                there = two + 360.0 * turns * float(rate[0])  # where the second motor then is
                same = abs((there - two + 180.0) % 360.0 - 180.0) < 0.01
                assert not (same and low + 0.01 < moved < high - 0.01), (text, seconds)
    assert stopped > count // 3


def test_ranges_of_five_bars_with_two_moving_motors(tmp_path: Path) -> None:
    check_both(6, 3, tmp_path)


@pytest.mark.soak
def test_ranges_of_two_hundred_five_bars(tmp_path: Path) -> None:
    check_both(200, 4, tmp_path)


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
