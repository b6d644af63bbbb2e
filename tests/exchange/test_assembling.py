"""Drafts of mechanisms become models: guides of slots, and blocks that slide or are slid over."""

from __future__ import annotations

import cmath
import math

import pytest

import gimcli
from gimcli.exchange.assembling import model_of
from gimcli.exchange.draft import GROUND, Draft


def slider_crank(*ground: complex, resolution: float = 1e-3) -> dict:
    """A slider-crank whose slot lies along the x axis, with further joints of the ground."""
    draft = Draft("Program", "f", resolution=resolution)
    o, a, b = draft.joint("O", 0j, GROUND), draft.joint("A", 1 + 1j), draft.joint("B", 4 + 0j)
    draft.body("crank", [o, a])
    draft.body("rod", [a, b])
    for k, place in enumerate(ground):
        draft.joint(f"G{k}", place, GROUND)
    draft.slot("slot", b, GROUND, 1 + 0j)
    return model_of(draft)


@pytest.mark.parametrize(
    ("ground", "guide"),
    [
        ((3 + 0j,), ["O", "G0"]),
        ((3 + 0j, -1 + 0j, 2 + 1j), ["G1", "G0"]),  # the two that are farthest apart, along the slot
        ((0.001 + 0j,), ["B_from", "B_to"]),  # places that are rounded to 0.001 give no direction
        ((0j,), ["B_from", "B_to"]),
        ((3 + 0.5j,), ["B_from", "B_to"]),
    ],
)
def test_a_guide_is_two_joints_along_the_slot_or_two_new_nodes(ground, guide):
    data = slider_crank(*ground)
    assert data["prismatic"] == {"slot": {"node": "B", "guide": guide}}
    (x, y), (end, level) = (data["nodes"][name] for name in guide)
    assert y == level == 0
    assert end - x > 0.2


def count(mechanism) -> dict[str, str]:
    table = dict(zip(*(list(column) for column in gimcli.mobility(mechanism).values()), strict=True))
    return {key: table[key] for key in ("Grübler's count", "mobility", "redundant constraints")}


def test_a_link_slides_over_a_block_that_two_pins_fix_to_the_ground():
    """A slider-crank: the rod of length sqrt(5) joins the slider at height 1 to the crank of length sqrt(8)."""
    draft = Draft("Program", "f")
    draft.body("slider", [])
    p, a, b = draft.joint("P", 0j), draft.joint("A", 2 + 1j, "slider"), draft.joint("B", 4 + 2j)
    q, r, o = (draft.joint(name, place, GROUND) for name, place in (("Q", -1 + 0j), ("R", -1j), ("O", 6 + 0j)))
    for name, joints in (("block", [p, q, r]), ("rod", [a, b]), ("crank", [o, b])):
        draft.body(name, joints)
    draft.slot("slot", p, "slider", 1 + 0j, body="block")
    draft.rotary("motor", o, "crank", law={"by": 30})
    mechanism = gimcli.load(model_of(draft))
    assert count(mechanism) == {"Grübler's count": "1", "mobility": "1", "redundant constraints": "none"}
    for angle in (120, 135, 150):
        end = 6 + cmath.rect(math.sqrt(8), math.radians(angle))
        x = end.real - math.sqrt(5 - (end.imag - 1) ** 2)
        assert gimcli.solve(mechanism, motor=angle)["A"] == pytest.approx((x, 1))


def test_the_travel_of_a_fixed_block_moves_the_link_that_slides_over_it_back():
    draft = Draft("Program", "f")
    draft.body("slider", [draft.joint("A", 2 + 1j)])
    p, q = draft.joint("P", 0j, GROUND), draft.joint("Q", -1 + 0j, GROUND)
    draft.body("block", [p, q])
    draft.slot("slot", p, "slider", 1 + 0j, body="block")
    draft.travel("drive", slot="slot", law={"by": 0.5})
    first, last = gimcli.trace(gimcli.load(model_of(draft)), steps=1).xy["A"]
    assert last - first == pytest.approx([-0.5, 0])


def test_two_links_of_one_block_are_one_body_without_a_redundant_constraint():
    """A block with the points B and C, a rod and a crank: Grübler's count is 3 * 3 - 2 * 4 = 1."""
    draft = Draft("Program", "f")
    a, b, c = draft.joint("A", 0j), draft.joint("B", 2 + 1j), draft.joint("C", 1 - 2j)
    d, o = draft.joint("D", 4 + 2j), draft.joint("O", 6 + 0j, GROUND)
    for name, joints in (("one", [a, b]), ("two", [a, c]), ("rod", [b, d]), ("crank", [o, d])):
        draft.body(name, joints)
    for name, body in (("slot", "one"), ("slot_2", "two")):
        draft.slot(name, a, GROUND, 1 + 0j, body=body)
    draft.rotary("motor", o, "crank", law={"by": 30})
    mechanism = gimcli.load(model_of(draft))
    assert count(mechanism) == {"Grübler's count": "1", "mobility": "1", "redundant constraints": "none"}
    for angle in (120, 150):
        place = gimcli.solve(mechanism, motor=angle)
        end = 6 + cmath.rect(math.sqrt(8), math.radians(angle))
        x = end.real - math.sqrt(5 - (end.imag - 1) ** 2)
        assert place["B"] == pytest.approx((x, 1))
        assert place["C"] == pytest.approx((x - 1, -2))


def test_mechanisms_are_of_at_most_500_joints_and_links():
    draft = Draft("test", "f")
    names = [draft.joint(f"J{k}", k + 0j) for k in range(500)]
    with pytest.raises(gimcli.ModelError, match="more than 500 joints are too many"):
        draft.point("J500", GROUND, 0j)
    draft = Draft("test", "f", joints=dict.fromkeys(names, 0j))
    for k in range(6):
        draft.body(f"b{k}", names)
    with pytest.raises(gimcli.ModelError, match="more than 3000 joints of links are too many"):
        draft.body("b6", names[:1])
    draft = Draft("test", "f", joints=dict.fromkeys(names, 0j))
    for k in range(500):
        draft.body(f"b{k}", ())
    with pytest.raises(gimcli.ModelError, match="more than 500 links are too many"):
        draft.body("b500", ())


def test_a_draft_in_space_holds_three_coordinates_and_has_the_size_of_its_diagonal():
    draft = Draft("Program", "f")
    pillar = draft.body("pillar", [draft.joint("A", (0.0, 0.0, 0.0), GROUND), draft.joint("B", (2.0, 3.0, 6.0))])
    draft.slot("slot", "B", pillar, (0.0, 3.0, 4.0))
    draft.point("P", pillar, (1.0, 1.0, 1.0))
    assert draft.joints["B"] == draft.slots[0].place == (2, 3, 6)
    assert draft.slots[0].direction == pytest.approx((0, 0.6, 0.8))
    assert draft.tracers["P"] == (pillar, (1, 1, 1))
    assert draft.size() == 7
    with pytest.raises(gimcli.ModelError, match="joint C: the coordinates are not finite numbers"):
        draft.joint("C", (0.0, 0.0, math.inf))


def sliding(fixed: str) -> Draft:
    """A link with a slot, of two further joints, over a block; `fixed` is the part on the ground."""
    draft = Draft("Program", "f")
    p, a, b, c = (draft.joint(name, place) for name, place in zip("PABC", (2 + 0j, 1j, 4 + 1j, 2 - 1j), strict=True))
    draft.body("slotted", [a, b])
    draft.body("block", [p, c])
    draft.bodies[GROUND] += {"block": [p, c], "slotted": [a, b], "ground": [p]}[fixed]
    draft.slot("slot", p, "slotted", 1 + 0j, body=GROUND if fixed == "ground" else "block")
    return draft


@pytest.mark.parametrize("fixed", ["block", "slotted", "ground"])
def test_a_block_takes_two_freedoms_whatever_is_fixed(fixed):
    """One link that slides along another one without turning: 3 - 2 freedoms; a block beside it turns about its pin."""
    freedoms = "2" if fixed == "ground" else "1"
    found = count(gimcli.load(model_of(sliding(fixed))))
    assert found == {"Grübler's count": freedoms, "mobility": freedoms, "redundant constraints": "none"}
