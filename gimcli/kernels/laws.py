"""Laws of springs, dampers and drives, each written once.

They are formulas of any numbers: floats in the kernels, and arrays, numbers with derivatives or those of a tape
elsewhere. A reading is an angle [rad], or a length or height in the normal frame; `unit` is 1 for an angle, else the
unit of length of the normal frame [m]. Efforts are in J per unit of the reading; a positive one increases it.
"""

from __future__ import annotations

from typing import Any

from gimcli.kernels.jit import kernel


@kernel
def spring(law: Any, value: Any, unit: Any) -> tuple[Any, Any, Any]:
    """Return energy [J], effort and stiffness (minus the derivative of the effort) of a spring at a reading.

    law: unloaded reading, stiffness [N/m or N m/rad] (`SpringForce.law`).
    """
    stretch, stiffness = value - law[0], law[1] * unit * unit
    effort = -stiffness * stretch
    return -0.5 * effort * stretch, effort, stiffness


@kernel
def damper(damping: Any, rate: Any, unit: Any) -> Any:
    """Return the effort of a viscous damper [N s/m or N m s/rad], or of viscous friction, at a rate of its reading."""
    return -damping * unit * unit * rate


@kernel
def drive(effort: Any, idle: Any, rate: Any) -> Any:
    """Return the effort of a drive that decreases with the speed, to 0 at `idle`; 0: it is independent of the speed."""
    return effort * (1.0 - rate / idle) if idle != 0.0 else effort
