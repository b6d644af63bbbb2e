"""List all configurations of the double butterfly at inputs over one full turn, with a proof that none is missing.

Configurations appear and vanish in pairs, where two of them meet, so their number is always even.

Run from the repository: python examples/all_assemblies.py
"""

from pathlib import Path

import numpy as np

from gimcli import configurations, load

MODEL = Path(__file__).parents[1] / "models" / "double_butterfly.yaml"
BARS = {("Q", "U"): 11.0, ("S", "V"): 9.0, ("T", "X"): 7.0, ("R", "Y"): 12.0}


def main() -> None:
    """Find the six published configurations, check the lengths of the bars, and count configurations over a turn."""
    mechanism = load(MODEL)
    found = configurations(mechanism, motor=112.62)
    bound = found.report()["bound"]
    assert found.complete
    assert (bound, found.count) == (18, 6), "18 complex and 6 real solutions: Nielsen & Roth 1999"
    for (a, b), length in BARS.items():
        distance = np.linalg.norm(found.xy[a] - found.xy[b], axis=-1)
        assert np.allclose(distance, length, rtol=1e-13, atol=0.0)
    turn = [configurations(mechanism, motor=angle) for angle in np.arange(0.0, 360.0, 30.0)]
    numbers = [one.count for one in turn]
    assert all(one.complete for one in turn)
    assert all(n % 2 == 0 for n in numbers), "configurations appear in pairs"
    print(f"{found.count} of {bound} solutions are real; over a turn there are {min(numbers)} to {max(numbers)}")


if __name__ == "__main__":
    main()
