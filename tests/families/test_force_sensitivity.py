"""Derivatives of forces along guides by stiffness, unloaded length and mass: closed forms."""

import pytest

import gimcli

GUIDE = """
units: {length: m}
nodes: {O: [0, 0], X: [1, 0], A: [0.5, 0], B: [0.7, 0]}
ground: [O, X]
links: {block: {nodes: [A, B]}}
prismatic: {slide: {nodes: [A, B], guide: [O, X]}}
actuators: {q: {node: A, guide: [O, X], law: {from: 0.4, to: 0.7}}}
masses: {block: 4}
gravity: [-2, -9.81]
springs: {s: {node: A, guide: [O, X], stiffness: 100, free: 0.4}}
dampers: {d: {node: A, guide: [O, X], damping: 3}}
"""
PIN = (
    GUIDE.replace(", B: [0.7, 0]", "").replace("[A, B]", "A").replace("nodes: A", "node: A").replace("block: 4", "A: 4")
)
"""The same with a pin in the guide: the mechanism has no moving member."""


@pytest.mark.parametrize("text", [GUIDE, PIN.replace("links: {block: {node: A}}\n", "")], ids=["block", "pin"])
def test_forces_along_a_guide_have_the_derivatives_of_their_laws(text):
    """F = k (x - free), the effort is F + 2 m; both are greatest at x = 0.7."""
    mass = "block.mass" if "block" in text else "A.mass"
    found = gimcli.sensitivity(gimcli.loads(text), of=["max(s.force)", "last(q.effort)"], steps=12).report()
    force, effort = (found["quantities"][name]["derivatives"] for name in ("max(s.force)", "last(q.effort)"))
    assert force["s.stiffness"]["value"] == pytest.approx(0.3, rel=1e-12)
    assert force["s.free"]["value"] == pytest.approx(-100.0, rel=1e-12)
    assert effort[mass]["value"] == pytest.approx(2.0, rel=1e-12)
