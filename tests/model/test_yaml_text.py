"""Model files as written by `yaml_text`: read back by our reader and by PyYAML (YAML 1.1), and their layout."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given, settings, strategies as st

from gimcli.model.source import read_yaml
from gimcli.model.yaml_text import WIDTH, yaml_text

AWKWARD = ["on", "No", "y", "null", "~", "", "1", "1.5", "1e3", "0x1F", "1_000", "1:30", "2020-01-01", ".5", ".inf",
           "-", "- a", "?", "a: b", "a #b", "a:", "<<", "=", "*a", "&a", "!a", "%a", "@a", "`a", "a, b", "[a", "{a",
           "'a'", '"a"', "a\\n", " a", "a ", "a\nb", "a\tb", "2*a + 3", "60 rpm", "(a)", "min(a, b)", "Hoeken's, 1926",
           "http://a.b/c?d#e", "ä–ö", "😀", "\x85", "\u2028", "---", "0o17", "007", "+1", "12e03", "1 2", "a\u00a0b",
           "1.2.3", "()", "((", "1(", "0 ", "2 /3"]  # fmt: skip
TEXT = st.sampled_from(AWKWARD) | st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]), max_size=12)
NAMES = TEXT.filter(bool)
SCALARS = TEXT | st.integers() | st.floats(allow_nan=False) | st.booleans() | st.none()
PARTS = st.recursive(
    SCALARS, lambda own: st.lists(own, max_size=5) | st.dictionaries(NAMES, own, max_size=4), max_leaves=12
)


def read(text: str) -> Any:
    return read_yaml(text, Path("text.yaml"))


@settings(max_examples=25, deadline=None)
@given(st.dictionaries(NAMES, PARTS, min_size=1, max_size=4))
@example({name: {name: {name: [name, {name: name}]}} for name in AWKWARD if name})
def test_reading_back_gives_the_same_data(data: dict[str, Any]) -> None:
    source = read(yaml_text(data))
    assert source.data == data
    assert [f for f in source.faults if "control character" not in f.text] == []


@settings(max_examples=25, deadline=None)
@given(st.dictionaries(NAMES, PARTS, min_size=1, max_size=4))
@example({name: {name: [name, {name: name}]} for name in AWKWARD if name})
def test_yaml_1_1_reads_the_same_data(data: dict[str, Any]) -> None:
    written = yaml.safe_load(yaml_text(data))
    assert keyed(written) == data


def keyed(value: Any) -> Any:
    """Return data with the key that YAML 1.1 reads as true as `on`."""
    if isinstance(value, dict):
        return {"on" if key is True else key: keyed(part) for key, part in value.items()}
    return [keyed(part) for part in value] if isinstance(value, list) else value


@settings(max_examples=25, deadline=None)
@given(st.floats(allow_nan=False))
@example(-0.0)
@example(1e16)
def test_floats_are_read_back_exactly(value: float) -> None:
    data = read(yaml_text({"a": [value]})).data
    assert repr(float(data["a"][0])) == repr(value)
    assert type(yaml.safe_load(yaml_text({"a": value}))["a"]) in (int, float)


def test_long_names_are_read_back() -> None:
    data = {"a": {"b" * 1100: {"c" * 1100: {"d": ["e" * 1100, {"f" * 1100: 1}]}}}}
    assert read(yaml_text(data)).data == yaml.safe_load(yaml_text(data)) == data


def test_layout() -> None:
    """A part is on one line; long parts are divided into their keys, long lists into lines."""
    long = {"nodes": [f"node {k}" for k in range(20)], "shape": {f"node {k}": [k, 0.5] for k in range(2)}}
    data = {
        "name": "Crank, rod: two members",
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {"A": [0.0, 1e-7], "B": [20.5, -3]},
        "elements": {"plate": long},
        "points": {"P": {"on": "plate", "at": [1, 2]}},
        "trace": ["P", "on"],
    }
    assert (
        yaml_text(data, ["Converted from a.txt", "second\nthird"])
        == """\
# Converted from a.txt
# second
# third
name: "Crank, rod: two members"
units: {length: mm, angle: deg}
nodes:
  A: [0, 1.0e-07]
  B: [20.5, -3]
elements:
  plate:
    nodes:
      [node 0, node 1, node 2, node 3, node 4, node 5, node 6, node 7, node 8, node 9, node 10,
       node 11, node 12, node 13, node 14, node 15, node 16, node 17, node 18, node 19]
    shape: {node 0: [0, 0.5], node 1: [1, 0.5]}
points:
  P: {on: plate, at: [1, 2]}
trace: [P, "on"]
"""
    )


def test_notes_are_comments_behind_their_parts() -> None:
    data = {"parameters": {"a": 2, "b": 4}, "links": {"crank": ["O", "A"]}, "gravity": [0, -9.81]}
    notes = {("parameters", "b"): "2*a", ("links", "crank"): "a\nb"}
    expected = "parameters:\n  a: 2\n  b: 4  # 2*a\nlinks:\n  crank: [O, A]  # a b\ngravity: [0, -9.81]\n"
    assert yaml_text(data, notes=notes) == expected


@pytest.mark.parametrize("path", sorted(Path("models").glob("*.yaml")), ids=lambda path: path.stem)
def test_shipped_models_are_read_back(path: Path) -> None:
    data = read(path.read_text(encoding="utf-8")).data
    text = yaml_text(data)
    assert read(text).data == data
    assert all(len(line) <= WIDTH or line.startswith(("name:", "source:")) for line in text.splitlines())
