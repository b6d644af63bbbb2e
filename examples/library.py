"""Use gimcli in a program: solve, trace and save a four-bar, and compare it with the law of cosines.

Run from the repository: python examples/library.py
"""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import gimcli

FOUR_BAR = {
    "name": "Four-bar", "units": {"length": "mm", "angle": "deg"},
    "nodes": {"O2": [0, 0], "O4": [100, 0], "A": [40, 0], "B": [136, 71]},
    "ground": ["O2", "O4"],
    "links": {
        "crank": ["O2", "A"],
        "coupler": {"nodes": ["A", "B"], "length": 120},
        "rocker": {"nodes": ["O4", "B"], "length": 80},
    },
    "actuators": {"motor": {"type": "rotary", "pivot": "O2", "arm": "A", "law": {"from": 0, "to": 360}}},
}  # fmt: skip


def rocker(crank: float) -> float:
    """Return the angle [deg] of the rocker at an angle [deg] of the crank, by the law of cosines."""
    x, y = 40.0 * math.cos(math.radians(crank)) - 100.0, 40.0 * math.sin(math.radians(crank))
    far = math.hypot(x, y)
    between = math.acos((80.0**2 + far**2 - 120.0**2) / (2.0 * 80.0 * far))
    return math.degrees(math.atan2(y, x) - between) % 360.0


def main() -> None:
    """Solve one position, trace a motion and save it."""
    four_bar = gimcli.load(FOUR_BAR)
    position = gimcli.solve(four_bar, motor=45)
    angle: float = position.angle["rocker"]
    assert position.status == "ok"
    assert math.isclose(angle % 360.0, rocker(45.0), abs_tol=1e-9), "law of cosines"
    motion = gimcli.trace(four_bar, steps=72, derivatives=1)
    assert all(word == "ok" for word in motion.status)
    assert math.isclose(motion.angle["crank"][-1], 360.0, abs_tol=1e-9), "full turns are counted"
    with tempfile.TemporaryDirectory() as folder:
        motion.save(Path(folder) / "four_bar.csv", Path(folder) / "four_bar.png")
    print(f"rocker at 45 deg: {angle:.9g} deg; {len(motion.status)} positions, largest residual {motion.worst:.0e}")


if __name__ == "__main__":
    main()
