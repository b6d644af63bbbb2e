"""A warning where the table of a load does not cover the law of its actuator."""

import pytest
from in_process import gim, ran

from gimcli import load

ENGINE = """
units: {{length: mm}}
nodes: {{O: [0, 0], A: [40, 0], B: [150, 0], G: [300, 0]}}
ground: [O, G]
links: {{crank: [O, A], rod: [A, B]}}
prismatic: {{bore: {{node: B, guide: [O, G]}}}}
actuators: {{motor: {{type: rotary, pivot: O, arm: A, law: {{from: {start}, to: {end}}}}}}}
masses: {{rod: {{mass: 1, inertia: 0}}}}
loads: {{gas: {{on: rod, local: [110, 0], force: [-100, 0], table: gas.csv, over: motor}}}}
"""


@pytest.mark.parametrize(
    ("start", "end", "warned"), [(0, 360, False), (90, 270, False), (90, 450, True), (-1, 9, True)]
)
@pytest.mark.parametrize("command", ["forces", "check"])
def test_a_table_that_ends_inside_the_law(command, start, end, warned, tmp_path):
    (tmp_path / "gas.csv").write_text("0,0\n180,1\n360,0\n")
    (tmp_path / "m.yaml").write_text(ENGINE.format(start=start, end=end))
    done = ran(command, "m.yaml", *(["--steps", "4", "--no-png"] if command == "forces" else []), cwd=tmp_path)
    text = done.error + done.text
    assert ("covers motor = 0 to 360" in text) == warned


def test_reversing_at_limits_reports_both(tmp_path):
    """The crank of a triple rocker with lengths 30, 20, 20, 50 swings to +-53.13 degrees (law of cosines)."""
    (tmp_path / "m.yaml").write_text(
        "nodes: {A: [0, 0], B: [30, 0], C: [40, 17], D: [50, 0]}\nground: [A, D]\n"
        "links: {crank: {nodes: [A, B], length: 30}, rod: {nodes: [B, C], length: 20},"
        " rocker: {nodes: [C, D], length: 20}}\n"
        "actuators: {motor: {type: rotary, pivot: A, arm: B, law: {from: 0, to: 360}}}\n"
    )
    done = gim("trace", tmp_path / "m.yaml", "--steps", 36, "--at-limit", "reverse", "--json", "-o", tmp_path / "x.csv")
    assert done.json["reachable"]["motor"][0] == pytest.approx([-53.1301023541560, 53.1301023541560], abs=1e-7)


@pytest.mark.parametrize("angle", [60, 420, -300])
def test_velocities_at_an_angle_are_those_of_the_law_up_to_full_turns(angle):
    from gimcli import solve

    mechanism = load("crank_rocker").with_({"motor.from": 90, "motor.to": 450})
    here, there = (solve(mechanism, motor=a, velocities=True).report() for a in (angle, 420))
    assert here["input_rates"]["motor"]["rate"] == pytest.approx(360)
    assert here["velocities"]["B"] == pytest.approx(there["velocities"]["B"], rel=1e-9)
