"""Euler's law: if all lengths grow in proportion, so do the positions, and no angle changes."""

import pytest
from bundled import MODELS

import gimcli

NAMES = [
    "elliptic_trammel", "excavator", "floating_hexagon", "gim_fig11", "innocenti_group", "peaucellier", "platform_3rpr",
    "scissor_lift", "slider_crank", "stephenson_2", "stephenson_3_far", "whitworth",
]  # fmt: skip


@pytest.mark.few(6)
@pytest.mark.parametrize("name", NAMES)
def test_all_lengths_and_strokes_together(name):
    mechanism = gimcli.load(MODELS / f"{name}.yaml")
    at = gimcli.solve(mechanism).inputs
    members = [member.name for member in mechanism.members[1:3]]
    nodes = [node for k, node in enumerate(mechanism.nodes) if k not in mechanism.members[0].nodes]
    found = gimcli.sensitivity(mechanism, of=[*nodes, *members], at=at)
    report = found.report()
    lengths = {name: d for name, d in report["dimensions"].items() if d["unit"] == mechanism.length_unit}
    sizes = {name: at.get(name, d["value"]) for name, d in lengths.items()}
    for quantity, slopes in found.derivatives.items():
        total = sum(slope * sizes.get(dimension, 0.0) for dimension, slope in slopes.items())
        expected = 0.0 if quantity.endswith(".angle") else report["quantities"][quantity]["value"]
        assert total == pytest.approx(expected, abs=1e-9 * mechanism.size * mechanism.scale)
