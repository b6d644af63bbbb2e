"""One solved row of a motion, from which the next rows are continued."""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.mechanism import FloatArray


@dataclass
class Row:
    """One solved position in the normal frame, and the measures that identify its branch."""

    time: float
    x: FloatArray  # (nodes,)
    y: FloatArray
    g: FloatArray  # (branches,) signed measure of each step with two solutions, see `kernels.loci`
    error: float = 0.0  # estimated error of the nodes
