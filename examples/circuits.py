"""The circuits of the double butterfly: at each input there are as many configurations as branches over this input.

Run from the repository: python examples/circuits.py
"""

import math
from pathlib import Path

import numpy as np

from gimcli import circuits, configurations, load

MODEL = Path(__file__).parents[1] / "models" / "double_butterfly.yaml"


def over(start: float, end: float, q: float) -> int:
    """Return how often an interval of the input contains a value, modulo full turns."""
    low, high = min(start, end), max(start, end)
    return math.floor((high - q) / 360.0) - math.floor((low - q) / 360.0)


def main() -> None:
    """Compare the circuits with the configurations at inputs that the search did not use."""
    mechanism = load(MODEL)
    found = circuits(mechanism)
    assert found.complete, "the configurations at all samples of the input are proved complete"
    curves = found.report()["curves"]
    for q in np.linspace(3.0, 355.0, 6):
        listed = configurations(mechanism, motor=q)
        ends = [(b["from"]["motor"], b["to"]["motor"]) for curve in curves for b in curve["branches"]]
        branches = sum(over(start, end, q) for start, end in ends)
        assert listed.complete
        assert listed.count == branches, "each configuration is on one branch, and each branch has one configuration"
    turning = sum(abs(curve["turns"]) == 1.0 for curve in curves)
    print(f"{found.count} circuits; on {turning} of them the input makes a full turn")


if __name__ == "__main__":
    main()
