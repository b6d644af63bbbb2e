"""One position of a mechanism, from which the files of other programs are written."""

from __future__ import annotations

from dataclasses import dataclass, field

from gimcli.mechanism import ComplexArray, Mechanism


@dataclass(frozen=True)
class DrawnPose:
    """A mechanism in an assembled position: other programs take all dimensions from it.

    `z`: positions of the nodes (nodes,) in the file's coordinates. `left_out`: sentences about what is not written.
    """

    mechanism: Mechanism
    z: ComplexArray
    left_out: list[str] = field(default_factory=list)
