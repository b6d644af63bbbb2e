"""The text of a model with other dimensions in place."""

from __future__ import annotations

import pytest
import yaml

import gimcli
from gimcli import UsageError, load, loads
from gimcli.model.edited_text import written_with

REST = "nodes: {O: [0, 0], G: [100, 0], A: [20, 30], B: [110, 70]}\nground: [O, G]\n"
LINKS = REST + "links: {crank: [O, A], rod: [A, B], rocker: [G, B]}\n"
MOTOR = LINKS + "actuators:\n  motor: {type: rotary, pivot: O, arm: A}\n"
CASES = {
    "a coordinate": (LINKS, {"B.x": 90.25}, "[110, 70]", "[90.25, 70]"),
    "all digits": (LINKS, {"B.x": 0.1 + 0.2}, "110", "0.30000000000000004"),
    "a small number": (LINKS, {"B.x": -1e-7}, "110", "-1.0e-07"),
    "a parameter": ("parameters: {a: 3, b: 2*a} # size\n" + LINKS, {"a": 4.5}, "a: 3", "a: 4.5"),
    "a formula": ("parameters: {a: 3}\n" + LINKS, {"B.x": "2*a + 100"}, "110", "2*a + 100"),
    "a formula in quotes": ("parameters: {a: 3}\n" + LINKS, {"B.x": "min(a, 2)"}, "110", '"min(a, 2)"'),
    "a number in place of a formula": (LINKS.replace("110", "100 + 10"), {"B.x": 90}, "100 + 10", "90"),
    "a length in place of a list": (LINKS, {"rod": 95}, "[A, B]", "{nodes: [A, B], length: 95}"),
    "a length in place of a block list": (
        REST + "links:\n  crank:\n    - O\n    - A # end\n  rod:\n  - A\n  - B\n", {"crank": 36, "rod.length": 95},
        "crank:\n    - O\n    - A # end\n  rod:\n  - A\n  - B\n",
        "crank: {nodes: [O, A], length: 36} # end\n  rod: {nodes: [A, B], length: 95}\n",
    ),
    "a length in a mapping": (REST + "links:\n  rod:\n    nodes: [A, B]  # first\n# end\n", {"rod": 95},
                              "# first\n", "# first\n    length: 95\n"),
    "a length in a mapping at the end": (REST + "links:\n  rod:\n    nodes: [A, B]", {"rod": 95}, "[A, B]",
                                         "[A, B]\n    length: 95"),
    "a length in a mapping in brackets": (REST + "links: {rod: {nodes: [A, B],}}\n", {"rod": 95}, "[A, B],",
                                          "[A, B], length: 95,"),
    "a length in a mapping after a list": (REST + "links:\n  rod:\n    nodes:\n    - A\n    - B\n\n", {"rod": 95},
                                           "- B\n", "- B\n    length: 95\n"),
    "an empty length": (REST + "links:\n  rod:\n    length:\n    nodes: [A, B]\n", {"rod": 95}, "length:",
                        "length: 95"),
    "an alias": (REST + "links:\n  rod: &bar [A, B]\n  bar: *bar\n", {"bar": 95}, "*bar",
                 "{nodes: [A, B], length: 95}"),
    "an anchor": (REST + "links:\n  rod: &bar [A, B]\n  bar: *bar\n", {"rod": 95}, "[A, B]\n  bar: *bar",
                  "{nodes: [A, B], length: 95}\n  bar: [A, B]"),
    "a law": (MOTOR, {"motor.by": 90}, "arm: A", "arm: A, law: {by: 90}"),
    "a law in an empty mapping": (MOTOR.replace("A}\n", "A, law: {}}\n"), {"motor.by": 90}, "{}", "{by: 90}"),
    "a law in place of nothing": (LINKS + "actuators:\n  m:\n    type: rotary\n    pivot: O\n    arm: A\n    law:\n",
                                  {"m.by": 90}, "law:", "law: {by: 90}"),
    "a law in a profile": (MOTOR.replace("A}\n", "A, law: {profile: cubic}}\n"), {"motor.by": 90}, "cubic",
                           "cubic, by: 90"),
    "an effort": (MOTOR.replace("A}\n", "A, free: true, effort: 3}\n"), {"motor.effort": 4}, "effort: 3", "effort: 4"),
    "a coefficient": (MOTOR.replace("A}\n", "A, law: {polynomial: [0, 3]}}\n"), {"motor.polynomial.1": 4}, "[0, 3]",
                      "[0, 4]"),
    "the duration": (LINKS, {"duration": 2}, "rocker: [G, B]}\n", "rocker: [G, B]}\nduration: 2\n"),
    "line ends of Windows": (LINKS.replace("\n", "\r\n"), {"duration": 2, "B.x": 7}, "\n", "\n"),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_new_values_are_written_in_place(name):
    text, changes, old, new = CASES[name]
    mechanism = loads(text)
    found = written_with(mechanism, changes)
    if old != new:
        assert found.count(new) >= 1
        assert text.count(old) == 1
        assert found == text.replace(old, new)
    else:
        assert found.count("\r\n") == found.count("\n") == text.count("\n") + 1
    assert loads(found).written.dimensions == mechanism.with_(changes).written.dimensions
    assert written_with(mechanism) == text


def test_values_of_earlier_changes_are_written():
    mechanism = loads(LINKS).with_({"B.x": 105}).with_({"crank": 36}).with_({"B.x": 104})
    found = yaml.safe_load(written_with(mechanism, {"G.x": 99}))
    assert (found["nodes"]["B"], found["nodes"]["G"], found["links"]["crank"]["length"]) == ([104, 70], [99, 0], 36)


@pytest.mark.few
def test_every_dimension_of_every_model_is_written(model):
    mechanism = load(model)
    named = [d for d in mechanism.written.dimensions.values() if not d.name.startswith(("motor.from", "duration"))]
    named = [d for d in named if d.name != "free.speed" and ".polynomial." not in d.name]  # it ends at 1
    changes = {d.name: d.value * (1 + 1e-9) + (not d.given) * 1e-9 for d in named}
    text = written_with(mechanism, changes)
    found = loads(text, model.parent).written.dimensions
    assert {name: found[name].value for name in changes} == changes


def test_a_model_in_memory_is_written_as_a_file():
    data = yaml.safe_load(LINKS)
    assert yaml.safe_load(written_with(load(data), {"B.x": 90})) == {**data, "nodes": {**data["nodes"], "B": [90, 70]}}


def test_a_text_that_has_no_place_for_the_value_is_refused():
    text = REST + "links:\n  rod: # a comment\n  - A\n  - B\n"
    with pytest.raises(UsageError):
        written_with(loads(text), {"rod": 95})


def test_a_comment_and_the_folder_of_tables_are_kept(tmp_path):
    (tmp_path / "feed.csv").write_text("0,0\n1,90\n")
    text = MOTOR.replace("arm: A}", "arm: A, law: {table: feed.csv}}") + "# the end\n"
    (tmp_path / "model.yaml").write_text(text)
    mechanism = gimcli.load(tmp_path / "model.yaml")
    assert written_with(mechanism, {"B.x": 90}) == text.replace("110", "90")
