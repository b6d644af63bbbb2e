"""Mechanisms drawn in a singular position: every row that exists is found, in both senses of the motion."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from closed_linkages import LAW, LINKAGES, Linkage
from typer.testing import CliRunner

from gimcli import load
from gimcli.branching.enumeration import circuits
from gimcli.branching.singular_positions import first_turn, survey
from gimcli.cli import app
from gimcli.motion.motion import Motion, trace

BASE, PLATFORM = 4.0, 2.0
RAMS = {
    "alike": ((2.0, 3.0), (2.0, 3.0), (2.0, 3.0)),
    "one": ((2.0, 3.0), (2.0, 2.0), (2.0, 2.0)),
    "unequal": ((2.0, 3.0), (2.0, 2.5), (2.0, 2.2)),
    "in and out": ((2.0, 1.5), (2.0, 2.5), (2.0, 2.2)),
}


def corners(radius: float) -> list[complex]:
    """Return the corners of an equilateral triangle about the origin, one at the top."""
    return [complex(radius * np.exp(1j * np.radians(a))) for a in (90, 210, 330)]


def platform(folder: Path, rams: str, back: bool = False) -> Path:
    """Write the symmetric 3-RPR platform, drawn in the position in which the lines of the rams meet."""
    laws = [law[::-1] if back else law for law in RAMS[rams]]
    nodes = [
        f"  {n}{k}: [{z.real}, {z.imag}]" for n, r in (("A", BASE), ("B", PLATFORM)) for k, z in enumerate(corners(r))
    ]
    drives = [
        f"  r{k}: {{type: linear, nodes: [A{k}, B{k}], law: {{from: {a}, to: {b}}}}}" for k, (a, b) in enumerate(laws)
    ]
    text = "\n".join(["units: {length: unit}", "nodes:", *nodes, "ground: [A0, A1, A2]", "actuators:", *drives])
    path = folder / "rpr.yaml"
    path.write_text(text + "\nelements: {platform: [B0, B1, B2]}\ntrace: [B0, B1, B2]\n")
    return path


def rams_and_sides(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """Return the lengths of the rams (3, rows) and of the sides (3, rows), from the nodes."""
    z = motion.mechanism.to_file(motion.z)
    at = {name: z[k] for k, name in enumerate(motion.mechanism.nodes)}
    rams = np.array([abs(at[f"A{k}"] - at[f"B{k}"]) for k in range(3)])
    return rams, np.array([abs(at[f"B{k}"] - at[f"B{(k + 1) % 3}"]) for k in range(3)])


@pytest.mark.few(6)
@pytest.mark.parametrize("steps", [360, 3600])
@pytest.mark.parametrize("back", [False, True], ids=["out", "back"])
@pytest.mark.parametrize("rams", RAMS)
def test_a_platform_drawn_where_its_rams_meet(rams: str, back: bool, steps: int, tmp_path: Path) -> None:
    motion = trace(load(platform(tmp_path, rams, back)), steps)
    assert motion.good.all()
    lengths, sides = rams_and_sides(motion)
    wanted = np.array([np.linspace(*(law[::-1] if back else law), steps + 1) for law in RAMS[rams]])
    assert np.abs(lengths - wanted).max() < 1e-10
    assert np.abs(sides - PLATFORM * math.sqrt(3.0)).max() < 1e-10
    distance = np.minimum(np.arange(steps + 1), steps - np.arange(steps + 1))[1:] + 1.0
    jump = np.abs(np.diff(motion.z, axis=1)).max(axis=0)
    assert (jump < 3.0 / np.sqrt(distance * steps)).all()  # a square root near the limit, not more


def test_rams_of_equal_length_rotate_the_platform(tmp_path: Path) -> None:
    """l^2 = R^2 + r^2 - 2 R r cos(psi); --branch 2 follows the other arc."""
    mechanism = load(platform(tmp_path, "alike"))
    length = np.linspace(2.0, 3.0, 361)
    psi = np.arccos((BASE**2 + PLATFORM**2 - length**2) / (2.0 * BASE * PLATFORM))
    for branch, sense in ((1, 1.0), (2, -1.0)):
        motion = trace(mechanism, 360, branch=branch)
        z = mechanism.to_file(motion.z)[mechanism.nodes.index("B0")]
        assert np.abs(z - 2j * np.exp(1j * sense * psi)).max() < 1e-10


@pytest.mark.few(2)
@pytest.mark.parametrize("rams", RAMS)
def test_all_commands_follow_the_platform(rams: str, tmp_path: Path) -> None:
    path = platform(tmp_path, rams)
    done = CliRunner().invoke(
        app, ["trace", str(path), "--circuit", "--json", "--no-png", "--out", str(tmp_path / "out")]
    )
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert (report["steps"], report["solved"]) == (360, 361)
    found = survey(load(path))
    limits = [found.curve.given(first_turn(found, one.what.p[-1])) for one in found.found if one.what.kind == "limit"]
    assert min(np.abs(at * found.curve.mechanism.scale - 2.0).max() for at in limits) < 1e-10
    solved = CliRunner().invoke(app, ["solve", str(path), "--json"])
    assert solved.exit_code == 0, solved.output


def test_circuits_of_the_platform_are_listed(tmp_path: Path) -> None:
    assert circuits(load(platform(tmp_path, "alike"))).count == 1


def on(case: Linkage, motion: Motion, place: object) -> bool:
    """Return whether all rows of a motion are on an arc."""
    found = motion.mechanism.to_file(motion.z)[motion.mechanism.nodes.index(case.node)]
    inputs = motion.mechanism.value_to_file(0, motion.mechanism.actuators[0].law(motion.time))
    return bool(motion.good.all() and all(abs(a - place(float(v))) < 1e-9 for a, v in zip(found, inputs, strict=True)))


@pytest.mark.few(9)
@pytest.mark.parametrize("profile", ["uniform", "cycloidal"])
@pytest.mark.parametrize("case", [pytest.param(case, id=case.name) for case in LINKAGES])
def test_a_linkage_drawn_in_its_singular_position(case: Linkage, profile: str, tmp_path: Path) -> None:
    """Every row is solved, on one arc or branch, and with --branch 2 on the other."""
    law = f"{{from: {case.critical}, to: {case.start}, profile: {profile}}}"
    path = tmp_path / "model.yaml"
    path.write_text(case.text(case.critical).replace(LAW, law))
    first = trace(load(path), 60)
    if case.other is None:
        assert on(case, first, case.arc)
        return
    second = trace(load(path), 60, branch=2)
    assert {on(case, first, case.arc), on(case, second, case.arc)} == {True, False}
    assert {on(case, first, case.other), on(case, second, case.other)} == {True, False}


@pytest.mark.parametrize("case", [pytest.param(case, id=case.name) for case in LINKAGES])
def test_a_law_that_starts_in_a_singular_position_keeps_the_drawn_arc(case: Linkage, tmp_path: Path) -> None:
    """Drawn near it, the mechanism reaches it on its own arc and returns on the same arc."""
    path = tmp_path / "model.yaml"
    path.write_text(case.text(case.start).replace(LAW, f"{{from: {case.critical}, to: {case.start}}}"))
    assert on(case, trace(load(path), 60), case.arc)


STRETCHED = 60.0
"""Five-bar of lengths 4 with motors at 180 deg - t and t: coupler and follower are stretched, 8 long, at t = 60 deg."""
FIVE_BAR = {
    "ends there": ("{from: 100, to: 120}", "{from: 80, to: 60}"),
    "starts there": ("{from: 120, to: 100}", "{from: 60, to: 80}"),
    "turns back there": ("{polynomial: [100, 80, -80]}", "{polynomial: [80, -80, 80]}"),
    "starts and ends there": ("{polynomial: [120, -80, 80]}", "{polynomial: [60, 80, -80]}"),
    "stays there": ("{from: 120, to: 120}", "{from: 60, to: 60}"),
}


def tip(degrees: float, side: float) -> complex:
    """Return the pin of the five-bar at t, above or below the line from A to B."""
    half = 2.0 + 4.0 * math.cos(math.radians(degrees))
    return complex(2.0, 4.0 * math.sin(math.radians(degrees)) + side * math.sqrt(max(16.0 - half**2, 0.0)))


def five_bar(folder: Path, drawn: float, laws: tuple[str, str]) -> Path:
    """Write the five-bar drawn at t with its pin above."""
    b, p = 4.0 + 4.0 * np.exp(1j * math.radians(drawn)), tip(drawn, 1.0)
    path = folder / "five.yaml"
    path.write_text(f"""
nodes: {{O: [0, 0], Q: [4, 0], A: [{4.0 - b.real}, {b.imag}], B: [{b.real}, {b.imag}], P: [2, {p.imag}]}}
ground: [O, Q]
links:
  a: {{nodes: [O, A], length: 4}}
  b: {{nodes: [Q, B], length: 4}}
  c: {{nodes: [A, P], length: 4}}
  d: {{nodes: [B, P], length: 4}}
actuators:
  m1: {{type: rotary, pivot: O, arm: A, law: {laws[0]}}}
  m2: {{type: rotary, pivot: Q, arm: B, law: {laws[1]}}}
trace: [P]
""")
    return path


@pytest.mark.parametrize("drawn", [80.0, STRETCHED])
@pytest.mark.parametrize("course", FIVE_BAR)
def test_two_inputs_at_their_limit(course: str, drawn: float, tmp_path: Path) -> None:
    """Drawn near the limit, the pin stays above; drawn at the limit, it is on one of both arcs."""
    mechanism = load(five_bar(tmp_path, drawn, FIVE_BAR[course]))
    motion = trace(mechanism, 40)
    assert motion.good.all()
    pin = mechanism.to_file(motion.z)[mechanism.nodes.index("P")]
    angles = np.degrees(mechanism.actuators[1].law(motion.time))
    arcs = [np.array([tip(float(t), side) for t in angles]) for side in (1.0, -1.0)]
    away = [np.abs(pin - arc).max() for arc in arcs]
    assert min(away) < 1e-7  # a rounding error e of the angle moves the pin by about sqrt(e)
    assert drawn == STRETCHED or away[0] < 1e-7
