"""Time of the drive torque of many designs, compared with that of their positions.

Run: python tests/benchmarks/design_forces.py [--steps 100000] [--repeats 7]

`steps` counts the rows of all designs; each design has 361. All run alternately in one process on one thread, compiled;
the best CPU time of the repeats counts, of forces and accelerations without that of the positions. Target: at most 4
times the time of the positions. The run stops if a torque differs from that of `gim forces` of the changed model by
more than 1e-10.
"""

from __future__ import annotations

import time

from machine import MODELS, Row, compare_all, interleaved  # isort: skip - first: one thread
import numpy as np

from gimcli import evaluator, forces, load

NAMES = {"watt_durango": "link5.length", "knuckle_press": "rod.length", "strandbeest": "crank.mass"}
"""The dimension that varies."""
STEPS, MOST, AGREEMENT = 360, 4.0, 1e-10


def compare(name: str, steps: int, repeats: int) -> list[Row]:
    """Return the rows of one mechanism."""
    mechanism, dimension = load(MODELS / f"{name}.yaml"), NAMES[name]
    effort = f"{mechanism.actuators[0].name}.effort"
    count = max(2, steps // (STEPS + 1))
    designs = mechanism.written.dimension(dimension).value * np.linspace(0.999, 1.001, count)[:, None]
    texts = {
        "positions": "solved",
        "accelerations": f"max({mechanism.traced[0]}.ax)",
        "drive torque": f"max(abs({effort}))",
    }
    sides = {program: evaluator(mechanism, [dimension], [text], steps=STEPS) for program, text in texts.items()}
    torque = float(sides["drive torque"](designs)[0][-1, 0])
    alone = float(np.nanmax(np.abs(forces(mechanism.with_({dimension: float(designs[-1, 0])}), STEPS)[effort])))
    far = abs(torque / alone - 1.0)
    if not far <= AGREEMENT:
        raise SystemExit(f"{name}: torques differ by {far:.1e}")
    best = interleaved({k: lambda own=own: own(designs) for k, own in sides.items()}, repeats, time.process_time)
    rows: list[Row] = []
    for program, seconds in best.items():
        own = seconds - best["positions"] * (program != "positions")
        ratio = own / best["positions"]
        row: Row = {"mechanism": name, "program": program, "ns per position": own / (count * (STEPS + 1)) * 1e9}
        row |= {"ratio": round(ratio, 2), "target": f"<= {MOST:g}", "met": "yes" if ratio <= MOST else "no"}
        rows.append(row | {"difference": float(f"{far:.1e}")})
    return rows


def main(arguments: list[str] | None = None) -> None:
    """Compare all mechanisms."""
    compare_all(str(__doc__), NAMES, compare, "design_forces", arguments)


if __name__ == "__main__":
    main()
