"""`gim circuits`: circuits compared with Grashof's law and known mechanisms."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from bundled import MODELS
from typer.testing import CliRunner

from gimcli import load
from gimcli.branching.enumeration import EnumerationConstants, circuits
from gimcli.cli import app

SEED = 11


def four_bar(path: Path, lengths: tuple[float, float, float, float]) -> Path:
    """Write a four-bar (crank a, coupler b, rocker c, frame d) with an initial position far from any assembled one."""
    a, b, c, d = lengths
    path.write_text(
        f"units: {{length: unit}}\nnodes: {{O: [0, 0], A: [0, {a}], B: [{d}, {c}], G: [{d}, 0]}}\nground: [O, G]\n"
        f"links:\n  crank: {{nodes: [O, A], length: {a}}}\n  coupler: {{nodes: [A, B], length: {b}}}\n"
        f"  rocker: {{nodes: [G, B], length: {c}}}\n"
        "actuators:\n  motor: {type: rotary, pivot: O, arm: A, law: {from: 17, to: 377}}\n"
    )
    return path


def random_lengths(count: int) -> list[tuple[float, float, float, float]]:
    """Return lengths that can be assembled, clearly different from change-point linkages."""
    rng, found = np.random.default_rng(SEED), []
    while len(found) < count:
        lengths = rng.uniform(0.3, 3.0, 4)
        order = np.sort(lengths)
        margin = order[0] + order[3] - order[1] - order[2]
        if order[3] < order[:3].sum() - 0.05 and abs(margin) > 0.05:
            found.append(tuple(lengths.tolist()))
    return found


@pytest.mark.few(6)
@pytest.mark.parametrize("lengths", random_lengths(24), ids=lambda v: "-".join(f"{x:.2f}" for x in v))
def test_circuits_and_branches_follow_from_grashofs_law(
    lengths: tuple[float, float, float, float], tmp_path: Path
) -> None:
    """Two circuits where shortest + longest < the others, else one; an oscillating input has two branches."""
    found = circuits(load(four_bar(tmp_path / "m.yaml", lengths)), EnumerationConstants(samples=24))
    a, _, _, d = lengths
    order = np.sort(lengths)
    grashof = order[0] + order[3] < order[1] + order[2]
    cranks = grashof and order[0] in (a, d)
    assert found.complete
    assert found.count == len(found.strands) == (2 if grashof else 1)
    for strand in found.strands:
        assert strand.circuit.closed
        assert abs(strand.circuit.turns) == (1.0 if cranks else 0.0)
        assert len(strand.branches) == (1 if cranks else 2)
    for places in found.places:
        assert len(places) == 1
    if cranks:
        assert sorted(at[0][0] for at in found.places) == [0, 1], "a configuration of the start on each circuit"


def test_the_two_branches_of_a_rocker_are_distinguished(tmp_path: Path) -> None:
    """Both configurations of an oscillating input are on one circuit or two, never on the same branch."""
    lengths = (2.0, 1.9, 2.1, 2.05)  # shortest + longest = 4.0 < 3.95 + ... : the coupler is shortest
    found = circuits(load(four_bar(tmp_path / "m.yaml", lengths)), EnumerationConstants(samples=24))
    assert len({at[0] for at in found.places}) == len(found.places)


def test_curves_that_intersect_are_one_circuit() -> None:
    """Parallelogram and antiparallelogram intersect in the two flat positions."""
    found = circuits(load(MODELS / "parallelogram.yaml"), EnumerationConstants(samples=24))
    assert found.count == 1
    assert len(found.strands) == 2
    assert found.complete


def test_circuits_of_a_linear_input_are_found_outside_its_law(tmp_path: Path) -> None:
    """A slider-crank driven by its slider: crank 1, rod 3: one circuit between 2 and 4, one between -4 and -2."""
    path = tmp_path / "m.yaml"
    path.write_text(
        "nodes: {O: [0, 0], A: [0, 1], B: [2.8284271247461903, 0], G: [9, 0]}\nground: [O, G]\n"
        "links: {crank: [O, A], rod: [A, B]}\nprismatic: {slide: {node: B, guide: [O, G]}}\n"
        "actuators: {jack: {type: linear, node: B, guide: [O, G], law: {from: 2.5, to: 3.5}}}\n"
    )
    found = circuits(load(path))
    scale = found.curve.mechanism.scale
    assert found.complete
    assert found.count == 2
    reach = sorted(tuple(v * scale for v in strand.interval) for strand in found.strands)
    assert np.allclose(reach, [(-4.0, -2.0), (2.0, 4.0)], atol=1e-10)
    assert all(len(strand.branches) == 2 for strand in found.strands)
    assert [at[0][0] for at in found.places] in ([0, 0], [1, 1]), "both cranks of the start are on one circuit"


def test_every_configuration_is_on_a_curve() -> None:
    """The double butterfly's six configurations at 145 degrees agree with the positions of the circuits there."""
    found = circuits(load(MODELS / "double_butterfly.yaml"))
    q = found.curve.begin()
    assert found.complete
    assert len(found.start) == len(found.places) == 6
    assert found.count == 4, "connected components of its curve: Porta, Ros, Creemers & Thomas 2007 (CuikSuite)"
    for z, places in zip(found.start.z, found.places, strict=True):
        assert len(places) == 1
        strand = found.strands[places[0][0]]
        low, high = strand.branches[places[0][1]].start[-1], strand.branches[places[0][1]].end[-1]
        turns = [q + 2.0 * math.pi * k for k in range(-3, 4)]
        assert any(min(low, high) <= value <= max(low, high) for value in turns)
        near = np.abs(found.curve.nodes(strand.circuit.p) - z[:, None]).max(axis=0)
        assert near.min() < 0.1


def test_the_json_report_of_the_command(tmp_path: Path) -> None:
    picture = tmp_path / "c.png"
    ran = CliRunner().invoke(app, ["circuits", str(MODELS / "chebyshev.yaml"), "--json", "--png", str(picture)])
    assert ran.exit_code == 0, ran.output
    report = json.loads(ran.stdout)
    assert report["circuits"] == 2
    assert report["complete"] is True
    assert [c["circuit"] for c in report["curves"]] == [1, 2]
    assert {c["circuit"] for c in report["configurations"]} <= {1, 2}
    assert picture.stat().st_size > 10_000
    # Chebyshev's crossed four-bar 5 : 2 : 5 : 4 is a double rocker: its input's limits by the law of cosines
    cosines = [(5.0**2 + 4.0**2 - r * r) / (2.0 * 5.0 * 4.0) for r in (5.0 - 2.0, 5.0 + 2.0)]
    limits = [math.degrees(math.acos(c)) for c in cosines]
    assert np.allclose(report["curves"][0]["interval"]["motor"], limits, atol=1e-9)
    assert np.allclose(report["curves"][1]["interval"]["motor"], [360.0 - limits[1], 360.0 - limits[0]], atol=1e-9)


def test_models_without_actuator_or_configuration_are_rejected(tmp_path: Path) -> None:
    path = tmp_path / "m.yaml"
    path.write_text("nodes: {O: [0, 0], A: [1, 0]}\nground: [O]\nlinks: {crank: [O, A]}\n")
    ran = CliRunner().invoke(app, ["circuits", str(path)])
    assert ran.exit_code != 0
    assert "nothing drives nodes A" in str(ran.exception)
    four_bar(path, (1.0, 1.0, 1.0, 9.0))
    ran = CliRunner().invoke(app, ["circuits", str(path), "--samples", "8"])
    assert ran.exit_code == 5
    assert "0 circuits" in ran.stdout


def test_the_mirrored_configuration_of_a_short_travel_is_found(tmp_path: Path) -> None:
    """Crank 0.01, rod 30, driven at its slider: one circuit about 30, one about -30, each 0.02 long."""
    path = tmp_path / "m.yaml"
    path.write_text(
        "nodes: {O: [0, 0], A: [0, 0.01], B: [29.99999833333329, 0], G: [90, 0]}\nground: [O, G]\n"
        "links: {crank: [O, A], rod: {nodes: [A, B], length: 30}}\nprismatic: {slide: {node: B, guide: [O, G]}}\n"
        "actuators: {jack: {type: linear, node: B, guide: [O, G], law: {from: 29.995, to: 30.005}}}\n"
    )
    found = circuits(load(path))
    scale = found.curve.mechanism.scale
    reach = sorted(tuple(v * scale for v in strand.interval) for strand in found.strands)
    assert np.allclose(reach, [(-30.01, -29.99), (29.99, 30.01)], atol=1e-9)


def test_progress_is_reported_while_circuits_are_followed():
    """The reported progress increases with every circuit, not only while configurations are found."""
    heard = []
    mechanism = load(MODELS / "double_butterfly.yaml")
    found = circuits(mechanism, EnumerationConstants(samples=6), lambda done, of: heard.append(done / of))
    assert heard == sorted(heard)
    listed = [part for part in heard if part < 0.5]
    followed = {part for part in heard if 0.5 <= part < 1.0}
    assert len(listed) == 5
    assert len(followed) >= found.count - 1 > 1
    assert heard[-1] == 1.0
