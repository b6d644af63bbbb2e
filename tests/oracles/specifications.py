"""Model files with an own reader, motions from the text of CSV files, their errors, and other frames of reference."""

from __future__ import annotations

import copy
import csv
import json
import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import yaml
from bundled import EXPLICIT, FILES

from gimcli import load
from gimcli.motion.motion import trace
from gimcli.output.csv import write_csv
from gimcli.positions.options import Options
from gimcli.quantities.motion_table import motion_table, usual

NAMES = [*(path.stem for path in EXPLICIT), "parallel_guide"]
STEPS = 24
LOADER = yaml.CBaseLoader if yaml.__with_libyaml__ else yaml.BaseLoader

# --- an own reader and writer ----------------------------------------------------------------------------


def numbers(value):
    """Convert texts of numbers and of true and false to values, at any depth."""
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
    if name == "parallel_guide":
        spec = copy.deepcopy(read("slider_crank"))
        del spec["nodes"]["G"]
        spec["nodes"]["H"] = [5.0, -0.4]
        spec["ground"] = ["O", "H"]
        spec["prismatic"] = {"slide": {"node": "B", "guide": ["H", "O"], "offset": -0.9}}
        return spec
    spec = numbers(yaml.load((FILES[0].parent / f"{name}.yaml").read_text(), Loader=LOADER))
    assert spec["units"]["angle"] == "deg"
    if not all(isinstance(xy, list) for xy in spec["nodes"].values()):  # nodes without coordinates in the file
        placed = load(FILES[0].parent / f"{name}.yaml")
        drawn = {node: [z.real, z.imag] for node, z in zip(placed.nodes, placed.to_file(placed.drawn), strict=True)}
        spec["nodes"] = {node: xy if isinstance(xy, list) else drawn[node] for node, xy in spec["nodes"].items()}
    for actuator in spec["actuators"].values():  # what only simulations use
        for key in ("free", "start", "speed", "effort"):
            actuator.pop(key, None)
    for kind in ("links", "elements"):
        parts = spec.setdefault(kind, {})
        for part, value in parts.items():
            parts[part] = value if isinstance(value, dict) else {"nodes": value}
    return {part: value for part, value in spec.items() if part != "trace"}


@dataclass
class Run:
    """The content of a CSV file, nodes as complex numbers, and its motion."""

    z: dict
    value: dict
    status: list
    residual: np.ndarray
    text: str
    motion: object


def run(spec, steps=STEPS, **options):
    """Trace a specification with all nodes and points, through a model file and a CSV file."""
    with tempfile.TemporaryDirectory() as folder:
        path, out = Path(folder) / "model.yaml", Path(folder) / "out.csv"
        path.write_text(json.dumps(spec))
        motion = trace(load(path), steps, Options(**{"jit": "on", **options}))
        names = (*spec["nodes"], *spec.get("points", {}))
        write_csv(motion_table(motion, usual(motion.mechanism, names)), out)
        text = out.read_text()
    head, *rows = csv.reader(text.splitlines())
    column = dict(zip(head, zip(*rows, strict=True), strict=True))
    floats = {name: np.array([float(cell or "nan") for cell in cells]) for name, cells in column.items()
              if not name.endswith("status")}  # fmt: skip
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
    """Return the largest distance of nodes between two runs, relative to the size."""
    return max(np.max(abs(z[rows] - expected[name])) for name, z in found.items()) / size(spec)


# --- the residual from the CSV alone ---------------------------------------------------------------------


def errors(spec, m):
    """Yield the errors of all constraints of a file: relative lengths and angles [rad] over the rows."""
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
        if "pivot" in drive:
            o = m.z[drive["pivot"]]
            reference = m.z[drive["reference"]] - o if "reference" in drive else 1
            yield np.angle((m.z[drive["arm"]] - o) / reference / ray(m.value[name]))
        elif "nodes" in drive:
            a, b = (m.z[node] for node in drive["nodes"])
            yield abs(b - a) / m.value[name] - 1
        else:
            u, v = (m.z[node] for node in drive["guide"])
            yield (((m.z[drive["node"]] - u) / unit(v - u)).real - m.value[name]) / big
    ground = spec["ground"]
    for name in ground if isinstance(ground, list) else spec["elements"][ground["member"]]["nodes"]:
        yield abs(m.z[name] - nodes[name]) / big


def worst(spec, m):
    """Return the largest error of each row."""
    with np.errstate(invalid="ignore"):
        return np.max([abs(error) for error in errors(spec, m)], axis=0)


# --- other frames and orders --------------------------------------------------------------------------------


def moved(spec, turn=0.0, shift=0j, scale=1.0, mirror=False):
    """Return a specification in another frame of reference, and the map of its points."""
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
        rotary, law = "pivot" in drive, drive.get("law", {})
        if "phase" in drive:
            assert rotary
            assert "reference" in drive
            drive["phase"] = side * drive["phase"] - drive["ratio"] * turn  # the leader's input changes by `turn`
        assert set(law) <= {"from", "to", "by", "profile"}
        assert isinstance(law.get("profile", ""), str)
        for key in {"from", "to", "by"} & set(law):
            start = turn if key != "by" and "reference" not in drive else 0.0
            law[key] = law[key] * side + start if rotary else law[key] * scale
    for gear in spec.get("gears", {}).values():
        gear |= {"radii": [scale * radius for radius in gear["radii"]]} if "radii" in gear else {}
        gear |= {"pitch": scale * gear["pitch"]} if "pitch" in gear else {}
    return spec, there


def shuffled(spec, seed):
    """Return a specification in which everything that has no fixed order is in random order."""
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


# --- other linkages --------------------------------------------------------------------------------------


def four_bar(crank, coupler, follower, frame):
    links = {"crank": (["O2", "A"], crank), "coupler": (["A", "B"], coupler), "follower": (["O4", "B"], follower)}
    return {
        "nodes": {"O2": 0, "O4": frame, "A": None, "B": None}, "ground": ["O2", "O4"], "elements": {},
        "links": {name: {"nodes": nodes, "length": length} for name, (nodes, length) in links.items()},
    }  # fmt: skip
