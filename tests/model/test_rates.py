"""Rates of laws: units, durations and ends that follow from them, and what contradicts."""

from __future__ import annotations

import math

import numpy as np
import pytest

import gimcli
from gimcli.model.edited_text import written_with

MODEL = """\
units: {{length: {length}, angle: {angle}}}
parameters: {{n: 20}}
nodes: {{O: [0, 0], A: [0, 20], B: [70, 0], G: [200, 0]}}
ground: [O, G]
links: {{crank: [O, A], rod: [A, B]}}
prismatic: {{slide: {{node: B, guide: [O, G]}}}}
actuators: {{{actuators}}}
{more}
"""
MOTOR, JACK = "motor: {{pivot: O, arm: A, law: {{{0}}}}}", "jack: {{node: B, guide: [O, G], law: {{{0}}}}}"


def load(*actuators: str, more: str = "", length: str = "mm", angle: str = "deg") -> gimcli.Mechanism:
    return gimcli.loads(MODEL.format(actuators=", ".join(actuators), more=more, length=length, angle=angle))


def course(mechanism: gimcli.Mechanism, number: int = 0) -> tuple[float, float, float]:
    """Return the first value, the last value (file's unit) and the duration of a law."""
    first, last = mechanism.value_to_file(number, mechanism.actuators[number].law(np.array([0.0, 1.0])))
    return float(first), float(last), mechanism.duration


@pytest.mark.parametrize(("law", "first", "last", "seconds"), [
    ("rate: 60 rpm, turns: 2", 90, 810, 2),
    ("rate: 60rpm", 90, 450, 1),
    ("rate: 60 RPM", 90, 450, 1),
    ("rate: 90 Deg/s, by: -45", 90, 45, 0.5),
    ("rate: -60 rpm", 90, -270, 1),
    ("rate: -30 rpm, turns: 3", 90, 90 - 1080, 6),
    ("from: 10, rate: 0.5 rev/s, turns: 1.5", 10, 550, 3),
    ("from: 10, rate: 90 deg / s, by: 45", 10, 55, 0.5),
    ("rate: -90 °/s, to: 0, from: 45, profile: cubic", 45, 0, 0.5),
    ("rate: -90, to: 0", 90, 0, 1),
    ("rate: 3.141592653589793 rad/s, by: 180", 90, 270, 1),
    ("rate: 10 rev/min, by: 30", 90, 120, 0.5),
    ("rate: n*6, turns: 1", 90, 450, 3),
    ("turns: 2.5", 90, 990, 1),
    ("to: 30", 90, 30, 1),
    ("from: 30, by: 5", 30, 35, 1),
])  # fmt: skip
def test_a_rotary_rate_gives_the_duration(law: str, first: float, last: float, seconds: float) -> None:
    assert course(load(MOTOR.format(law))) == pytest.approx((first, last, seconds), rel=1e-14)


@pytest.mark.parametrize(("law", "last", "seconds"), [
    ("rate: 40 mm/s, by: 20", 90, 0.5),
    ("rate: 4 cm/s, to: 90", 90, 0.5),
    ("rate: 40 mm/s, to: 50", 50, 0.5),
    ("rate: 0.04 m/s, by: 20", 90, 0.5),
    ("rate: 2.4 m/min, by: 20", 90, 0.5),
    ("rate: 2 in/s, by: 25.4", 95.4, 0.5),
    ("rate: 1 ft/s, by: 3.048", 73.048, 0.01),
    ("rate: -1e1, by: -5", 65, 0.5),
])  # fmt: skip
def test_a_linear_rate_gives_the_duration(law: str, last: float, seconds: float) -> None:
    assert course(load(JACK.format(law))) == pytest.approx((70, last, seconds), rel=1e-13)


def test_units_of_the_file_hold_for_rates_without_a_unit() -> None:
    assert course(load(MOTOR.format("rate: 2, from: 0, by: 1"), angle="rad")) == pytest.approx((0, 1, 0.5))
    assert course(load(MOTOR.format("rate: 60 rpm"), angle="rad"))[2] == pytest.approx(1.0)
    assert course(load(JACK.format("rate: 50.8 mm/s, by: 4"), length="in"))[2] == pytest.approx(2.0)


def test_a_duration_gives_the_increment() -> None:
    assert course(load(MOTOR.format("rate: 60 rpm"), more="duration: 2.5")) == pytest.approx((90, 990, 2.5))
    assert course(load(JACK.format("rate: 4 mm/s"), more="duration: 2.5")) == pytest.approx((70, 80, 2.5))
    agreed = load(MOTOR.format("rate: 60 rpm, turns: 2"), more="duration: 2")
    assert course(agreed) == pytest.approx((90, 810, 2))


def test_one_duration_holds_for_all_inputs() -> None:
    """An input with a rate alone runs as long as the others."""
    both = load(JACK.format("rate: 4 mm/s"), MOTOR.format("rate: 60 rpm, turns: 3"))
    assert course(both) == pytest.approx((70, 82, 3))
    assert course(both, 1) == pytest.approx((90, 1170, 3))
    turning = load(JACK.format("rate: 4 mm/s"), MOTOR.format("rate: 30 rpm"))
    assert course(turning) == pytest.approx((70, 78, 2))


def test_velocities_have_the_rate() -> None:
    """At a constant rate of 60 rpm the pin of a crank of 20 mm has the speed 2 pi 20 mm/s."""
    found = gimcli.trace(load(MOTOR.format("rate: 60 rpm, turns: 2"), more="trace: [A]"), steps=8, derivatives=1)
    x, y = found.xy["A"].T
    assert found["A.vx"] == pytest.approx(-2 * math.pi * y, abs=1e-9)
    assert found["A.vy"] == pytest.approx(2 * math.pi * x, abs=1e-9)


def test_two_inputs_of_equal_duration_are_accepted() -> None:
    both = ", ".join([MOTOR.format("rate: 60 rpm"), JACK.format("rate: 5, by: 10")])
    assert course(load(both)) == pytest.approx((90, 810, 2))


def test_other_speeds_of_an_input_may_have_a_unit() -> None:
    free = "motor: {pivot: O, arm: A, free: true, speed: -30 rpm, effort: {stall: 4, idle: 120 rpm}}"
    model = load(free, more="masses: {B: 1}")
    (release,) = model.dynamics.releases
    assert (release.speed, release.effort.idle) == pytest.approx((-math.pi, 4 * math.pi))
    (release,) = model.with_({"motor.speed": "2 rev/s"}).dynamics.releases
    assert release.speed == pytest.approx(4 * math.pi)


def test_rate_and_turns_are_dimensions() -> None:
    motor = load(MOTOR.format("rate: 60 rpm, turns: 2"))
    assert motor.with_({"motor.rate": 180}).duration == pytest.approx(4.0)
    assert motor.with_({"motor.rate": "30 rpm"}).duration == pytest.approx(4.0)
    assert motor.with_({"motor.rate": "n*18"}).duration == pytest.approx(2.0)
    assert motor.with_({"motor.turns": 3}).duration == pytest.approx(3.0)
    alone = load(MOTOR.format("rate: 60 rpm"))
    assert course(alone.with_({"duration": 3})) == pytest.approx((90, 1170, 3))


def test_another_rate_can_be_written_into_the_file() -> None:
    motor = load(MOTOR.format("rate: 60 rpm, turns: 2"))
    assert "law: {rate: 180, turns: 2}" in written_with(motor, {"motor.rate": "30 rpm"})
    assert "law: {rate: n*6, turns: 2}" in written_with(motor, {"motor.rate": "n*6"})
    assert written_with(motor) == MODEL.format(
        actuators=MOTOR.format("rate: 60 rpm, turns: 2"), more="", length="mm", angle="deg"
    )


def test_designs_with_other_rates_have_their_own_times() -> None:
    """The greatest speed of the crank's pin along x is that at the bottom, radius times rate."""
    motor = load(MOTOR.format("rate: 60 rpm, turns: 1"), more="trace: [A]")
    notes: list[str] = []
    found = gimcli.sweep(motor, {"motor.rate": [180, 360, 720]}, steps=8, keep=["max(A.vx)"], notify=notes.append)
    assert found["max(A.vx)"] == pytest.approx([20 * math.pi, 40 * math.pi, 80 * math.pi])
    assert not [note for note in notes if "motor.rate" in note]


def test_the_first_value_of_a_law_places_a_node_without_coordinates() -> None:
    text = "nodes: {{O: [0, 0], A: }}\nground: [O]\nlinks: {{crank: {{nodes: [O, A], length: 2}}}}\n"
    text += "actuators: {{motor: {{pivot: O, arm: A, law: {{{0}}}}}}}\n"
    found = gimcli.loads(text.format("from: 30, rate: 60 rpm, turns: 2, polynomial: [0, 0, 3, -2]"))
    assert found.to_file(found.drawn)[1] == pytest.approx(complex(math.sqrt(3), 1))
