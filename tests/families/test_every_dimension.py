"""Any dimension of every shipped model can be varied in `sweep` and `sensitivity`: a result, or a message."""

from contextlib import suppress

import pytest
from bundled import FILES

import gimcli
from gimcli import GimError


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_all_dimensions_are_recorded(path):
    """The numbers of the plan as functions of all dimensions at once have their nominal values."""
    mechanism = gimcli.load(path)
    names = [one.name for one in mechanism.written.dimensions.values() if not one.formula]
    recorded, recording = mechanism.written.recorded(mechanism, names)
    assert recorded.nodes == mechanism.nodes
    assert len(recording.variables) == len(names)


@pytest.mark.soak
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_each_dimension_varies_alone(path):
    mechanism = gimcli.load(path)
    for one in mechanism.written.dimensions.values():
        for ask in (
            lambda name: gimcli.sensitivity(mechanism, by=name, steps=1, samples=0, jit="off"),
            lambda name, value=one.value: gimcli.sweep(mechanism, {name: [value]}, keep="solved", steps=2),
        ):
            with suppress(GimError):  # refused by name
                ask(one.name)


def test_gravity_varies_beside_a_rotor():
    model = {
        "nodes": {"O": [0, 0], "A": [1, 0]}, "ground": ["O"], "links": {"crank": ["O", "A"]}, "gravity": [0, -9.81],
        "actuators": {"m": {"pivot": "O", "arm": "A", "rotor": {"inertia": 1}}},
    }  # fmt: skip
    found = gimcli.sweep(gimcli.load(model), {"gravity.y": [-10, -9]}, keep="max(A.x)", steps=4)
    assert list(found["max(A.x)"]) == [1, 1]


@pytest.mark.parametrize("name", ["wiper", "garage_door"])
def test_sensitivities_beside_a_rotor(name):
    mechanism = gimcli.load(next(path for path in FILES if path.stem == name))
    assert len(gimcli.sensitivity(mechanism, of="T.x", steps=2, samples=0).keys()) > 2
