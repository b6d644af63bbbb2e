"""Invalid model files: each error has its line, its column, what is wrong and how to correct it."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest
import yaml

from gimcli import ModelError, load
from gimcli.cli import main
from gimcli.mechanism import ANGLE, HEIGHT, SPAN
from gimcli.model.check import checked
from gimcli.model.source import read_source

TOP = """\
nodes: {O: [0, 0], G: [3, 0], A: [0, 1], B: [3, 2]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B], rocker: [G, B]}
"""


def motor(text, name="bad"):
    return f"{TOP}actuators:\n  {name}: {text}\n"


def law(text):
    return motor(f"{{type: rotary, pivot: O, arm: A, law: {text}}}")


# name: (text, line:column, fragments of the message); tests/tables/sentences/model.yaml has all others
REFUSED = {
    "table is binary": (law("{table: binary.csv}"), "5:54", ["not a text file"]),
    "table with an endless cell": (law("{table: cell.csv}"), "5:54", ["not a text file"]),
    "tab": ("nodes:\n\tA: [0, 0]\n", "2:1", ["tabs", "use spaces"]),
    "tab after spaces": ("nodes:\n  \tA: [0, 0]\n  B: 1\n", "2:3", ["tabs", "use spaces"]),
    "control character": (TOP + "name: a\x07b\n", "4:8", ["control character 0x07", "remove"]),
    "zero byte": (TOP + "\x00", "4:1", ["not a text file"]),
}

TABLES = {
    "good.csv": b"time,value\n1,0\n3,10\n",
    "words.csv": b"0,0\n\n1,one\n",
    "wide.csv": b"0,0,0\n1,1,1\n",
    "short.csv": b"t,v\n0,1\n",
    "back.csv": b"t,v\n0,0\n1,1\n1,2\n",
    "binary.csv": b"\xff\xfe\x00\x01\xd8",
    "cell.csv": b"0," + b"1" * 200_000 + b"x\n1,2\n",
}


@pytest.fixture
def folder(tmp_path):
    for name, data in TABLES.items():
        (tmp_path / name).write_bytes(data)
    return tmp_path


def faults(path):
    """Return the errors of an invalid file, one per line."""
    with pytest.raises(ModelError) as caught:
        load(path)
    assert caught.value.exit_code == 3
    return str(caught.value).splitlines()


def refused(folder, text):
    path = folder / "m.yaml"
    path.write_text(text, encoding="utf-8")
    return faults(path)


@pytest.mark.parametrize("case", REFUSED)
def test_an_error_names_its_line_and_its_correction(case, folder):
    text, place, fragments = REFUSED[case]
    messages = refused(folder, text)
    found = [line for line in messages if all(fragment in line for fragment in fragments)]
    assert len(found) == 1, messages
    assert found[0].startswith(f"{folder / 'm.yaml'}:{place}: "), messages
    assert len({line.split(": ", 1)[0] for line in messages}) == 1, f"errors in other lines: {messages}"


def test_the_command_line_exits_with_3_and_prints_nothing_else(folder, monkeypatch, capsys):
    path = folder / "m.yaml"
    path.write_text(TOP + "lnks: {}\nduration: 0\n")
    for command in ("solve", "trace", "mobility", "sequence"):
        monkeypatch.setattr("sys.argv", ["gim", command, str(path)])
        with pytest.raises(SystemExit) as caught:
            main()
        out, err = capsys.readouterr()
        assert caught.value.code == 3
        assert out == ""
        assert err.splitlines()[0] == "gim:"
        assert [line.split(":")[1] for line in err.splitlines()[1:]] == ["4", "5"]


def test_all_errors_of_a_file_are_reported_together_in_line_order(folder):
    text = """\
nodes: {O: [0, 0], G: [3, 0], A: [0, 1], B: [3, .nan], C: [7, 7]}
ground: [O, G, O]
links:
  crank: [O, Aa]
  rod: {nodes: [A, B], length: -1, colour: red}
  rod: [A, B]
  rocker: [G, B]
prismatic:
  slide: {node: C, guide: [O, C]}
actuators:
  motor: {type: rotary, pivot: O, arm: A, law: {from: 0}}
points:
  P: {on: crnk, at: [0, 0]}
trace: [P, Q]
duration: soon
"""
    messages = refused(folder, text)
    places = [re.match(r".*m\.yaml:(\d+):(\d+): ", line).groups() for line in messages]
    assert places == sorted(places, key=lambda p: (int(p[0]), int(p[1])))
    expected = ["got nan", "named twice", "'Aa'", "above 0", "'colour'", "'rod' is given twice", "`to` is missing",
           "member 'crnk'", "'Q' is neither", "expected a number, got 'soon'"]  # fmt: skip
    assert len(messages) == len(expected), messages
    for line, fragment in zip(messages, expected, strict=True):
        assert fragment in line


def test_references_to_an_invalid_part_are_not_reported(folder):
    text = TOP.replace("A: [0, 1]", "A: [0, x]").replace("rod: [A, B]", "rod: {nodes: [A, B], length: 0}")
    messages = refused(folder, text + "points: {P: {on: rod, at: [1, y]}}\ntrace: [P, A]\nmasses: {rod: {mass: 1}}\n")
    assert len(messages) == 3, messages


# -- files that are no model files ---------------------------------------------------------------------


def test_a_missing_file_lists_the_files_of_its_folder(folder):
    (folder / "crank.yaml").write_text(TOP)
    (messages,) = faults(folder / "crankk.yaml")
    assert "no such file" in messages
    assert "crank.yaml" in messages
    (messages,) = faults(folder / "nowhere" / "crank.yaml")
    assert "no such file" in messages


def test_a_folder_lists_its_model_files(folder):
    (folder / "crank.yaml").write_text(TOP)
    (messages,) = faults(folder)
    assert "is a folder" in messages
    assert "crank.yaml" in messages


@pytest.mark.parametrize(
    "data",
    [
        b"\x89PNG\r\n\x1a\n\x00\x00",
        b"\x7fELF\x02\x01\x01\x00\x00",
        "nodes: {Ä: 1}".encode("latin-1"),
        TOP.encode("utf-16"),
    ],
    ids=["png", "elf", "latin-1", "utf-16"],
)
def test_a_file_that_is_not_utf8_text(data, folder):
    path = folder / "m.yaml"
    path.write_bytes(data)
    (messages,) = faults(path)
    assert "not a text file" in messages


def test_a_name_too_long_for_the_file_system(folder):
    (messages,) = faults(folder / ("x" * 5000))
    assert "cannot be read" in messages


def test_an_endless_file():
    (messages,) = faults("/dev/zero")
    assert "too large" in messages


BOMBS = {
    "50 MB of [": (lambda: "[" * 50_000_000, "too large"),
    "50 MB of - ": (lambda: "- " * 25_000_000, "too large"),
    "3.9 MB of [": (lambda: "[" * 3_900_000, "no keys"),
    "3.9 MB of [ below a key": (lambda: TOP + "trace: " + "[" * 3_900_000, "nested too deeply"),
    "3.9 MB of {": (lambda: "{" * 3_900_000, "nested too deeply"),
    "3.9 MB of - ": (lambda: TOP + "trace:\n  " + "- " * 1_900_000, "nested too deeply"),
    "3.9 MB of ?": (lambda: "? " * 1_900_000, "nested too deeply"),
    "brackets behind comments": (lambda: TOP + "trace: " + "[ # ]\n " * 500_000, "nested too deeply"),
    "deeply indented blocks": (lambda: "".join(" " * k + "a:\n" for k in range(2_700)), "nested too deeply"),
    "deep sequences": (lambda: "trace:\n" + "".join(" " * k + "-\n" for k in range(2_700)), "nested too deeply"),
    "too many parts": (lambda: TOP + "trace: [" + "A," * 1_500_000 + "]", "are too many"),
    "billion laughs": (
        lambda: "a: &a [x, x, x, x, x, x, x, x, x, x]\n"
        + "".join(f"{b}: &{b} [{', '.join(['*' + a] * 10)}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True)),
        "are too many",
    ),
    "aliases that nest": (
        lambda: "a0: &a0 [x]\n" + "".join(f"a{k}: &a{k} [*a{k - 1}]\n" for k in range(1, 5_000)),
        "nested too deeply",
    ),
}  # fmt: skip


@pytest.mark.few(6)
@pytest.mark.parametrize("case", BOMBS)
def test_files_that_would_exhaust_memory_are_rejected_at_once(case, folder):
    text, pattern = BOMBS[case]
    path = folder / "m.yaml"
    path.write_text(text())
    begin = time.process_time()
    messages = faults(path)
    assert time.process_time() - begin < 3.0
    assert len(messages) == 1
    assert re.search(pattern, messages[0])
    assert len(messages[0]) < 300


# -- files that are accepted -----------------------------------------------------------------


def accepted(folder, text):
    path = folder / "m.yaml"
    path.write_text(text, encoding="utf-8")
    load(path)
    return checked(read_source(path))


PAGE = """\
name: Slider-crank with a coupler point
source: where the dimensions come from
units: {length: mm, angle: deg, mass: kg}
nodes: {O: [0, 0], A: [20, 0], B: [90, 0], G: [200, 0], C: [50, 30], P: [0, 50], Q: [40, 50], R: [35, 70], S: [5, 72]}
ground: [O, G]
links:
  crank: [O, A]
  rod: {nodes: [A, B], length: 70}
elements:
  plate: [A, B, C]
  body:
    nodes: [P, Q, R, S]
    shape: {P: [0, 0], Q: [40, 0], R: [35, 20], S: [5, 22]}
prismatic:
  slide: {node: B, guide: [O, G]}
  ram: {nodes: [P, Q], guide: [O, G], offset: 50}
actuators:
  motor:
    type: rotary
    pivot: O
    arm: A
    reference: G
    law: {from: 0, to: 360}
  jack:
    type: linear
    nodes: [O, P]
    law: {from: 100, to: 140, profile: quintic}
  table:
    type: linear
    node: B
    guide: [O, G]
    law: {from: 60, to: 90}
points:
  T: {on: rod, at: [50, 30]}
  U: {on: rod, local: [35, 10]}
trace: [T, B]
duration: 2
masses:
  crank: {mass: 1.0, inertia: 0.0833, centre: [0.5, 0]}
gravity: [0, -9.81]
loads:
  push: {on: rod, at: [90, 0], force: [-50, 0]}
  twist: {on: body, torque: 3}
"""


def test_a_file_with_every_section_is_accepted(folder):
    model = accepted(folder, PAGE)
    assert model.links["crank"].nodes == ["O", "A"]
    assert model.links["rod"].length == 70.0
    assert model.points["T"].on == "rod"
    assert model.actuators["jack"].law.profile.name == "quintic"


@pytest.mark.parametrize(("keys", "kind", "row"), [
    ("pivot: O, arm: A", "rotary", ANGLE),
    ("nodes: [O, B]", "linear", SPAN),
    ("node: B, guide: [O, G]", "linear", HEIGHT),
])  # fmt: skip
def test_the_type_of_an_actuator_follows_from_its_keys(keys, kind, row, folder):
    actuators = []
    for text in (keys, f"type: {kind}, {keys}"):
        accepted(folder, motor(f"{{{text}}}").replace("rocker: [G, B]", "rocker: [G, A]"))
        actuators.append(load(folder / "m.yaml").actuators[0])
    assert actuators[0] == actuators[1]
    assert actuators[0].kind == row


@pytest.mark.parametrize("word", ["member", "true", "True", "'true'"])
def test_the_member_of_a_point_or_load_may_have_another_key(word, folder):
    text = TOP + "points: {P: {on: rod, local: [1, 2]}}\nloads: {f: {on: rod, at: [1, 2], force: [3, 4]}}\n"
    accepted(folder, text)
    known = load(folder / "m.yaml")
    accepted(folder, text.replace("on:", f"{word}:"))
    other = load(folder / "m.yaml")
    assert other.points == known.points
    assert other.dynamics.loads == known.dynamics.loads


def test_a_model_that_a_program_of_yaml_1_1_rewrites_is_the_same(folder):
    """PyYAML reads the key `on` as true and writes it as `true:`."""
    path = folder / "rewritten.yaml"
    own = Path("models/jansen.yaml")
    path.write_text(yaml.safe_dump(yaml.safe_load(own.read_text(encoding="utf-8"))), encoding="utf-8")
    assert "true:" in path.read_text(encoding="utf-8")
    assert {p.name: p.local for p in load(path).points} == pytest.approx({p.name: p.local for p in load(own).points})


@pytest.mark.parametrize("law", [
    "{from: 0, to: 9}", "{by: 30}", "{by: -30, profile: cubic}", "{from: 0, to: 9, profile: cycloidal}",
    "{from: 0, to: 9, profile: harmonic}", "{from: 0, to: 9, profile: uniform}", "{polynomial: [1, 2, 3]}",
    "{profile: {polynomial: [1, 2, 3]}}", "{from: 0, to: 9, profile: {polynomial: [0, 0, 3, -2]}}",
    "{from: 0, to: 9, polynomial: [0, 0, 3, -2]}", "{table: good.csv}", "{profile: {table: good.csv}}", "{}",
])  # fmt: skip
def test_laws_of_every_form_are_accepted(law, folder):
    accepted(folder, motor(f"{{type: rotary, pivot: O, arm: A, law: {law}}}"))


def test_names_and_numbers_follow_yaml_1_2(folder):
    text = """\
name: 2024
nodes: {1: [0, 0], 2: [3e0, -0], on: [.5, +1], no: [1e-3, 2.], "1e3": [2, 2], 'q r': [3, 3], Ä: [5, 5], 5: [9, 9]}
ground: [1, "2"]
links: {a: [1, on], b: [2, no], y: [on, '1e3'], n: ["q r", Ä], m: [Ä, 5]}
points: {off: {on: y, local: [1e-3, 1E+1]}}
trace: [on, off]
"""
    model = accepted(folder, text)
    assert model.name == "2024"
    assert model.ground.nodes == ["1", "2"]
    assert model.nodes["no"] == [0.001, 2.0]
    assert model.links["y"].nodes == ["on", "1e3"]
    assert model.links["m"].nodes == ["Ä", "5"]
    assert model.points["off"].local == [0.001, 10.0]


def test_sections_without_content_count_as_absent(folder):
    model = accepted(folder, TOP + "points:\nactuators:\ntrace:\nunits:\n")
    assert model.points == {}
    assert model.units.length == "m"


def test_text_may_contain_any_character(folder):
    accepted(
        folder,
        "# [[[[[[[[[[[[[[[[[[[[ {{{{{{{{{{{{{{\n" + TOP + f"source: >-\n  {'a - b [c] ' * 30}\nname: '{'[' * 50}'\n",
    )


def test_an_alias_repeats_its_anchor(folder):
    text = """\
nodes: {O: [0, 0], G: [3, 0], A: [0, 1], B: [3, 1]}
ground: [O, G]
links: {left: {nodes: [O, A], length: &r 1}, middle: [A, B], right: {nodes: [G, B], length: *r}}
"""
    assert accepted(folder, text).links["right"].length == 1.0


def test_a_byte_order_mark_and_windows_line_ends(folder):
    path = folder / "m.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + TOP.replace("\n", "\r\n").encode())
    assert list(checked(read_source(path)).nodes) == ["O", "G", "A", "B"]


def test_a_large_element_is_checked_in_time(folder):
    names = [f"n{k}" for k in range(20_000)]
    places = ", ".join(f"{n}: [{k % 141}, {k // 141}]" for k, n in enumerate(names))
    path = folder / "m.yaml"
    path.write_text(f"nodes: {{{places}}}\nground: [n0]\nelements: {{e: [{', '.join(names)}]}}\n")
    begin = time.perf_counter()
    checked(read_source(path))
    assert time.perf_counter() - begin < 5.0
