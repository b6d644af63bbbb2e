"""Invalid model files: each error has its line, its column, what is wrong and how to correct it."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest
import yaml

from gimcli import load
from gimcli.cli import main
from gimcli.errors import ModelError
from gimcli.mechanism import ANGLE, HEIGHT, SPAN
from gimcli.model.check import checked
from gimcli.model.source import read_source

TOP = """\
nodes: {O: [0, 0], G: [3, 0], A: [0, 1], B: [3, 2]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B], rocker: [G, B]}
"""
FREE = """\
nodes: {O: [0, 0], G: [3, 0], A: [0, 1], B: [3, 2], C: [5, 5], D: [6, 5]}
ground: [O, G]
"""


def links(text):
    return f"{FREE}links:\n  good: [O, A]\n  bad: {text}\n"


def element(text):
    return f"{FREE}links: {{good: [O, A]}}\nelements:\n  bad: {text}\n"


def slide(text):
    return f"{TOP}prismatic:\n  bad: {text}\n"


def motor(text, name="bad"):
    return f"{TOP}actuators:\n  {name}: {text}\n"


def law(text):
    return motor(f"{{type: rotary, pivot: O, arm: A, law: {text}}}")


def point(text):
    return f"{TOP}points:\n  bad: {text}\n"


def nodes(text):
    return f"ground: [O, G]\nnodes:\n  O: [0, 0]\n  G: [3, 0]\n  A: {text}\nlinks: {{crank: [O, A], rod: [A, G]}}\n"


# name: (text, line:column, fragments of the message)
REFUSED = {
    # keys and names
    "unknown key": (TOP + "lnks: {}\n", "4:1", ["unknown key 'lnks'", "did you mean 'links'"]),
    "unknown key, no similar one": (TOP + "wheels: 4\n", "4:1", ["unknown key 'wheels'", "known here", "prismatic"]),
    "unknown key, nested": (links("{nodes: [A, B], lenght: 3}"), "5:24", ["'lenght'", "did you mean 'length'"]),
    "unknown key, deep": (law("{from: 0, to: 9, profle: cubic}"), "5:63", ["'profle'", "did you mean 'profile'"]),
    "attribute's name as a key": (law("{from_: 0, to: 9}"), "5:47", ["unknown key 'from_'", "did you mean 'from'"]),
    "misspelt node": (FREE + "links: {good: [O, A], bad: [A, b]}\n", "3:32", ["node 'b'", "did you mean 'B'"]),
    "undeclared node": (
        links("[A, Zeta]"),
        "5:12",
        ["node 'Zeta' is not declared", "declare it under `nodes:`", "O, G"],
    ),
    "undeclared node, long form": (links("{nodes: [A, Zeta]}"), "5:20", ["node 'Zeta' is not declared"]),
    "key twice": (TOP + "ground: [O]\n", "4:1", ["'ground' is given twice", "line 2", "rename or remove"]),
    "node twice": (nodes("[1, 1]\n  O: [3, 3]"), "6:3", ["'O' is given twice", "line 3"]),
    "link and element of one name": (
        TOP + "elements:\n  rod: [A, B, O]\n",
        "5:3",
        ["'rod' is given twice", "`links:` in line 3", "rename"],
    ),
    "actuator and slide of one name": (
        slide("{node: B, guide: [O, G]}") + "actuators:\n  bad: {type: linear, node: B, guide: [O, G]}\n",
        "7:3",
        ["'bad' is given twice", "`prismatic:` in line 5"],
    ),
    "actuator named as a column": (motor("{type: linear, nodes: [O, B]}", "status"), "5:3", ["'status' is reserved"]),
    "member named ground": (FREE + "links: {ground: [O, A]}\n", "3:9", ["'ground' is reserved", "rename"]),
    "empty key": (TOP + '"": 3\n', "4:1", ["a key must be a word"]),
    "list as key": (TOP + "? [a]\n: 3\n", "4:3", ["a key must be a word"]),
    "name that is a number": (links("[A, 1e3]"), "5:12", ["expected a name", "1000.0", "quotes"]),
    # values
    "coincident nodes": (
        FREE.replace("C: [5, 5]", "C: [3, 2]") + "links: {a: [B, C]}\n",
        "3:12",
        ["B and C", "coincide", "length"],
    ),
    "nearly coincident nodes": (
        "nodes: {O: [1, 0], A: [1e-17, 0], B: [0, 0]}\nground: [O]\nlinks: {a: [O, A], b: [A, B]}\n",
        "3:23",
        ["coincide"],
    ),
    "coincident nodes of an element": (
        FREE.replace("C: [5, 5]", "C: [3, 2]") + "elements: {a: [B, A, C]}\n",
        "3:15",
        ["B and C", "coincide", "shape"],
    ),
    "zero length": (links("{nodes: [A, B], length: 0}"), "5:32", ["length", "above 0", "got 0"]),
    "negative length": (links("{nodes: [A, B], length: -2.5}"), "5:32", ["above 0", "got -2.5"]),
    "length far too small": (links("{nodes: [A, B], length: 1e-15}"), "5:32", ["too small", "longer"]),
    "NaN length": (links("{nodes: [A, B], length: .nan}"), "5:32", ["finite number", "got nan"]),
    "infinite length": (links("{nodes: [A, B], length: -.inf}"), "5:32", ["finite number", "got -inf"]),
    "overflowing length": (links("{nodes: [A, B], length: 1e999}"), "5:32", ["finite number", "got inf"]),
    "long integer as length": (links(f"{{nodes: [A, B], length: 1{'0' * 400}}}"), "5:32", ["finite number"]),
    "text as length": (links("{nodes: [A, B], length: long}"), "5:32", ["expected a number", "'long'"]),
    "unit at a length": (links("{nodes: [A, B], length: 5 mm}"), "5:32", ["expected a number", "'5 mm'", "`units:`"]),
    "quoted number": (links("{nodes: [A, B], length: '5'}"), "5:32", ["expected a number", "'5'"]),
    "boolean as length": (links("{nodes: [A, B], length: true}"), "5:32", ["expected a number", "True"]),
    "list as length": (links("{nodes: [A, B], length: [1]}"), "5:32", ["expected a number", "[1]"]),
    "NaN coordinate": (nodes("[1, .nan]"), "5:10", ["nodes.A.1", "finite number"]),
    "text coordinate": (nodes("[one, 1]"), "5:7", ["nodes.A.0", "expected a number", "'one'"]),
    "one coordinate": (nodes("[1]"), "5:6", ["at least 2 entries", "got 1"]),
    "three coordinates": (nodes("[1, 2, 3]"), "5:6", ["at most 2", "got 3"]),
    "no coordinates": (nodes(""), "5:3", ["A has no coordinates", "give the `length` of crank"]),
    "enormous mechanism": (nodes("[1e200, 0]"), "5:7", ["at most 1e+100", "got 1e+200"]),
    "unknown unit": ("units: {length: mmm}\n" + TOP, "1:17", ["'mmm'", "expected one of m, mm", "did you mean 'mm'"]),
    "units as a word": ("units: mm\n" + TOP, "1:8", ["expected a mapping such as {length: ...}", "'mm'"]),
    "zero duration": (TOP + "duration: 0\n", "4:11", ["duration", "at least 1e-12", "got 0"]),
    "duration whose square overflows": (TOP + "duration: 1.0e+300\n", "4:11", ["duration", "at most 1e+12"]),
    "mass too large": (
        TOP + "masses: {crank: {mass: 1.0e+300}}\n",
        "4:24",
        ["masses.crank.mass", "at most 1e+30"],
    ),
    "gravity too large": (TOP + "gravity: [0, -1.0e+300]\n", "4:14", ["gravity.1", "at least -1e+30"]),
    "duration whose square underflows": (TOP + "duration: 1.0e-300\n", "4:11", ["duration", "at least 1e-12"]),
    # members
    "link of one node twice": (links("[A, A]"), "5:8", ["named twice", "different nodes"]),
    "link of three nodes": (links("[A, B, C]"), "5:8", ["at most 2", "got 3", "`elements:`"]),
    "link as a word": (links("A-B"), "5:8", ["a list of nodes", "'A-B'"]),
    "element of two nodes": (element("[A, B]"), "5:8", ["at least 3", "got 2", "`links:`"]),
    "element of one node twice": (element("[A, B, A]"), "5:8", ["named twice"]),
    "shape lacks a node": (
        element("{nodes: [A, B, C], shape: {A: [0, 0], B: [1, 0]}}"),
        "5:34",
        ["has no node C", "add its coordinates"],
    ),
    "shape with another node": (
        element("{nodes: [Alfa, Bravo, C], shape: {Alfa: [0, 0], Brav: [1, 0], Bravo: [2, 0], C: [1, 1]}}").replace(
            "C: [5, 5]", "C: [5, 5], Alfa: [7, 7], Bravo: [8, 7]"
        ),
        "5:56",
        ["'Brav' is not a node of 'bad'", "did you mean 'Bravo'"],
    ),
    "coincident shape": (
        element("{nodes: [A, B, C], shape: {A: [1, 0], B: [2, 0], C: [1, 0]}}"),
        "5:34",
        ["A and C", "coincide in its shape", "move one"],
    ),
    "text in a shape": (
        element("{nodes: [A, B, C], shape: {A: [1, 0], B: [2, x], C: [1, 4]}}"),
        "5:53",
        ["shape.B.1", "expected a number"],
    ),
    "no members": (FREE, "1:1", ["no members", "`links:`, `elements:` or `actuators:`"]),
    "member of ground nodes": (
        FREE + "links: {a: [O, A], b: [O, G]}\n",
        "3:23",
        ["'b'", "ground nodes only", "remove it"],
    ),
    # ground
    "no ground": (
        "nodes: {A: [0, 0], B: [1, 0]}\nlinks: {a: [A, B]}\n",
        "1:1",
        ["'ground' is missing", "{member: NAME}"],
    ),
    "no nodes": ("ground: [A]\nlinks: {a: [A, B]}\n", "1:1", ["'nodes' is missing", "`nodes:`"]),
    "empty ground": (TOP.replace("[O, G]", "[]"), "2:9", ["no node is fixed", "{member: NAME}"]),
    "ground as a word": (TOP.replace("[O, G]", "O"), "2:9", ["a list of nodes or {member: NAME}", "'O'"]),
    "ground node unknown": (TOP.replace("[O, G]", "[O, Gg]"), "2:13", ["node 'Gg'", "did you mean 'G'"]),
    "ground node twice": (TOP.replace("[O, G]", "[O, O]"), "2:9", ["named twice"]),
    "held member unknown": (TOP.replace("[O, G]", "{member: rd}"), "2:18", ["member 'rd'", "did you mean 'rod'"]),
    "held member with coincident nodes": (
        "nodes: {A: [1, 1], B: [1, 1], C: [2, 1]}\nground: {member: a}\n"
        "links: {a: {nodes: [A, B], length: 1}, b: [B, C]}\n",
        "2:18",
        ["A and B", "move one"],
    ),
    # slides
    "guide of no member": (slide("{node: B, guide: [O, B]}"), "5:25", ["O and B", "no common member"]),
    "guide of unknown node": (slide("{node: B, guide: [O, H]}"), "5:29", ["node 'H' is not declared"]),
    "guide of one node": (slide("{node: B, guide: [O]}"), "5:25", ["at least 2 entries"]),
    "sliding on its own member": (slide("{node: A, guide: [O, A]}"), "5:8", ["A belongs to 'crank'", "another member"]),
    "sliding on its own ground": (slide("{node: G, guide: [O, G]}"), "5:8", ["G belongs to 'ground'"]),
    "slide without a node": (slide("{guide: [O, G]}"), "5:8", ["either `node`", "`nodes`"]),
    "slide with node and nodes": (slide("{node: B, nodes: [A, B], guide: [O, G]}"), "5:8", ["either `node`"]),
    "slide without guide": (slide("{node: B}"), "5:8", ["'guide' is missing", "add `guide:`"]),
    "slide with nodes of two members": (
        slide("{nodes: [B, C], guide: [O, G]}").replace("nodes: {O", "nodes: {C: [9, 9], O"),
        "5:16",
        ["B and C", "no common member"],
    ),
    "coincident guide": (
        "nodes: {O: [0, 0], G: [0, 0], B: [3, 2]}\nground: [O, G]\nlinks: {rod: [O, B]}\n"
        "prismatic: {s: {node: B, guide: [O, G]}}\n",
        "4:33",
        ["guide nodes O and G coincide", "move one"],
    ),
    "nearly coincident guide": (
        "nodes: {O: [0.3, 0], G: [0.30000000000000004, 0], B: [3, 2]}\nground: [O, G]\nlinks: {rod: [O, B]}\n"
        "prismatic: {s: {node: B, guide: [O, G]}}\n",
        "4:33",
        ["guide nodes O and G coincide"],
    ),
    "offset as text": (slide("{node: B, guide: [O, G], offset: far}"), "5:41", ["expected a number", "'far'"]),
    # actuators
    "motor without arm": (motor("{type: rotary, pivot: O}"), "5:8", ["'bad' needs `arm`"]),
    "motor without pivot": (motor("{type: rotary, arm: A}"), "5:8", ["'bad' needs `pivot`"]),
    "jack without nodes": (motor("{type: linear, node: B}"), "5:8", ["`nodes`", "`guide`"]),
    "type against its keys": (
        motor("{type: linear, pivot: O, arm: A}"),
        "5:15",
        ["`type: linear` contradicts `pivot` and `arm`", "remove"],
    ),
    "type against a guide": (
        motor("{type: rotary, node: B, guide: [O, G]}"),
        "5:15",
        ["`type: rotary`", "`node` and `guide`", "linear"],
    ),
    "keys of two types": (
        motor("{pivot: O, arm: A, nodes: [O, B]}"),
        "5:8",
        ["`pivot` and `arm` of", "`nodes` of"],
    ),
    "no keys of a type": (motor("{law: {by: 3}}"), "5:8", ["`pivot` and `arm`", "`nodes`", "`node` and `guide`"]),
    "reference alone": (motor("{reference: O}"), "5:8", ["'bad' needs `pivot` and `arm`"]),
    "unknown type": (motor("{type: rotory, pivot: O, arm: A}"), "5:15", ["'rotory'", "did you mean 'rotary'"]),
    "nodes at a motor": (motor("{type: rotary, pivot: O, arm: A, nodes: [O, B]}"), "5:41", ["`nodes` does not belong"]),
    "pivot at a jack": (motor("{type: linear, nodes: [O, B], pivot: O}"), "5:38", ["`pivot` does not belong"]),
    "floating pivot": (motor("{type: rotary, pivot: A, arm: B}"), "5:30", ["'rod' and 'crank'", "`reference`"]),
    "arm elsewhere": (motor("{type: rotary, pivot: O, arm: B}"), "5:38", ["O and arm B", "no common moving member"]),
    "arm is the pivot": (motor("{type: rotary, pivot: O, arm: O}"), "5:38", ["no common moving member"]),
    "arm on the ground": (motor("{type: rotary, pivot: O, arm: G}"), "5:38", ["no common moving member"]),
    "arm on the held member": (
        "nodes: {A: [0, 0], B: [1, 0], C: [2, 2]}\nground: {member: h}\nlinks: {h: [A, B], a: [B, C]}\n"
        "actuators: {m: {type: rotary, pivot: A, arm: B}}\n",
        "4:46",
        ["no common moving member"],
    ),
    "reference elsewhere": (
        motor("{type: rotary, pivot: O, arm: A, reference: B}"),
        "5:52",
        ["O and reference B", "no common member other than 'crank'"],
    ),
    "reference is the pivot": (motor("{type: rotary, pivot: O, arm: A, reference: O}"), "5:52", ["the pivot itself"]),
    "unknown pivot": (motor("{type: rotary, pivot: Q, arm: A}"), "5:30", ["node 'Q' is not declared"]),
    "jack within a member": (motor("{type: linear, nodes: [A, B]}"), "5:30", ["'rod'", "is constant", "two members"]),
    "jack at one node": (motor("{type: linear, nodes: [A, A]}"), "5:30", ["named twice"]),
    "travel on a guide of no member": (
        motor("{type: linear, node: A, guide: [O, B]}"),
        "5:39",
        ["O and B", "no common member"],
    ),
    # laws
    "law with from": (law("{from: 3}"), "5:46", ["`to` is missing", "or `by`"]),
    "unknown profile": (
        law("{from: 3, to: 4, profile: cubik}"),
        "5:72",
        ["expected one of uniform", "got 'cubik'", "did you mean 'cubic'"],
    ),
    "two profiles": (
        law("{from: 3, to: 4, profile: {name: cubic, polynomial: [0, 1]}}"),
        "5:72",
        ["`name` and `polynomial`", "expected one of"],
    ),
    "name and polynomial, short form": (
        law("{from: 3, to: 4, profile: cubic, polynomial: [0, 1]}"),
        "5:72",
        ["`name` and `polynomial`", "expected one of"],
    ),
    "polynomial not from 0 to 1": (
        law("{from: 3, to: 4, profile: {polynomial: [0, 2]}}"),
        "5:85",
        ["go from 0 to 1", "got 0 to 2"],
    ),
    "polynomial not from 0 to 1, short": (
        law("{by: 4, polynomial: [1, 0]}"),
        "5:66",
        ["go from 0 to 1", "got 1 to 1"],
    ),
    "table missing": (law("{table: no.csv}"), "5:54", ["no.csv", "no such file", "the model's folder"]),
    "table with from": (law("{from: 0, to: 1, table: good.csv}"), "5:46", ["absolute values", "remove"]),
    "table not numeric": (law("{table: words.csv}"), "5:54", ["words.csv", "line 3", "1,one"]),
    "table of three columns": (law("{table: wide.csv}"), "5:54", ["line 1", "time,value"]),
    "table of one row": (law("{table: short.csv}"), "5:54", ["two rows"]),
    "table not increasing": (law("{table: back.csv}"), "5:54", ["line 4", "time 1 after 1", "increase"]),
    "table is binary": (law("{table: binary.csv}"), "5:54", ["not a text file"]),
    "table with an endless cell": (law("{table: cell.csv}"), "5:54", ["not a text file"]),
    "table is a folder": (law("{table: .}"), "5:54", ["directory"]),
    "table and duration": (
        "duration: 3\n" + law("{profile: {table: good.csv}}"),
        "6:64",
        ["covers 2 s", "`duration` is 3 s", "equal"],
    ),
    "distance of a jack not positive": (
        motor("{type: linear, nodes: [O, B], law: {from: 2, to: 0}}"),
        "5:43",
        ["distance above 0", "got 0"],
    ),
    "increment of a jack below zero": (
        motor("{type: linear, nodes: [O, G], law: {by: -4}}").replace("[O, G], law", "[O, B], law"),
        "5:43",
        ["distance above 0", "got -0.39"],
    ),
    "jack of zero initial length": (
        "nodes: {O: [0, 0], G: [4, 0], A: [4, 0]}\nground: [O, G]\nlinks: {a: [O, A]}\n"
        "actuators: {m: {type: linear, nodes: [G, A], law: {by: 1}}}\n",
        "4:51",
        ["distance above 0", "got 0"],
    ),
    "endless turning": (law("{from: 0, to: 1e300}"), "5:46", ["reaches 1e+300", "shorten"]),
    "endless travel": (
        motor("{type: linear, node: B, guide: [O, G], law: {by: -1e9}}"),
        "5:52",
        ["reaches -1e+09", "shorten"],
    ),
    # points, trace, dynamics
    "two words for the member": (
        point("{member: rod, on: rod, at: [1, 1]}"),
        "5:9",
        ["`member` is another word for `on`", "remove one"],
    ),
    "two other words for the member": (
        point("{member: rod, true: rod, at: [1, 1]}"),
        "5:22",
        ["`true` is", "remove one"],
    ),
    "unknown member by another word": (point("{true: rood, at: [1, 1]}"), "5:15", ["member 'rood'", "'rod'"]),
    "merge key": (TOP + "points: {P: {<<: *x, on: rod, at: [1, 1]}}\n", "4:14", ["merge keys (`<<`)", "an alias"]),
    "point on unknown member": (point("{on: rood, at: [1, 1]}"), "5:13", ["member 'rood'", "did you mean 'rod'"]),
    "point without coordinates": (point("{on: rod}"), "5:8", ["either `at` (initial coordinates) or `local`"]),
    "point with two positions": (point("{on: rod, at: [1, 1], local: [1, 1]}"), "5:8", ["either `at`"]),
    "point named as a node": (f"{TOP}points:\n  A: {{on: rod, at: [1, 1]}}\n", "5:3", ["the name of a node", "rename"]),
    "point on a member with coincident nodes": (
        "nodes: {O: [1, 1], A: [1, 1]}\nground: [O]\nlinks: {a: {nodes: [O, A], length: 1}}\n"
        "points: {P: {on: a, at: [0, 0]}}\n",
        "4:25",
        ["O and A", "move one"],
    ),
    "trace of an unknown name": (TOP + "trace: [A, Bb]\n", "4:12", ["'Bb' is neither", "did you mean 'B'"]),
    "trace of an unused node": (
        TOP.replace("nodes: {O", "nodes: {Z: [9, 9], O") + "trace: [A, Z]\n",
        "4:12",
        ["'Z' belongs to no member", "remove it from `trace`"],
    ),
    "trace twice": (TOP + "trace: [A, B, A]\n", "4:15", ["'A' is listed twice"]),
    "mass of unknown member": (TOP + "masses: {rood: {mass: 1}}\n", "4:10", ["member 'rood'", "did you mean 'rod'"]),
    "negative mass": (TOP + "masses: {rod: {mass: -1}}\n", "4:22", ["at least 0", "got -1"]),
    "mass without mass": (TOP + "masses: {rod: {inertia: 1}}\n", "4:15", ["'mass' is missing"]),
    "load on unknown member": (TOP + "loads: {f: {on: rd, torque: 3}}\n", "4:17", ["member 'rd'", "'rod'"]),
    "load without force or torque": (TOP + "loads: {f: {on: rod}}\n", "4:12", ["either `force` or `torque`"]),
    "force without a point": (TOP + "loads: {f: {on: rod, force: [1, 2]}}\n", "4:12", ["either `at`"]),
    # the file as YAML
    "tab": ("nodes:\n\tA: [0, 0]\n", "2:1", ["tabs", "use spaces"]),
    "tab after spaces": ("nodes:\n  \tA: [0, 0]\n  B: 1\n", "2:3", ["tabs", "use spaces"]),
    "unclosed bracket": ("nodes: {A: [0, 0}\n", "1:17", ["not readable as YAML"]),
    "empty": ("", "1:1", ["empty", "`nodes`"]),
    "comments only": ("# a\n\n# b\n", "1:1", ["empty"]),
    "a list": ("- nodes\n- ground\n", "1:1", ["no keys", "`nodes:`"]),
    "a word": ("\nmechanism\n", "2:1", ["no keys"]),
    "two documents": (TOP + "---\n" + TOP, "4:1", ["second document", "one model"]),
    "nodes as a list": (
        "nodes: [O, A]\nground: [O]\nlinks: {a: [O, A]}\n",
        "1:8",
        ["nodes: expected a mapping such as {A: ...}"],
    ),
    "control character": (TOP + "name: a\x07b\n", "4:8", ["control character 0x07", "remove"]),
    "zero byte": (TOP + "\0", "4:1", ["not a text file"]),
    "alias without an anchor": (TOP.replace("[O, G]", "*fixed"), "2:9", ["*fixed", "has no anchor"]),
    "recursive alias": (TOP + "trace: &t [*t]\n", "4:12", ["*t", "has no anchor"]),
    "nested too deeply": (TOP + "trace: " + "[" * 20 + "]" * 20, "4:20", ["nested too deeply"]),
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


WORDS = {
    "joints": "nodes", "pivots": "nodes", "bars": "links", "Members": "links", "bodies": "elements",
    "sliders": "prismatic", "motors": "actuators", "inputs": "actuators", "fixed": "ground", "frame": "ground",
    "forces": "loads", "mass": "masses",
}  # fmt: skip


@pytest.mark.parametrize("word", WORDS)
def test_a_key_of_other_programs_leads_to_the_key_of_the_model_file(word, folder):
    (message,) = refused(folder, TOP + f"{word}: {{}}\n")
    assert message.endswith(f":4:1: unknown key '{word}'; did you mean '{WORDS[word]}'?")


def test_a_section_under_another_name_is_not_reported_as_missing_too(folder):
    (message,) = refused(folder, TOP.replace("nodes:", "joints:"))
    assert message.endswith(":1:1: unknown key 'joints'; did you mean 'nodes'?")


def test_unreadable_coordinates_are_the_only_error(folder):
    messages = refused(folder, "nodes: {A: [a, 0], B: [b, 0]}\nground: [A]\nlinks: {l: [A, B]}\n")
    assert [line.split(": ")[1] for line in messages] == ["nodes.A.0", "nodes.B.0"]


# -- files that are no model files ---------------------------------------------------------------------


def test_a_missing_file_lists_the_files_of_its_folder(folder):
    (folder / "crank.yaml").write_text(TOP)
    (messages,) = faults(folder / "crankk.yaml")
    assert "no such file" in messages
    assert "in that folder: crank.yaml" in messages
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
