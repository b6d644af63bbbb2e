"""Independent machines in one file: each moves as if it were alone, and its limits leave the others solved."""

import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from bundled import MODELS

import gimcli
from gimcli import StructureError

TWO = """
units: {length: cm}
nodes: {A: [0, 0], B: [0, 2], C: [3, 3], D: [4, 0], E: [10, 0], F: [10.5, 0.5], G: [13, 2.5], H: [14, 0]}
ground: [A, D, E, H]
links: {a: [A, B], b: {nodes: [B, C], length: 3.2}, c: {nodes: [C, D], length: 1.5}, e: [E, F], f: [F, G], g: [G, H]}
actuators:
  rocker: {pivot: A, arm: B, law: {by: 300}}
  crank: {pivot: E, arm: F, law: {by: 360}}
"""

LIMIT = math.degrees(math.acos((4.0 + 16.0 - 4.7**2) / 16.0))
"""Input of the rocker with b and c in line: |BD| = 3.2 + 1.5, by the law of cosines with 2 and 4."""


def beside(first, second, away):
    """Return the data of two models as one; all names of the second begin with `q` and its nodes lie `away`."""
    data, other = (yaml.safe_load((MODELS / f"{name}.yaml").read_text()) for name in (first, second))
    text = yaml.safe_dump(
        {k: other[k] for k in ("nodes", "ground", "links", "elements", "actuators", "prismatic") if k in other}
    )
    names = {
        *other["nodes"],
        *other.get("links", {}),
        *other.get("elements", {}),
        *other["actuators"],
        *other.get("prismatic", {}),
    }

    def named(part):
        if isinstance(part, dict):
            return {named(k) if k in names else k: named(v) for k, v in part.items()}
        return [named(one) for one in part] if isinstance(part, list) else f"q{part}" if part in names else part

    moved = named(yaml.safe_load(text))
    for place in moved["nodes"].values():
        place[0] += away
    data = {
        k: v for k, v in data.items() if k not in ("trace", "points", "masses", "loads", "gravity", "name", "source")
    }
    for section, part in moved.items():
        if section in data:
            data[section] = [*data[section], *part] if isinstance(part, list) else {**data[section], **part}
        else:
            data[section] = part
    return data


def alone(name, away=0.0):
    data = yaml.safe_load((MODELS / f"{name}.yaml").read_text())
    for place in data["nodes"].values():
        place[0] += away
    return gimcli.load({k: v for k, v in data.items() if k not in ("trace", "points")})


def test_a_limit_of_one_machine_leaves_the_other_solved():
    found = gimcli.trace(gimcli.loads(TWO), steps=36)
    assert set(found["crank.status"]) == {"ok"}
    assert list(found["rocker.status"]) == ["ok"] + ["unreachable"] * 36
    assert list(found["status"]) == list(found["rocker.status"])
    assert np.isfinite(found["G.x"]).all()
    assert np.isfinite(found["C.x"]).sum() == 1
    rocker, crank = found.report()["machines"]
    assert (rocker["name"], rocker["solved"], crank["name"], crank["solved"]) == ("rocker", 1, "crank", 37)
    assert crank["reachable"] == {"crank": [[45.0, 405.0]]}
    assert crank["events"] == []
    (limit,) = rocker["events"]
    assert limit["at"] == pytest.approx({"rocker": LIMIT}, abs=1e-9)
    assert limit["interval"]["rocker"] == pytest.approx([-LIMIT, LIMIT], abs=1e-9)
    assert not found.answered


@pytest.mark.parametrize("at_limit", ["stop", "skip", "reverse"])
def test_two_equal_machines_meet_their_limits_at_the_same_time(at_limit):
    data = yaml.safe_load(TWO.partition("e: [E")[0] + "}")
    data["nodes"] |= {f"{n}2": [x + 7.0, y] for n, (x, y) in data["nodes"].items() if n in "ABCD"}
    data["nodes"] = {n: p for n, p in data["nodes"].items() if n not in "EFGH"}
    data["ground"] = ["A", "D", "A2", "D2"]
    one = data["links"]
    data["links"] = {
        **one, "a2": ["A2", "B2"], "b2": {**one["b"], "nodes": ["B2", "C2"]}, "c2": {**one["c"], "nodes": ["C2", "D2"]}
    }  # fmt: skip
    data["actuators"] = {f"r{k}": {"pivot": f"A{k}", "arm": f"B{k}", "law": {"by": 300}} for k in ("", "2")}
    found = gimcli.trace(gimcli.load(data), steps=60, at_limit=at_limit)
    single = {**data, "nodes": {n: p for n, p in data["nodes"].items() if "2" not in n}, "ground": ["A", "D"]}
    single |= {"links": one, "actuators": {"r": data["actuators"]["r"]}}
    expected = gimcli.trace(gimcli.load(single), steps=60, at_limit=at_limit)
    for own in ("r.status", "r2.status", "status"):
        assert list(found[own]) == list(expected["status"])
    assert np.allclose(found["C.x"], expected["C.x"], rtol=0, atol=1e-12, equal_nan=True)
    assert np.allclose(found["C2.x"] - 7.0, expected["C.x"], rtol=0, atol=1e-12, equal_nan=True)
    kinds = [event["kind"] for event in expected.events]
    assert [[e["kind"] for e in one["events"]] for one in found.machines] == [kinds, kinds]


@pytest.mark.parametrize(
    ("first", "second"),
    [("crank_rocker", "jansen"), ("stephenson_3_far", "slider_crank"), ("scotch_yoke", "gim_fig13b")],
)
def test_each_machine_moves_as_if_it_were_alone(first, second):
    away = 1e6
    together = gimcli.trace(gimcli.load(beside(first, second, away)), steps=24)
    apart = gimcli.trace(alone(first), steps=24), gimcli.trace(alone(second), steps=24)
    size = apart[1].mechanism.size * apart[1].mechanism.scale
    names = [one.name for one in together.mechanism.machines]
    assert len(names) == 2
    for name, own in zip(names, apart, strict=True):
        assert list(together[f"{name}.status"]) == list(own["status"])
    for column in apart[0]:
        if column.endswith((".x", ".y")):
            assert np.array_equal(together[column], apart[0][column], equal_nan=True), column
    for column in apart[1]:
        if column.endswith((".x", ".y")):
            shift = away if column.endswith(".x") else 0.0
            assert np.allclose(
                together[f"q{column}"] - shift, apart[1][column], rtol=0, atol=1e-9 * size, equal_nan=True
            )


def test_solve_names_the_machine_that_cannot_be_assembled():
    found = gimcli.solve(gimcli.loads(TWO), rocker=150, crank=45)
    assert found.status == "not-assembled"
    assert found.reason.startswith("rocker: ")
    assert found.xy["F"] == pytest.approx([10.5, 0.5])
    assert np.isnan(found.xy["C"]).all()
    assert {"F", "G"} <= set(found.report()["nodes"])
    assert "C" not in found.report()["nodes"]
    good = gimcli.solve(gimcli.loads(TWO), rocker=90, crank=45)
    assert good.status == "ok"
    assert abs(complex(*(good.xy["G"] - good.xy["H"]))) == pytest.approx(math.hypot(1.0, 2.5), rel=1e-14)


def test_a_part_that_nothing_drives_is_an_error_and_a_strut_is_not():
    strut = TWO.replace("A: [0, 0]", "A: [0, 0], S: [1, 9], P: [0, 8], Q: [3, 8]").replace(
        "ground: [", "ground: [P, Q, "
    )
    strut = strut.replace("links: {", "links: {left: [P, S], right: [Q, S], ")
    found = gimcli.trace(gimcli.loads(strut.replace("{by: 300}", "{by: 5}")), steps=8)
    assert set(found["status"]) == {"ok"}
    assert np.ptp(found["S.x"]) == 0.0
    with pytest.raises(StructureError):
        gimcli.trace(gimcli.loads(strut.replace("right: [Q, S], ", "")), steps=8)


def test_machines_of_another_assembly_keep_it():
    mechanism = gimcli.assembled(gimcli.loads(TWO), assembly=1)
    other = gimcli.assembled(gimcli.loads(TWO), assembly=2)
    first, second = (gimcli.trace(replace(one), steps=4).xy["G"][0] for one in (mechanism, other))
    configurations = gimcli.configurations(gimcli.loads(TWO)).each["crank"].xy["G"]
    assert np.allclose([first, second], configurations[:2], rtol=0, atol=1e-9)


def test_configurations_are_listed_and_chosen_for_each_machine():
    mechanism = gimcli.loads(TWO)
    found = gimcli.configurations(mechanism, rocker=150)  # out of the range of the rocker
    assert {name: one.count for name, one in found.each.items()} == {"rocker": 0, "crank": 2}
    assert not found.answered
    assert [one["machine"] for one in found.report()["configurations"]] == ["crank", "crank"]
    both = gimcli.configurations(mechanism)
    for k in (1, 2):
        chosen = gimcli.assembled(mechanism, assembly=f"crank={k}")
        position = gimcli.solve(chosen)
        assert np.allclose(position.xy["G"], both.each["crank"].xy["G"][k - 1], rtol=0, atol=1e-12)
        assert np.allclose(position.xy["C"], both.each["rocker"].xy["C"][both.each["rocker"].drawn], rtol=0, atol=1e-12)
    with pytest.raises(gimcli.UsageError):
        gimcli.assembled(mechanism, assembly="crnk=1")


def test_circuits_limits_and_workspaces_are_those_of_each_machine():
    mechanism = gimcli.loads(TWO)
    found = gimcli.singularities(mechanism)
    assert sorted(found.each) == ["crank", "rocker"]
    limits = [e["at"]["rocker"] for e in found.events if e["machine"] == "rocker" and e["kind"] == "limit"]
    assert sorted(limits) == pytest.approx([-LIMIT, LIMIT], abs=1e-9)
    assert {e["kind"] for e in found.events if e["machine"] == "crank"} == {"stationary"}
    assert [one["name"] for one in found.report()["machines"]] == ["rocker", "crank"]
    assert list(found["machine"]) == ["rocker"] * 4 + ["crank"] * 2
    assert np.isnan(found["crank"][:4]).all()
    circuits = gimcli.circuits(mechanism)
    assert {name: one.count for name, one in circuits.each.items()} == {
        "rocker": 1,
        "crank": 2,
    }  # Grashof: two circuits
    traced = gimcli.trace(mechanism, steps=8, circuit=True)
    assert set(traced["machine"]) == {"rocker", "crank"}
    assert traced.report()["solved"] == 18
    bounds = gimcli.workspace(mechanism, "G").report()["paths"][0]["inputs"]["crank"]
    assert bounds["full_turn"]
    assert gimcli.workspace(mechanism, "C").report()["paths"][0]["inputs"]["rocker"]["to"] == pytest.approx(LIMIT)


def test_check_has_the_sections_of_each_machine():
    found = gimcli.check(gimcli.loads(TWO))
    report = found.report()
    assert [one["name"] for one in report["machines"]] == ["rocker", "crank"]
    assert [one["type"] for one in report["machines"]] == [
        "four-bar linkage: triple-rocker (not Grashof)", "four-bar linkage: crank-rocker",
    ]  # fmt: skip
    ranges = {one["name"]: (one["range"], one["full_turn"]) for one in report["inputs"]}
    assert ranges["rocker"] == (pytest.approx([-LIMIT, LIMIT], abs=1e-9), False)
    assert ranges["crank"][1]
    assert {part.partition(":")[0] for part in str(found).split("\n\n")[1:]} == {"rocker", "crank"}
    assert report["mobility"] == gimcli.mobility(gimcli.loads(TWO)).mobility == 2


def test_a_strut_beside_a_crank_disturbs_no_command():
    data = {
        "nodes": {"O": [0, 0], "A": [1, 0], "G": [3, 0], "H": [5, 0], "B": [4, 2]}, "ground": ["O", "G", "H"],
        "links": {"crank": ["O", "A"], "left": ["G", "B"], "right": ["H", "B"]},
        "actuators": {"m": {"pivot": "O", "arm": "A"}},
    }  # fmt: skip
    mechanism = gimcli.load(data)
    (path,) = gimcli.workspace(mechanism).report()["paths"]
    assert path["length"] == pytest.approx(2.0 * math.pi, rel=1e-9)
    with pytest.raises(gimcli.UsageError):
        gimcli.workspace(mechanism, "B")
    assert gimcli.check(mechanism).report()["mobility"] == 1
    assert gimcli.circuits(mechanism).count == 1
    assert gimcli.singularities(mechanism).events == []
    assert {"m.status", "B.status"} <= set(gimcli.trace(mechanism, steps=2))


@pytest.mark.parametrize("height", [1e-3, 1e-7])
def test_a_flat_strut_beside_a_crank_ends_no_command_with_a_traceback(height):
    mechanism = gimcli.load({
        "nodes": {"O": [10, 0], "A": [11, 0], "G": [0, 0], "H": [2, 0], "B": [1, height]}, "ground": ["O", "G", "H"],
        "links": {"crank": ["O", "A"], "left": ["G", "B"], "right": ["H", "B"]}, "units": {"length": "m"},
        "actuators": {"m": {"pivot": "O", "arm": "A"}}, "masses": {"A": 1}, "gravity": [0, -10],
    })  # fmt: skip
    found = gimcli.trace(mechanism, steps=8)
    assert set(found["m.status"]) == {"ok"}
    assert np.hypot(found["A.x"] - 10.0, found["A.y"]) == pytest.approx(np.ones(9), rel=1e-12)
    gimcli.tradeoff(mechanism, steps=4, tolerances=[1e-2, 1e-12])
    gimcli.sensitivity(mechanism, steps=4)
    assert gimcli.forces(mechanism, steps=4).complete


def test_pictures_are_one_file_for_each_machine(tmp_path):
    gimcli.singularities(gimcli.loads(TWO)).save(tmp_path / "s.csv", tmp_path / "s.png")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["s.crank.png", "s.csv", "s.rocker.png"]


def test_a_traced_ground_node_that_no_machine_has_is_fixed():
    data = {
        "nodes": {"O": [0, 0], "A": [1, 0], "P": [5, 0], "Q": [6, 0], "Z": [9, 0]}, "ground": ["O", "P", "Z"],
        "links": {"c": ["O", "A"], "d": ["P", "Q"]}, "trace": ["Z", "A"],
        "actuators": {"m": {"pivot": "O", "arm": "A"}, "n": {"pivot": "P", "arm": "Q"}},
    }  # fmt: skip
    points = gimcli.trace(gimcli.load(data), steps=4).report()["points"]
    assert {name: one["curve"] for name, one in points.items()} == {"Z": "fixed", "A": "closed"}


STRUT = """
units: {{length: m}}
nodes: {{G: [0, 0], H: [2, 0], K: [1, {height}], A: [5, 0], B: [6, 0]}}
ground: [G, H, A]
links: {{s: [G, K], t: [K, H], crank: [A, B]}}
actuators: {{motor: {{pivot: A, arm: B, law: {{by: 360}}}}}}
masses: {{B: 2{mass}}}
gravity: [0, -10]
trace: [B]
"""
MOTOR = np.radians(np.linspace(0.0, 360.0, 13))


def test_a_strut_without_a_determined_place_leaves_the_results_of_the_machine_beside_it():
    """Two bars 1e-7 from a line, whose forces are singular, beside a mass m on a crank r: torque m g r cos(q)."""
    mechanism = gimcli.loads(STRUT.format(height=1e-7, mass=", K: 1"))
    found = gimcli.forces(mechanism, steps=12)
    assert found["motor.effort"] == pytest.approx(20.0 * np.cos(MOTOR), abs=1e-9)
    assert list(found["motor.status"]) == ["ok"] * 13
    assert list(found["K.status"]) == ["singular"] * 13
    assert gimcli.holding_forces(mechanism, motor=60).each["motor"]["motor.effort"] == pytest.approx(10.0)
    assert gimcli.reduce(mechanism, steps=12)["J"] == pytest.approx([2.0] * 13, rel=1e-9)
    assert sorted(gimcli.equilibrium(mechanism)["motor"] % 360.0) == pytest.approx([90.0, 270.0])
    derivatives = gimcli.sensitivity(mechanism, of="B.x", by="crank", steps=12).derivatives["B.x"]["crank.length"]
    assert derivatives == pytest.approx(np.cos(MOTOR), abs=1e-12)
    swept = gimcli.sweep(mechanism, {"B.x": "6,7", "K.y": "1e-7,1"}, steps=12, keep=["range(B.x)", "max(K.y)"])
    assert swept["range(B.x)"] == pytest.approx([2.0, 2.0, 4.0, 4.0])
    assert swept["max(K.y)"] == pytest.approx([np.nan, 1.0, np.nan, 1.0], nan_ok=True)
    assert gimcli.tradeoff(mechanism, steps=12, tolerances=[1e-2, 1e-12]).answered


def test_a_loaded_strut_has_reactions_beside_a_machine():
    """A weight on two bars of slope 1/2: half of it in each, twice as much along the ground."""
    found = gimcli.forces(gimcli.loads(STRUT.format(height=0.5, mass=", K: 1")), steps=12)
    assert found.report()["solved"] == 13
    assert (found["G.fx"], found["G.fy"]) == (pytest.approx([10.0] * 13), pytest.approx([5.0] * 13))
    assert found.each["K"].statistics["H"].greatest.value == pytest.approx(math.hypot(10.0, 5.0))


def test_derivatives_of_a_strut_beside_a_machine():
    """K is at (1, h) with h^2 = s^2 - 1 for equal bars s: a longer left bar moves it by s/2 to the right."""
    mechanism = gimcli.loads(STRUT.format(height=0.5, mass=""))
    found = gimcli.sensitivity(mechanism, of=["K.x", "B.x"], by=["s", "crank"], steps=4)
    assert found.each["K"].derivatives["K.x"]["s.length"] == pytest.approx(math.sqrt(1.25) / 2.0)
    both = gimcli.sensitivity(mechanism, of=["B.x", "angle:crank/s"], by="motor", steps=4)
    assert both.each["motor"].derivatives["B.x"]["motor"][1] == pytest.approx(-math.pi / 180.0)
    assert both.each["K+motor"].derivatives["angle:crank/s"]["motor"] == pytest.approx([1.0] * 5)
