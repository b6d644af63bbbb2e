"""The page on the model file: it has every key, unit, profile and kind, and what it says of tables and names is so."""

import re

import pytest
from bundled import MODELS
from fences import MANUAL

from gimcli.model.check import COLUMNS, FORMULA
from gimcli.model.json_schema import json_schema
from gimcli.model.laws import PROFILES

SCHEMA = json_schema()
TEXT = (MANUAL / "model-file.md").read_text(encoding="utf-8")
SECTIONS = {
    "Units": "units", "Ground": "ground", "Link": "links", "Element": "elements", "Prismatic": "prismatic",
    "Profile": "profiles", "Law": "law", "Actuator": "actuators", "Effort": "free inputs", "Tracer": "points",
    "Rotor": "rotors", "Gear": "gears", "Mass": "masses", "Load": "loads", "Spring": "springs", "Damper": "dampers",
    "PairFriction": "friction",
}  # fmt: skip
"""Heading under which a part of the schema is described."""


def section(title):
    """Return the text under a heading."""
    found = re.search(rf"(?ms)^##+ {title}$(.*?)(?=^##+ |\Z)", TEXT)
    assert found, title
    return found[1]


def words(text):
    """Return what stands in backticks, taken apart."""
    return {word for code in re.findall(r"`([^`\n]+)`", text) for word in re.findall(r"[\w.-]+", code)}


def test_every_section_of_a_file_has_a_heading_and_a_row():
    rows = words(section("Sections"))
    for key in SCHEMA["properties"]:
        assert key in rows
        assert re.search(rf"(?m)^## (.* )?{key}( .*)?$", TEXT), key


def test_every_part_of_the_schema_has_its_place():
    assert set(SCHEMA["$defs"]) == set(SECTIONS)


@pytest.mark.parametrize("part", SECTIONS)
def test_every_key_is_described_where_it_belongs(part):
    keys = set(SCHEMA["$defs"][part]["properties"])
    assert keys <= words(section(SECTIONS[part])), keys - words(section(SECTIONS[part]))


@pytest.mark.parametrize("key", ["length", "angle", "mass"])
def test_every_unit_is_listed_and_the_default_is_named(key):
    row = next(line for line in section("units").splitlines() if line.startswith(f"| `{key}`"))
    part = SCHEMA["$defs"]["Units"]["properties"][key]
    assert set(part["enum"]) <= words(row)
    assert row.endswith(f"| `{part['default']}` |")


def test_every_profile_and_kind_is_listed():
    assert set(PROFILES) <= words(section("profiles"))
    assert set(SCHEMA["$defs"]["Actuator"]["properties"]["type"]["anyOf"][0]["enum"]) <= words(section("actuators"))
    assert set(SCHEMA["$defs"]["Effort"]["properties"]["over"]["enum"]) <= words(section("free inputs"))


def test_the_examples_are_bundled_models():
    named = set(re.findall(r"`(\w+\.yaml)`", section("From the drawing to the file")))
    assert len(named) > 9
    assert named <= {path.name for path in MODELS.glob("*.yaml")}


def test_reserved_names_and_signs_are_listed():
    assert {"ground", *COLUMNS} <= words(section("Names"))
    assert all(f"`{sign}`" in section("Names") for sign in FORMULA)
