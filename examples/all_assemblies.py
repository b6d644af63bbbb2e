"""Every way to assemble the double butterfly, proved complete, over a turn of its input.

Assemblies appear and vanish in pairs, where two of them meet: their number stays even. Run from the repository:
python examples/all_assemblies.py
"""

from pathlib import Path

import numpy as np

from gimcli import load
from gimcli.assemblies import all_configurations, configurations_over

MODEL = Path(__file__).parents[1] / "models" / "double_butterfly.yaml"
BARS = {("Q", "U"): 11.0, ("S", "V"): 9.0, ("T", "X"): 7.0, ("R", "Y"): 12.0}


def main() -> None:
    """Find the six published assemblies, check their bars, and count over a turn."""
    mechanism = load(MODEL)
    found = all_configurations(mechanism, np.radians([112.62]))
    assert found.complete
    assert (found.bound, len(found)) == (18, 6), "18 complex and 6 real assemblies: Nielsen & Roth 1999"
    at = {name: mechanism.to_file(found.z)[:, k] for k, name in enumerate(mechanism.nodes)}
    for (a, b), length in BARS.items():
        assert np.allclose(np.abs(at[a] - at[b]), length, rtol=1e-13, atol=0.0)
    turn = configurations_over(mechanism, np.radians([np.arange(0.0, 360.0, 5.0)]))
    numbers = [len(row) for row in turn]
    assert all(row.complete for row in turn)
    assert all(n % 2 == 0 for n in numbers), "assemblies meet in pairs"
    print(f"{len(found)} of {found.bound} assemblies are real; over a turn there are {min(numbers)} to {max(numbers)}")


if __name__ == "__main__":
    main()
