"""Fig. 11 of the GIM paper: the error decreases by eq. (3), with the factor that the spectral radius predicts.

Run from the repository: python examples/fig11_convergence.py
"""

from pathlib import Path

import numpy as np

from gimcli import load
from gimcli.gim.sweeper import fit_history
from gimcli.motion.solve import solve
from gimcli.positions.options import Options

MODEL = Path(__file__).parents[1] / "models" / "gim_fig11.yaml"


def main() -> None:
    """Solve the displaced position by sweeps, and compare the convergence factor with the spectral radius."""
    mechanism = load(MODEL)
    inputs = np.array([actuator.law(np.ones(1))[0] for actuator in mechanism.actuators])
    position = solve(mechanism, inputs, Options(method="gim", strategy="classic", tolerance=1e-5), history=True)
    assert position.sweeps == 13, "the paper's count"
    law = fit_history(position)
    assert abs(law.rate / law.radius - 1.0) < 0.1, "eq. (3) with the predicted factor"
    print(f"{position.sweeps} sweeps; factor {law.rate:.4f} per sweep, spectral radius {law.radius:.4f}")


if __name__ == "__main__":
    main()
