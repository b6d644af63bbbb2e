"""Messages for the errors of a first model: one error, with the key or the line that the file lacks."""

from __future__ import annotations

import pytest

import gimcli
from gimcli.errors import ModelError, StructureError

MODEL = """\
nodes: {O: [0, 0], A: [0, 20], B: [70, 0], H: [90, 0]}
ground: [O, H]
links: {crank: [O, A], rod: [A, B]}
"""
SLIDE = "prismatic: {piston: {node: B, guide: [O, H]}}\n"
OPEN = """\
nodes: {O: [0, 0], H: [90, 0], A: , B: }
ground: [O, H]
links: {crank: {nodes: [O, A], length: 20}, rod: {nodes: [A, B], length: 60}}
prismatic: {slide: {node: B, guide: [O, H]}}
"""


@pytest.mark.parametrize(("text", "fragments"), [
    (MODEL + "masses: {piston: 0.5}", ["'piston' does not exist", "members: crank, rod; or a node: O, A, B, H"]),
    (MODEL + "loads: {gas: {on: piston, force: [1, 0]}}", ["'piston' does not exist", "or a node: O, A, B, H"]),
    (MODEL + "points: {P: {on: piston, at: [1, 0]}}", ["'piston' does not exist; members: crank, rod"]),
    (MODEL + "springs: {s: {nodes: [O, B], k: 3}}", ["'k'", "did you mean 'stiffness'"]),
    (MODEL + "dampers: {d: {nodes: [O, B], c: 3}}", ["'c'", "did you mean 'damping'"]),
    (MODEL.replace("[70, 0]", "right"), ["nodes.B: expected [x, y] or {side: right}, got 'right'"]),
    (MODEL.replace("A: [0, 20]", "A:"), ["a blank must follow the colon"]),
    (OPEN + "actuators: {jack: {node: B, guide: [O, H], law: {to: 50, rate: 4 m/s}}}", ["needs `from`: the node B"]),
    (OPEN + "actuators: {motor: {pivot: O, arm: B, law: {rate: 60 rpm}}}", ["no common moving member"]),
])  # fmt: skip
def test_a_message_names_the_cure(text: str, fragments: list[str]) -> None:
    with pytest.raises(ModelError) as caught:
        gimcli.loads(text)
    assert len(caught.value.faults) == 1
    assert all(fragment in str(caught.value) for fragment in fragments), str(caught.value)


@pytest.mark.parametrize(("text", "cure"), [
    (MODEL + SLIDE, "actuators: {motor: {pivot: O, arm: A}}"),
    (MODEL + "actuators: {jack: {node: B, guide: [H, O], law: {by: 5}}}", SLIDE.replace("piston", "slide").replace(
        "O, H", "H, O").strip()),
])  # fmt: skip
def test_the_line_for_an_undriven_freedom_makes_the_mechanism_move(text: str, cure: str) -> None:
    model = gimcli.loads(text)
    with pytest.raises(StructureError) as caught:
        gimcli.solve(model)
    assert f"`{cure}`" in str(caught.value)
    assert gimcli.solve(gimcli.loads(f"{text}\n{cure}")).status == "ok"
