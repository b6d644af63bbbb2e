"""Choose between two values: over arrays as they stand, between two numbers when compiled.

With it one formula serves both: numpy runs it over all rows of a block, the compiler over one row
in a loop that it vectorises.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gimcli.kernels.jit import scalar_form


def _either(condition: bool, yes: float, no: float) -> float:
    return yes if condition else no


@scalar_form(_either)
def where(condition: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where the condition holds, else `no`."""
    return np.where(condition, yes, no)
