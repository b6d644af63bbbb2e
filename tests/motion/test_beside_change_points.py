"""Rows close to a change point, where the equations determine a position less accurately than the tolerance."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bundled import MODELS

import gimcli
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


def parallelograms(count, ram=False):
    """Cranks of 1 m at distances of 3 m, coupled by rods of 3 m; `ram`: two links of 1 m hold the last pin."""
    angle = 0.6
    pin = np.array([np.cos(angle), np.sin(angle)])
    nodes = {f"Q{k}": [3.0 * k, 0.0] for k in range(count)} | {
        f"B{k}": [3.0 * k + pin[0], pin[1]] for k in range(count)
    }
    ground = [f"Q{k}" for k in range(count)]
    links = {f"c{k}": [f"Q{k}", f"B{k}"] for k in range(count)} | {
        f"r{k}": [f"B{k}", f"B{k + 1}"] for k in range(count - 1)
    }
    if ram:
        end, last = np.array([3.0 * count - 0.5, 0.0]), np.array(nodes[f"B{count - 1}"])
        half = (end - last) / 2.0
        side = np.array([-half[1], half[0]]) * np.sqrt(1.0 / (half @ half) - 1.0)
        nodes |= {"G": end.tolist(), "E": (last + half + side).tolist()}
        links |= {"e": [f"B{count - 1}", "E"], "g": ["E", "G"]}
        ground += ["G"]
    nodes = {name: [float(value) for value in place] for name, place in nodes.items()}
    motor = {"pivot": "Q0", "arm": "B0", "law": {"from": 40, "to": 240}}
    return gimcli.load({"nodes": nodes, "ground": ground, "links": links, "actuators": {"motor": motor}})


@pytest.mark.parametrize("count", [10, 40, 130])
def test_long_chains_pass_their_change_point(count):
    """The cranks stay parallel: their pins are at Q + exp(i angle), also where 2^count branches meet at 180 degrees."""
    motion = gimcli.trace(parallelograms(count), 100)
    assert set(motion.status) == {"ok"}
    (event,) = [e for e in motion.events if e["kind"] == "change point"]
    assert event["at"]["motor"] == pytest.approx(180.0, abs=1e-4)
    turn = np.exp(1j * np.radians(motion["motor"]))
    for k in (1, count - 1):
        pin = motion[f"B{k}.x"] + 1j * motion[f"B{k}.y"]
        np.testing.assert_allclose(pin, 3.0 * k + turn, atol=1e-9 * 3 * count)


@pytest.mark.parametrize("count", [10, 40])
def test_long_chains_end_at_their_limit(count):
    """The two links are in line where 1 + 2.5^2 - 5 cos(angle) = 2^2."""
    motion = gimcli.trace(parallelograms(count, ram=True), 100)
    angle = np.degrees(np.arccos(0.65))
    within = motion["motor"] < angle
    assert set(motion.status[within]) == {"ok"}
    assert set(motion.status[~within]) == {"unreachable"}
    (event,) = [e for e in motion.events if e["kind"] == "limit"]
    assert event["at"]["motor"] == pytest.approx(angle, abs=1e-7)
