"""CPU time of commands with an empty cache of machine code, and again with the cache that they have filled.

Run: python tests/benchmarks/compile_time.py [--against FOLDER] [--repeats 3]

With `--against`, another version of the program, in a folder, runs alternately; the column `ratio` is new / other.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

from machine import MODELS, RESULTS, ROOT, Row, keep, show  # isort: skip - first: one thread

COMMANDS = {
    "trace of dyads": ("trace", "jansen"),
    "trace of a coupled group": ("trace", "stephenson_3_far"),
    "simulate": ("simulate", "watt_durango", "--time", "1"),
}


def cpu(program: Path, folder: str, command: tuple[str, ...]) -> float:
    """Return the CPU time of a compiled command [s]; program: the folder that contains gimcli."""
    name, model, *options = command
    environment = os.environ | {"XDG_CACHE_HOME": folder}
    words = [name, str(MODELS / f"{model}.yaml"), *options, "--jit", "on", "--no-png", "--out", folder]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    line = [sys.executable, "-m", "gimcli", *words]
    subprocess.run(line, check=True, capture_output=True, env=environment, cwd=program)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def empty_then_full(program: Path, command: tuple[str, ...]) -> tuple[float, float]:
    """Return the CPU times of the first and of the second call [s]."""
    with tempfile.TemporaryDirectory() as folder:
        return cpu(program, folder, command), cpu(program, folder, command)


def compare(what: str, repeats: int, programs: list[Path]) -> Row:
    """Return the best times of one command."""
    times = [[empty_then_full(program, COMMANDS[what]) for program in programs] for _ in range(repeats)]
    best = [[min(time[k][call] for time in times) for call in (0, 1)] for k in range(len(programs))]
    row: Row = {"what": what, "first s": round(best[0][0], 2), "second s": round(best[0][1], 2)}
    if len(programs) > 1:
        row |= {"first s, other": round(best[1][0], 2), "second s, other": round(best[1][1], 2)}
        row["ratio"] = round(best[0][0] / best[1][0], 2)
    return row


def main(arguments: list[str] | None = None) -> None:
    """Time all commands."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", type=Path, help="folder of another version")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--out", type=Path, default=RESULTS)
    chosen = parser.parse_args(arguments)
    programs = [ROOT, *([chosen.against] if chosen.against else [])]
    rows = [compare(what, chosen.repeats, programs) for what in COMMANDS]
    show("CPU time with an empty cache, and again", rows)
    print(f"\nwritten to {keep('compile_time', rows, chosen.out)}")


if __name__ == "__main__":
    main()
