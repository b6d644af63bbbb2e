"""List all configurations of the double butterfly at inputs over one full turn, with a proof that none is missing.

Configurations appear and vanish in pairs, where two of them meet, so their number is always even.

Run from the repository: python examples/all_assemblies.py
"""

from pathlib import Path

import numpy as np

from gimcli import load
from gimcli.assemblies import all_configurations, configurations_over

MODEL = Path(__file__).parents[1] / "models" / "double_butterfly.yaml"
BARS = {("Q", "U"): 11.0, ("S", "V"): 9.0, ("T", "X"): 7.0, ("R", "Y"): 12.0}


def main() -> None:
    """Find the six published configurations, check the lengths of the bars, and count configurations over a turn."""
    mechanism = load(MODEL)
    found = all_configurations(mechanism, np.radians([112.62]))
    assert found.complete
    assert (found.bound, len(found)) == (18, 6), "18 complex and 6 real solutions: Nielsen & Roth 1999"
    at = {name: mechanism.to_file(found.z)[:, k] for k, name in enumerate(mechanism.nodes)}
    for (a, b), length in BARS.items():
        assert np.allclose(np.abs(at[a] - at[b]), length, rtol=1e-13, atol=0.0)
    turn = configurations_over(mechanism, np.radians([np.arange(0.0, 360.0, 5.0)]))
    numbers = [len(row) for row in turn]
    assert all(row.complete for row in turn)
    assert all(n % 2 == 0 for n in numbers), "configurations appear in pairs"
    print(f"{len(found)} of {found.bound} solutions are real; over a turn there are {min(numbers)} to {max(numbers)}")


if __name__ == "__main__":
    main()
