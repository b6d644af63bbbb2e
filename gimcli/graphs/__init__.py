"""Graphs and animations of motions: the texts of --plot, the quantities that they name, and the rows that are shown.

Knows: what of a motion is drawn; `output` draws it.
Asks: branching, continuation, dynamics, language, motion, output, positions, quantities, rates.
Asked by: families, library.

Its modules are imported when they are first used, as those of `output`.
"""

from typing import TYPE_CHECKING

from gimcli.door import modules_of

if TYPE_CHECKING:
    from gimcli.graphs import (
        circuit_animation as circuit_animation,
        extras as extras,
        motion_animation as motion_animation,
    )

__getattr__ = modules_of(__name__)
