"""Drafts of mechanisms become models: which nodes are guides of slots."""

from __future__ import annotations

import pytest

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
