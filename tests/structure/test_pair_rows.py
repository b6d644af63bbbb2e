"""A pair that model files do not have, made of one row: two members keep their relative angle, as by a belt.

All analyses must handle this pair by its row alone; the results are compared with closed forms.
"""

from dataclasses import replace

import numpy as np
import pytest
from heavy_models import motion_forces

from gimcli.assemblies import all_configurations
from gimcli.branching.enumeration import circuits
from gimcli.comparison.bodies import Bodies
from gimcli.mechanism import ANGLE, PairRow
from gimcli.model.compile import compile_model
from gimcli.model.part import long_form
from gimcli.model.schema import Model
from gimcli.motion.motion import trace
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.assur import formation
from gimcli.structure.mobility import assembled, mobility

DYAD = {
    "nodes": {"O": [0.0, 0.0], "A": [1.0, 0.0], "P": [4.0, 0.0], "B": [4.0, 1.5], "C": [2.5, 3.0]},
    "ground": ["O", "P"],
    "links": {"crank": ["O", "A"], "arm": ["P", "B"], "l": ["A", "C"], "r": ["B", "C"]},
    "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"from": 0.0, "to": 90.0}}},
    "masses": {name: {"mass": m, "inertia": 0.1} for name, m in (("crank", 1.0), ("arm", 2.0), ("l", 3.0), ("r", 4.0))},
    "gravity": [0.0, -9.81],
    "duration": 1e6,
}  # fmt: skip
COUPLED = {
    "nodes": {"O": [0.0, 0.0], "A": [1.0, 0.4], "P": [5.0, 0.0], "B": [4.6, 2.0], "C": [2.5, 3.0], "D": [6.5, 2.6],
              "Q": [7.0, 0.0]},
    "ground": ["O", "P", "Q"],
    "links": {"crank": ["O", "A"], "l": ["A", "C"], "r": ["C", "B"], "arm": ["P", "B"], "s": ["B", "D"],
              "q": ["Q", "D"]},
    "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"by": 20.0}}},
}  # fmt: skip


def belted(data, body, guide):
    """Return a mechanism with two members that keep their drawn relative angle."""
    mechanism = compile_model(Model.model_validate(long_form(data)))
    members = [next(k for k, m in enumerate(mechanism.members) if m.name == name) for name in (body, guide)]
    first, second = (arm(mechanism, mechanism.drawn[:, None], k)[0] for k in members)
    row = PairRow("belt", ANGLE, (), tuple(members), reference=first / second / abs(first / second), pair="belt")
    return replace(mechanism, pairs=(row,))


def arm(mechanism, z, index):
    """Return the vector from a binary member's first to its second node (rows,)."""
    first, second = mechanism.members[index].nodes
    return z[second] - z[first]


def by_circles(theta):
    """Return A, B, C of the dyad at crank angles (rows,): the arm is 90 deg ahead of the crank, C is on two circles."""
    a, b = np.exp(1j * theta), 4.0 + 1.5j * np.exp(1j * theta)
    left, right = abs(2.5 + 3.0j - 1.0), abs(2.5 + 3.0j - (4.0 + 1.5j))
    d = abs(b - a)
    x = (d**2 + left**2 - right**2) / (2.0 * d)
    return a, b, a + (b - a) / d * (x + 1j * np.sqrt(left**2 - x**2))


@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
def test_members_of_a_belt_rotate_by_the_same_angle(method):
    mechanism = belted(DYAD, "arm", "crank")
    motion = trace(mechanism, 18, Options(method=method, tolerance=1e-12))
    assert set(motion.status) == {Status.OK}
    found = mechanism.to_file(motion.z)
    for node, expected in zip("ABC", by_circles(motion.inputs[0]), strict=True):
        assert found[mechanism.nodes.index(node)] == pytest.approx(expected, abs=1e-9)


def test_a_belt_transmits_a_torque():
    """In a quasi-static motion the motor's torque is the derivative of the potential energy of the weights."""
    mechanism = belted(DYAD, "arm", "crank")
    motion = trace(mechanism, 9)
    found = motion_forces(motion)

    def potential(theta):
        a, b, c = by_circles(theta)
        centres = {"crank": a / 2, "arm": (4.0 + b) / 2, "l": (a + c) / 2, "r": (b + c) / 2}
        return 9.81 * sum(mass["mass"] * centres[name].imag for name, mass in DYAD["masses"].items())

    theta, step = motion.inputs[0], 1e-5
    expected = (potential(theta + step) - potential(theta - step)) / (2.0 * step)
    assert found.effort(0) == pytest.approx(expected, rel=1e-8, abs=1e-7)


@pytest.mark.parametrize("method", ["auto", "newton", "gim"])
def test_a_belt_between_floating_members(method):
    """Two members without fixed pivots are kept parallel in a coupled group; both keep their lengths."""
    mechanism = belted(COUPLED, "s", "l")
    body, guide = mechanism.pairs[0].members
    motion = trace(mechanism, 12, Options(method=method, tolerance=1e-13))
    assert set(motion.status) == {Status.OK}
    turn = arm(mechanism, motion.z, body) / arm(mechanism, motion.z, guide)
    assert np.angle(turn / turn[0]) == pytest.approx(np.zeros(13), abs=1e-11)
    for index, member in enumerate(mechanism.members[1:], start=1):
        length = abs(member.shape[1] - member.shape[0])
        assert abs(arm(mechanism, motion.z, index)) == pytest.approx(np.full(13, length), rel=1e-11)


@pytest.mark.parametrize("data", [(DYAD, "arm", "crank"), (COUPLED, "s", "l")], ids=["dyad", "coupled"])
def test_a_belt_counts_as_one_constraint(data):
    mechanism = belted(*data)
    loose = replace(mechanism, pairs=())
    z = assembled(mechanism)
    with_it, without = (mobility(m, z) for m in (mechanism, loose))
    assert (with_it.mobility, with_it.gruebler, with_it.undriven, with_it.redundant) == (1, 1, (), ())
    assert (without.mobility, without.gruebler) == (2, 2)
    groups = formation(mechanism).groups
    assert sum(len(g.links) for g in groups) == len(mechanism.members) - 1
    assert [g.surplus for g in groups] == [0] * len(groups)
    assert len(Bodies(mechanism).pairs) == len(Bodies(loose).pairs) + 1


def test_all_configurations_with_a_belt():
    """The dyad can be assembled on both sides of A B; the belt allows no other choice."""
    mechanism = belted(DYAD, "arm", "crank")
    found = all_configurations(mechanism, np.array([0.3]))
    a, b, c = by_circles(np.array(0.3))
    mirrored = a + (b - a) * ((c - a) / (b - a)).conjugate()
    places = sorted((mechanism.to_file(z)[mechanism.nodes.index("C")] for z in found.z), key=np.imag)
    assert np.array(places) == pytest.approx(np.array(sorted([c, mirrored], key=np.imag)), abs=1e-12)
    assert len(circuits(mechanism).strands) == 1
