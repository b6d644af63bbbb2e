"""Messages for the errors of a first model: one error, with the key or the line that the file lacks."""

from __future__ import annotations

import pytest

import gimcli
from gimcli import StructureError

MODEL = """\
nodes: {O: [0, 0], A: [0, 20], B: [70, 0], H: [90, 0]}
ground: [O, H]
links: {crank: [O, A], rod: [A, B]}
"""
SLIDE = "prismatic: {piston: {node: B, guide: [O, H]}}\n"


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
