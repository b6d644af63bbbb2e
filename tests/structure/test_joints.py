"""The list of joints: kinds, bodies and inputs by definition, and their constraints."""

from bundled import MODELS

import gimcli
from gimcli.structure.joints import joints

PRESS = {
    "nodes": {
        "O": [0, 0], "A": [1, 0.5], "B": [4, 0], "C": [5, 0], "P": [6, 0], "S": [1, 2], "T": [0, 2], "W": [2, 3],
    },
    "ground": ["O", "P", "T"],
    "links": {"crank": ["O", "A"], "rod": ["A", "B"], "slide": ["B", "C"]},
    "prismatic": {"bore": {"nodes": ["B", "C"], "guide": ["O", "P"]}, "slot": {"node": "S", "guide": ["O", "A"]}},
    "actuators": {
        "motor": {"pivot": "O", "arm": "A"},
        "feed": {"node": "B", "guide": ["O", "P"]},
        "ram": {"nodes": ["T", "S"]},
        "lift": {"node": "W", "guide": ["O", "T"]},
    },
}  # fmt: skip


def test_kinds_bodies_and_inputs_of_the_joints():
    """Bodies: ground 0, crank 1, rod 2, slide 3, then the nodes without a member: S 4 and W 5."""
    mechanism = gimcli.load(PRESS)
    found = {joint.name: (joint.kind, joint.bodies, joint.actuator) for joint in joints(mechanism)}
    assert found == {
        "O": ("R", (0, 1), -1), "A": ("R", (1, 2), -1), "B": ("R", (2, 3), -1),
        "bore": ("P", (0, 3), 1), "slot": ("PR", (1, 4), -1),
        "motor": ("RPP", (1, 0), 0), "ram": ("RPR", (0, 4), 2), "lift": ("PPR", (0, 5), 3),
    }  # fmt: skip


def test_each_joint_has_as_many_constraints_as_freedoms_that_it_takes():
    """In the plane 3 less the freedoms left: two of a pin or a prismatic pair, one of a slot, none of an input."""
    for path in sorted(MODELS.glob("*.yaml")):
        mechanism = gimcli.load(path)
        pairs = [joint for joint in joints(mechanism) if joint.slides]
        assert [3 - len(pair.kind) for pair in pairs] == [len(pair.slides) for pair in pairs]
        assert [k for pair in pairs for k in pair.slides] == list(range(len(mechanism.slides)))
        pins = [joint for joint in joints(mechanism) if joint.kind == "R"]
        held = sum(len(member.nodes) for member in mechanism.members)
        used = {node for member in mechanism.members for node in member.nodes}
        assert sum(pin.pairs for pin in pins) == held - len(used)
        driven = [joint.actuator for joint in joints(mechanism) if joint.actuator >= 0]
        assert sorted(driven) == list(range(len(mechanism.actuators)))
