"""Rigid triangles of members: found in bars, plates and the frame; hinted at, and no output joints."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

import gimcli
from gimcli.cli import app
from gimcli.quantities.transmission import output_joints
from gimcli.structure.rigid_triangles import rigid_bodies, rigid_triangles, triangle_hints

FOUR_BAR = """\
nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 3], C: [1, 4], D: [3, 5]}
ground: [O, G]
elements: {%s}
links: {crank: [O, A], rocker: [G, B], %s}
actuators: {m: {type: rotary, pivot: O, arm: A, law: {from: 90, to: 100}}}
trace: [C]
"""
BARS = FOUR_BAR % ("", "rod: [A, B], d: [A, C], e: [B, C]")
TRUSS = FOUR_BAR % ("", "rod: [A, B], d: [A, C], e: [B, C], f: [B, D], g: [C, D]")
ON_A_PLATE = FOUR_BAR % ("plate: [A, B, D]", "d: [A, C], e: [B, C]")
ON_THE_FRAME = FOUR_BAR % ("", "rod: [A, B], d: [O, C], e: [G, C]")
ELEMENT = FOUR_BAR % ("plate: [A, B, C]", "")


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        (
            BARS,
            "rod, d and e form a rigid triangle with 2 configurations: write one member [A, B, C] under `elements:`",
        ),
        (TRUSS, "rod, d, e, f and g form 2 rigid triangles with 4 configurations: write one member [A, B, C, D]"),
        (ON_A_PLATE, "plate, d and e form a rigid triangle"),
        (ON_THE_FRAME, "ground, d and e form a rigid triangle with 2 configurations: fix C under `ground:`"),
    ],
    ids=["bars", "truss", "plate", "frame"],
)
def test_a_rigid_triangle_is_found_and_its_dyad_is_no_output(text, hint):
    mechanism = gimcli.loads(text)
    (found,) = triangle_hints(mechanism)
    assert found.startswith(hint)
    assert [set(joint.names) for joint in output_joints(mechanism)] in ([{"rod", "rocker"}], [{"plate", "rocker"}])


@pytest.mark.parametrize("text", [ELEMENT, BARS.replace("e: [B, C]", "e: [D, C], f: [G, D]")], ids=["element", "chain"])
def test_mechanisms_without_rigid_triangles(text):
    mechanism = gimcli.loads(text)
    assert rigid_triangles(mechanism) == ()
    assert len(set(rigid_bodies(mechanism).values())) == len(mechanism.members)


def test_the_configurations_of_bars_are_twice_those_of_an_element(tmp_path):
    """By mirror images of the triangle; solve --all and circuits print the hint, for the bars only."""
    hint, counts = triangle_hints(gimcli.loads(BARS))[0], []
    for text in (BARS, ELEMENT):
        (tmp_path / "m.yaml").write_text(text)
        for command in (["solve", "--all"], ["circuits", "--samples", "12"]):
            done = CliRunner().invoke(app, [command[0], str(tmp_path / "m.yaml"), *command[1:]])
            assert done.exit_code == 0, done.output
            assert (hint in done.output) == (text == BARS)
        counts.append(gimcli.configurations(gimcli.loads(text)).count)
    assert counts[0] == 2 * counts[1]


def test_the_angle_of_a_rigid_triangle_is_measured_on_request():
    found = gimcli.trace(gimcli.loads(BARS), steps=2, measure="transmission:d/e")
    assert "transmission:d/e" in found.table().names
