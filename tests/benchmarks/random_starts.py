"""Random starts: how often each method converges, and how many configurations it finds.

Run: python tests/benchmarks/random_starts.py [--starts 10000]

Nodes are random in a square of twice the mechanism's size, with the same starts for each method, the drawn inputs and
tolerance 1e-10. `gim` sweeps by the sequence of `gim sequence`; `newton` is Newton-Raphson from the given start,
without closed forms and restarts; `auto` is the method of `gim solve --start random`. A start has converged if the
independent residual confirms it. Configurations are clusters of node positions (1e-6 of the size). Two shipped models
are left out, because their counts have no meaning: a folded Peaucellier linkage has additional freedoms, and sweeps can
reverse the true prismatic pair of the Scotch yoke, which the residual does not detect.
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

from gimcli import Mechanism, load
from gimcli.gim.sweeper import Sweeper
from gimcli.kernels import jit
from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.motion.assemble import Assembler
from gimcli.motion.solve import random_guess
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
"""Number of starts that a process solves in one job."""

Solver = Callable[[FloatArray, ComplexArray], tuple[bool, ComplexArray]]


class Alone(Assembler):
    """Newton-Raphson from the given start only."""

    def _starts(self, packed: Packed, block: RowBlock, drawn: RowBlock) -> Iterator[ComplexArray]:
        yield (drawn.x[:, NEW] + 1j * drawn.y[:, NEW])[list(packed.group.base)]


def solver(mechanism: Mechanism, method: str, run: Run) -> Solver:
    """Return a function of inputs and guess that returns whether a method converged, and the position."""
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
    """The results of some starts."""

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
    """Solve from some random starts; the residual must confirm a position."""
    inputs, solve = mechanism.drawn_inputs, solver(mechanism, method, run)
    solve(inputs, random_guess(mechanism, seeds[0]))  # compile and search sequences before the timing
    begin = time.perf_counter()
    done = [solve(inputs, random_guess(mechanism, seed)) for seed in seeds]
    seconds = time.perf_counter() - begin
    z = np.array([position for _, position in done]).T
    error = residual(mechanism, z, np.repeat(inputs[:, None], len(seeds), axis=1)).total
    good = np.array([fine for fine, _ in done]) & (error <= allowed(mechanism, TOLERANCE, method == "gim"))
    return Found(int(good.sum()), z[:, good], seconds)


def portion(job: tuple[str, str, range]) -> Found:
    """Solve the starts of one job."""
    name, method, seeds = job
    return attempt(load(MODELS / f"{name}.yaml"), method, seeds, jit.compiled)


def measure(name: str, method: str, starts: int, together: Callable[..., Iterator[Found]]) -> Row:
    """Return the row of one method and one mechanism."""
    jobs = [(name, method, range(k, min(k + PORTION, starts))) for k in range(0, starts, PORTION)]
    parts = list(together(portion, jobs))
    found = Found(
        sum(p.settled for p in parts), np.concatenate([p.z for p in parts], axis=1), sum(p.seconds for p in parts)
    )
    size = load(MODELS / f"{name}.yaml").size
    return {
        "mechanism": name, "method": method, "starts": starts, "settled": found.settled,
        "settled %": round(100.0 * found.settled / starts, 2), "configurations": found.configurations(size),
        "ms per start": round(found.seconds / starts * 1e3, 4),
    }  # fmt: skip


def shortfalls(rows: list[Row]) -> list[str]:
    """Return where `auto` converges less often, or finds fewer configurations, than another method."""
    by = {(r["mechanism"], r["method"]): r for r in rows}
    found = []
    for (name, method), other in by.items():
        auto = by[name, "auto"]
        for what in ("settled", "configurations"):
            if int(str(auto[what])) < int(str(other[what])):
                found.append(f"{name}: auto {what} {auto[what]}, {method} {other[what]}")
    return found


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
    print(f"\nwritten to {keep('random_starts', rows, chosen.out)}")


if __name__ == "__main__":
    main()
