"""The shipped models show every key of the model file, every choice, and every unit that is used in practice."""

from __future__ import annotations

import re

import pytest
from bundled import FILES, MANUAL

from gimcli.model.json_schema import json_schema
from gimcli.model.source import read_source

SCHEMA = json_schema()
UNUSUAL = {("Units.length", "um"), ("Units.length", "km")}
"""Units in which no shipped model is written."""


def options(schema):
    """Yield the schemas that a value may have, with their references resolved, and the names of the references."""
    for one in schema.get("anyOf", [schema]):
        name = one.get("$ref", "").rpartition("/")[2]
        yield SCHEMA["$defs"].get(name, one), name


def keys(data, schema, name):
    """Yield the names of all keys in some data, such as `Law.rate`, and of its words, as (`Law.profile`, 'cubic')."""
    for one, own in options(schema):
        own = own or name
        if isinstance(data, dict):
            for key, value in data.items():
                key = "on" if key == "true" else key
                if key in one.get("properties", {}):
                    yield f"{own}.{key}"
                    yield from keys(value, one["properties"][key], f"{own}.{key}")
                elif isinstance(one.get("additionalProperties"), dict):
                    yield from keys(value, one["additionalProperties"], own)
        elif data in one.get("enum", ()):
            yield name, data


def known(schema, name):
    """Yield what `keys` can yield."""
    for one, own in options(schema):
        own = own or name
        for key, value in one.get("properties", {}).items():
            yield f"{own}.{key}"
            yield from known(value, f"{own}.{key}")
        if isinstance(one.get("additionalProperties"), dict):
            yield from known(one["additionalProperties"], own)
        for word in one.get("enum", ()):
            yield name, word


@pytest.fixture(scope="module")
def shown():
    """Return the keys and words of each shipped model."""
    return {path.stem: set(keys(read_source(path).data, SCHEMA, "Model")) for path in FILES}


def test_each_key_and_each_word_is_shown(shown):
    """Words: units, kinds of actuators, profiles, sides, what a table runs over."""
    wanted = set(known(SCHEMA, "Model"))
    assert {"Model.nodes", "Law.rate", "Spring.stiffness", ("Law.profile", "cubic"), ("Effort.over", "speed")} <= wanted
    assert wanted - UNUSUAL - set().union(*shown.values()) == set()


def test_masses_and_forces_of_nodes_are_shown():
    data = [read_source(path).data for path in FILES]
    assert any(set(one.get("masses", {})) & set(one["nodes"]) for one in data)
    assert any(load.get("on") in one["nodes"] for one in data for load in one.get("loads", {}).values())


def test_the_page_names_models_that_show_each_section(shown):
    text = (MANUAL / "models.md").read_text(encoding="utf-8")
    rows = re.findall(r"(?m)^\| `(\w+)`[^|]*\| (.*) \|$", text[text.index("## Which model shows") :])
    assert {section for section, _ in rows} == set(SCHEMA["properties"]) - {"name", "source", "trace", "links"}
    for section, models in rows:
        for name in re.findall(r"`(\w+)`", models):
            assert f"Model.{section}" in shown[name], (section, name)
