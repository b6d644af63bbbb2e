"""Common functions of the benchmarks: one thread, name of the machine, timing, tables and CSV files.

Import this module first: it restricts the numerical libraries to one thread.
"""

from __future__ import annotations

import argparse
import csv
import os
import platform
import re
import time
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

for _name in ("OMP", "OPENBLAS", "MKL", "NUMBA"):
    os.environ.setdefault(f"{_name}_NUM_THREADS", "1")

ROOT = Path(__file__).parents[2]
MODELS = ROOT / "models"
RESULTS = Path(__file__).parent / "results"

Row = dict[str, object]


def cpu() -> str:
    """Return the name of the processor in a form for file names."""
    name = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        found = re.search(r"model name\s*:\s*(.+)", info.read_text())
        name = found.group(1) if found else name
    return re.sub(r"[^a-z0-9]+", "-", re.sub(r"\(.*?\)|cpu|processor", "", name.lower())).strip("-")


def result_path(name: str, folder: Path = RESULTS) -> Path:
    """Return the path of the results of a benchmark on this machine."""
    return folder / f"{name}-{cpu()}-{os.cpu_count()}.csv"


def interleaved(
    sides: dict[str, Callable[[], object]], repeats: int, clock: Callable[[], float] = time.perf_counter
) -> dict[str, float]:
    """Return the best time of each program [s]; the programs run alternately."""
    best = dict.fromkeys(sides, float("inf"))
    for _ in range(repeats):
        for name, side in sides.items():
            begin = clock()
            side()
            best[name] = min(best[name], clock() - begin)
    return best


def keep(name: str, rows: Sequence[Row], folder: Path = RESULTS) -> Path:
    """Write the rows as CSV; the name of the machine is in the name of the file."""
    path = result_path(name, folder)
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return path


def show(title: str, rows: Sequence[Row]) -> None:
    """Print rows as a table."""
    heads = list(rows[0])
    cells = [[_text(row[h]) for h in heads] for row in rows]
    width = [max(len(h), *(len(c[k]) for c in cells)) for k, h in enumerate(heads)]
    print(f"\n{title}\n" + "  ".join(h.ljust(w) for h, w in zip(heads, width, strict=True)))
    for line in cells:
        print("  ".join(c.ljust(w) for c, w in zip(line, width, strict=True)).rstrip())


def _text(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def compare_all(
    doc: str,
    names: Iterable[str],
    compare: Callable[[str, int, int], list[Row]],
    kept: str,
    arguments: list[str] | None,
) -> None:  # fmt: skip
    """Compare mechanisms with the steps and repeats of the command line; print and write the rows."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--out", type=Path, default=RESULTS)
    chosen = parser.parse_args(arguments)
    rows: list[Row] = []
    for name in names:
        part = compare(name, chosen.steps, chosen.repeats)
        show(name, [{k: v for k, v in r.items() if k != "mechanism"} for r in part])
        rows += part
    print(f"\nwritten to {keep(kept, rows, chosen.out)}")
