"""Parameters, formulas and tolerances of the model file."""

from __future__ import annotations

from typing import Any

import pytest

from gimcli import ModelError, UsageError, load, loads
from gimcli.model.dimensions import tolerances, written
from gimcli.model.part import Part
from gimcli.model.remarks import remarks

FORMULAS = """\
parameters: {a: 38, b: 2*a + 3, turn: 90, half: "pi/2"}
nodes: {O: [0, 0], G: [b + 21, 0], A: [-2*-a, a/2], B: ["b", 60], C: [20, 7e1]}
ground: [O, G]
links: {crank: [O, A], rod: {nodes: [A, B], length: "sqrt(b*b)"}, rocker: [G, B]}
elements: {plate: {nodes: [A, B, C], shape: {A: [0, 0], B: [b, 0], C: [a, a]}}}
actuators:
  motor: {type: rotary, pivot: O, arm: A, free: true, effort: a/10, start: -turn, law: {from: 0, to: 2*turn}}
  jack: {type: linear, nodes: [O, B], law: {polynomial: [b, a - 8]}}
points: {P: {on: rod, local: [a/2, -a]}}
duration: turn/45
masses: {rod: {mass: a/1000, centre: [b/2, 0]}}
gravity: [0, -9*1]
loads: {push: {on: rod, local: [a, 0], force: [0, -a]}}
springs: {coil: {pivot: O, arm: A, stiffness: 1/4}}
friction: {A: 1/100}
"""
NUMBERS = """\
nodes: {O: [0, 0], G: [100, 0], A: [76, 19], B: [79, 60], C: [20, 70]}
ground: [O, G]
links: {crank: [O, A], rod: {nodes: [A, B], length: 79}, rocker: [G, B]}
elements: {plate: {nodes: [A, B, C], shape: {A: [0, 0], B: [79, 0], C: [38, 38]}}}
actuators:
  motor: {type: rotary, pivot: O, arm: A, free: true, effort: 3.8, start: -90, law: {from: 0, to: 180}}
  jack: {type: linear, nodes: [O, B], law: {polynomial: [79, 30]}}
points: {P: {on: rod, local: [19, -38]}}
duration: 2
masses: {rod: {mass: 0.038, centre: [39.5, 0]}}
gravity: [0, -9]
loads: {push: {on: rod, local: [38, 0], force: [0, -38]}}
springs: {coil: {pivot: O, arm: A, stiffness: 0.25}}
friction: {A: 0.01}
"""
FOUR_BAR = """\
nodes: {O: [0, 0], G: [3, 0], A: [0, 1], B: [3, 2]}
ground: [O, G]
links:
  crank: [O, A]
  rod: {nodes: [A, B], length: LENGTH}
  rocker: [G, B]
"""


def plain(part: Any) -> Any:
    """Return a part of a model as plain data, without what a file with formulas has more."""
    if isinstance(part, Part):
        return {key: plain(one) for key, one in vars(part).items() if key not in ("parameters", "formulas", "name")}
    return {key: plain(one) for key, one in part.items()} if isinstance(part, dict) else part


def test_formulas_mean_the_numbers_that_they_give():
    one, other = loads(FORMULAS).written.model, loads(NUMBERS).written.model
    assert plain(one) == plain(other)
    assert loads(FORMULAS).written.source.data["links"]["rod"]["length"] == "sqrt(b*b)"  # still as in the file
    assert one.parameters == {"a": 38.0, "b": 79.0, "turn": 90.0, "half": 1.5707963267948966}


def test_formulas_in_a_dict():
    model = {"parameters": {"a": 2, "b": "a/2"}, "nodes": {"O": [0, "0*a"], "A": ["a", 0]}, "ground": ["O"],
             "links": {"crank": {"nodes": ["O", "A"], "length": "b"}}}  # fmt: skip
    assert load(model).written.model.links["crank"].length == 1.0
    with pytest.raises(ModelError):
        load({**model, "parameters": {"b": "c"}})


def test_an_alias_of_a_formula():
    found = loads("parameters: {a: 3}\n" + FOUR_BAR.replace("[0, 1]", "&place [a, a]").replace("[3, 2]", "*place")
                  .replace("LENGTH", "a"))  # fmt: skip
    assert found.written.model.nodes["B"] == found.written.model.nodes["A"] == [3.0, 3.0]


def test_many_parameters_are_evaluated_in_any_order_or_refused():
    chain = ", ".join(f"p{k}: p{k + 1} + 1" for k in range(999))
    assert loads(f"parameters: {{{chain}, p999: 1}}\n" + FOUR_BAR.replace("LENGTH", "p0/100")).written.model.links[
        "rod"
    ].length == pytest.approx(10.0)
    more = ", ".join(f"p{k}: p{k + 1}" for k in range(5000))
    with pytest.raises(ModelError):
        loads(f"parameters: {{{more}, p5000: 1}}\n" + FOUR_BAR.replace("LENGTH", "5"))


def test_similar_names_are_searched_for_the_first_faults_only():
    coordinates = ", ".join(f"n{k}: [paramm{k}, 0]" for k in range(100))
    parameters = ", ".join(f"param{k}: 1" for k in range(500))
    with pytest.raises(ModelError) as refused:
        loads(f"parameters: {{{parameters}}}\nnodes: {{{coordinates}}}\nground: [n0]\nlinks: {{a: [n0, n1]}}\n")
    assert len(refused.value.faults) == 100
    assert "did you mean 'param0'?" in refused.value.faults[0]
    assert "did you mean" not in refused.value.faults[99]


def test_a_parameter_without_effect_is_remarked():
    found = remarks(loads("parameters: {a: 38, b: 2*a, c: 1}\n" + FOUR_BAR.replace("LENGTH", "5")).written.model)
    assert [where for where, _ in found] == [("parameters", "b"), ("parameters", "c")]


TOLERANCES = "parameters: {a: 38}\ntolerances: %s\n" + FOUR_BAR.replace("LENGTH", "a/10")


def test_tolerances_by_the_names_of_dimensions():
    mechanism = loads(TOLERANCES % "{crank: 0.05, rod.length: a/1000, B.x: 0.02, a: 0.1}")
    assert tolerances(mechanism) == {"crank.length": 0.05, "rod.length": 0.038, "B.x": 0.02, "a": 0.1}
    assert tolerances(loads(NUMBERS)) == {}


def test_a_mechanism_without_a_model_has_no_dimensions():
    from dataclasses import replace

    with pytest.raises(UsageError):
        written(replace(loads(NUMBERS), written=None))
    with pytest.raises(UsageError):
        replace(loads(NUMBERS), written=None).with_({"rod.length": 2})
