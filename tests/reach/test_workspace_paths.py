"""Paths of a point moved by one input: they contain all configurations and no other positions."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from bundled import MODELS

from gimcli import Mechanism, load, workspace
from gimcli.assemblies import all_configurations
from gimcli.branching.enumeration import circuits
from gimcli.branching.resampling import circuit_motion
from gimcli.mechanism import FloatArray
from gimcli.reach.reach import Reach, ReachedPath, reach
from gimcli.structure.carried import carried_point
from gimcli.structure.residual import residual

ENGINE: dict[str, Any] = {
    "nodes": {"O": [0, 0], "A": [1, 0.5], "S": [4, 0], "T": [5, 0], "P": [4.5, 0.5], "G": [9, 0]},
    "ground": ["O", "G"],
    "links": {"crank": ["O", "A"], "rod": ["A", "S"]},
    "elements": {"piston": ["S", "T", "P"]},
    "prismatic": {"bore": {"nodes": ["S", "T"], "guide": ["O", "G"]}},
    "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
    "trace": ["S"],
}


def made(tmp_path: Path, data: dict[str, Any]) -> Mechanism:
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(data, sort_keys=False))
    return load(path)


def worst(found: Reach, run: ReachedPath) -> float:
    """Return the greatest residual of the constraints along a path."""
    task = found.task
    return float(residual(task.mechanism, task.nodes(run.x), task.inputs(run.x).T).total.max())


def passes(found: Reach, run: ReachedPath, value: float) -> int:
    """Return how often the input has a value along a path; the ends of its pieces are repeated."""
    u = np.concatenate([found.task.inputs(p.branch.x)[:, 0] for p in run.pieces])
    away = u - value
    if found.task.mechanism.actuators[0].rotary:
        away = (away + math.pi) % (2.0 * math.pi) - math.pi
    return int(np.sum((away[:-1] * away[1:] < 0.0) & (np.abs(np.diff(away)) < 1.0)))


def test_a_redundant_link_keeps_its_length_along_every_path() -> None:
    """The third crank of a parallelogram: the antiparallelogram would change the length of EF."""
    found = reach(load(MODELS / "parallelogram_third_crank.yaml"), "F")
    (run,) = found.runs
    mechanism, z = found.task.mechanism, found.task.nodes(run.x)
    e, f = (mechanism.nodes.index(n) for n in "EF")
    assert np.allclose(np.abs(z[f] - z[e]) * mechanism.scale, 1.0, atol=1e-12)


@pytest.mark.few(1)
@pytest.mark.parametrize(
    "stem",
    ["parallelogram_third_crank", "scotch_yoke", "slider_crank", "plantigrade", "hart_a_frame", "whitworth", "watt_1"],
)
def test_paths_pass_every_configuration_once(stem: str) -> None:
    mechanism = load(MODELS / f"{stem}.yaml")
    found = reach(mechanism, mechanism.traced[0])
    assert found.complete
    law = mechanism.actuators[0].law(np.linspace(0.0, 1.0, 1001))
    for value in law.min() + np.ptp(law) * np.array([0.1234, 0.4321, 0.8765]):
        there = all_configurations(mechanism, np.array([value]))
        assert sum(passes(found, run, value) for run in found.runs) == len(there)
    assert max(worst(found, run) for run in found.runs) < 1e-10


def test_a_block_is_not_reversed(tmp_path: Path) -> None:
    """An engine: the rod on either side of the crank, the piston as in the model; strokes of r + l (Norton 4.11)."""
    found = reach(made(tmp_path, ENGINE), "S")
    assert len(found.runs) == 2
    crank, rod = math.hypot(1.0, 0.5), math.hypot(3.0, 0.5)
    scale, origin = found.task.mechanism.scale, found.task.mechanism.origin.real
    ends = sorted(tuple(corner[0] * scale + origin for corner in run.bounds) for run in found.runs)
    assert np.allclose(ends, [(-crank - rod, crank - rod), (rod - crank, rod + crank)], atol=1e-9)


def test_chains_connected_only_by_the_frame_do_not_multiply_paths() -> None:
    """A point of the first arm of the hexagon turns about H0 by its own cylinder, independent of the others."""
    found = workspace(load(MODELS / "floating_hexagon.yaml"), "M0", every=True)._found
    assert [a.name for a in found.task.mechanism.actuators] == ["cylinder_0"]
    assert len(found.runs) == 4  # the rod on either side, also mirrored about the line of the hexagon's corners
    mechanism = found.task.mechanism
    for run in found.runs:
        points = mechanism.to_file(run.points() @ np.array([1.0, 1.0j]))
        assert np.allclose(np.abs(points - 3.0), math.hypot(2.5, 0.8), atol=1e-7)


@pytest.mark.few(1)
@pytest.mark.parametrize("stem", ["crank_rocker", "watt_2", "watt_1", "double_crank"])
def test_extremes_agree_with_those_of_the_circuits(stem: str) -> None:
    mechanism = load(MODELS / f"{stem}.yaml")
    name = mechanism.traced[0]
    found = reach(mechanism, name)
    assert not found.task.limited
    own = np.array([np.concatenate(run.bounds) for run in found.runs])
    others = []
    for strand in circuits(mechanism).strands:
        y = carried_point(mechanism, name, circuit_motion(strand.circuit, 2001, 1e-10).z)
        others.append([-vertex(-y.real), -vertex(-y.imag), vertex(y.real), vertex(y.imag)])
    assert np.allclose(own[np.lexsort(own.round(6).T)], np.array(others)[np.lexsort(np.round(others, 6).T)], atol=2e-9)


def vertex(values: FloatArray) -> float:
    """Return the greatest value of a closed curve, from the parabola through its greatest row and the neighbours."""
    k = int(np.argmax(values[:-1]))
    a, b, c = values[k - 1] if k else values[-2], values[k], values[k + 1]
    return float(b - (c - a) ** 2 / (8.0 * (a - 2.0 * b + c)))
