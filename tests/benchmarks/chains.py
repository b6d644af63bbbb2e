"""Planning time, time per position and memory of chains of N stages or windows, with fitted exponents.

Run: python tests/benchmarks/chains.py [--steps 1000] [--largest 1000] [--limit 60]

The height of a scissor lift of N stages is N sqrt(L^2 - w^2). In a row of N four-bar windows (benchmark A02 of the
multibody library, bars of 1 m) every upper node is its pivot moved by the same vector. N increases until planning would
take longer than the limit (extrapolated from the last two sizes); sizes that are left out are printed.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from unittest.mock import patch

from machine import RESULTS, Row, interleaved, keep, show  # isort: skip - first: one thread
import numpy as np
import yaml

from gimcli import Mechanism, load
from gimcli.motion.motion import Motion, trace
from gimcli.structure.plan import make_plan
from gimcli.structure.steps import Plan

SIZES = (1, 3, 10, 30, 100, 300, 1000)
AGREEMENT = 1e-9
"""Largest difference from the closed form, relative to the height or length of the chain."""

Data = dict[str, object]


def scissor(n: int) -> Data:
    """Return the model of a scissor of n stages: bars 2, drawn at width 1.2, driven from 1.8 to 0.4."""
    nodes = {"L0": [0, 0], "X": [2, 0], "R0": [1.2, 0]}
    elements = {}
    for k in range(1, n + 1):
        nodes |= {f"C{k}": [0.6, 1.6 * k - 0.8], f"L{k}": [0, 1.6 * k], f"R{k}": [1.2, 1.6 * k]}
        for side, low, high in (("a", "L", "R"), ("b", "R", "L")):
            three = [f"{low}{k - 1}", f"C{k}", f"{high}{k}"]
            elements[f"{side}{k}"] = {"nodes": three, "shape": dict(zip(three, ([0, 0], [1, 0], [2, 0]), strict=True))}
    drive = {"type": "linear", "node": "R0", "guide": ["L0", "X"], "law": {"from": 1.8, "to": 0.4}}
    return {
        "name": f"scissor of {n}", "units": {"length": "unit"}, "nodes": nodes, "ground": ["L0", "X"],
        "elements": elements, "prismatic": {"roller": {"node": "R0", "guide": ["L0", "X"]}},
        "actuators": {"ram": drive}, "trace": [f"L{n}"],
    }  # fmt: skip


def windows(n: int) -> Data:
    """Return the model of n four-bar windows: bars of 1 m, driven from 0.2 to 2.9 rad."""
    nodes = {f"A{k}": [k, 0] for k in range(n + 1)} | {f"B{k}": [k, 1] for k in range(n + 1)}
    links = {f"v{k}": {"nodes": [f"A{k}", f"B{k}"], "length": 1} for k in range(n + 1)}
    links |= {f"h{k}": {"nodes": [f"B{k}", f"B{k + 1}"], "length": 1} for k in range(n)}
    drive = {"type": "rotary", "pivot": "A0", "arm": "B0", "law": {"from": 0.2, "to": 2.9}}
    return {
        "name": f"{n} windows", "units": {"angle": "rad"}, "nodes": nodes, "ground": [f"A{k}" for k in range(n + 1)],
        "links": links, "actuators": {"motor": drive}, "trace": [f"B{n}"],
    }  # fmt: skip


def scissor_miss(motion: Motion, n: int) -> float:
    """Return the error of the height, relative to the height of n bars."""
    high = motion.mechanism.to_file(motion.z[motion.mechanism.nodes.index(f"L{n}")]).imag
    width = motion.inputs[0] * motion.mechanism.scale
    return float(np.max(np.abs(high - n * np.sqrt(4.0 - width**2))) / (2.0 * n))


def windows_miss(motion: Motion, n: int) -> float:
    """Return the largest error of the upper nodes, relative to the length; each is its pivot moved by the crank."""
    places = motion.mechanism.to_file(motion.z)
    moved = np.stack([places[motion.mechanism.nodes.index(f"B{k}")] - k for k in range(n + 1)])
    return float(np.max(np.abs(moved - np.exp(1j * motion.inputs[0]))) / max(n, 1))


@dataclass(frozen=True)
class Chain:
    """A family of models and the closed form of its motion."""

    model: Callable[[int], Data]
    miss: Callable[[Motion, int], float]


CHAINS = {"scissor": Chain(scissor, scissor_miss), "windows": Chain(windows, windows_miss)}


def loaded(data: Data) -> tuple[Mechanism, float]:
    """Return the mechanism of a model's data and the time it took to load [s]."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.yaml"
        path.write_text(yaml.safe_dump(data, sort_keys=False))
        begin = time.perf_counter()
        mechanism = load(path)
        return mechanism, time.perf_counter() - begin


def measure(name: str, n: int, steps: int, repeats: int) -> Row:
    """Return the row of one chain; its motion must agree with the closed form."""
    mechanism, load_time = loaded(CHAINS[name].model(n))
    begin = time.perf_counter()
    plan = make_plan(mechanism)
    planning = time.perf_counter() - begin
    if planning < 1.0:
        planning = min(planning, interleaved({"plan": lambda: make_plan(replace(mechanism))}, repeats)["plan"])
    begin = time.perf_counter()
    motion = trace(replace(mechanism), steps)  # a copy, for which no plan is stored
    call, miss = time.perf_counter() - begin, CHAINS[name].miss(motion, n)
    if not (motion.solved == steps + 1 and miss <= AGREEMENT):
        raise SystemExit(f"{name} of {n}: {motion.solved} of {steps + 1} rows solved, {miss:.1e} off the closed form")
    return {
        "chain": name, "n": n, "nodes": len(mechanism.nodes), "load s": round(load_time, 4),
        "plan s": round(planning, 6), "ns per position": round(marginal(mechanism, plan, n, steps, repeats), 1),
        "call s": round(call, 4), "MB": round(memory(mechanism, plan, steps), 3), "miss": float(f"{miss:.1e}"),
    }  # fmt: skip


def planned(mechanism: Mechanism, plan: Plan, steps: int) -> Motion:
    """Trace with an existing plan: planning has its own column."""
    with patch("gimcli.motion.motion.make_plan", lambda *_, **__: plan):
        return trace(mechanism, steps)


def marginal(mechanism: Mechanism, plan: Plan, n: int, steps: int, repeats: int) -> float:
    """Return the time per position [ns]; short chains get more positions."""
    few = max(steps, 100 * steps // n)
    sides = {k * few: lambda k=k: planned(mechanism, plan, k * few) for k in (1, 2)}
    best = interleaved(sides, repeats)
    return (best[2 * few] - best[few]) / few * 1e9


def memory(mechanism: Mechanism, plan: Plan, steps: int) -> float:
    """Return the peak memory of allocations during a motion [MB]."""
    tracemalloc.start()
    planned(mechanism, plan, steps)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def exponent(rows: list[Row], column: str) -> float:
    """Return the slope of a column over n on logarithmic axes, from n = 10 on."""
    points = [(float(str(r["n"])), float(str(r[column]))) for r in rows]
    points = [(n, v) for n, v in points if n >= 10 and v > 0.0]
    if len(points) < 2:
        return math.nan
    return float(np.polyfit(*np.log(np.array(points)).T, 1)[0])


def extrapolated(rows: list[Row], n: int) -> float:
    """Return the expected planning time [s] at n, extrapolated from the last two sizes."""
    if len(rows) < 2:
        return 0.0
    (a, s), (b, t) = ((float(str(r["n"])), float(str(r["plan s"]))) for r in rows[-2:])
    return t * (n / b) ** max(math.log(t / s) / math.log(b / a), 0.0)


def family(name: str, chosen: argparse.Namespace) -> list[Row]:
    """Return the rows of one chain, up to the size that the limit allows."""
    rows: list[Row] = []
    for n in (n for n in SIZES if n <= chosen.largest):
        expected = extrapolated(rows, n)
        if expected > chosen.limit:
            print(f"{name} of {n}: left out, planning would take about {expected:.0f} s")
            break
        rows.append(measure(name, n, chosen.steps, chosen.repeats))
    return rows


def main(arguments: list[str] | None = None) -> None:
    """Measure both chains."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--largest", type=int, default=1000)
    parser.add_argument("--limit", type=float, default=60.0, help="seconds of planning")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--out", type=Path, default=RESULTS)
    chosen = parser.parse_args(arguments)
    every = []
    for name in CHAINS:
        rows = family(name, chosen)
        show(name, [{k: v for k, v in r.items() if k != "chain"} for r in rows])
        slopes = ", ".join(f"{c} ~ n^{exponent(rows, c):.2f}" for c in ("load s", "plan s", "ns per position", "MB"))
        print(f"from n = 10 on: {slopes}")
        every += rows
    print(f"\nwritten to {keep('chains', every, chosen.out)}")


if __name__ == "__main__":
    main()
