"""The circuits of the double butterfly: at each input there are as many configurations as branches over this input.

Run from the repository: python examples/circuits.py
"""

import math
from pathlib import Path

import numpy as np

from gimcli import load
from gimcli.assemblies import all_configurations
from gimcli.branching.enumeration import circuits

MODEL = Path(__file__).parents[1] / "models" / "double_butterfly.yaml"


def over(start: float, end: float, q: float) -> int:
    """Return how often an interval of the input contains a value, modulo full turns."""
    low, high = min(start, end), max(start, end)
    return math.floor((high - q) / math.tau) - math.floor((low - q) / math.tau)


def main() -> None:
    """Compare the circuits with the configurations at inputs that the search did not use."""
    mechanism = load(MODEL)
    found = circuits(mechanism)
    assert found.complete, "the configurations at all samples of the input are proved complete"
    for q in np.linspace(0.05, 6.2, 25):
        listed = all_configurations(mechanism, np.array([q]))
        branches = sum(over(b.start, b.end, q) for strand in found.strands for b in strand.branches)
        assert listed.complete
        assert len(listed) == branches, "each configuration is on one branch, and each branch has one configuration"
    turning = sum(abs(strand.circuit.turns) == 1.0 for strand in found.strands)
    print(f"{found.count} circuits; on {turning} of them the input makes a full turn")


if __name__ == "__main__":
    main()
