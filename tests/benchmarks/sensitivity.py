"""Time of the derivatives of positions by ten dimensions, compared with that of the positions.

Run: python tests/benchmarks/sensitivity.py [--steps 100000] [--repeats 7]

All run alternately in one process on one thread, compiled; the best CPU time of the repeats counts. "positions" are
those of `gim trace` without writing. Derivatives are those of all nodes, in blocks of rows as in
`gim sensitivity`. Target: at most 2.5 times the time of the positions. The run stops if a
derivative differs from the difference of the positions of changed mechanisms by more than 1e-6 of the largest one.
"""

from __future__ import annotations

import time

from machine import MODELS, Row, compare_all, interleaved  # isort: skip - first: one thread
import numpy as np

from gimcli import Mechanism, load
from gimcli.families.family import Family
from gimcli.kernels import jit
from gimcli.motion.motion import Motion, trace
from gimcli.positions.options import Options

DIMENSIONS = {
    "crank_rocker": ("O2.x", "O2.y", "O4.x", "O4.y", "crank.length", "coupler.length", "rocker.length"),
    "jansen": (
        "O.x", "G.x", "m.length", "j.length", "k.length", "c.length", "f.length", "g.length", "bde.shape.J3.x",
        "bde.shape.J3.y",
    ),
}  # fmt: skip
"""Ten dimensions; seven are all that move a node of the four-bar."""
MOST = 2.5
BLOCK = 4096
"""Rows in one call."""
STEP, AGREEMENT, CHECKED = 1e-4, 1e-6, 72


class Sensitivities:
    """The derivatives of a mechanism by ten dimensions."""

    def __init__(self, mechanism: Mechanism, names: tuple[str, ...]) -> None:
        self.family = Family(mechanism, names)

    def __call__(self, motion: Motion) -> np.ndarray:
        """Return the derivatives (dimensions + inputs, nodes, rows) of the last block of rows of a motion."""
        for begin in range(0, motion.z.shape[1], BLOCK):
            rows = slice(begin, begin + BLOCK)
            found, _ = self.family.slopes(
                self.family.nominal[None], motion.z[None, :, rows], motion.inputs[None, :, rows], jit.compiled
            )  # fmt: skip
        return found[0]


def positions(mechanism: Mechanism, steps: int) -> Motion:
    """Trace a loaded mechanism with compiled kernels."""
    return trace(mechanism, steps, Options(jit="on"))


def apart(mechanism: Mechanism, names: tuple[str, ...]) -> float:
    """Return the largest difference from differences of positions, relative to the largest derivative."""
    found = Sensitivities(mechanism, names)(positions(mechanism, CHECKED))
    worst = 0.0
    for k, name in enumerate(names):
        value = next(v for n, v in zip(names, Family(mechanism, names).nominal, strict=True) if n == name)
        sides = [positions(mechanism.with_({name: float(value + h)}), CHECKED) for h in (STEP, -STEP)]
        high, low = ((m.mechanism.to_file(m.z) - mechanism.origin) / mechanism.scale for m in sides)
        worst = max(worst, float(np.max(np.abs(found[k] - (high - low) / (2.0 * STEP)))))
    far = worst / float(np.max(np.abs(found)))
    if not far <= AGREEMENT:
        raise SystemExit(f"{mechanism.name}: derivatives differ by {far:.1e} from differences of positions")
    return far


def compare(name: str, steps: int, repeats: int) -> list[Row]:
    """Return the rows of one mechanism."""
    mechanism = load(MODELS / f"{name}.yaml")
    far = apart(mechanism, DIMENSIONS[name])
    slopes, motion = Sensitivities(mechanism, DIMENSIONS[name]), positions(mechanism, steps)
    best = interleaved(
        {
            "positions": lambda: positions(mechanism, steps),
            "derivatives of all nodes": lambda: slopes(motion),
        },
        repeats,
        time.process_time,
    )
    rows: list[Row] = []
    for program, seconds in best.items():
        ratio = seconds / best["positions"]
        row: Row = {
            "mechanism": name,
            "program": program,
            "dimensions": len(DIMENSIONS[name]),
            "ns per position": seconds / steps * 1e9,
        }
        row |= {"ratio": round(ratio, 2), "target": f"<= {MOST:g}", "met": "yes" if ratio <= MOST else "no"}
        rows.append(row | {"difference": float(f"{far:.1e}")})
    return rows


def main(arguments: list[str] | None = None) -> None:
    """Compare all mechanisms."""
    compare_all(str(__doc__), DIMENSIONS, compare, "sensitivity", arguments)


if __name__ == "__main__":
    main()
