"""One solved row of a motion: what others are continued from."""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.mechanism import FloatArray


@dataclass
class Row:
    """One solved position and the measures that identify its branch."""

    time: float
    x: FloatArray  # (nodes,)
    y: FloatArray
    g: FloatArray  # (branches,)
    error: float = 0.0
