"""Laws of springs, dampers and drives, each written once.

They are formulas of any numbers: floats in the kernels, and arrays, numbers with derivatives or those of a tape
elsewhere. A positive effort [N or N m] increases the reading on which it acts.
"""

from __future__ import annotations

from typing import Any

from gimcli.kernels.jit import kernel


@kernel
def spring(law: Any, value: Any, unit: Any) -> tuple[Any, Any, Any]:
    """Return energy [J], effort [N or N m] and stiffness [N/m or N m/rad] of a spring at a value of its reading.

    law: unloaded value, stiffness (`SpringForce.law`). unit: m per unit of the reading, 1 for an angle [rad].
    """
    stretch = unit * (value - law[0])
    effort = -law[1] * stretch
    return -0.5 * effort * stretch, effort, law[1]


@kernel
def damper(damping: Any, rate: Any) -> Any:
    """Return the effort of a viscous damper, or of viscous friction, at a rate [m/s or rad/s]."""
    return -damping * rate


@kernel
def drive(effort: Any, idle: Any, rate: Any) -> Any:
    """Return the effort of a drive that decreases with the speed, to 0 at `idle`; 0: it is independent of the speed."""
    return effort * (1.0 - rate / idle) if idle != 0.0 else effort
