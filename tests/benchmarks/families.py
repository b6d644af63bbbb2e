"""CPU time for a design of 72 steps, compared with loops written by hand and with pylinkage's batch of designs.

Run: python tests/benchmarks/families.py [--designs 10000] [--repeats 5] [--largest 1000000]

All programs run alternately in one process on one thread. `gim` starts each design, keeps its branch, checks every row
against all constraints and gives it a status; the loops by hand and pylinkage do nothing of this. "other" is the number
of designs that differ from `gim` by more than 1e-6 of the size in a row that it has solved. The second table shows
designs that fail (lengths varied by 70 %), the third one the cost by the number of designs and of threads, and the
memory of the process.
"""

from __future__ import annotations

import argparse
import os
import resource
import time
from collections.abc import Callable

from machine import MODELS, Row, interleaved, keep, show  # isort: skip - first: one thread
import families_by_hand as by_hand
import numpy as np
import peers

from gimcli import load
from gimcli.families import family as families
from gimcli.families.family import Family
from gimcli.kernels import jit
from gimcli.mechanism import FloatArray
from gimcli.status import Status

STEPS = 72
CHUNK = 4096
SPREAD = 0.02
CASES: dict[str, tuple[tuple[str, ...], Callable[[FloatArray, int], FloatArray], tuple[str, ...], float]] = {
    "crank_rocker": (("crank", "coupler", "rocker"), by_hand.crank_rocker, ("A", "B"), 10.0),
    "jansen": (("m", "j", "k", "c", "f", "g"), by_hand.jansen, ("J1", "J2", "J3", "J4", "J5"), 13.0),
    "stephenson_3_far": (("CD", "EF", "AB", "FG"), by_hand.stephenson, ("C", "E", "B"), 45.0),
    "platform_3rrr": (
        ("distal_0", "distal_1", "distal_2", "proximal_0", "proximal_1", "proximal_2"), by_hand.platform,
        ("C0", "C1", "C2"), 45.0,
    ),
}  # fmt: skip
"""Links whose lengths vary, the loop by hand, its nodes, and the CPU time that `gim` may take [us]."""
PEER = {"crank_rocker": (0, 1, 2), "jansen": (0, 1, 5, 6, 7, 8)}
"""The entries of pylinkage's constraints for the lengths."""


def family_of(name: str) -> Family:
    """Return the family of a shipped model."""
    return Family(load(MODELS / f"{name}.yaml"), [f"{link}.length" for link in CASES[name][0]])


def varied(family: Family, count: int, spread: float, seed: int = 1) -> FloatArray:
    """Return random designs (count, dimensions)."""
    return np.asarray(
        family.nominal * (1.0 + spread * np.random.default_rng(seed).uniform(-1, 1, (count, len(family.names))))
    )


def ours(family: Family, designs: FloatArray, threads: int = 1) -> tuple[FloatArray, int]:
    """Solve designs in chunks; return the number of solved rows of each, and of designs solved one by one."""
    solved, careful = [], 0
    for begin in range(0, len(designs), CHUNK):
        found = family.solve(designs[begin : begin + CHUNK], STEPS, threads=threads)
        solved.append(found.solved)
        careful += found.careful
    return np.concatenate(solved), careful


def pylinkage(name: str, designs: FloatArray) -> Callable[[], FloatArray] | None:
    """Return pylinkage's batch of designs; None if it cannot solve the mechanism or is not installed."""
    try:
        from pylinkage.population import Ensemble

        model, start, crank, angle = peers._simulated(peers.LINKAGES[name])
    except (peers.UnableError, ImportError):
        return None
    constraints = np.repeat([np.asarray(model.get_constraints(), dtype=float)], len(designs), axis=0)
    constraints[:, PEER[name]] = designs
    ensemble = Ensemble(model, constraints, np.repeat([start], len(designs), axis=0))
    return lambda: ensemble.simulate(STEPS, dt=angle / STEPS / crank.angular_velocity, store=False)


def differing(family: Family, name: str, designs: FloatArray, other: FloatArray, first: int) -> int:
    """Return the number of designs that differ from `gim`; other (designs, nodes, 2, rows from `first` on)."""
    found, m = family.solve(designs, STEPS), family.mechanism
    nodes = [m.nodes.index(node) for node in CASES[name][2]]
    z = m.to_file(found.z[:, nodes])[:, :, first:]
    own = other[:, : len(nodes)]
    apart = np.abs(z - (own[:, :, 0] + 1j * own[:, :, 1]))
    apart = np.where(found.good[:, None, first:], apart, 0.0)
    return int(np.sum(~(np.max(apart, axis=(1, 2)) <= 1e-6 * m.size * m.scale)))


def compare(name: str, count: int, repeats: int) -> list[Row]:
    """Return the rows of one mechanism."""
    family, hand = family_of(name), CASES[name][1]
    designs = varied(family, count, SPREAD)
    peer = pylinkage(name, designs)
    sides: dict[str, Callable[[], object]] = {
        "gim": lambda: ours(family, designs), "by hand": lambda: hand(designs, STEPS)
    }  # fmt: skip
    if peer is not None:
        sides["pylinkage, batch"] = peer
    for side in sides.values():
        side()  # compiles
    best = interleaved(sides, repeats, time.process_time)
    careful = ours(family, designs)[1]
    others = {"gim": 0, "by hand": differing(family, name, designs, hand(designs, STEPS), 0)}
    if peer is not None:
        path = np.moveaxis(np.asarray(peer()), 1, 3)  # (designs, joints, 2, rows), the first row is step 1
        others["pylinkage, batch"] = differing(family, name, designs, path[:, 2:], 1)
    return [
        {
            "mechanism": name, "program": side, "designs": count, "us a design": 1e6 * seconds / count,
            "ratio to gim": seconds / best["gim"], "goal": CASES[name][3] if side == "gim" else "",
            "careful": careful if side == "gim" else "", "other": others[side],
        }
        for side, seconds in best.items()
    ]  # fmt: skip


def failing(name: str, count: int) -> list[Row]:
    """Return the cost of designs by their status."""
    family = family_of(name)
    designs = varied(family, count, 0.7 if name == "crank_rocker" else 0.2)
    status = family.solve(designs, STEPS).status
    rows: list[Row] = []
    for code in np.unique(status).tolist():
        own = designs[status == code]
        begin = time.process_time()
        careful = ours(family, own)[1]
        each = 1e6 * (time.process_time() - begin) / len(own)
        rows.append({
            "mechanism": name, "status": Status(code).word, "designs": len(own), "us a design": each,
            "careful": careful,
        })  # fmt: skip
    return rows


def growth(name: str, largest: int) -> list[Row]:
    """Return the cost by the number of designs and threads."""
    family, rows = family_of(name), []
    count = 1000
    while count <= largest:
        designs = varied(family, count, SPREAD)
        for threads in sorted({1, os.cpu_count() or 1}):
            wall, cpu = time.perf_counter(), time.process_time()
            ours(family, designs, threads)
            wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
            rows.append({
                "mechanism": name, "designs": count, "threads": threads, "us a design": 1e6 * wall / count,
                "CPU us a design": 1e6 * cpu / count, "peak memory MB": peak,
            })  # fmt: skip
        count *= 10
    return rows


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--designs", type=int, default=10000)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--largest", type=int, default=1_000_000)
    parser.add_argument("--keep", action="store_true", help="write results/ for this machine")
    chosen = parser.parse_args()
    families.choose = lambda *_: jit.compiled
    first = [row for name in CASES for row in compare(name, chosen.designs, chosen.repeats)]
    show("CPU time of designs of 72 steps", first)
    second = [row for name in CASES for row in failing(name, chosen.designs)]
    show("Designs that fail", second)
    third = growth("crank_rocker", chosen.largest)
    show("Number of designs and threads", third)
    if chosen.keep:
        for title, rows in (("families", first), ("families-failing", second), ("families-growth", third)):
            keep(title, rows)


if __name__ == "__main__":
    main()
