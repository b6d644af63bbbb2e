"""Other programs on the same mechanisms: for each a function of the number of steps, or the reason why it is unable.

The function traces the first traced point of the mechanism and returns it as complex numbers (rows,). Work that does
not depend on the number of steps (building the model, compiling) is not timed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

TURN = 2.0 * math.pi

Trace = Callable[[int], np.ndarray]


class UnableError(Exception):
    """The program cannot solve the mechanism; the text is the reason."""


@dataclass(frozen=True)
class Linkage:
    """A mechanism as bars between points, the input of a constraint solver."""

    fixed: dict[str, complex]
    drives: dict[str, tuple[str, float, float, float]]  # driven point: pivot, radius, first and last angle
    free: dict[str, complex]  # drawn
    bars: dict[tuple[str, str], float]
    point: tuple[str, str, complex]  # u + z (v - u) / |v - u|
    dyads: tuple[tuple[str, ...], ...] = field(default=())  # in order of solution

    def driven(self, time: float) -> dict[str, complex]:
        """Return the driven points at a time 0..1."""
        return {
            name: self.fixed[pivot] + radius * complex(math.cos(angle), math.sin(angle))
            for name, (pivot, radius, first, last) in self.drives.items()
            for angle in (first + (last - first) * time,)
        }

    def traced(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the traced point from the two nodes that carry it."""
        z = self.point[2]
        return u + z * (v - u) / np.abs(v - u) if z else u


def _bars(text: str) -> dict[tuple[str, str], float]:
    """Read "AB 40 BC 120.5 ..."."""
    words = text.split()
    return {(a[0], a[1]): float(b) for a, b in zip(words[::2], words[1::2], strict=True)}


def _degrees(pivot: str, radius: float, first: float, last: float) -> tuple[str, float, float, float]:
    return pivot, radius, math.radians(first), math.radians(last)


FAR = math.degrees(math.atan2(15.0, -2.0))
LINKAGES = {
    "crank_rocker": Linkage(
        {"O": 0j, "Q": 100 + 0j}, {"A": _degrees("O", 40, 0, 360)}, {"B": 130 + 74j}, _bars("AB 120 QB 80"),
        ("A", "B", 60 + 40j), (("B", "A", "Q", "AB", "QB"),),
    ),
    "jansen": Linkage(
        {"O": 0j, "G": -38 - 7.8j}, {"A": _degrees("O", 15, 0, 360)},
        {"B": -24.014 + 31.272j, "C": -74.794 + 8.143j, "D": -26.952 - 45.515j, "E": -59.232 - 28.053j},
        _bars("AB 50 GB 41.5 GC 40.1 BC 55.8 AD 61.9 GD 39.3 CE 39.4 DE 36.7"),
        ("D", "E", -7.746594005449595 + 48.38378118041967j),
        (
            ("B", "A", "G", "AB", "GB"), ("C", "G", "B", "GC", "BC"), ("D", "A", "G", "AD", "GD"),
            ("E", "C", "D", "CE", "DE"),
        ),
    ),
    "stephenson_3_far": Linkage(
        {"A": 7 + 4j, "D": 23 + 10j, "G": 45 + 17j}, {"F": _degrees("G", math.sqrt(229), FAR, FAR + 360)},
        {"C": 25 + 25j, "E": 18 + 35j, "B": 5 + 16j},
        {
            ("D", "C"): math.sqrt(229), ("F", "E"): math.sqrt(634), ("A", "B"): math.sqrt(148),
            ("C", "E"): math.sqrt(149), ("E", "B"): math.sqrt(530), ("B", "C"): math.sqrt(481),
        },
        ("C", "E", 0j),
    ),
    "platform_3rrr": Linkage(
        {"A": -8.660254037844386 - 5j, "B": 8.660254037844386 - 5j, "C": 10j},
        {"P": _degrees("A", 6, 76, 60), "Q": _degrees("B", 6, -164, -150), "R": _degrees("C", 6, -35, -50)},
        {"U": -1.7483 - 1.6863j, "V": 3.3443 - 0.6539j, "W": -0.0960 + 3.2402j},
        _bars("PU 6 QV 6 RW 6 UV 5.196152422706632 VW 5.196152422706632 WU 5.196152422706632"),
        ("U", "V", 2.598076211353316 + 1.5j),
    ),
}  # fmt: skip


def _simulated(linkage: Linkage) -> tuple[Any, list[Any], Any, float]:
    """Return a pylinkage Linkage, its start position, its crank, and the angle of the crank's motion [rad]."""
    from pylinkage.actuators import Crank
    from pylinkage.components import Ground
    from pylinkage.dyads import FixedDyad, RRRDyad
    from pylinkage.simulation import Linkage as Simulated

    if not linkage.dyads:
        raise UnableError(
            "its numba solver finds one node from two known ones, its triads have two free nodes; this group has three"
        )
    parts = {name: Ground(z.real, z.imag, name=name) for name, z in linkage.fixed.items()}
    ((name, (pivot, radius, first, last)),) = linkage.drives.items()
    parts[name] = Crank(parts[pivot], radius, initial_angle=first)
    for node, a, b, first_bar, second_bar in linkage.dyads:
        r, s = (linkage.bars[bar[0], bar[1]] for bar in (first_bar, second_bar))
        anchors = [getattr(parts[n], "output", parts[n]) for n in (a, b)]
        at = linkage.free[node]
        parts[node] = RRRDyad(*anchors, r, s, x=at.real, y=at.imag)
    u, v, z = linkage.point
    ends = [getattr(parts[n], "output", parts[n]) for n in (u, v)]
    parts["point"] = FixedDyad(*ends, abs(z), math.atan2(z.imag, z.real))
    start = [part.position for part in parts.values()]
    return Simulated(list(parts.values())), start, parts[name], last - first


def pylinkage(linkage: Linkage) -> Trace:
    """Compile a pylinkage Linkage; its `step_fast` runs in numba."""
    model, start, crank, angle = _simulated(linkage)

    def trace(steps: int) -> np.ndarray:
        model.set_coords(start)
        path = model.step_fast(steps, dt=angle / steps / crank.angular_velocity)
        return path[:, -1, 0] + 1j * path[:, -1, 1]

    return trace


def pylinkage_rates(linkage: Linkage) -> Trace:
    """Compile a pylinkage Linkage; its `step_fast_with_kinematics` gives position, velocity, acceleration."""
    model, start, crank, angle = _simulated(linkage)
    model.set_input_velocity(crank, angle)

    def trace(steps: int) -> np.ndarray:
        model.set_coords(start)
        found = model.step_fast_with_kinematics(steps, dt=angle / steps / crank.angular_velocity)
        return np.stack([part[:, -1, 0] + 1j * part[:, -1, 1] for part in found])

    return trace


def solvespace(linkage: Linkage) -> Trace:
    """Build a SolveSpace sketch: driven points are given, the other points are solved step by step."""
    from python_solvespace import ResultFlag, SolverSystem

    system = SolverSystem()
    plane = system.create_2d_base()
    given = linkage.fixed | linkage.driven(0.0)
    points = {name: system.add_point_2d(z.real, z.imag, plane) for name, z in given.items()}
    system.set_group(2)
    points |= {name: system.add_point_2d(z.real, z.imag, plane) for name, z in linkage.free.items()}
    for (a, b), length in linkage.bars.items():
        system.distance(points[a], points[b], length, plane)
    u, v, _ = linkage.point
    ends = [points[n].params for n in (u, v)]
    drawn = [(points[n].params, (z.real, z.imag)) for n, z in linkage.free.items()]

    def trace(steps: int) -> np.ndarray:
        out = np.empty((steps, 2), dtype=complex)
        for params, at in drawn:
            system.set_params(params, at)
        for k in range(steps):
            for name, z in linkage.driven((k + 1) / steps).items():
                system.set_params(points[name].params, (z.real, z.imag))
            if system.solve() != ResultFlag.OKAY:
                raise UnableError(f"it does not settle in step {k + 1} of {steps}")
            out[k] = [complex(*system.params(p)) for p in ends]
        return linkage.traced(out[:, 0], out[:, 1])

    return trace


def exudyn(linkage: Linkage) -> Trace:
    """Build an Exudyn system of mass points and distance constraints; its static solver steps along the law."""
    import exudyn as exu
    from exudyn.itemInterface import SensorNode

    mbs, nodes = _exudyn_system(linkage)
    sensors = [
        mbs.AddSensor(
            SensorNode(nodeNumber=nodes[n], storeInternal=True, outputVariableType=exu.OutputVariableType.Position)
        )
        for n in linkage.point[:2]
    ]
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.staticSolver.verboseMode = 0
    settings.staticSolver.newton.relativeTolerance = 1e-10
    settings.staticSolver.adaptiveStep = False
    settings.solutionSettings.writeSolutionToFile = False

    def trace(steps: int) -> np.ndarray:
        settings.staticSolver.numberOfLoadSteps = steps
        settings.solutionSettings.sensorsWritePeriod = 0.5 / steps
        if not mbs.SolveStatic(settings):
            raise UnableError("its static solver does not settle")
        u, v = (mbs.GetSensorStoredData(s)[-steps:, 1:3] @ [1, 1j] for s in sensors)
        return linkage.traced(u, v)

    return trace


def _exudyn_system(linkage: Linkage) -> tuple[Any, dict[str, int]]:
    """Return an Exudyn system and its nodes; the driven points follow the law in both coordinates."""
    import exudyn as exu
    from exudyn.itemInterface import (
        MarkerNodeCoordinate,
        MarkerNodePosition,
        MassPoint2D,
        NodePoint2D,
        NodePointGround,
        ObjectConnectorCoordinate,
        ObjectConnectorDistance,
    )

    mbs = exu.SystemContainer().AddSystem()
    still = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=mbs.AddNode(NodePointGround()), coordinate=0))
    nodes, markers = {}, {}
    for name, z in (linkage.fixed | linkage.driven(0.0) | linkage.free).items():
        if name in linkage.fixed:
            nodes[name] = mbs.AddNode(NodePointGround(referenceCoordinates=[z.real, z.imag, 0]))
        else:
            nodes[name] = mbs.AddNode(NodePoint2D(referenceCoordinates=[z.real, z.imag]))
            mbs.AddObject(MassPoint2D(physicsMass=1, nodeNumber=nodes[name]))
        markers[name] = mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[name]))
    for name, (_, radius, first, last) in linkage.drives.items():
        for axis, part in enumerate((math.cos, math.sin)):
            marker = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[name], coordinate=axis))
            law = _offset(part, radius, first, last - first)
            mbs.AddObject(ObjectConnectorCoordinate(markerNumbers=[still, marker], offsetUserFunction=law))
    for (a, b), length in linkage.bars.items():
        mbs.AddObject(ObjectConnectorDistance(markerNumbers=[markers[a], markers[b]], distance=length))
    return mbs, nodes


def _offset(part: Callable[[float], float], radius: float, first: float, angle: float) -> Callable[..., float]:
    """Return the displacement of one coordinate of a driven point from its start."""
    begin = part(first)
    return lambda mbs, time, item, offset: radius * (part(first + angle * time) - begin)


PEERS: dict[str, tuple[Callable[[Linkage], Trace], int]] = {
    "pylinkage": (pylinkage, 1),
    "solvespace": (solvespace, 50),
    "exudyn": (exudyn, 50),
}
"""Each program, and the factor by which it runs fewer steps."""
