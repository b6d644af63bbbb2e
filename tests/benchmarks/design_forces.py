"""Time of the drive torque of many designs, compared with that of their positions.

Run: python tests/benchmarks/design_forces.py [--steps 100000] [--repeats 7]

`steps` counts the rows of all designs; each design has 361. All run alternately in one process on one thread, compiled;
the best CPU time of the repeats counts. Target: at most 4 times the time of the positions. The run stops if a torque
differs from that of `gim forces` of the changed model by more than 1e-10 of the largest one.
"""

from __future__ import annotations

import time
from typing import Any

from machine import MODELS, Row, compare_all, interleaved  # isort: skip - first: one thread
import numpy as np

from gimcli import forces, load
from gimcli.families.column_names import ColumnNames
from gimcli.families.design_columns import DesignColumns
from gimcli.families.design_motions import DesignMotions
from gimcli.families.family import Family

NAMES = {"watt_durango": "link5.length", "knuckle_press": "rod.length", "strandbeest": "crank.mass"}
"""The dimension that varies."""
STEPS, MOST, AGREEMENT = 360, 4.0, 1e-10
OPTIONS: dict[str, Any] = {"jit": "on", "threads": 1}


def compare(name: str, steps: int, repeats: int) -> list[Row]:
    """Return the rows of one mechanism."""
    mechanism, dimension = load(MODELS / f"{name}.yaml"), NAMES[name]
    family, actuator = Family(mechanism, [dimension]), mechanism.actuators[0].name
    designs = family.nominal * np.linspace(0.999, 1.001, max(2, steps // (STEPS + 1)))[:, None]
    solved, names = family.solve(designs, STEPS, **OPTIONS), ColumnNames(mechanism, family.names)

    def column(text: str) -> Any:
        return DesignColumns(DesignMotions(family, solved, OPTIONS), names)[text]

    torque = column(f"{actuator}.effort")
    alone = forces(mechanism.with_({dimension: float(designs[-1, 0])}), STEPS)[f"{actuator}.effort"]
    far = float(np.nanmax(np.abs(torque[-1] - alone)) / np.nanmax(np.abs(alone)))
    if not far <= AGREEMENT:
        raise SystemExit(f"{name}: torques differ by {far:.1e}")
    best = interleaved(
        {
            "positions": lambda: family.solve(designs, STEPS, **OPTIONS),
            "accelerations": lambda: column(f"{mechanism.traced[0]}.ax"),
            "drive torque": lambda: column(f"{actuator}.effort"),
        },
        repeats,
        time.process_time,
    )
    rows: list[Row] = []
    for program, seconds in best.items():
        ratio = seconds / best["positions"]
        row: Row = {"mechanism": name, "program": program, "ns per position": seconds / solved.codes.size * 1e9}
        row |= {"ratio": round(ratio, 2), "target": f"<= {MOST:g}", "met": "yes" if ratio <= MOST else "no"}
        rows.append(row | {"difference": float(f"{far:.1e}")})
    return rows


def main(arguments: list[str] | None = None) -> None:
    """Compare all mechanisms."""
    compare_all(str(__doc__), NAMES, compare, "design_forces", arguments)


if __name__ == "__main__":
    main()
