"""Mechanisms with other dimensions: their motions are those of an edited file, also in another assembly."""

from __future__ import annotations

import numpy as np
import pytest
from bundled import MODELS

import gimcli
from gimcli import Mechanism


def agree(one: Mechanism, other: Mechanism, name: str) -> None:
    """Check that a point of two mechanisms has the same path."""
    first, second = (gimcli.trace(m, steps=24, jit="off") for m in (one, other))
    assert [*first.status] == [*second.status]
    assert np.isfinite(first.xy[name]).any()
    assert np.allclose(first.xy[name], second.xy[name], rtol=0.0, atol=1e-9 * one.size * one.scale, equal_nan=True)


def test_the_motion_is_that_of_the_edited_file():
    text = (MODELS / "crank_rocker.yaml").read_text(encoding="utf-8")
    edited = text.replace("length: 40", "length: 35").replace("[60, 40]", "[80, 40]")
    agree(gimcli.loads(text).with_({"crank": 35, "P.x": 80}), gimcli.loads(edited), "P")
    assert not np.allclose(gimcli.solve(gimcli.loads(text), motor=9).xy["P"],
                           gimcli.solve(gimcli.loads(edited), motor=9).xy["P"])  # fmt: skip


@pytest.mark.parametrize(("name", "changes", "point"), [
    ("crank_rocker", {"crank": 35}, "P"), ("crank_rocker", {"O4.x": 104, "O4.y": 3, "O2.x": 1}, "P"),
    ("crank_rocker", {"crank": 90, "coupler": 270, "rocker": 180, "O4.x": 225}, "P"),
    ("five_bar", {"motor_1.to": 125}, "P"),
])  # fmt: skip
def test_another_assembly_is_kept(name, changes, point):
    """The other assembly with other dimensions, against the mechanism with these dimensions in its other assembly."""
    mechanism = gimcli.load(MODELS / f"{name}.yaml")
    found = gimcli.configurations(mechanism)
    assert len(found.signs) == 2
    number = 1 if found.drawn == 1 else 2
    kept = gimcli.assembled(mechanism, assembly=number).with_(changes)
    assert gimcli.configurations(kept).drawn == number - 1
    assert gimcli.configurations(mechanism.with_(changes)).drawn == 2 - number
    agree(kept, gimcli.assembled(mechanism.with_(changes), assembly=number), point)
    agree(kept.with_({}), kept, point)
