"""Dimensions by name, and other values for them: the same as an edit of the file."""

from __future__ import annotations

import math
import operator
import pickle
from dataclasses import replace

import numpy as np
import pytest
import yaml
from bundled import FILES

import gimcli
from gimcli import GimError, Mechanism, ModelError, loads
from gimcli.language.expression import FUNCTIONS
from gimcli.model.compile import compile_model
from gimcli.model.source import read_source

TEXT = """\
name: Test
units: {length: mm}
parameters: {a: 38, b: 2*a + 3}
nodes: {O: [0, 0], G: [100, 0], A: [20, 30], B: [110, 70], C: [60, 90], S: [150, 5], T: [60, 40], U: [80, 50]}
ground: [O, G]
links: {crank: [O, A], rod: {nodes: [A, B], length: b + 9}, rocker: [G, B], tail: [B, S]}
elements: {plate: {nodes: [A, B, C], shape: {A: [0, 0], B: [a*2, 0], C: [30, 40]}}, other: [A, T, U]}
prismatic: {slide: {node: S, guide: [O, G]}, groove: {node: T, guide: [O, G], offset: a/2}}
actuators:
  motor: {type: rotary, pivot: O, arm: A, law: {from: 10, to: 370}}
  jack: {type: linear, nodes: [O, C], law: {by: 3}}
  free: {type: rotary, pivot: G, arm: B, free: true, start: 50, effort: {stall: 3, idle: 40},
    rotor: {inertia: 0.01, ratio: 7}}
  table: {type: linear, nodes: [O, U], law: {polynomial: [90, 3]}}
points: {P: {on: rod, local: [50, 10]}, Q: {on: rod, at: [70, 60]}}
masses: {rod: {mass: 2, inertia: 0.1, centre: [30, 0]}}
gravity: [0, -9.81]
loads: {push: {on: rod, at: [90, 0], force: [-50, 0]}, screw: {on: crank, torque: 3}}
springs: {coil: {pivot: O, arm: A, stiffness: 3, free: 20}}
dampers: {shock: {nodes: [O, B], damping: 15}}
friction: {A: 0.02, B: {mu: 0.1, radius: 5}}
tolerances: {rod: 0.1}
"""
EDITS = {
    "a": ("a: 38", "a: 40", 40), "b": ("2*a + 3", "80", 80), "G.x": ("[100, 0]", "[101, 0]", 101),
    "B.y": ("[110, 70]", "[110, 71]", 71), "rod.length": ("b + 9", "95", 95),
    "crank.length": ("[O, A], rod", "{nodes: [O, A], length: 41}, rod", 41), "plate.shape.B.x": ("a*2, 0", "77, 0", 77),
    "plate.shape.C.y": ("[30, 40]", "[30, 41]", 41), "groove.offset": ("offset: a/2", "offset: 1", 1),
    "slide.offset": ("{node: S, guide: [O, G]}", "{node: S, guide: [O, G], offset: 2}", 2),
    "motor.from": ("from: 10", "from: 12", 12), "motor.to": ("370", "-30", -30), "jack.by": ("by: 3", "by: 4", 4),
    "free.by": ("free: true", "law: {by: 4}, free: true", 4), "free.start": ("start: 50", "start: 5", 5),
    "free.effort.stall": ("stall: 3", "stall: 4", 4), "free.effort.idle": ("idle: 40", "idle: 41", 41),
    "free.rotor.inertia": ("inertia: 0.01", "inertia: 0.02", 0.02), "free.rotor.ratio": ("ratio: 7", "ratio: 8", 8),
    "free.speed": ("free: true", "free: true, speed: 2", 2), "table.polynomial.1": ("[90, 3]", "[90, 4]", 4),
    "P.x": ("[50, 10]", "[51, 10]", 51), "Q.y": ("[70, 60]", "[70, 61]", 61),
    "duration": ("name: Test", "duration: 2", 2),
    "rod.mass": ("mass: 2", "mass: 3", 3), "rod.inertia": ("inertia: 0.1", "inertia: 0.2", 0.2),
    "gravity.y": ("-9.81", "-1.6", -1.6),
    "rod.centre.x": ("centre: [30,", "centre: [31,", 31), "push.at.x": ("at: [90", "at: [91", 91),
    "push.force.x": ("[-50", "[-51", -51), "screw.torque": ("torque: 3", "torque: 4", 4),
    "coil.stiffness": ("stiffness: 3", "stiffness: 4", 4), "coil.free": ("free: 20", "free: 21", 21),
    "shock.damping": ("damping: 15", "damping: 16", 16), "A.friction": ("0.02", "0.03", 0.03),
    "B.friction.mu": ("mu: 0.1", "mu: 0.2", 0.2), "B.friction.radius": ("radius: 5", "radius: 6", 6),
}  # fmt: skip
"""An edit of the text and the same value, by the name of the dimension."""


def numbers(mechanism: Mechanism) -> list[object]:
    """Return everything that a mechanism is compiled to."""
    found = [mechanism.drawn, *(member.shape for member in mechanism.members), mechanism.scale, mechanism.origin]
    found += [mechanism.pairs, mechanism.points, mechanism.duration, mechanism.dynamics, mechanism.size]
    found += [(a.drawn, a.law.start, a.law.end) if hasattr(a.law, "start") else a.law for a in mechanism.actuators]
    return [*found, mechanism.gauges, mechanism.traced, mechanism.floating]


def same(one: Mechanism, other: Mechanism) -> bool:
    return all(np.array_equal(a, b) if isinstance(a, np.ndarray) else a == b
               for a, b in zip(numbers(one), numbers(other), strict=True))  # fmt: skip


@pytest.mark.parametrize("name", EDITS)
def test_another_value_is_an_edit_of_the_file(name):
    old, new, value = EDITS[name]
    assert TEXT.count(old) == 1
    edited = replace(loads(TEXT.replace(old, new)), name="Test")
    found = loads(TEXT).with_({name: value})
    assert same(found, edited)
    assert not same(found, loads(TEXT))
    assert found.written.dimension(name).value == value


def test_the_names_of_all_dimensions():
    found = {d.name: d for d in loads(TEXT).written.dimensions.values()}
    axes = {f"{node}.{axis}" for node in "OGABCSTUPQ" for axis in "xy"}
    own = {f"plate.shape.{node}.{axis}" for node in "ABC" for axis in "xy"}
    more = {
        "push.at.y",
        "push.force.y",
        "gravity.x",
        "rod.centre.y",
        "table.polynomial.0",
        "rocker.length",
        "tail.length",
    }
    assert found.keys() == EDITS.keys() | axes | own | more
    assert next(iter(found)) == "a"
    implied = {name for name, d in found.items() if not d.given}
    assert implied == {
        "crank.length",
        "rocker.length",
        "tail.length",
        "slide.offset",
        "free.by",
        "free.speed",
        "duration",
    }
    assert found["crank.length"].value == math.hypot(20, 30)
    assert found["rod.length"].formula == "b + 9"
    assert (found["free.by"].value, found["duration"].value) == (360.0, 1.0)
    units = {d.unit: [n for n in found if found[n].unit == d.unit] for d in found.values()}
    assert units["angle"] == ["motor.from", "motor.to", "free.by", "free.start", "coil.free"]
    assert units["mass"] == ["rod.mass"]
    assert set(units[""]) >= {"a", "duration", "free.speed", "free.effort.stall", "push.force.x", "coil.stiffness"}


def test_every_number_of_every_model_is_a_dimension(model):
    """The reader's own data are walked: the count of numbers is that of the dimensions that are given."""

    def count(part):
        if isinstance(part, dict):
            with_unit = str(part.get("rate", "")).endswith("rpm")
            return with_unit + sum(count(one) for key, one in part.items() if key != "tolerances")
        if isinstance(part, list):
            return sum(map(count, part))
        return isinstance(part, int | float) and not isinstance(part, bool)

    mechanism = gimcli.load(model)
    texts = sum(bool(d.formula) for d in mechanism.written.dimensions.values())
    assert sum(d.given for d in mechanism.written.dimensions.values()) == count(read_source(model).data) + texts


def test_calls_are_chained_and_keep_the_file():
    path = next(path for path in FILES if path.stem == "crank_rocker")
    first = gimcli.load(path)
    found = first.with_({"crank": 41}).with_({"B.x": 140, "crank.length": 42})
    assert (found.path, found.files, found.name) == (first.path, first.files, first.name)
    assert found.written.changes == {"crank.length": 42, "B.x": 140}
    assert found.written.dimension("crank").value == 42.0
    assert first.written.dimension("crank").value == 40.0
    assert same(first.with_({}), first)


def test_formulas_are_values_too():
    found = loads(TEXT).with_({"b": "a/2", "rod": "b + 90"})
    assert (found.written.dimension("b").value, found.written.dimension("rod").value) == (19.0, 109.0)
    assert found.with_({"a": 10}).written.dimension("rod").value == 95.0
    assert loads(TEXT).with_({"a": "38/2"}).written.dimension("b").value == 41.0


@pytest.mark.parametrize("changes", [{"a": -6}, {"A.x": 0, "A.y": 0}, {"b": "1/(a - 38)"}, {"a": -(10**5000)}])
def test_nothing_of_a_refused_change_is_left(changes):
    mechanism = loads(TEXT)
    with pytest.raises(GimError) as refused:
        mechanism.with_(changes)
    assert "\n" not in str(refused.value)
    assert same(mechanism.with_({"a": 38}), mechanism)


def test_dual_numbers_pass_through_formulas():
    """Objects with operators replace numbers; the derivative of b + 9 = 2 a + 12 by a is 2."""

    class Dual:
        def __init__(self, value, slope):
            self.value, self.slope = value, slope

        def __add__(self, other):
            return Dual(self.value + getattr(other, "value", other), self.slope + getattr(other, "slope", 0))

        def __rmul__(self, other):
            return Dual(other * self.value, other * self.slope)

        __mul__ = __rmul__

        def __truediv__(self, other):
            return Dual(self.value / other, self.slope / other)

    mechanism = loads(TEXT)
    found = mechanism.written.substituted({"a": Dual(38.0, 1.0)}, {name: operator.neg for name in FUNCTIONS})
    length, turned = found.links["rod"].length, found.elements["plate"].shape["B"][0]
    assert (length.value, length.slope) == (88.0, 2.0)
    assert (turned.value, turned.slope) == (76.0, 2.0)
    assert mechanism.written.model.links["rod"].length == 88.0


def test_a_substituted_model_compiles_to_the_same_mechanism():
    mechanism = loads(TEXT)
    model = mechanism.written.substituted({"a": 41.0, "jack.by": 5.0}, FUNCTIONS)
    assert same(compile_model(model), mechanism.with_({"a": 41, "jack.by": 5}))


def test_a_model_in_memory_has_dimensions():
    found = gimcli.load(yaml.safe_load(TEXT))
    assert same(found.with_({"a": 40}), loads(TEXT).with_({"a": 40}))
    with pytest.raises(ModelError) as refused:
        found.with_({"a": -6})
    assert refused.value.faults[0].startswith("<dict> with a = -6: rod.length")


def test_a_mechanism_from_another_process_has_dimensions():
    mechanism = loads(TEXT).with_({"a": 40})
    found = pickle.loads(pickle.dumps(mechanism))
    assert same(found.with_({"b": 80}), mechanism.with_({"b": 80}))
