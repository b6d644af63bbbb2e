"""Every name in every shipped model, misspelled, removed or duplicated: a model file is read or refused with a line."""

import random
import re

import pytest
import yaml

import gimcli
from gimcli import shipped

SAMPLE = 150
"""Damaged files that the suite reads; the soak reads all."""

NAME = re.compile(r"[A-Za-z_][\w']*")


def declared(text):
    """Return the names that the sections of a model file declare."""
    sections = [part for key, part in yaml.safe_load(text).items() if key != "units" and isinstance(part, dict)]
    return {str(name) for part in sections for name in part}


def damaged(text):
    """Yield a model file with each name misspelled, removed or duplicated, and without each line that has one."""
    names = declared(text)
    for line in re.finditer(r"(?m)^.*\n", text):
        code = line.group().split("#")[0]
        if not code.strip() or code.startswith(("name:", "source:")):
            continue
        found = [m for m in NAME.finditer(code) if m.group() in names]
        for match in found:
            a, b = line.start() + match.start(), line.start() + match.end()
            word = match.group()
            yield text[:a] + "zz9" + text[b:]
            yield text[:a] + f"{word}, {word}" + text[b:]
            tail = text[b:]
            yield text[:a] + (tail[2:] if tail.startswith(", ") else tail)
        if found:
            yield text[: line.start()] + text[line.end() :]
            yield text[: line.end()] + text[line.start() :]


def faults(text):
    """Return the errors of a model file; none if it is read."""
    try:
        gimcli.loads(text, shipped.folder())
    except gimcli.ModelError as error:
        return error.faults
    return []


def refused_with_a_line(text):
    """Return whether a text is refused; each error has a line, or names the gears that do not fit together."""
    found = faults(text)
    assert all(re.match(r"gears: |.*?:\d+:", fault) for fault in found), found
    return bool(found)


def cases():
    return [text for name in shipped.names() for text in damaged(shipped.path_of(name).read_text(encoding="utf-8"))]


def test_a_damaged_name_is_refused_with_its_line():
    found = [refused_with_a_line(text) for text in random.Random(1).sample(cases(), SAMPLE)]
    assert sum(found) > SAMPLE / 3


@pytest.mark.soak
def test_each_damaged_name_is_refused_with_its_line():
    for text in cases():
        refused_with_a_line(text)


@pytest.mark.parametrize("node", ["O", "U", "V", "G", "H"])
def test_a_rack_without_one_of_its_nodes(node):
    text = re.sub(rf"(?m)^  {node}: .*\n", "", shipped.path_of("rack_lift").read_text(encoding="utf-8"))
    with pytest.raises(gimcli.ModelError):
        gimcli.loads(text)


def test_a_wheel_that_is_drawn_as_a_point_has_no_direction():
    nodes = {"O": [0, 0], "Q": [3, 0], "A": [1, 0], "B": [3, 0]}
    model = {
        "nodes": nodes, "ground": ["O", "Q"], "links": {"one": ["O", "A"], "two": {"nodes": ["Q", "B"], "length": 1}},
        "actuators": {"m": {"pivot": "O", "arm": "A"}},
        "gears": {"g": {"members": ["one", "two"], "pivots": ["O", "Q"], "ratio": 2}},
    }  # fmt: skip
    with pytest.raises(gimcli.ModelError):
        gimcli.load(model)
    nodes["B"] = [4, 0]
    assert gimcli.load(model).name
