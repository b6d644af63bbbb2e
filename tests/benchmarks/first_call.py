"""The first call on a machine: a small job must not compile; a large job compiles once, and prints that it does.

Run: python tests/benchmarks/first_call.py [--runs 5] [--steps 100000]

The cache is an empty folder. Whole processes are timed alternately with the necessary imports; the best run counts.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from machine import MODELS, RESULTS, Row, interleaved, keep, show  # isort: skip - first: one thread

IMPORTS = "import numpy, typer, pydantic, yaml; from matplotlib.figure import Figure"
GIM = "from gimcli.cli import main; main()"
SMALL, LARGE = "crank_rocker", "platform_3rrr"


def child(folder: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run Python in a child process with its cache in a folder."""
    environment = os.environ | {"XDG_CACHE_HOME": folder}
    return subprocess.run([sys.executable, *arguments], check=True, capture_output=True, text=True, env=environment)


def trace(folder: str, model: str, steps: int, *options: str) -> subprocess.CompletedProcess[str]:
    """Trace a shipped model in a child process; results and cache are in a folder."""
    path = str(MODELS / f"{model}.yaml")
    return child(folder, *options, "-c", GIM, "trace", path, "--steps", str(steps), "--out", folder)


def machine_code(folder: str) -> int:
    """Return the number of compiled kernels in a folder."""
    return sum(1 for _ in Path(folder).rglob("*.nbc"))


def small(runs: int) -> list[Row]:
    """Compare 360 steps of a four-bar, with an empty cache, with the necessary imports; it must not compile."""
    with tempfile.TemporaryDirectory() as folder:
        imported = trace(folder, SMALL, 360, "-X", "importtime").stderr
        if "numba" in imported or machine_code(folder):
            raise SystemExit("360 steps of a four-bar import or run a compiler")
        sides = {"trace": lambda: trace(folder, SMALL, 360), "imports": lambda: child(folder, "-c", IMPORTS)}
        best = interleaved(sides, runs)
    ratio = round(best["trace"] / best["imports"], 2)
    return [
        {"what": "bare imports, picture included", "s": round(best["imports"], 3), "ratio": 1.0, "message": ""},
        {"what": f"first trace of {SMALL}, 360 steps", "s": round(best["trace"], 3), "ratio": ratio, "message": ""},
    ]


def large(steps: int, imports: float) -> list[Row]:
    """Time a large job twice; only the first call must print that it compiles."""
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        for call in ("first", "second"):
            begin = time.perf_counter()
            lines = trace(folder, LARGE, steps).stderr.strip().splitlines()
            seconds, notices = time.perf_counter() - begin, [line.strip() for line in lines if "compil" in line]
            if bool(notices) != (call == "first") or not machine_code(folder):
                raise SystemExit(f"the {call} call of {LARGE} with {steps} steps printed about compiling: {notices}")
            what = f"{call} trace of {LARGE}, {steps} steps"
            ratio = round(seconds / imports, 2)
            rows.append({"what": what, "s": round(seconds, 3), "ratio": ratio, "message": "".join(notices[:1])})
    return rows


def main(arguments: list[str] | None = None) -> None:
    """Time first calls."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--steps", type=int, default=100_000, help="of the large job; 0 leaves it out")
    parser.add_argument("--out", type=Path, default=RESULTS)
    chosen = parser.parse_args(arguments)
    rows = small(chosen.runs)
    if chosen.steps:
        rows += large(chosen.steps, float(str(rows[0]["s"])))
    show("whole processes, empty cache at first", rows)
    print(f"\nwritten to {keep('first_call', rows, chosen.out)}")


if __name__ == "__main__":
    main()
