"""Rows close to a change point, where the equations determine a position less accurately than the tolerance."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bundled import MODELS

from gimcli import load
from gimcli.motion.motion import trace


@pytest.mark.parametrize("short", [1e-3, 7.3e-4, 1e-4, 1e-5, 0.0], ids=str)
def test_a_row_near_the_second_flat_position(short: float, tmp_path: Path) -> None:
    """An antiparallelogram 1-3-1-3 through 180 and 360 deg: B and O2 are symmetric about the bisector of A O4.

    Near 360 deg the follower rotates twice as fast as the crank, in the opposite sense.
    """
    text = (MODELS / "antiparallelogram.yaml").read_text()
    path = tmp_path / "m.yaml"
    start = 60.0 - short
    path.write_text(text.replace("{from: 5, to: 170}", f"{{from: {start!r}, to: {start + 360.0!r}}}"))
    motion = trace(load(path), 360)
    assert motion.solved == 361
    nodes = motion.mechanism.nodes
    o2, o4, a, b = (motion.mechanism.to_file(motion.z[nodes.index(n)]) for n in ("O2", "O4", "A", "B"))
    # diagonals of an antiparallelogram are parallel: O2-B and A-O4; the figure is symmetric about their common normal
    middle, along = 0.5 * (a + o4), (o4 - a) / np.abs(o4 - a)
    expected = middle - along * np.conj((o2 - middle) / along).real + 1j * along * ((o2 - middle) / along).imag
    assert np.abs(b - expected).max() < 1e-10
