"""Complete force balancing of a four-bar by counterweights: the shaking force is constant and equal to the weight.

Berkof and Lowen, A new method for completely force balancing simple linkages, J. Eng. Ind. 91 (1969). The centre of
mass of the coupler is at c3 (complex: along A -> B, and to its left). Those of crank and rocker must then fulfil

    m2 c2 = m3 a2 (c3 / a3 - 1),   m4 c4 = -m3 a4 c3 / a3

Run from the repository: python examples/shaking_force.py
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from gimcli import load
from gimcli.dynamic_data import Inertia
from gimcli.dynamics.forces import Forces
from gimcli.mechanism import Dynamics, Mechanism
from gimcli.motion.motion import trace
from gimcli.quantities.state import MotionState

MODEL = Path(__file__).parents[1] / "models" / "crank_rocker.yaml"
G = 9.81


def forces(mechanism: Mechanism, centres: tuple[complex, complex, complex]) -> Forces:
    """Return the forces for crank, coupler and rocker of 2, 3 and 4 kg with the given centres of mass."""
    numbers = [[m.name for m in mechanism.members].index(name) for name in ("crank", "coupler", "rocker")]
    inertias = tuple(Inertia(k, 2.0 + n, 1e-3, c) for n, (k, c) in enumerate(zip(numbers, centres, strict=True)))
    weighted = replace(mechanism, dynamics=Dynamics(mechanism.scale * 1e-3, inertias, gravity=-1j * G))
    return MotionState(trace(weighted, 360)).forces


def main() -> None:
    """Compare the unbalanced four-bar with the balanced one."""
    mechanism = load(MODEL)
    length = {m.name: abs(m.shape[1] - m.shape[0]) for m in mechanism.members}
    a2, a3, a4 = (length[name] for name in ("crank", "coupler", "rocker"))
    c3 = (0.5 + 0.1j) * a3
    bars = forces(mechanism, (a2 / 2 + 0j, c3, a4 / 2 + 0j))
    balanced = forces(mechanism, (3.0 / 2.0 * a2 * (c3 / a3 - 1), c3, -3.0 / 4.0 * a4 * c3 / a3))
    weight = -1j * G * 9.0
    assert np.max(np.abs(bars.shaking_force - weight)) > 5.0, "unbalanced"
    assert np.max(np.abs(balanced.shaking_force - weight)) < 1e-9, "only the weight remains"
    assert np.ptp(balanced.shaking_moment) > 0.1, "the shaking moment is not balanced"
    for found in (bars, balanced):
        assert np.max(np.abs(found.power_error)) < 1e-12 * np.max(np.abs(found.drive_power)), "power balance"
    shaken = np.max(np.abs(bars.shaking_force - weight))
    left = np.max(np.abs(balanced.shaking_force - weight))
    print(f"largest shaking force without the weight: {shaken:.4g} N; balanced: {left:.0e} N")


if __name__ == "__main__":
    main()
