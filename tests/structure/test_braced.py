"""A link between two nodes of an element is redundant: it changes no result."""

import cmath

import numpy as np
import pytest
from link_graphs import loaded

from gimcli import StructureError
from gimcli.motion.solve import solve
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.mobility import mobility, require_driven

CRANK, ROD = 1.0, 3.0
PIVOT, EYE, FOOT = 0j, 1.5 - 0.5j, 2.5 + 2.0j


def rod(angle):
    """Return the tip of the crank, and the end of the rod from there through the eye, from the definition."""
    tip = CRANK * cmath.exp(1j * angle)
    return tip, tip + ROD * (EYE - tip) / abs(EYE - tip)


def braced():
    """A ram drives the end of a rod that slides through an eye; the crank is both an element and a link."""
    tip, end = rod(0.6)
    return {
        "nodes": {
            "O": [0, 0], "E": [EYE.real, EYE.imag], "F": [FOOT.real, FOOT.imag], "A": [tip.real, tip.imag],
            "B": [-0.5, 0.7], "P": [end.real, end.imag],
        },
        "ground": ["O", "E", "F"],
        "links": {"brace": ["O", "A"], "rod": ["A", "P"]},
        "elements": {"crank": ["O", "A", "B"]},
        "prismatic": {"eye": {"node": "E", "guide": ["A", "P"]}},
        "actuators": {"ram": {"type": "linear", "nodes": ["F", "P"]}},
    }  # fmt: skip


@pytest.mark.parametrize("angle", [0.6, 0.7])
def test_concentric_circles_are_not_used_as_a_dyad(angle):
    mechanism = loaded(braced())
    tip, end = rod(angle)
    found = solve(mechanism, np.array([abs(end - FOOT) / mechanism.scale]), Options())
    assert found.status is Status.OK
    z = dict(zip(mechanism.nodes, mechanism.to_file(found.z), strict=True))
    assert max(abs(z["A"] - tip), abs(z["P"] - end)) < 1e-9


@pytest.mark.parametrize("reference", ["O", "B"])
def test_an_actuator_between_members_without_relative_motion_is_redundant(reference):
    """The gradient of such an angle is zero except for rounding errors: it does not increase the rank."""
    spec = braced()
    spec["actuators"] = {"motor": {"type": "rotary", "pivot": "A", "arm": "O", "reference": reference}}
    mechanism = loaded(spec)
    found = mobility(mechanism, mechanism.drawn)
    assert (found.mobility, found.overdriven) == (1, ("motor",))
    assert {"A", "B", "P"} <= set(found.undriven)
    with pytest.raises(StructureError):
        require_driven(mechanism)
