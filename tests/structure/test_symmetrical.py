"""Mobility where branches meet: every branch has its own, and drives are judged on the branch that they move."""

import cmath
import math

import numpy as np
import pytest
from symmetrical_mechanisms import symmetrical

import gimcli
from gimcli.structure.mobility import mobility


@pytest.mark.few(10)  # one of each kind
@pytest.mark.parametrize("seed", range(200))
def test_symmetrical_mechanisms_have_the_mobility_of_each_branch(seed):
    """Closed forms, see `symmetrical_mechanisms`."""
    _, data, branches = symmetrical(seed)
    found = gimcli.mobility(gimcli.load(data)).report()
    listed = {(b["mobility"], frozenset(b["undriven"]), frozenset(b["over_driven"])) for b in found["branches"]}
    assert listed == branches
    assert found["mobility"] == max(mobility for mobility, *_ in branches)
    driven = (found["mobility"], frozenset(), frozenset()) in branches
    assert not driven or found["undriven"] == found["overdriven"] == []


def cranks(count, length, angle, driven=True):
    """Fraczek & Wojtyra, example 1.12: equal cranks 1 m apart and one coupler, drawn at an angle [deg]."""
    arm = cmath.rect(length, math.radians(angle))
    arm = complex(arm.real, 0.0 if angle % 180 == 0 else arm.imag)
    ends = {f"B{k}": k + arm for k in range(count)}
    data = {
        "units": {"length": "m", "angle": "deg"},
        "nodes": {f"A{k}": [k, 0] for k in range(count)} | {n: [z.real, z.imag] for n, z in ends.items()},
        "ground": [f"A{k}" for k in range(count)],
        "links": {f"crank_{k}": [f"A{k}", f"B{k}"] for k in range(count)},
        "elements": {"coupler": list(ends)},
    }
    law = {"from": 0, "to": 360}
    return data | ({"actuators": {"motor": {"pivot": "A0", "arm": "B0", "law": law}}} if driven else {})


@pytest.mark.few(4)
@pytest.mark.parametrize("angle", [0, 180, 0.1, 30])
@pytest.mark.parametrize("length", [0.9, 1.0, 1.3])
@pytest.mark.parametrize("count", [3, 4])
def test_the_textbook_example_is_the_same_mechanism_however_it_is_drawn(count, length, angle):
    """All cranks are parallel at every angle; the constraints lose rank at 0 and 180 deg, where no other branch is."""
    mechanism = gimcli.load(cranks(count, length, angle))
    found = gimcli.mobility(mechanism)
    assert (found.mobility, found.report()["gruebler"]) == (1, 3 - count)
    assert len(found.report()["redundant"]) == count - 2
    assert len(found.report()["branches"]) == 1
    motion = gimcli.trace(mechanism, steps=36)
    assert set(motion["status"]) == {"ok"}
    arm = length * np.exp(1j * np.radians(motion["motor"]))
    for k in range(count):
        assert np.abs(motion[f"B{k}.x"] + 1j * motion[f"B{k}.y"] - k - arm).max() < 1e-9
    events = [(e["kind"], e["at"]["motor"]) for e in motion.report()["events"]]
    assert events == [("tangency", pytest.approx(at, abs=1e-9)) for at in (0.0, 180.0, 360.0)]
    listed = gimcli.singularities(mechanism).report()["singularities"]
    assert [one["kind"] for one in listed] == ["tangency"] * 2
    assert sorted(one["at"]["motor"] % 360.0 for one in listed) == pytest.approx([0.0, 180.0], abs=1e-9)
    checked = gimcli.check(mechanism).report()
    assert (checked["mobility"], checked["solved"], checked["rows"]) == (1, 361, 361)
    assert [one["full_turn"] for one in checked["outputs"]] == [True] * (count - 1)
    assert checked["transmission"][0]["worst"] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("angle", [0, 180, 30])
def test_the_textbook_example_without_its_actuator(angle):
    found = gimcli.mobility(gimcli.load(cranks(3, 1.0, angle, driven=False))).report()
    assert (found["mobility"], found["undriven"]) == (1, ["B0", "B1", "B2"])
    with pytest.raises(gimcli.GimError):
        gimcli.trace(gimcli.load(cranks(3, 1.0, angle, driven=False)))


@pytest.mark.parametrize("seed", [5, 15, 25, 35])
def test_branches_that_touch_are_not_a_tangent_mechanism(seed):
    """From the extreme of its rocker a crank-rocker moves on, with a flat parallelogram on the rocker."""
    name, data, branches = symmetrical(seed)
    assert (name, len(branches)) == ("rocker_at_its_extreme", 1)
    drawn = gimcli.load(data)
    start = drawn.inputs_to_file(drawn.drawn_inputs)["motor"]
    data["actuators"]["motor"]["law"] = {"from": start, "to": start + 40}
    motion = gimcli.trace(gimcli.load(data), steps=12)
    assert set(motion["status"]) == {"ok"}
    z = {n: motion[f"{n}.x"] + 1j * motion[f"{n}.y"] for n in ("Q", "B0", "C")}
    places = {n: complex(*place) for n, place in data["nodes"].items()}
    for one, other in (("Q", "B0"), ("B0", "C")):
        assert np.abs(np.abs(z[one] - z[other]) - abs(places[one] - places[other])).max() < 1e-9


# mobility where a shipped mechanism folds: the rhombus of Peaucellier's cell collapses to two arms, one about each end
# (2); each pair of equal bars of the scissors turns about its own pins (3)
FOLDED = {"parallelogram": 1, "antiparallelogram": 1, "galloway_kite": 1, "peaucellier": 2, "scissor_lift": 3}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.soak if n in ("peaucellier", "scissor_lift") else ()) for n in FOLDED]
)
def test_drives_are_judged_on_the_branch_that_they_move_at_every_singular_position(name):
    mechanism = gimcli.load(name)
    base = gimcli.mobility(mechanism)
    assert (base.mobility, len(base.report()["branches"])) == (1, 1)
    found = []
    for one in gimcli.singularities(mechanism).report()["singularities"]:
        if one["kind"] == "stationary":
            continue
        z = np.array([complex(*one["nodes"][node]) for node in mechanism.nodes])
        here = mobility(mechanism, (z - mechanism.origin) / mechanism.scale)
        assert here.undriven == here.overdriven == ()
        assert here.branches[0].mobility == base.report()["branches"][0]["mobility"]
        found.append(here.mobility)
    assert max(found) == FOLDED[name]
