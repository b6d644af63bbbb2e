"""Parameters that are set by hand: a new motion, their ranges, faults, and files that are saved meanwhile."""

from __future__ import annotations

import math

import pytest
from live_server import running

MODEL = """\
parameters: {r: 1, s: 0, t: -2, g: 4*r}
nodes: {O: [0, 0], G: [g, 0], A: [0, 1], B: [4, 3]}
ground: [O, G]
links: {crank: {nodes: [O, A], length: r}, coupler: {nodes: [A, B], length: 5 + s}, rocker: [G, B]}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {by: 60}}}
trace: [B]
"""


@pytest.fixture
def path(tmp_path):
    (tmp_path / "m.yaml").write_text(MODEL)
    return tmp_path / "m.yaml"


def crank_length(client):
    motion = client.ask("GET", "/data").json["motion"]
    x, y = client.solve(motion=motion)["nodes"][2]
    return (x * x + y * y) ** 0.5


def ranges(client):
    return {one["name"]: one for one in client.ask("GET", "/inputs").json["parameters"]}


def test_each_parameter_that_is_a_number_has_a_slider(path):
    with running(path) as client:
        found = ranges(client)
        assert list(found) == ["r", "s", "t"]
        assert {name: (one["low"], one["high"]) for name, one in found.items()} == {
            "r": (0.5, 2.0), "s": (-5.0, 5.0), "t": (-4.0, -1.0),
        }  # fmt: skip
        assert all(one["value"] == one["given"] for one in found.values())


def test_a_parameter_set_by_hand_is_solved(path):
    with running(path) as client, client.events() as events:
        assert next(events)["motion"] == 1
        assert client.ask("POST", "/set", {"parameters": {"r": 1.25}}).json == {"motion": 2}
        assert next(events) == {"motion": 2, "errors": []}
        assert crank_length(client) == pytest.approx(1.25)
        found = ranges(client)["r"]
        assert (found["value"], found["given"], found["low"], found["high"]) == (1.25, 1.0, 0.5, 2.0)
        assert len(client.notes) == 1  # only of the file
    assert path.read_text() == MODEL


def test_faults_are_shown_beside_the_last_motion(path):
    with running(path) as client, client.events() as events:
        next(events)
        client.ask("POST", "/set", {"parameters": {"r": -1}})
        errors = next(events)["errors"]
        assert len(errors) == 1
        assert "m.yaml with r = -1: crank.length: " in errors[0]
        client.ask("POST", "/set", {"parameters": {"r": 1, "s": -4.9}})
        assert "not-assembled" in next(events)["errors"][0]
        client.ask("POST", "/set", {"parameters": {"s": 0.5}})
        assert next(events) == {"motion": 2, "errors": []}


def test_the_file_wins_where_it_has_another_value(path):
    with running(path) as client, client.events() as events:
        next(events)
        client.ask("POST", "/set", {"parameters": {"r": 1.25, "s": 0.5}})
        next(events)
        path.write_text(MODEL.replace("r: 1,", "r: 1.5,").replace("trace: [B]", "trace: [A]"))
        next(events)
        assert crank_length(client) == pytest.approx(1.5)
        assert ranges(client)["s"]["value"] == 0.5
        path.write_text(MODEL.replace("s: 0, ", "").replace(" + s", ""))
        next(events)
        assert list(ranges(client)) == ["r", "t"]
        assert crank_length(client) == pytest.approx(1.0)


def test_values_of_the_command_line_are_those_of_the_file(path):
    with running(path, changes={"r": "1.25", "g": "4.5"}) as client:
        assert {name: one["given"] for name, one in ranges(client).items()} == {
            "r": 1.25,
            "s": 0.0,
            "t": -2.0,
            "g": 4.5,
        }
        assert crank_length(client) == pytest.approx(1.25)


@pytest.mark.parametrize(("body", "text"), [
    ({"parameters": {"g": 3}}, "'g' is not a parameter with a number"), ({"parameters": {"x": 3}}, "'x' is not"),
    ({"parameters": {"r": "3"}}, "finite numbers"), ({"parameters": [3]}, "finite numbers"), ([], "an object"),
    ({"parameters": {"r": 10**400}}, "finite numbers"), ({"parameters": {"r": math.nan}}, "finite numbers"),
    ({"parameters": {"r": True}}, "finite numbers"), ({"parameters": {}, "page": "a"}, "the key parameters"),
])  # fmt: skip
def test_invalid_requests_are_refused(path, body, text):
    with running(path) as client:
        found = client.ask("POST", "/set", body)
        assert found.status == 400
        assert text in found.text
        assert client.ask("GET", "/data").json["motion"] == 1
