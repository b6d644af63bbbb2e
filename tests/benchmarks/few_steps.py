"""CPU time for a design by the number of steps, and for a trace of a changed design against one of the same design.

Run: python tests/benchmarks/few_steps.py [--designs 4000] [--repeats 5]

All numbers of steps run alternately in one process on one thread; "ratio" is to 72 steps. The second table has
`trace(m.with_({...}), steps=36)`, its parts, and a further trace of the same mechanism.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from functools import partial

from machine import MODELS, Row, interleaved, keep, show  # isort: skip - first: one thread
from families import CASES, family_of, varied

import gimcli

STEPS = (72, 1, 5, 18, 22, 36, 42, 43, 60, 71)


def best(runs: list[Callable[[], object]], repeats: int) -> list[float]:
    """Return the least CPU time of each run [s]; the runs alternate."""
    found = interleaved({str(k): run for k, run in enumerate(runs)}, repeats, time.process_time)
    return [found[str(k)] for k in range(len(runs))]


def measured(name: str, designs: int, repeats: int) -> tuple[list[Row], Row]:
    """Return the rows of a mechanism in both tables."""
    family = family_of(name)
    table = varied(family, designs, 0.02)
    runs = [partial(family.solve, table, steps, jit="on", threads=1) for steps in STEPS]
    runs[0]()
    taken = best(runs, repeats)
    sweeps: list[Row] = [
        {"mechanism": name, "steps": steps, "us": one / designs * 1e6, "ratio": one / taken[0]}
        for steps, one in zip(STEPS, taken, strict=True)
    ]
    mechanism = gimcli.load(MODELS / f"{name}.yaml")
    values = dict(zip(family.names, (family.nominal * 1.001).tolist(), strict=True))
    again = mechanism.with_(values)
    gimcli.trace(again, steps=36)
    whole, change, trace = best(
        [
            lambda: gimcli.trace(mechanism.with_(values), steps=36),
            lambda: mechanism.with_(values),
            lambda: gimcli.trace(again, steps=36),
        ],
        40 * repeats,
    )
    ms = {"changed, traced [ms]": whole * 1e3, "with_ [ms]": change * 1e3, "traced again [ms]": trace * 1e3}
    return sweeps, {"mechanism": name, **ms, "ratio": whole / trace}


def main() -> None:
    """Measure and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--designs", type=int, default=4000)
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    found = [measured(name, given.designs, given.repeats) for name in CASES]
    sweeps = [row for rows, _ in found for row in rows]
    show("a design by the number of steps", sweeps)
    show("a changed design", [row for _, row in found])
    keep("few_steps", sweeps)


if __name__ == "__main__":
    main()
