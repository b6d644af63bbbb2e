"""Messages about positions that cannot be assembled: amounts and intervals against triangles and the law of cosines."""

import math
import re

import pytest

import gimcli
from gimcli.motion.unassembled import Unassembled, reason
from gimcli.status import Status

FOUR = """
units: {{length: mm}}
nodes: {{A: [0, 0], B: [10, 5], C: [40, 5], D: [50, 0]}}
ground: [A, D]
links:
  crank: {{nodes: [A, B], length: {crank}}}
  rod: {{nodes: [B, C], length: {rod}}}
  rocker: {{nodes: [C, D], length: {rocker}}}
actuators: {{motor: {{type: rotary, pivot: A, arm: B, law: {{{law}}}}}}}
"""
CYLINDER = """
units: {length: mm}
nodes: {A: [0, 0], B: [100, 0], C: [80, 90]}
ground: [A, B]
links: {arm: [B, C]}
actuators: {cyl: {type: linear, nodes: [A, C], law: {from: 843.3, to: 900}}}
"""
SLIDER = """
units: {length: mm}
nodes: {A: [0, 0], B: [10, 0], C: [20, 50], G: [100, 0]}
ground: [A, G]
links:
  crank: {nodes: [A, B], length: 30}
  rod: {nodes: [B, C], length: 25}
prismatic: {slide: {node: C, guide: [A, G], offset: 50}}
actuators: {motor: {type: rotary, pivot: A, arm: B, law: {from: 0, to: 360}}}
"""


def words(text, status=Status.NOT_ASSEMBLED, **options):
    mechanism = gimcli.loads(text)
    return reason(mechanism, status, mechanism.start_inputs, **options)


def numbers(text, name):
    """Return the ends of the interval that a message gives for an input."""
    return [float(v) for v in re.search(rf"{name} = (\S+) to (\S+)", text).groups()]


def test_a_dyad_that_is_too_short_at_the_start_of_the_law():
    text = words(FOUR.format(crank=30, rod=20, rocker=20, law="from: 180, to: 360"))
    limit = math.degrees(math.acos((30**2 + 50**2 - 40**2) / (2 * 30 * 50)))
    assert numbers(text, "motor") == pytest.approx([360 - limit, 360 + limit], rel=1e-5)


def test_a_rod_that_is_too_long():
    text = words(FOUR.format(crank=10, rod=90, rocker=20, law="from: 180, to: 360"))
    assert "rod (90 mm) is too long for rocker (20 mm) and B-D (60 mm): by 10 mm" in text


def test_the_travel_of_a_cylinder():
    text, arm = words(CYLINDER), math.hypot(20, 90)
    assert f"by {843.3 - arm - 100:.3f} mm at cyl = 843.3 mm" in text
    assert f"{math.hypot(80, 90):.3f} mm" in text
    assert numbers(text, "cyl") == pytest.approx([100 - arm, 100 + arm], rel=1e-3)


def test_a_rod_that_does_not_reach_its_slide():
    text = words(SLIDER)
    low = math.degrees(math.asin(25 / 30))
    assert numbers(text, "motor") == pytest.approx([low, 180 - low], rel=1e-5)


def test_a_coupled_group_gets_its_largest_errors():
    text = gimcli.load("platform_3rrr").written.source.text.replace("[B0, C0], length: 6", "[B0, C0], length: 1")
    mechanism = gimcli.loads(text)
    found = Unassembled(mechanism, mechanism.start_inputs)
    errors = sorted(found._errors(found._closest()), reverse=True)
    said = words(text)
    assert "instead of 6" in said
    assert errors[0] > 1e-3
    moved = found._closest()
    moved[mechanism.nodes.index("C1")] += 1e-3
    assert sum(e**2 for e in found._errors(moved)) > sum(e**2 for e in errors)


def test_other_statuses_keep_their_text():
    text = FOUR.format(crank=10, rod=45, rocker=45, law="by: 360")
    assert words(text, Status.SINGULAR) == Status.SINGULAR.text


def test_no_advice_leads_back_to_all_configurations():
    text = gimcli.load("platform_3rrr").written.source.text.replace("[B0, C0], length: 6", "[B0, C0], length: 1")
    assert "solve --all" in words(text)
    assert "solve --all" not in words(text, tried=["all"])


def test_a_limit_says_what_cannot_reach():
    mechanism = gimcli.loads(FOUR.format(crank=30, rod=20, rocker=20, law="from: 0, to: 360"))
    text = reason(mechanism, Status.LIMIT, mechanism.value_from_file(0, 90) + 0 * mechanism.start_inputs)
    assert f"cannot span B-D (58.3095 mm): {math.hypot(30, 50) - 40:.4f} mm too short at motor = 90 deg; " in text
    assert text.endswith(Status.LIMIT.text)
