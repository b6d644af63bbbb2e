"""From random starts: how often each method settles, and how many configurations it finds.

Run: python tests/benchmarks/random_starts.py [--starts 10000]

Nodes are strewn evenly over a square of twice the mechanism's size, the same starts for each method, inputs as
drawn, tolerance 1e-10. `gim` sweeps by the sequence that `gim sequence` tells; `newton` is Newton-Raphson alone
from the start given, without closed forms and restarts; `auto` is what `gim solve --start random` does. A start has
settled where the residual of the members as written says so, too. Configurations are clusters of node positions
(1e-6 of the size). The mechanisms are in general position. Counts mean nothing for two of the bundled ones that are
left out: a folded Peaucellier linkage moves by itself, and sweeps turn a Scotch yoke, held by a true prismatic pair,
end for end, which the residual does not see.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from machine import MODELS, RESULTS, Row, keep, show  # isort: skip - first: one thread
import numpy as np

from gimcli import load
from gimcli.gim.sweeper import Sweeper
from gimcli.kernels import jit
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembler
from gimcli.motion.start import random_guess
from gimcli.positions.block import NEW, RowBlock
from gimcli.positions.newton import Packed, Run
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import allowed, residual

NAMES = (
    "crank_rocker", "slider_crank", "whitworth", "jansen", "klann", "stephenson_1", "stephenson_2",
    "stephenson_3_far", "gim_fig11", "platform_3rrr", "platform_3rpr", "double_butterfly", "ten_bar",
)  # fmt: skip
METHODS = ("gim", "newton", "auto")
TOLERANCE = 1e-10
APART = 1e-6
"""Positions farther apart than this, relative to the size, are different configurations."""

PORTION = 250
"""Starts that a process is given at a time."""

Solver = Callable[[FloatArray, ComplexArray], tuple[bool, ComplexArray]]


class Alone(Assembler):
    """Newton-Raphson from the start given and from nowhere else."""

    def _starts(self, packed: Packed, block: RowBlock, drawn: RowBlock) -> Iterator[ComplexArray]:
        yield (drawn.x[:, NEW] + 1j * drawn.y[:, NEW])[list(packed.group.base)]


def solver(mechanism: Mechanism, method: str, run: Run) -> Solver:
    """Return a function of inputs and guess that tells whether a method settled, and where."""
    if method == "gim":
        sweeper = Sweeper(mechanism, Options(method="gim", tolerance=TOLERANCE), run)

        def swept(inputs: FloatArray, guess: ComplexArray) -> tuple[bool, ComplexArray]:
            done = sweeper.settle(inputs, guess)
            return done.good, done.z

        return swept
    plan = make_plan(mechanism, closed_forms=method == "auto")
    kind = Assembler(mechanism, plan, run, TOLERANCE, anywhere=True)
    assembler = kind if method == "auto" else Alone(mechanism, plan, run, TOLERANCE)

    def assembled(inputs: FloatArray, guess: ComplexArray) -> tuple[bool, ComplexArray]:
        found = assembler.assemble(inputs, guess)
        return found.status is Status.OK, found.row.x + 1j * found.row.y

    return assembled


@dataclass(frozen=True)
class Found:
    """What some starts gave."""

    settled: int
    z: ComplexArray  # (nodes, settled)
    seconds: float

    def configurations(self, size: float) -> int:
        """Return the number of clusters."""
        left, count = self.z, 0
        while left.shape[1]:
            left = left[:, np.max(np.abs(left - left[:, :1]), axis=0) > APART * size]
            count += 1
        return count


def attempt(mechanism: Mechanism, method: str, seeds: range, run: Run) -> Found:
    """Solve from some random starts; what the residual does not confirm has not settled."""
    inputs, solve = mechanism.drawn_inputs, solver(mechanism, method, run)
    solve(inputs, random_guess(mechanism, seeds[0]))  # compiled, and its sequences searched
    begin = time.perf_counter()
    done = [solve(inputs, random_guess(mechanism, seed)) for seed in seeds]
    seconds = time.perf_counter() - begin
    z = np.array([position for _, position in done]).T
    error = residual(mechanism, z, np.repeat(inputs[:, None], len(seeds), axis=1)).total
    good = np.array([fine for fine, _ in done]) & (error <= allowed(mechanism, TOLERANCE, method == "gim"))
    return Found(int(good.sum()), z[:, good], seconds)


def portion(job: tuple[str, str, range]) -> Found:
    """Do one process's share."""
    name, method, seeds = job
    return attempt(load(MODELS / f"{name}.yaml"), method, seeds, jit.compiled)


def measure(name: str, method: str, starts: int, together: Callable[..., Iterator[Found]]) -> Row:
    """Return what one method gave on one mechanism."""
    jobs = [(name, method, range(k, min(k + PORTION, starts))) for k in range(0, starts, PORTION)]
    parts = list(together(portion, jobs))
    found = Found(
        sum(p.settled for p in parts), np.concatenate([p.z for p in parts], axis=1), sum(p.seconds for p in parts)
    )
    size = load(MODELS / f"{name}.yaml").size
    return {
        "mechanism": name, "method": method, "starts": starts, "settled": found.settled,
        "settled %": round(100.0 * found.settled / starts, 2), "configurations": found.configurations(size),
        "ms a start": round(found.seconds / starts * 1e3, 4),
    }  # fmt: skip


def shortfalls(rows: list[Row]) -> list[str]:
    """Tell where `auto` settles less often, or finds fewer configurations, than another method."""
    by = {(r["mechanism"], r["method"]): r for r in rows}
    told = []
    for (name, method), other in by.items():
        auto = by[name, "auto"]
        for what in ("settled", "configurations"):
            if int(str(auto[what])) < int(str(other[what])):
                told.append(f"{name}: auto {what} {auto[what]}, {method} {other[what]}")
    return told


def main(arguments: list[str] | None = None) -> None:
    """Compare the methods on all mechanisms."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--starts", type=int, default=10_000)
    parser.add_argument("--models", nargs="+", default=NAMES)
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    parser.add_argument("--out", type=Path, default=RESULTS)
    chosen = parser.parse_args(arguments)
    rows = []
    with multiprocessing.Pool(chosen.processes) as pool:
        for name in chosen.models:
            part = [measure(name, method, chosen.starts, pool.imap) for method in METHODS]
            show(name, [{k: v for k, v in r.items() if k != "mechanism"} for r in part])
            rows += part
    for line in shortfalls(rows) or ["auto is at least as good as either everywhere"]:
        print(line)
    print(f"\nkept in {keep('random_starts', rows, chosen.out)}")


if __name__ == "__main__":
    main()
