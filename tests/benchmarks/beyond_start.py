"""CPU time of commands beyond the start, for several source trees, run alternately; prints times and ratios.

Run: python tests/benchmarks/beyond_start.py COMMAND RUNS TREE... [-- MODEL...], where TREE is a checkout and its first
one is that to which the others are compared. Commands are as a user gives them; a command that only starts, reads the
model and solves one position (`gim solve`) is subtracted. The time is the least of the runs, after one run that fills
the caches.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from itertools import dropwhile, takewhile
from pathlib import Path

MODELS = Path(__file__).parents[2] / "models"


def cpu(tree: str, command: str, model: Path) -> float:
    """Return the CPU time of a command of a source tree [s]; infinite if the command does not apply to the model."""
    own = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    own |= {"PYTHONPATH": tree, "OPENBLAS_NUM_THREADS": "1"}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-m", "gimcli", command, str(model)], env=own, cwd="/", capture_output=True, check=False
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return used if done.returncode in (0, 1) else float("inf")


def beyond(command: str, runs: int, trees: list[str], model: Path) -> list[float]:
    """Return the CPU time of a command beyond the start for each tree [s]."""
    both = (command, "solve")
    first = [cpu(tree, one, model) for tree in trees for one in both]
    if max(first) == float("inf"):
        return []
    times = [[[cpu(tree, one, model) for one in both] for tree in trees] for _ in range(runs)]
    least = [[min(run[k][i] for run in times) for i in (0, 1)] for k in range(len(trees))]
    return [whole - start for whole, start in least]


def main() -> None:
    """Compare trees."""
    command, runs, *trees = takewhile(lambda word: word != "--", sys.argv[1:])
    names = [*dropwhile(lambda word: word != "--", sys.argv[1:])][1:] or sorted(p.stem for p in MODELS.glob("*.yaml"))
    total = [0.0] * len(trees)
    for name in names:
        found = beyond(command, int(runs), [str(Path(tree).resolve()) for tree in trees], MODELS / f"{name}.yaml")
        if found:
            total = [a + b for a, b in zip(total, found, strict=True)]
            print(f"{name:28}", *(f"{own:7.3f} s ({own / found[0]:.2f})" for own in found), flush=True)
    print(f"{'total':28}", *(f"{own:7.3f} s ({own / total[0]:.2f})" for own in total))


if __name__ == "__main__":
    main()
