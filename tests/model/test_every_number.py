"""Every key of a model file that takes a number, out of its range: an answer, or an error with its line."""

import copy
import json
import random
import re
import signal
from contextlib import chdir, contextmanager

import pytest
import yaml
from in_process import gim

VALUES = (0, -1, 1e-300, -1e300, 1e100, 1e30, 1e15, 1e20, 1e-20, float("inf"), float("nan"), "three", True, None)
SAMPLE = 12
"""Changed files of the suite; the soak has all."""

SECONDS = 100
"""Longest time of a command; the bound on work ends those that do not end by themselves in about 20 s."""

MODEL = yaml.safe_load("""
units: {length: mm, mass: g}
parameters: {s: 60}
nodes: {O: [0, 0], C: [100, 0], A: [40, 0], B: [130, 71], P: [60, 60], W: [180, 100]}
ground: [O, C, W]
links: {crank: {nodes: [O, A], length: 40}}
elements: {coupler: {nodes: [A, B, P], shape: {A: [0, 0], B: [120, 0], P: [60, 40]}}}
prismatic: {guide: {node: B, guide: [C, W], offset: 20}}
actuators:
  motor: {pivot: O, arm: A, law: {from: s, to: 90}, speed: 10, start: 50, free: true,
          effort: {stall: 4, idle: 300}, rotor: {inertia: 0.0001, ratio: 3}}
points: {Q: {on: coupler, local: [60, 40]}, R: {on: coupler, at: [60, 50]}}
duration: 2
masses: {coupler: {mass: 200, inertia: 0.001, centre: [50, 10]}, B: 30}
gravity: [0, -9.81]
loads: {push: {on: coupler, at: [60, 50], follower: [3, 4]}, pull: {on: coupler, local: [1, 2], force: [1, 2]},
        twist: {on: crank, torque: 0.1}}
springs: {coil: {nodes: [O, B], stiffness: 50, free: 100}}
dampers: {oil: {pivot: O, arm: A, damping: 0.01}}
friction: {A: {viscous: 0.001, mu: 0.1, radius: 4}, O: 0.001}
tolerances: {crank.length: 0.1}
""")
"""A crank and a coupler whose pin slides on a line."""

GEARS = yaml.safe_load("""
units: {length: mm}
nodes: {O: [0, 0], C: [50, 0], A: [10, 0], B: [60, 10], S: [0, 20], T: [30, 20], V: [100, 20]}
ground: [O, C, S, V]
links: {one: [O, A], two: [C, B], rack: [T, X]}
actuators: {motor: {pivot: O, arm: A, law: {by: 30}}}
masses: {one: 1, two: 2, rack: 3}
gears:
  lift: {type: rack, members: [one, rack], pivots: [O], radii: [20]}
  pair: {members: [one, two], pivots: [O, C], radii: [20, 30], pressure_angle: 25}
""")
GEARS["nodes"]["X"] = [60, 20]
GEARS["prismatic"] = {"slide": {"nodes": ["T", "X"], "guide": ["S", "V"]}}
GEARS["friction"] = {"slide": {"mu": 0.1, "length": 10}}
GEARS["gravity"] = [0, -9.81]

LAW = ("actuators", "motor", "law")
CHANGES = (
    {LAW: {"by": 30}},
    {LAW: {"turns": 2}},
    {LAW: {"from": 40, "rate": 30}},
    {LAW: {"by": 30, "polynomial": [0, 1]}},
    {LAW: {"by": 30, "profile": {"polynomial": [0, 1]}}},
    {("actuators", "motor", "effort"): 2},
    {("actuators", "motor", "effort"): {"constant": 2}},
)
GEAR_CHANGES = (
    {},
    {("gears", "pair"): {"members": ["one", "two"], "pivots": ["O", "C"], "teeth": [20, 30]}},
    {
        ("gears", "pair"): {
            "type": "belt",
            "members": ["one", "two"],
            "pivots": ["O", "C"],
            "teeth": [20, 30],
            "pitch": 5,
        }
    },
    {("gears", "pair"): {"members": ["one", "two"], "pivots": ["O", "C"], "ratio": 2}},
    {
        ("gears",): {"lift": {"type": "rack", "members": ["one", "rack"], "pivots": ["O"], "radii": [20]}},
        ("actuators", "second"): {"pivot": "C", "arm": "B", "follows": "motor", "ratio": 2, "phase": 11},
    },
    {
        ("actuators",): {
            "push": {
                "node": "T",
                "guide": ["S", "V"],
                "law": {"by": 1},
                "free": True,
                "rotor": {"inertia": 1e-4, "lead": 5},
            }
        },
    },
)
COMMANDS = ("solve", "trace", "check", "mobility", "forces", "equilibrium", "modes", "simulate", "singularities")


def changed(model, changes):
    """Return a copy of a model with values at paths."""
    found = copy.deepcopy(model)
    for path, value in changes.items():
        part = found
        for key in path[:-1]:
            part = part[key]
        part[path[-1]] = value
    return found


FILES = [changed(MODEL, {}), *(changed(MODEL, c) for c in CHANGES), *(changed(GEARS, c) for c in GEAR_CHANGES)]


def numbers(part, path=()):
    """Yield the paths of all numbers of a file."""
    if isinstance(part, dict | list):
        entries = part.items() if isinstance(part, dict) else enumerate(part)
        for key, value in entries:
            yield from numbers(value, (*path, key))
    elif isinstance(part, int | float) and not isinstance(part, bool):
        yield path


def promised(schema):
    """Return the keys that take numbers, with * for names and numbers of entries."""
    found = set()

    def walk(part, path):
        while "$ref" in part:
            part = schema["$defs"][part["$ref"].rsplit("/", 1)[-1]]
        for one in [*part.get("anyOf", ()), *part.get("oneOf", ())]:
            walk(one, path)
        if "number" in (part.get("type"), *(part["type"] if isinstance(part.get("type"), list) else ())):
            found.add(path)
        for key, one in part.get("properties", {}).items():
            walk(one, (*path, key))
        for key in ("additionalProperties", "items"):
            if isinstance(part.get(key), dict):
                walk(part[key], (*path, "*"))
        for one in part.get("prefixItems", ()):
            walk(one, (*path, "*"))

    walk(schema, ())
    return found


def cases():
    """Return each number of a file, and a value for it, once for each key."""
    seen, found = set(), []
    for number, file in enumerate(FILES):
        for path in numbers(file):
            if path not in seen:
                seen.add(path)
                found += [(number, path, value) for value in VALUES]
    return found


@contextmanager
def in_time():
    """Raise TimeoutError after SECONDS."""

    def late(number, frame):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(SECONDS)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def run(case, commands, path):
    """Run commands on a changed file; return those that end with anything but an answer or an error with a place."""
    number, where, value = case
    path.write_text(yaml.safe_dump(changed(FILES[number], {where: value}), sort_keys=False))
    wrong = []
    for command in commands:
        try:
            with in_time(), chdir(path.parent):
                done = gim(command, path, *(["--steps", 8] if command in ("trace", "forces") else []), "--json")
        except (Exception, TimeoutError) as error:
            wrong.append((command, where, value, repr(error)))
            continue
        placed = done.code != 3 or re.search(r"file\.yaml:\d+:\d+: |^[a-z]+: '", done.error)
        answer = json.loads(done.text) if done.text else done.error and done.code in (2, 3, 4, 5)
        if not (placed and answer):
            wrong.append((command, where, value, done.code, done.error))
    return wrong


def test_the_files_are_correct(tmp_path):
    for k, file in enumerate(FILES):
        path = tmp_path / f"{k}.yaml"
        path.write_text(yaml.safe_dump(file, sort_keys=False))
        done = gim("solve", path)
        assert done.code in (0, 5), done.error


def test_every_key_with_a_number_is_in_a_file():
    schema = json.loads(gim("schema").text)
    own = [path for file in FILES for path in numbers(file)]

    def has(keys):
        return any(
            len(path) == len(keys) and all(b in ("*", a) for a, b in zip(path, keys, strict=True)) for path in own
        )

    assert [keys for keys in promised(schema) if not has(keys)] == []


def test_numbers_out_of_range(tmp_path):
    source = random.Random(3)
    wrong = [run(case, source.sample(COMMANDS, 2), tmp_path / "file.yaml") for case in source.sample(cases(), SAMPLE)]
    assert [one for case in wrong for one in case] == []


@pytest.mark.soak
def test_each_number_out_of_range(tmp_path):
    wrong = [run(case, COMMANDS, tmp_path / "file.yaml") for case in cases()]
    assert [one for case in wrong for one in case] == []
