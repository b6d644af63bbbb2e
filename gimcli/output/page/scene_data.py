"""A scene as JSON data: what script/mechanism.js draws."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.mechanism import FRAME
from gimcli.output.anchors import Anchor
from gimcli.output.scene import Scene

if TYPE_CHECKING:
    from gimcli.output.gear_outlines import GearOutlines

DIGITS = 10
"""Significant digits of lengths and directions."""


def scene_data(scene: Scene, origin: complex) -> dict[str, Any]:
    """Return the items of a scene; coordinates of the file are relative to `origin`."""
    mechanism = scene.mechanism

    def place(anchor: Anchor) -> int | list[float]:
        if anchor.node >= 0:
            return anchor.node
        fixed = scene.carriers[anchor.member].origin < 0
        return [anchor.member, *_pair(anchor.local - origin if fixed else anchor.local)]

    return {
        "nodes": list(mechanism.nodes),
        "members": [member.name for member in mechanism.members],
        "carriers": [[carrier.origin, carrier.towards] for carrier in scene.carriers],
        "fixed": sorted(scene.fixed),
        "pins": list(scene.pins),
        "plain": list(scene.plain),
        "crosses": list(scene.crosses),
        "bodies": [
            {"member": b.member, "kind": b.kind, "outline": [place(a) for a in b.outline], "above": b.above}
            for b in scene.bodies
        ],
        "sliders": [
            {
                "name": s.name, "nodes": list(s.nodes), "line": place(s.line), "along": _pair(s.along),
                "travel": [_digits(t) for t in s.travel], "side": _pair(s.side) if s.side else None,
                "bracket": [place(a) for a in s.bracket],
            }
            for s in scene.sliders
        ],
        "supports": [{"node": s.node, "upward": s.upward} for s in scene.supports],
        "drives": [
            {
                "name": d.name, "kind": d.kind, "nodes": list(d.nodes), "sense": d.sense,
                "direction": _pair(d.direction), "aside": d.aside, "guide": d.guide,
            }
            for d in scene.drives
        ],
        "elements": [
            {"name": e.name, "kind": e.kind, "ends": [place(a) for a in e.ends], "pivot": e.pivot, "lane": e.lane}
            for e in scene.elements
        ],
        "loads": [
            {"name": one.name, "at": place(one.at), "force": _pair(one.force), "follower": one.follower,
             "torque": one.torque}
            for one in scene.loads
        ],
        "gears": _gears(scene.gears, scene, place) if scene.gears else None,
        "centres": [place(at) for at in scene.centres],
        "tracers": [{"name": name, "at": place(anchor)} for name, anchor in scene.tracers.items()],
    }  # fmt: skip


def _gears(outlines: GearOutlines, scene: Scene, place: Callable[[Anchor], int | list[float]]) -> dict[str, Any]:
    fixed = [wheel.member == FRAME and not scene.mechanism.floating for wheel in outlines.wheels]
    return {
        "wheels": [
            {"pivot": w.pivot, "member": w.member, "radius": _digits(w.radius), "ring": w.ring, "fixed": still}
            for w, still in zip(outlines.wheels, fixed, strict=True)
        ],
        "belts": [
            {"pivots": list(b.pivots), "radii": [_digits(r) for r in b.radii], "crossed": b.crossed}
            for b in outlines.belts
        ],
        "racks": [{"ends": [place(end) for end in rack.ends]} for rack in outlines.racks],
    }


def curve_anchors(scene: Scene, origin: complex, names: tuple[str, ...]) -> list[dict[str, Any]]:
    """Return the traced points by name, each as a node or as a point of a member."""
    own = {tracer["name"]: tracer["at"] for tracer in scene_data(scene, origin)["tracers"]}
    nodes = scene.mechanism.nodes
    return [{"name": name, "at": nodes.index(name) if name in nodes else own[name]} for name in names]


def window(scene: Scene) -> list[float]:
    """Return left, right, bottom, top of what all rows show, in coordinates of the file."""
    z = scene.extent()
    z = z[np.isfinite(z)]
    return [float(v) for v in (z.real.min(), z.real.max(), z.imag.min(), z.imag.max())]


def _pair(z: complex) -> list[float]:
    return [_digits(z.real), _digits(z.imag)]


def _digits(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
