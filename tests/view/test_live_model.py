"""A file that is saved while it is shown: new motions, errors with line and column, the last motion."""

from __future__ import annotations

import os
import re
import time

import pytest
from live_server import running

import gimcli
from gimcli import ModelError, UsageError
from gimcli.view import live_model

MODEL = """\
nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 3]}
ground: [O, G]
links: {crank: [O, A], coupler: [A, B], rocker: [G, B]}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {by: 60}}}
trace: [B]
"""
LONGER = MODEL.replace("crank: [O, A]", "crank: {nodes: [O, A], length: 1.25}")
SHORT = "links: {crank: {nodes: [O, A], length: 1}, coupler: {nodes: [A, B], length: 1}, rocker: [G, B]}"


@pytest.fixture
def path(tmp_path):
    (tmp_path / "m.yaml").write_text(MODEL)
    return tmp_path / "m.yaml"


def replaced(path, text):
    """Save as most editors do: write another file, then give it the name."""
    other = path.with_suffix(".tmp")
    other.write_text(text)
    other.replace(path)


def crank_length(client):
    motion = client.ask("GET", "/data").json["motion"]
    a = client.solve(motion=motion)["nodes"][2]
    return (a[0] ** 2 + a[1] ** 2) ** 0.5


@pytest.mark.parametrize("save", [lambda path, text: path.write_text(text), replaced], ids=["in place", "replaced"])
def test_a_saved_file_is_solved_again(path, save):
    with running(path) as client, client.events() as events:
        assert next(events) == {"motion": 1, "errors": []}
        assert crank_length(client) == pytest.approx(1.0)
        save(path, LONGER)
        assert next(events) == {"motion": 2, "errors": []}
        assert crank_length(client) == pytest.approx(1.25)
    assert [note[: note.index(",")] for note in client.notes] == ["m: 25 of 25 positions solved"] * 2


@pytest.mark.parametrize(
    ("text", "error"),
    [
        (MODEL.replace("[O, G]\n", "[O, X]\n"), r"m\.yaml:2:13: .*'X'"),
        (MODEL.replace("ground:", "grounds:"), r"m\.yaml:2:1: .*ground"),
        (MODEL + "  - {", r"m\.yaml:6:\d+: not readable as YAML"),
        (MODEL.replace("actuators", "# actuators"), "no actuator"),
        (re.sub("links: .*", SHORT, MODEL), "not-assembled"),
    ],
)
def test_an_error_is_shown_and_the_last_motion_stays(path, text, error):
    with running(path) as client, client.events() as events:
        next(events)
        before = client.ask("GET", "/data").text
        path.write_text(text)
        event = next(events)
        assert event["motion"] == 1
        assert re.search(error, "\n".join(event["errors"])), event
        assert client.ask("GET", "/data").text == before
        assert client.solve(motor=95.0)["status"] == "ok"
        path.write_text(MODEL)
        assert next(events) == {"motion": 2, "errors": []}


def test_a_file_may_disappear_and_return(path):
    with running(path) as client, client.events() as events:
        next(events)
        path.unlink()
        event = next(events)
        assert event["motion"] == 1
        assert "no such file" in event["errors"][0]
        path.write_text(LONGER)
        assert next(events) == {"motion": 2, "errors": []}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_in_place_of_the_file_is_reported(path):
    pipe = path.parent / "pipe"
    os.mkfifo(pipe)
    with running(path) as client, client.events() as events:
        next(events)
        os.replace(pipe, path)
        assert "is not a regular file" in next(events)["errors"][0]
        path.unlink()
        path.write_text(LONGER)
        while (event := next(events))["errors"]:  # while there is no file
            assert event["motion"] == 1
        assert event == {"motion": 2, "errors": []}


def test_a_file_that_is_being_written_is_no_error(path):
    with running(path) as client, client.events() as events:
        next(events)
        with path.open("w") as handle:
            for line in LONGER.splitlines(keepends=True):
                handle.write(line)
                handle.flush()
                time.sleep(0.03)
        event = next(events)  # a slow machine may read a part that is a model too
        assert event["motion"] in (2, 3)
        assert event["errors"] == []


def test_tables_are_followed_too(path):
    (path.parent / "law.csv").write_text("0,90\n1,120\n")
    path.write_text(MODEL.replace("{by: 60}", "{table: law.csv}"))
    with running(path) as client, client.events() as events:
        next(events)
        (path.parent / "law.csv").write_text("0,90\n1,100\n")
        assert next(events)["motion"] == 2
        assert client.ask("GET", "/inputs").json["inputs"][0]["high"] == pytest.approx(100.0)
        (path.parent / "law.csv").unlink()
        assert "law.csv" in next(events)["errors"][0]
        (path.parent / "law.csv").write_text("0,90\n1,110\n")
        assert next(events) == {"motion": 3, "errors": []}


def test_a_table_that_is_missing_at_the_start_is_found_later(path):
    path.write_text(MODEL.replace("{by: 60}", "{table: law.csv}"))
    with running(path) as client, client.events() as events:
        event = next(events)
        assert event["motion"] == 0
        assert re.search(r"m\.yaml:4:\d+: .*law\.csv", event["errors"][0])
        assert client.ask("GET", "/data").json == {"motion": 0, "data": None}
        (path.parent / "law.csv").write_text("0,90\n1,110\n")
        assert next(events) == {"motion": 1, "errors": []}


def test_a_save_while_solving_replaces_the_motion(path, monkeypatch):
    """The second motion would never end; it is given up when the file is saved once more."""
    calls = []

    def endless(mechanism, *, progress, **settings):
        calls.append(mechanism)
        while len(calls) == 2:
            progress("tracing")(0, 1)
            time.sleep(0.01)
        return gimcli.trace(mechanism, progress=progress, **settings)

    monkeypatch.setattr(live_model, "trace", endless)
    with running(path) as client, client.events() as events:
        next(events)
        path.write_text(LONGER)
        while len(calls) < 2:
            time.sleep(0.01)
        path.write_text(LONGER.replace("1.25", "1.125"))
        assert next(events) == {"motion": 2, "errors": []}
        assert crank_length(client) == pytest.approx(1.125)


def test_a_file_saved_without_a_change_is_solved_again_without_error(path):
    with running(path) as client, client.events() as events:
        next(events)
        os.utime(path, ns=(1, 1))
        assert next(events) == {"motion": 2, "errors": []}


def test_settings_that_do_not_fit_and_missing_files_are_refused_at_once(path):
    with pytest.raises(UsageError), running(path, plot="speed"):
        pass
    with pytest.raises(ModelError), running(path.parent / "n.yaml"):
        pass


def test_a_setting_that_a_saved_file_no_longer_fits_is_an_error_of_the_page(path):
    with running(path, measure=["transmission:coupler/rocker"]) as client, client.events() as events:
        next(events)
        path.write_text(MODEL.replace("rocker", "follower"))
        assert "rocker" in next(events)["errors"][0]
        assert gimcli.load(path).members[3].name == "follower"
