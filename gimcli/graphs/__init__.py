"""Graphs and animations of motions: the texts of --plot, the quantities that they name, and the rows that are shown.

Knows: what of a motion is drawn; `output` draws it.
Asks: branching, continuation, dynamics, language, motion, output, positions, quantities, rates.
Asked by: families, library.

Its modules are imported when they are first used, as those of `output`.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gimcli.graphs import (
        circuit_animation as circuit_animation,
        extras as extras,
        motion_animation as motion_animation,
    )


def __getattr__(name: str) -> Any:
    """Import a module of the package."""
    if find_spec(f"{__name__}.{name}") is None:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return import_module(f"{__name__}.{name}")
