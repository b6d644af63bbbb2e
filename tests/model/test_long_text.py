"""The long form of a model: reading it back gives the same mechanism, and it has no short forms left."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from in_process import gim

import gimcli
from gimcli import Mechanism
from gimcli.model.long_text import long_form

LEFT_OUT = ("files", "path", "written", "left_out", "name", "stated")
EVERYTHING = """\
name: Press
units: {length: mm}
parameters: {r: 20, l: 3*r + 15}
nodes: {O: [0, 0], A: [r, 0], B: [r + l - 4, 3], G: [200, 0], C: [50, 30], D: [60, 40], E: [120, 3], Z: [7, 7]}
ground: [O, G]
elements: {plate: [C, A, D]}
links: {crank: [O, A], rod: {nodes: [A, B], length: l}, block: [B, E]}
prismatic: {slide: {nodes: [B, E], guide: [O, G], offset: 3}}
actuators:
  motor: {pivot: O, arm: A, free: true, effort: 3, law: {rate: 60 rpm, turns: 2, profile: cubic}}
  swing: {pivot: A, arm: C, reference: B, law: {polynomial: [80, 5, -3]}}
points:
  P: {member: rod, at: [50, 30]}
  Q: {on: ground, at: [50, -10]}
  R: {on: plate, local: [3, r/4]}
masses: {crank: {mass: 0.3, inertia: 1.0e-4}, plate: {mass: r/100}, B: 2, G: 1}
gravity: [0, -9.81]
loads:
  push: {on: block, at: [100, 3], force: [-50, 0], table: cut.csv, over: motor}
  side: {true: B, force: [0, 5]}
  screw: {on: crank, torque: 3}
  tool: {on: plate, local: [1, 2], follower: [0, 7]}
springs: {coil: {nodes: [O, B], stiffness: 200}, torsion: {pivot: A, arm: B, reference: O, stiffness: 3}}
dampers: {shock: {node: B, guide: [O, G], damping: 15}}
friction: {A: 0.02, slide: {mu: 0.1, length: 20, viscous: 5}, B: {mu: r/100, radius: 2}}
tolerances: {crank: 0.05, r: 0.1}
"""


def differences(one: Any, other: Any, at: str = "") -> list[str]:
    """Return the names of the parts in which two mechanisms differ, by more than rounding."""
    if isinstance(one, Mechanism):
        pairs = [(f.name, getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one)]
        return [d for name, a, b in pairs if name not in LEFT_OUT for d in differences(a, b, name)]
    if callable(one) and callable(other):
        time = np.linspace(0.0, 1.0, 7)
        return [] if np.allclose(one(time), other(time), rtol=1e-12, atol=1e-12) else [at]
    if dataclasses.is_dataclass(one):
        pairs = [(f.name, getattr(one, f.name), getattr(other, f.name)) for f in dataclasses.fields(one)]
        return [d for name, a, b in pairs if name not in LEFT_OUT for d in differences(a, b, f"{at}.{name}")]
    if isinstance(one, tuple) and len(one) == len(other):
        return [d for k, (a, b) in enumerate(zip(one, other, strict=True)) for d in differences(a, b, f"{at}.{k}")]
    if isinstance(one, np.ndarray) or type(one) in (float, complex):
        return [] if np.allclose(one, other, rtol=1e-12, atol=1e-12) else [at]
    return [] if one == other else [at]


def back(text: str, folder: Path = Path("models")) -> Mechanism:
    return gimcli.loads(text, folder)


@pytest.mark.few
@pytest.mark.parametrize("path", sorted(Path("models").glob("*.yaml")), ids=lambda path: path.stem)
def test_the_long_form_of_a_shipped_model_is_the_same_mechanism(path: Path) -> None:
    model = gimcli.load(path)
    text = long_form(model)
    again = back(text)
    assert differences(model, again) == []
    assert yaml.safe_load(long_form(again)) == yaml.safe_load("\n".join(without_notes(text)))
    found = again.written.dimensions
    for name, known in model.written.dimensions.items():
        if known.where[0] in ("nodes", "links", "elements", "prismatic", "duration"):
            assert found[name].value == pytest.approx(known.value, rel=1e-12, abs=1e-12), name


def without_notes(text: str) -> list[str]:
    """Return the lines of a long form without the comments for formulas."""
    return [line.split("  #")[0] for line in text.splitlines()]


def test_everything_of_the_format_has_a_long_form(tmp_path: Path) -> None:
    (tmp_path / "cut.csv").write_text("0,0\n360,1\n")
    model = gimcli.loads(EVERYTHING, tmp_path)
    text = long_form(model)
    again = back(text, tmp_path)
    assert differences(model, again) == []
    data = yaml.safe_load(text.replace(" on:", " 'on':").replace("{on:", "{'on':"))
    assert data["parameters"] == {"r": 20, "l": 75}
    assert data["links"]["crank"] == {"nodes": ["O", "A"], "length": 20}
    assert data["links"]["rod"] == {"nodes": ["A", "B"], "length": 75}
    assert list(data).index("elements") < list(data).index("links")
    assert data["elements"]["plate"]["shape"]["A"] == pytest.approx([math.hypot(30, 30), 0])
    assert data["actuators"]["motor"]["type"] == data["actuators"]["swing"]["type"] == "rotary"
    law = {"from": 0, "to": 720, "profile": {"name": "cubic"}}
    assert data["actuators"]["motor"] | {"law": law} == data["actuators"]["motor"]
    assert data["actuators"]["motor"]["effort"] == {"constant": 3}
    assert data["actuators"]["swing"]["law"] == {"profile": {"polynomial": [80, 5, -3]}}
    assert data["duration"] == 2
    assert data["points"]["P"]["local"] != data["points"]["Q"]["at"] == [50, -10]
    assert data["masses"]["B"] == {"mass": 2}
    assert data["masses"]["plate"]["mass"] == 0.2
    assert data["loads"]["side"] == {"on": "B", "force": [0, 5]}
    assert data["springs"]["coil"]["free"] == pytest.approx(math.hypot(91, 3))
    assert data["trace"] == ["P", "Q", "R"]
    assert "  l: 75  # 3*r + 15\n" in text
    assert "length: 75}  # length: l\n" in text
    assert "  # local.1: r/4\n" in text
    assert long_form(again).replace("parameters: {r: 20, l: 75}", "parameters:\n  r: 20\n  l: 75") == (
        "\n".join([*without_notes(text), ""])
    )


def test_other_dimensions_are_those_of_the_long_form(tmp_path: Path) -> None:
    (tmp_path / "cut.csv").write_text("0,0\n360,1\n")
    model = gimcli.loads(EVERYTHING, tmp_path).with_({"r": 24})
    assert "  l: 87  # 3*r + 15\n" in long_form(model)
    assert differences(model, back(long_form(model), tmp_path)) == []


def test_nodes_without_coordinates_get_theirs() -> None:
    text = "nodes: {O: [0, 0], G: [4, 0], A: [1, 0], B: {side: left}}\nground: [O, G]\n"
    text += "links: {crank: [O, A], coupler: {nodes: [A, B], length: 3}, rocker: {nodes: [G, B], length: 2}}\n"
    text += "actuators: {motor: {pivot: O, arm: A}}\n"
    model = gimcli.loads(text)
    again = back(long_form(model))
    assert differences(model, again) == []
    assert "B: {side" not in long_form(model)


def test_the_command_prints_the_long_form() -> None:
    assert gim("check", "models/crank_rocker.yaml", "--long").text == long_form(gimcli.load("models/crank_rocker.yaml"))
    wrong = gim("check", "models/crank_rocker.yaml", "--long", "--json")
    assert wrong.code == 2
    assert "--json" in wrong.error


def test_another_assembly_is_that_of_the_long_form() -> None:
    found = back(gim("check", "models/slider_crank.yaml", "--assembly", "2", "--long").text)
    own = gimcli.load("models/slider_crank.yaml")
    piston = own.nodes.index("B")
    for one, other in zip(own.members[1:], found.members[1:], strict=True):
        assert one.shape * own.scale == pytest.approx(other.shape * found.scale)
    assert found.drawn[piston].real < 0.0 < own.drawn[piston].real
