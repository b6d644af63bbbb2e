"""What the server answers, to whom, and what it refuses."""

from __future__ import annotations

import json
import socket

import numpy as np
import pytest
from bundled import MODELS
from live_server import running

import gimcli

REQUEST = {"page": "a", "motion": 1, "inputs": {"motor": 30.0}}


@pytest.fixture(scope="module")
def crank():
    with running(MODELS / "crank_rocker.yaml") as client:
        yield client


def test_the_page_may_connect_only_to_its_server(crank):
    page = crank.ask("GET", "/")
    assert page.status == 200
    assert page.text.startswith("<!DOCTYPE html>")
    policy = page.headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "; connect-src 'self'; " in policy
    assert "unsafe" not in policy
    assert "http" not in policy
    assert crank.ask("GET", "/data").headers["Content-Security-Policy"].startswith("default-src 'none'; frame-")
    assert page.headers["X-Content-Type-Options"] == "nosniff"
    assert page.headers["Cache-Control"] == "no-store"
    assert page.headers["Cross-Origin-Resource-Policy"] == "same-origin"


def test_it_listens_on_this_machine_only(crank):
    assert crank.server.socket.getsockname()[0] == "127.0.0.1"


@pytest.mark.parametrize("path", ["/", "/data", "/inputs", "/events", "/solve", "/set"])
@pytest.mark.parametrize(
    "headers",
    [
        {"Host": "127.0.0.1"}, {"Host": "127.0.0.1:1"}, {"Host": "example.org:{port}"}, {"Host": None}, {"Host": ""},
        {"Host": ["127.0.0.1:{port}", "example.org:{port}"]}, {"Host": "127.0.0.1:{port}.example.org"},
        {"Origin": "http://example.org"}, {"Origin": "null"}, {"Origin": "http://127.0.0.1:1"},
        {"Origin": "https://127.0.0.1:{port}"}, {"Origin": "http://localhost:{port}"},
        {"Origin": "http://127.0.0.1:{port}.example.org"}, {"Sec_Fetch_Site": "cross-site"},
        {"Sec_Fetch_Site": "same-site", "Sec_Fetch_Mode": "cors"},
    ],
    ids=lambda headers: " ".join(f"{name}:{value}" for name, value in headers.items()),
)  # fmt: skip
def test_requests_of_other_pages_are_refused(crank, path, headers):
    def here(value):
        return value.replace("{port}", str(crank.port)) if isinstance(value, str) else value

    sent = {
        name: [here(v) for v in value] if isinstance(value, list) else here(value) for name, value in headers.items()
    }
    found = crank.ask(*(("POST", path, REQUEST) if path in ("/solve", "/set") else ("GET", path)), **sent)
    assert found.status == 403
    assert "nodes" not in found.text
    assert "DOCTYPE" not in found.text


@pytest.mark.parametrize("host", ["127.0.0.1:{}", "localhost:{}", "LOCALHOST:{}"])
def test_its_own_page_is_answered(crank, host):
    name = host.format(crank.port)
    found = crank.ask(
        "POST", "/solve", REQUEST, Host=name, Origin=f"http://{name.lower()}", Sec_Fetch_Site="same-origin"
    )
    assert found.status == 200


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/models", 404), ("GET", "/../pyproject.toml", 404), ("GET", "/%2e%2e/pyproject.toml", 404),
        ("GET", "/data/", 404), ("GET", "/crank_rocker.yaml", 404), ("GET", "/live.js", 404),
        ("GET", "http://example.org/", 404), ("POST", "/", 405), ("POST", "/data", 405), ("GET", "/solve", 405),
        ("GET", "/set", 405),
        ("PUT", "/solve", 501), ("DELETE", "/", 501), ("HEAD", "/", 501), ("OPTIONS", "/solve", 501),
    ],
)  # fmt: skip
def test_nothing_else_is_served(crank, method, path, status):
    found = crank.ask(method, path, REQUEST if method in ("POST", "PUT") else None)
    assert found.status == status
    assert found.headers["Content-Type"].startswith("text/plain")
    assert "Access-Control-Allow-Origin" not in found.headers


@pytest.mark.parametrize(
    ("body", "text"),
    [
        (b"", "JSON object"), (b"{", "JSON object"), (b"\xff\xfe", "JSON object"), (b"[" * 5000, "JSON object"),
        (b"[]", "keys page, motion, inputs, time"), (b"3", "keys page"), ({**REQUEST, "file": "x"}, "keys page"),
        ({**REQUEST, "page": 3}, "page: expected a text"), ({**REQUEST, "page": "a" * 99}, "page: expected a text"),
        ({**REQUEST, "motion": "1"}, "motion: expected a whole number"),
        ({**REQUEST, "inputs": [1]}, "inputs: expected an object of numbers"),
        ({**REQUEST, "inputs": {"motor": "1"}}, "inputs: expected an object of numbers"),
        ({**REQUEST, "inputs": {"motor": True}}, "inputs: expected an object of numbers"),
        ({**REQUEST, "inputs": {"motor": float("nan")}}, "expected a finite number"),
        ({**REQUEST, "inputs": {"motor": 1e300}}, "at most 10000 turns"),
        ({**REQUEST, "inputs": {"motor": 1e6}}, "at most 20 turns"),
        ({**REQUEST, "inputs": {"engine": 1}}, "no actuator 'engine'"),
        ({**REQUEST, "time": "now"}, "time: expected a finite number"),
        ({**REQUEST, "time": float("inf")}, "time: expected a finite number"),
    ],
    ids=str,
)  # fmt: skip
def test_invalid_bodies_are_answered_with_a_reason(crank, capfd, body, text):
    found = crank.ask("POST", "/solve", body)
    assert (found.status, text in found.text) == (400, True), found.text
    assert crank.ask("POST", "/solve", REQUEST).status == 200
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Content_Type": "text/plain"}, 415), ({"Content_Type": None}, 415), ({"Content_Length": "70000"}, 413),
        ({"Content_Length": "9" * 999}, 413), ({"Content_Length": "-1"}, 411), ({"Content_Length": ["2", "3"]}, 411),
        ({"Content_Length": None, "Transfer_Encoding": "chunked"}, 411),
    ],
)  # fmt: skip
def test_bodies_of_other_types_and_lengths_are_refused(crank, headers, status):
    assert crank.ask("POST", "/solve", b"", **headers).status == status


def test_half_a_request_does_not_stop_the_server(crank, capfd):
    for text in (b"GET / HT", b"POST /solve HTTP/1.1\r\nHost: x", b"\x16\x03\x01\x02\x00\x01\r\n\r\n", b"\r\n" * 9):
        with socket.create_connection(("127.0.0.1", crank.port)) as connection:
            connection.sendall(text)
    assert crank.ask("GET", "/data").status == 200
    assert capfd.readouterr() == ("", "")


def test_a_motion_that_was_replaced_is_not_moved(crank):
    assert crank.ask("POST", "/solve", {**REQUEST, "motion": 2}).status == 409


def test_positions_are_those_of_solve_over_a_turn(crank):
    mechanism = gimcli.load(MODELS / "crank_rocker.yaml")
    for angle in np.linspace(0.0, 360.0, 25):
        found = crank.solve(motor=angle)
        assert found["status"] == "ok"
        assert found["inputs"] == pytest.approx({"motor": angle}, abs=1e-12)
        exact = gimcli.solve(mechanism, motor=angle).xy
        assert np.allclose(found["nodes"], [exact[name] for name in mechanism.nodes], atol=1e-9, rtol=0.0)


def test_the_data_name_inputs_with_their_ranges(crank):
    (slider,) = crank.ask("GET", "/inputs").json["inputs"]
    assert slider == {"name": "motor", "unit": "deg", "low": 0.0, "high": 360.0, "step": 0.5, "value": 0.0}


def test_each_page_has_its_own_position_and_begins_in_the_motion():
    with running(MODELS / "five_bar.yaml") as client:
        names = [i["name"] for i in client.ask("GET", "/inputs").json["inputs"]]
        first = client.solve("a", **{names[0]: 20.0})
        assert client.solve("b", **{names[1]: 130.0})["inputs"][names[0]] != 20.0
        assert client.solve("a")["nodes"] == first["nodes"]
        begun = {"page": "a", "motion": 1, "inputs": {}, "time": 0.5}
        trace = gimcli.trace(gimcli.load(MODELS / "five_bar.yaml"), 24)
        found = client.ask("POST", "/solve", begun).json
        assert [found["inputs"][name] for name in names] == pytest.approx([trace[name][12] for name in names])


def test_an_input_beyond_its_limit_is_answered_with_the_limit(tmp_path):
    """Triple rocker; its limits follow from the law of cosines."""
    text = "nodes: {A: [0,0], B: [4,0.5], C: [5.2,2.4], D: [4,0]}\nground: [A,D]\n"
    text += "links: {a: {nodes: [A,B], length: 4}, b: {nodes: [B,C], length: 1.5}, c: {nodes: [D,C], length: 2}}\n"
    text += "actuators: {m: {type: rotary, pivot: A, arm: B, law: {from: 20, to: 200}}}\ntrace: [C]\n"
    (tmp_path / "rocker.yaml").write_text(text)
    low, high = (np.degrees(np.arccos((32.0 - reach**2) / 32.0)) for reach in (0.5, 3.5))
    with running(tmp_path / "rocker.yaml") as client:
        (slider,) = client.ask("GET", "/inputs").json["inputs"]
        assert [slider["low"], slider["high"]] == pytest.approx([low, high])
        found = client.solve(m=90.0)
        assert found["status"] == "unreachable"
        assert found["inputs"]["m"] == pytest.approx(high)
        assert f"m = {high:.3f} deg" in found["reason"]
        assert client.solve(m=50.0)["status"] == "ok"


def test_a_slider_of_an_input_without_a_law_ends_at_the_limits(tmp_path):
    """The same triple rocker; its input rests."""
    text = "nodes: {A: [0,0], B: [4,0.5], C: [5.2,2.4], D: [4,0]}\nground: [A,D]\n"
    text += "links: {a: {nodes: [A,B], length: 4}, b: {nodes: [B,C], length: 1.5}, c: {nodes: [D,C], length: 2}}\n"
    text += "actuators: {m: {type: rotary, pivot: A, arm: B, law: {from: 20, to: 20}}}\n"
    (tmp_path / "rocker.yaml").write_text(text)
    with running(tmp_path / "rocker.yaml") as client:
        (slider,) = client.ask("GET", "/inputs").json["inputs"]
        ends = [np.degrees(np.arccos((32.0 - reach**2) / 32.0)) for reach in (0.5, 3.5)]
        assert [slider["low"], slider["high"]] == pytest.approx(ends)


def test_the_data_are_one_json_object_with_the_motion(crank):
    found = json.loads(crank.ask("GET", "/data").text)
    assert found["motion"] == 1
    assert found["data"]
