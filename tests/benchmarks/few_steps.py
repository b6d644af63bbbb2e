"""CPU time for a design by the number of steps, and for a trace of a changed design against one of the same design.

Run: python tests/benchmarks/few_steps.py [--designs 4000] [--repeats 5]

All numbers of steps run alternately in one process on one thread; "ratio" is to 72 steps. The second table has
`trace(m.with_({...}), steps=36)`, its parts, and a further trace of the same mechanism.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

from machine import MODELS, Row, keep, show  # isort: skip - first: one thread
import numpy as np
from families import CASES, family_of, varied

import gimcli

STEPS = (72, 1, 5, 18, 22, 36, 42, 43, 60, 71)


def best(runs: list[Callable[[], object]], repeats: int) -> list[float]:
    """Return the least CPU time of each run [s]; the runs alternate."""
    least = [np.inf] * len(runs)
    for _ in range(repeats):
        for k, run in enumerate(runs):
            began = time.process_time()
            run()
            least[k] = min(least[k], time.process_time() - began)
    return least


def main() -> None:
    """Measure and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--designs", type=int, default=4000)
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    sweeps: list[Row] = []
    changes: list[Row] = []
    for name in CASES:
        family = family_of(name)
        designs = varied(family, given.designs, 0.02)
        runs = [lambda s=steps: family.solve(designs, s, jit="on", threads=1) for steps in STEPS]
        runs[0]()
        taken = best(runs, given.repeats)
        for steps, one in zip(STEPS, taken, strict=True):
            sweeps.append({"mechanism": name, "steps": steps, "us": one / given.designs * 1e6, "ratio": one / taken[0]})
        mechanism = gimcli.load(MODELS / f"{name}.yaml")
        values = dict(zip(family.names, (family.nominal * 1.001).tolist(), strict=True))
        changed = mechanism.with_(values)
        gimcli.trace(changed, steps=36)
        parts = best(
            [
                lambda: gimcli.trace(mechanism.with_(values), steps=36),
                lambda: mechanism.with_(values),
                lambda: gimcli.trace(changed, steps=36),
            ],
            40 * given.repeats,
        )
        changes.append(
            {"mechanism": name, "changed, traced [ms]": parts[0] * 1e3, "with_ [ms]": parts[1] * 1e3,
             "traced again [ms]": parts[2] * 1e3, "ratio": parts[0] / parts[2]}
        )  # fmt: skip
    show("a design by the number of steps", sweeps)
    show("a changed design", changes)
    keep("few_steps", sweeps)


if __name__ == "__main__":
    main()
