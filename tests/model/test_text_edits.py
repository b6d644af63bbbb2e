"""Coordinates are replaced in the text of a model file; the rest of the text stays as it is."""

from pathlib import Path

import pytest
import yaml

from gimcli.model.edited_text import replaced as replaced_in
from gimcli.model.source import read_yaml


def replaced(text, changes):
    return replaced_in(read_yaml(text, Path("<text>")), changes)


A, B = ("nodes", "A"), ("nodes", "B")
SPELLINGS = {
    "flow lists": "nodes: {A: [1, 2], B: [3, 4]}  # drawn\nname: x\n",
    "block lists": "nodes:\n  A:\n    - 1   # first\n    -   2\n  B:\n  - 3\n  - 4\nname: x\n",
    "lists over several lines": "nodes:\n  A: [1,  # x of A\n      2]\n  B: [\n    3, 4,\n  ]\nname: 'a # b'\n",
    "quoted names and other scripts": 'nodes: {"A": [1, 2], \'B\': [3, 4], "\U0001f600 Δ": [5, 6]}\nname: Δ\n',
    "numbers in other forms": "nodes: {A: [+1.0e0, .2e1], B: [3., 4]}\n",
    "line ends of Windows": "nodes:\r\n  A: [1, 2]\r\n  B: [3, 4]\r\nname: x\r\n",
    "comments before and after": "# Δ 1 2\n\n---\nnodes: # 1\n  # A: [1, 2]\n  A: [1, 2]\n\n  B: [3, 4]\n...\n",
    "explicit keys": "nodes:\n  ? A\n  : [1, 2]\n  ? B\n  : [3, 4]\n",
    "tags": "nodes: {A: [!!float 1, 2], B: !!seq [3, 4]}\n",
    "no line end": "nodes: {A: [1, 2], B: [3, 4]}",
}


@pytest.mark.parametrize("name", SPELLINGS)
def test_every_spelling_of_coordinates(name):
    text = SPELLINGS[name]
    new = replaced(text, {(*A, 0): -7.5, (*B, 1): 1e-07})
    expected = yaml.safe_load(text)
    expected["nodes"]["A"][0], expected["nodes"]["B"][1] = -7.5, 1e-07
    assert yaml.safe_load(new) == expected
    before, after = text.splitlines(), new.splitlines()
    assert len(before) == len(after)
    assert sum(a != b for a, b in zip(before, after, strict=True)) <= 2
    assert new.replace("-7.5", "").replace("1.0e-07", "") != text  # both were written
    assert replaced(text, {}) == text


ANCHORS = {
    "a number that another node uses": (
        "nodes: {A: [&a 1, 2], B: [*a, 4]}\n", "nodes: {A: [&a 9, 2], B: [1, 4]}\n",
    ),
    "a number that a length uses": (
        "nodes: {A: [&a 1, 2], B: [3, 4]}\nlinks: {l: {length: *a}}\n",
        "nodes: {A: [&a 9, 2], B: [3, 4]}\nlinks: {l: {length: 1}}\n",
    ),
    "a position that two nodes share": (
        "nodes:\n  A: &p [1, 2]\n  B: *p\n", "nodes:\n  A: &p [9, 2]\n  B: [1, 2]\n",
    ),
    "all coordinates, as a shape": (
        "nodes: &n\n  A: [1, 2]\n  B: [3, 4]\nelements: {e: {shape: *n}}\n",
        "nodes: &n\n  A: [9, 2]\n  B: [3, 4]\nelements: {e: {shape: {A: [1, 2], B: [3, 4]}}}\n",
    ),
    "an alias in an alias": (
        "nodes: &n {A: &p [1, 2], B: *p}\nx: *n\n", "nodes: &n {A: &p [9, 2], B: [1, 2]}\nx: {A: [1, 2], B: [1, 2]}\n",
    ),
    "an alias of something else": (
        "nodes: {A: [1, 2], B: [3, 4]}\nx: &x [5]\ny: *x\n", "nodes: {A: [9, 2], B: [3, 4]}\nx: &x [5]\ny: *x\n",
    ),
    "text of several lines in an alias": (
        "nodes: {A: [1, 2], B: [3, 4]}\nx: &x\n  at: [1]\n  name: a, b\n  note: |\n    one\n    two\ny: *x\n", None,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ANCHORS)
def test_aliases_keep_their_values(name):
    text, expected = ANCHORS[name]
    if expected is not None:
        assert replaced(text, {(*A, 0): 9}) == expected
        return
    new = replaced(text, {("x", "at", 0): 9})
    before, after = yaml.safe_load(text), yaml.safe_load(new)
    assert after["x"] == {**before["x"], "at": [9]}
    assert after["y"] == before["y"]


def test_a_coordinate_given_by_an_alias_is_written_out():
    text = "nodes: {B: [&b 3, 4], A: [*b, 2]}\n"
    assert replaced(text, {(*A, 0): 9}) == "nodes: {B: [&b 3, 4], A: [9, 2]}\n"
    assert replaced(text, {(*A, 0): 9, (*B, 0): 8}) == "nodes: {B: [&b 8, 4], A: [9, 2]}\n"


def test_a_node_given_by_an_alias_is_written_out():
    text = "nodes: {B: &b [3, 4], A: *b}\n"
    assert replaced(text, {(*A, 0): 9}) == "nodes: {B: &b [3, 4], A: [9, 4]}\n"


def test_an_alias_of_a_mapping_keeps_a_value_that_another_alias_in_it_had():
    text = "nodes: &n {A: &p [1, 2], B: *p}\nx: *n\n"
    assert replaced(text, {(*B, 0): 9}) == "nodes: &n {A: &p [1, 2], B: [9, 2]}\nx: {A: [1, 2], B: [1, 2]}\n"
