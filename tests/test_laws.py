"""Laws that every motion obeys, whatever the mechanism: frames, scales, mirrors, orders, steps, methods.

A model file is read here on our own, and what comes out is read from the text of the CSV.
"""

from __future__ import annotations

import copy
import csv
import json
import tempfile
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import yaml

from gimcli.model import load
from gimcli.motion.motion import trace
from gimcli.output import write_csv
from gimcli.positions.options import Options
from gimcli.rates.motion_table import motion_table

FILES = sorted((Path(__file__).parents[1] / "models").glob("*.yaml"))
NAMES = [*(path.stem for path in FILES), "parallel_guide"]
STEPS = 24
TIGHT, SHIFTED = 1e-11, 1e-9

# --- reading and writing on our own ----------------------------------------------------------------------


def numbers(value):
    """Turn the texts of numbers into floats, of truths into truths, deep inside."""
    if isinstance(value, dict):
        return {key: numbers(part) for key, part in value.items()}
    if isinstance(value, list):
        return [numbers(part) for part in value]
    if value in ("true", "false"):
        return value == "true"
    try:
        return float(value)
    except ValueError:
        return value


@cache
def read(name):
    if name == "parallel_guide":  # no model has an offset
        spec = copy.deepcopy(read("slider_crank"))
        del spec["nodes"]["G"]
        spec["nodes"]["H"] = [5.0, -0.4]
        spec["ground"] = ["O", "H"]
        spec["prismatic"] = {"slide": {"node": "B", "guide": ["H", "O"], "offset": -0.9}}
        return spec
    spec = numbers(yaml.load((FILES[0].parent / f"{name}.yaml").read_text(), Loader=yaml.BaseLoader))
    assert spec["units"]["angle"] == "deg"
    for kind in ("links", "elements"):
        parts = spec.setdefault(kind, {})
        for part, value in parts.items():
            parts[part] = value if isinstance(value, dict) else {"nodes": value}
    return {part: value for part, value in spec.items() if part != "trace"}


@dataclass
class Run:
    """What the CSV tells, nodes as complex numbers; and the motion it was written from."""

    z: dict
    value: dict
    status: list
    residual: np.ndarray
    text: str
    motion: object


def run(spec, steps=STEPS, **options):
    """Trace a specification with all its nodes and points, by way of two files."""
    with tempfile.TemporaryDirectory() as folder:
        path, out = Path(folder) / "model.yaml", Path(folder) / "out.csv"
        path.write_text(json.dumps(spec))
        motion = trace(load(path), steps, Options(**{"jit": "on", **options}))
        names = (*spec["nodes"], *spec.get("points", {}))
        write_csv(motion_table(motion, names), out)
        text = out.read_text()
    head, *rows = csv.reader(text.splitlines())
    column = dict(zip(head, zip(*rows, strict=True), strict=True))
    floats = {name: np.array([float(cell or "nan") for cell in cells]) for name, cells in column.items()
              if name != "status"}  # fmt: skip
    return Run(
        {name: floats[f"{name}.x"] + 1j * floats[f"{name}.y"] for name in names},
        {name: floats[name] for name in spec["actuators"]}, list(column["status"]), floats["residual"], text, motion,
    )  # fmt: skip


@cache
def known(name, steps=STEPS, **options):
    return run(read(name), steps, **options)


def place(xy):
    return complex(*xy)


def size(spec):
    z = np.array([place(xy) for xy in spec["nodes"].values()])
    return abs(complex(np.ptp(z.real), np.ptp(z.imag)))


def unit(z):
    return z / abs(z)


def ray(degrees):
    return np.exp(1j * np.radians(degrees))


def apart(found, expected, spec, rows=slice(None)):
    """Greatest distance of nodes between two runs, relative to the size."""
    return max(np.max(abs(z[rows] - expected[name])) for name, z in found.items()) / size(spec)


# --- the residual from the CSV alone ---------------------------------------------------------------------


def errors(spec, m):
    """Yield the errors of all that a file says: relative lengths and angles [rad] over the rows."""
    nodes = {name: place(xy) for name, xy in spec["nodes"].items()}
    big = size(spec)
    for link in spec["links"].values():
        a, b = link["nodes"]
        yield abs(m.z[b] - m.z[a]) / link.get("length", abs(nodes[b] - nodes[a])) - 1
    for element in spec["elements"].values():
        shape = {name: place(xy) for name, xy in element.get("shape", {}).items()} or nodes
        a, b, *rest = element["nodes"]
        for p, q in [(a, b), *((a, c) for c in rest), *((b, c) for c in rest)]:
            yield abs(m.z[q] - m.z[p]) / abs(shape[q] - shape[p]) - 1
        for c in rest:
            yield np.angle((m.z[c] - m.z[a]) / (m.z[b] - m.z[a]) / (shape[c] - shape[a]) * (shape[b] - shape[a]))
    for pair in spec.get("prismatic", {}).values():
        u, v = (m.z[name] for name in pair["guide"])
        for name in pair.get("nodes", [pair.get("node")]):
            yield (((m.z[name] - u) / unit(v - u)).imag - pair.get("offset", 0)) / big
    for name, drive in spec["actuators"].items():
        if drive["type"] == "rotary":
            o = m.z[drive["pivot"]]
            reference = m.z[drive["reference"]] - o if "reference" in drive else 1
            yield np.angle((m.z[drive["arm"]] - o) / reference / ray(m.value[name]))
        elif "nodes" in drive:
            a, b = (m.z[node] for node in drive["nodes"])
            yield abs(b - a) / m.value[name] - 1
        else:
            u, v = (m.z[node] for node in drive["guide"])
            yield (((m.z[drive["node"]] - u) / unit(v - u)).real - m.value[name]) / big
    held = spec["ground"]
    for name in held if isinstance(held, list) else spec["elements"][held["member"]]["nodes"]:
        yield abs(m.z[name] - nodes[name]) / big


def worst(spec, m):
    """Greatest error of each row."""
    with np.errstate(invalid="ignore"):
        return np.max([abs(error) for error in errors(spec, m)], axis=0)


@pytest.mark.parametrize("name", NAMES)
def test_rows_marked_ok_are_right(name):
    m = known(name, 72)
    good = np.array(m.status) == "ok"
    assert np.all(good)
    assert np.max(worst(read(name), m)[good]) <= 1e-10
    assert np.max(m.residual[good]) <= 1e-10


@pytest.mark.parametrize("name", NAMES)
def test_inputs_are_those_of_the_laws(name):
    for actuator, drive in read(name)["actuators"].items():
        value, law = known(name).value[actuator], drive["law"]
        if "by" in law:
            assert value[-1] - value[0] == pytest.approx(law["by"], rel=1e-12)
        else:
            assert [value[0], value[-1]] == pytest.approx([law["from"], law["to"]], rel=1e-14)
        if law.get("profile", "uniform") == "uniform":
            assert value == pytest.approx(np.linspace(value[0], value[-1], STEPS + 1), rel=1e-13, abs=1e-12)


# --- other frames ----------------------------------------------------------------------------------------


def moved(spec, turn=0.0, shift=0j, scale=1.0, mirror=False):
    """Return a specification seen from elsewhere, and the map of its points."""
    spec = copy.deepcopy(spec)
    side = -1.0 if mirror else 1.0
    factor = scale * complex(ray(turn)) if turn else scale

    def there(z):
        return factor * (np.conj(z) if mirror else z) + shift

    def local(xy):
        return [xy[0] * scale, xy[1] * scale * side]

    def pair(xy):
        z = complex(there(place(xy)))
        return [z.real, z.imag]

    spec["nodes"] = {name: pair(xy) for name, xy in spec["nodes"].items()}
    for link in spec["links"].values():
        if "length" in link:
            link["length"] *= scale
    for element in spec["elements"].values():
        if "shape" in element:
            element["shape"] = {name: local(xy) for name, xy in element["shape"].items()}
    for slide in spec.get("prismatic", {}).values():
        if "offset" in slide:
            slide["offset"] *= scale * side
    for point in spec.get("points", {}).values():
        for key, change in (("at", pair), ("local", local)):
            if key in point:
                point[key] = change(point[key])
    for drive in spec["actuators"].values():
        rotary, law = drive["type"] == "rotary", drive["law"]
        assert set(law) <= {"from", "to", "by", "profile"}
        assert isinstance(law.get("profile", ""), str)
        for key in {"from", "to", "by"} & set(law):
            start = turn if key != "by" and "reference" not in drive else 0.0
            law[key] = law[key] * side + start if rotary else law[key] * scale
    return spec, there


FRAMES = {
    "turned": ({"turn": 37.0}, TIGHT),
    "million times": ({"scale": 1e6}, TIGHT),
    "millionth": ({"scale": 1e-6}, TIGHT),
    "shifted": ({"shift": 1.0}, SHIFTED),
    "mirrored": ({"mirror": True}, TIGHT),
    "mirrored and turned": ({"mirror": True, "turn": 37.0, "scale": 3.0}, TIGHT),
}


@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("name", NAMES)
def test_the_frame_changes_only_rounding(name, frame):
    spec, here = read(name), known(name)
    change, tolerance = FRAMES[frame]
    if "shift" in change:
        change = {"shift": 1000 * size(spec) * (0.6 + 0.8j)}
    other, there = moved(spec, **change)
    m = run(other)
    assert m.status == here.status
    assert apart(m.z, {node: there(z) for node, z in here.z.items()}, other) <= tolerance


# --- orders ----------------------------------------------------------------------------------------------


def shuffled(spec, seed):
    """Return a specification with everything in another order that may stand in any."""
    spec, generator = copy.deepcopy(spec), np.random.default_rng(seed)

    def mix(values):
        return [values[k] for k in generator.permutation(len(values))]

    for part in ("nodes", "links", "elements", "prismatic", "actuators", "points"):
        spec[part] = dict(mix(list(spec.get(part, {}).items())))
    based = {point["on"] for point in spec["points"].values() if "local" in point}
    for kind in ("links", "elements"):
        for member, value in spec[kind].items():
            if member not in based:
                value["nodes"] = mix(value["nodes"])
    if isinstance(spec["ground"], list):
        spec["ground"] = mix(spec["ground"])
    return {part: value for part, value in spec.items() if value}


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_the_order_in_the_file_does_not_matter(name, seed):
    spec, here = read(name), known(name)
    other = {"links": {}, "elements": {}, **shuffled(spec, seed)}
    m = run(other)
    assert m.status == here.status
    assert apart(m.z, here.z, spec) <= TIGHT


# --- steps -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_more_steps_do_not_move_the_others(name):
    few, many = known(name), known(name, 2 * STEPS)
    assert few.status == many.status[::2]
    assert apart({node: z[::2] for node, z in many.z.items()}, few.z, read(name)) <= TIGHT


@pytest.mark.parametrize("steps", [1, 3, 5])
@pytest.mark.parametrize("name", NAMES)
def test_coarse_steps_keep_the_branch(name, steps):
    coarse, fine = known(name, steps), known(name, 360)
    assert set(coarse.status) == {"ok"}
    common = {node: z[:: 360 // steps] for node, z in fine.z.items()}
    assert apart(coarse.z, common, read(name)) <= TIGHT


TURNING = [
    name
    for name in NAMES
    if all(
        d["type"] == "rotary" and abs(d["law"].get("by", d["law"].get("to", 0) - d["law"].get("from", 0))) == 360
        for d in read(name)["actuators"].values()
    )
]


@pytest.mark.parametrize("name", TURNING)
def test_a_full_turn_comes_home(name):
    m = known(name, 72)
    assert max(abs(z[-1] - z[0]) for z in m.z.values()) <= TIGHT * size(read(name))


# --- methods ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
def test_newton_agrees_with_auto(name):
    m, auto = known(name, method="newton"), known(name)
    assert m.status == auto.status
    assert apart(m.z, auto.z, read(name)) <= 1e-10


GIM = {"method": "gim", "tolerance": 1e-8, "jit": "off", "sweeps": 2000}


@pytest.mark.parametrize("name", NAMES)
def test_gim_agrees_or_says_so(name):
    steps = 8
    m, auto = run(read(name), steps, **GIM), known(name, steps)
    good = [k for k, status in enumerate(m.status) if status == "ok"]
    assert {"ok", "not-converged", "stalled", "other-configuration"} >= set(m.status)
    for node, z in m.z.items():
        assert np.all(np.isnan(np.delete(z, good)))
        assert np.max(abs(z - auto.z[node])[good], initial=0.0) <= 1e-5 * size(read(name))
    if good:
        assert np.max(worst(read(name), m)[good]) <= 1e-7


COUPLED = [
    "double_butterfly", "double_butterfly_symmetric", "gim_fig11", "gim_fig13c", "plantigrade", "platform_3rpr",
    "platform_3rrr", "stephenson_2", "stephenson_3_far", "ten_bar",
]  # fmt: skip


@pytest.mark.parametrize("name", COUPLED)
def test_plain_and_compiled_agree_bit_for_bit(name):
    assert run(read(name), 12, jit="off").text == run(read(name), 12, jit="on").text


@pytest.mark.parametrize("name", ["gim_fig11", "gim_fig13b", "platform_3rrr", "whitworth"])
def test_plain_and_compiled_sweeps_agree_bit_for_bit(name):
    plain, compiled = (run(read(name), 6, **{**GIM, "jit": jit}) for jit in ("off", "on"))
    assert plain.text == compiled.text


# --- straight through flat positions ---------------------------------------------------------------------


def four_bar(crank, coupler, follower, frame):
    links = {"crank": (["O2", "A"], crank), "coupler": (["A", "B"], coupler), "follower": (["O4", "B"], follower)}
    return {
        "nodes": {"O2": 0, "O4": frame, "A": None, "B": None}, "ground": ["O2", "O4"], "elements": {},
        "links": {name: {"nodes": nodes, "length": length} for name, (nodes, length) in links.items()},
    }  # fmt: skip


def third_crank():
    spec = {"nodes": {"O2": 0, "E": 1, "D": 2, "A": None, "F": None, "C": None}, "ground": ["O2", "E", "D"]}
    spec["links"] = {o + a: {"nodes": [o, a], "length": 1} for o, a in (("O2", "A"), ("E", "F"), ("D", "C"))}
    spec["elements"] = {"bar": {"nodes": ["A", "F", "C"], "shape": {"A": [0, 0], "F": [1, 0], "C": [2, 0]}}}
    return spec


def about(a, b, p):
    """Mirror p in the line a-b."""
    return a + unit(b - a) ** 2 * np.conj(p - a)


FLAT = {
    "parallelogram": (four_bar(1, 3, 1, 3), lambda t: {"B": 3 + ray(t)}),
    "long parallelogram": (four_bar(3, 1, 3, 1), lambda t: {"B": 1 + 3 * ray(t)}),
    "antiparallelogram": (four_bar(1, 3, 1, 3), lambda t: {"B": about(ray(t), 3, 3 + ray(t))}),
    "long antiparallelogram": (four_bar(3, 1, 3, 1), lambda t: {"B": about(3 * ray(t), 1, 1 + 3 * ray(t))}),
    "rhombus": (four_bar(1, 1, 1, 1), lambda t: {"B": 1 + ray(t)}),
    "folded rhombus": (four_bar(1, 1, 1, 1), lambda t: {"B": 0 * ray(t)}),
    "kite": (four_bar(1, 1, 3, 3), lambda t: {"B": about(ray(t), 3, 0j)}),
    "folded kite": (four_bar(1, 1, 3, 3), lambda t: {"B": 0 * ray(t)}),
    "kite about its axis": (
        four_bar(1, 3, 3, 1), lambda t: {"B": ray(t / 2) * (ray(t / 2).real + np.sqrt(9 - ray(t / 2).imag ** 2))},
    ),
    "third crank": (third_crank(), lambda t: {"F": 1 + ray(t), "C": 2 + ray(t)}),
}  # fmt: skip
"""Specification and places of the driven nodes at the crank angle t [deg]; A is the crank's pin."""


def flat(linkage, start, sense):
    spec, places = FLAT[linkage]
    spec = copy.deepcopy(spec)
    crank = next(iter(spec["links"].values()))["length"]
    drawn = {"A": crank * ray(50.0), **places(50.0)}
    spec["nodes"] = {n: complex(drawn[n] if z is None else z) for n, z in spec["nodes"].items()}
    spec["nodes"] = {n: [z.real, z.imag] for n, z in spec["nodes"].items()}
    law = {"from": start, "to": start + sense * 360}
    spec["actuators"] = {"motor": {"type": "rotary", "pivot": "O2", "arm": "A", "law": law}}
    return spec, lambda t: {"A": crank * ray(t), **places(t)}


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("start", [20.0, 65.5, 90.0, 20.0 + 1e-6, 20.0 - 1e-9, 20.0 + 1e-12])
@pytest.mark.parametrize("steps", [360, 359, 50, 7, 4, 6, 8])
@pytest.mark.parametrize("linkage", FLAT)
def test_straight_through_the_flat_positions(linkage, start, sense, steps):
    spec, places = flat(linkage, start, sense)
    m = run(spec, steps)
    assert set(m.status) == {"ok"}
    for node, z in places(m.value["motor"]).items():
        assert np.max(abs(m.z[node] - z)) <= 1e-9 * size(spec)
    assert np.max(worst(spec, m)) <= 1e-10


@pytest.mark.parametrize("linkage", FLAT)
def test_a_start_in_the_flat_position_is_right_as_far_as_it_goes(linkage):
    """Drawn elsewhere, so that the branch is known; whether it goes on from there is left open."""
    spec, places = flat(linkage, 0.0, 1)
    m = run(spec, 36)
    good = np.array(m.status) == "ok"
    for node, z in places(m.value["motor"]).items():
        assert np.max(abs(m.z[node] - z)[good], initial=0.0) <= 1e-9 * size(spec)


# --- the tests themselves --------------------------------------------------------------------------------


def test_a_wrong_row_is_noticed():
    name = "crank_rocker"
    m = run(read(name))
    assert np.max(worst(read(name), m)) <= 1e-10
    m.z["B"] = m.z["B"] + 1e-7
    assert np.max(worst(read(name), m)) > 1e-10


def test_jumps_are_noticed():
    """The expected places are continuous, and other branches are far from them."""
    t = np.linspace(20, 380, 3601)
    for linkage, (_, places) in FLAT.items():
        for z in places(t).values():
            assert max(abs(b - a) for a, b in pairwise(z)) < 0.02, linkage
