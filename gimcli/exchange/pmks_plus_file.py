"""PMKS+: the `.pmks` file of a mechanism, which PMKS+ opens."""

from __future__ import annotations

from gimcli.exchange.drawn_linkage import DrawnPose
from gimcli.exchange.pmks_plus_writer import drawing_text


def write(pose: DrawnPose) -> str:
    """Return the content of a file; `pose.left_out` gets sentences about what PMKS+ has not."""
    return drawing_text(pose) + "\n"
