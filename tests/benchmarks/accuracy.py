"""Accuracy of all methods for ill-conditioned mechanisms, and the limit by rounding errors; prints the manual's table.

Run: python tests/benchmarks/accuracy.py
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "oracles"))

from extreme_cases import (
    METHODS,
    Case,
    U,
    chain_of_scissors,
    chain_of_windows,
    change_point,
    dead_centre,
    far_off,
    guides,
    kite,
    long_rod,
    parallelogram,
    redundant,
    scaled,
    short_links,
    sliver,
    steep_rod,
)
from specifications import size

CASES: dict[str, Case] = {
    "change point missed by 1e-3": change_point(1e-3, 1),
    "change point missed by 1e-6": change_point(1e-6, 1),
    "change point missed by 1e-12": change_point(1e-12, 1),
    "parallelogram through 180 deg": parallelogram(50, 310, 52),
    "kite through its folded position": kite(60, 780, 72),
    "slider driven to 1e-4 from its dead centre": dead_centre({"from": 3.5, "to": 3.9999}, 20),
    "rod 1e-6 from perpendicular to its guide": steep_rod(1e-6),
    "two slots 0.1 deg from parallel": guides(1e-1),
    "slider-crank 1 : 1e6": long_rod(1e6),
    "four-bar with lengths 1 : 1e4": short_links(1e4),
    "four-bar in units of 1e-9": scaled(1e-9),
    "four-bar 1.4e8 from the origin": far_off(1e8 - 1e8j),
    "ternary member 1e-9 from flat": sliver(1e-9),
    "100 windows": chain_of_windows(100),
    "20 scissors": chain_of_scissors(20),
    "third crank too long by 1e-12": redundant(1e-12),
    "third crank too long by 1e-6": redundant(1e-6),
}


def limit(case: Case) -> float:
    """Return the largest effect of one rounding error of a length in the rows that are compared."""
    m = case.run("auto")
    rows = case.compared(m) or [0]
    return U * max(case.condition(case.value(m, row)) for row in rows)


def attained(case: Case, method: str) -> tuple[float, int, int, str]:
    """Return the largest error of rows that are ok, relative to the size; their number; all rows; other statuses."""
    m = case.run(method)
    worst = max((case.error(m, row) for row in case.compared(m)), default=0.0) / size(case.spec)
    reasons = Counter(word for word in m.status if word != "ok")
    return worst, m.status.count("ok"), len(m.status), ", ".join(reasons)


def cell(case: Case, method: str) -> str:
    """Return the result of a method as the text of a table cell."""
    worst, good, rows, why = attained(case, method)
    return f"{worst:.0e}" if good == rows else f"{worst:.0e}, {good} of {rows}: {why}" if good else why


def main() -> None:
    """Print the table."""
    print("| case | condition x rounding | `auto` | `newton` | `gim` |\n|---|---|---|---|---|")
    for name, case in CASES.items():
        print(f"| {name} | {limit(case):.0e} | " + " | ".join(cell(case, method) for method in METHODS) + " |")


if __name__ == "__main__":
    main()
