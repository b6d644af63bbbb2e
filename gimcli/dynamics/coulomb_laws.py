"""Laws of dry (Coulomb) friction in pairs: the friction circle of a pin, and a guide with two contacts.

Source: Marghitu 2009, section 4 (friction circle); for the two contacts, the forces of a guide of finite length.
"""

from __future__ import annotations

from typing import Any

import numpy as np


def friction_circle(mu: float, radius: float) -> float:
    """Return the radius of the friction circle, r mu / sqrt(1 + mu^2), in the unit of the radius.

    The moment of friction in a pin is this radius times the force in the pin, against the relative rotation.
    """
    return radius * mu / float(np.sqrt(1.0 + mu**2))


def contact_forces(normal: Any, moment: Any, length: float) -> tuple[Any, Any]:
    """Return the normal forces of the two contacts of a guide from its whole normal force and moment.

    The contacts are at -length/2 and +length/2 along the guide; the moment is about the middle between them.
    """
    return 0.5 * normal - moment / length, 0.5 * normal + moment / length


def guide_normal(normal: Any, moment: Any, length: float) -> Any:
    """Return |N1| + |N2| of the two contacts of a guide, by which mu is multiplied: max(|N|, 2 |M| / length)."""
    return np.maximum(np.abs(normal), 2.0 * np.abs(moment) / length)
