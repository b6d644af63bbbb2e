"""The Peaucellier-Lipkin cell traces an exact straight line, because it is an inversor: |OP| |OQ| is constant.

Run from the repository: python examples/straight_line.py
"""

from pathlib import Path

import numpy as np

import gimcli

MODEL = Path(__file__).parents[1] / "models" / "peaucellier.yaml"


def main() -> None:
    """Trace the motion and check both properties (crank 2, frame 2, arms 5, rhombus 2.5)."""
    found = gimcli.trace(gimcli.load(MODEL), 360)
    path = {name: found.xy[name] @ np.array([1.0, 1.0j]) for name in ("P", "Q")}
    assert np.ptp(path["Q"].real) < 1e-12 * 4.6875, "Q moves on a straight line"
    assert np.allclose(np.abs(path["P"]) * np.abs(path["Q"]), 5.0**2 - 2.5**2, rtol=1e-12, atol=0.0)
    print(f"x of Q is {path['Q'].real[0]:.12g} within {np.ptp(path['Q'].real):.1e}")


if __name__ == "__main__":
    main()
