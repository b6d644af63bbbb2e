"""Every quantity in every place, as the manual's table says: the same numbers, or the place that has them."""

import re

import numpy as np
import pytest
from bundled import MANUAL, MODELS
from live_server import running

import gimcli
from gimcli.errors import GimError

STEPS, ROW, FAR = 10, 4, 130.0
MOVES, RESTS = ("law", "yes"), ("rest", "yes")
DESIGN = {"rate": [400.0]}
CHANGES = {"lid.mass": 1e-2, "rate": 1e-2, "S.x": 1e-3}


def table():
    """Return the texts of quantities with the words of their places."""
    lines = (MANUAL / "quantities.md").read_text(encoding="utf-8").splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.count("|") == 11]
    head, *rows = [row for row in rows if not row[0].startswith("---")]
    return [(text, dict(zip(head[1:], row[1:], strict=True))) for row in rows for text in re.findall("`(.*?)`", row[0])]


QUANTITIES = table()


def asked(place, *words):
    return pytest.mark.parametrize("text", [text for text, own in QUANTITIES if own[place] in words])


@pytest.fixture(scope="module")
def hatch():
    """A four-bar with a mass, a spring, a damper, a load and a released input."""
    return gimcli.load(MODELS / "hatch.yaml")


@pytest.fixture(scope="module")
def traced(hatch):
    """A motion with all quantities as columns."""
    return gimcli.trace(hatch, STEPS, measure=[text for text, own in QUANTITIES if own["trace"] == "yes"])


@pytest.fixture(scope="module")
def circuit(hatch):
    return gimcli.trace(hatch, STEPS, circuit=True)


@pytest.fixture(scope="module")
def found(hatch, traced):
    """The results of all places but sweeps, at the inputs of the traced motion."""
    at = {"hinge": traced["hinge"]}
    return {
        "solve": gimcli.solve(hatch, {"hinge": traced["hinge"][ROW]}), "arrays": gimcli.solve(hatch, at),
        "forces": gimcli.forces(hatch, STEPS),
        "at rest": gimcli.holding_forces(hatch, hinge=float(traced["hinge"][ROW])),
        "equilibrium": gimcli.equilibrium(hatch), "simulate": gimcli.simulate(hatch, 0.2),
    }  # fmt: skip


def alike(some, expected, rel=1e-8):
    expected = np.asarray(expected)
    room = rel * np.max(np.abs(expected[np.isfinite(expected)]), initial=1.0)
    np.testing.assert_allclose(some, expected, rtol=rel, atol=room)


@asked("trace", "yes")
def test_motions_have_the_same_numbers(found, traced, text):
    alike(gimcli.trace(traced.mechanism, STEPS)[text], traced[text])
    alike(found["forces"][text], traced[text])


@asked("solve", *MOVES)
def test_single_positions_have_those_of_the_motion(found, traced, text):
    alike(found["solve"][text], traced[text][ROW])
    alike(found["arrays"][text][1:-1], traced[text][1:-1], 1e-7)


@asked("sweep", "yes")
def test_designs_have_those_of_the_motion(hatch, traced, text):
    rows = [name for name in traced if name.startswith(text) and name not in ("hinge.effort", "step")]
    name = text if text in traced else next(iter(rows), "")
    swept = gimcli.sweep(hatch, DESIGN, steps=STEPS, keep=f"last({name})" if name else text)
    alike(swept[list(swept)[2]][0], traced[name][-1] if name else traced[text])


@asked("circuit", *RESTS)
def test_circuits_have_those_of_positions_at_rest(hatch, circuit, text):
    """Of rows that are the positions of their inputs from the start, whose path has the same direction."""
    for row in (1, 2):
        at = {"hinge": float(circuit["hinge"][row])}
        held = gimcli.holding_forces(hatch, at)
        assert held["L"][0] == pytest.approx(circuit["L"][row], abs=1e-7)
        if "area" not in text and "curvature" not in text and "advantage" not in text:
            alike(circuit[text][row], held[text][0])


@asked("equilibrium", *RESTS)
def test_equilibria_have_those_of_positions_at_rest(hatch, found, text):
    own, known = found["equilibrium"], 0
    for row, one in enumerate(own.equilibria):
        held = gimcli.holding_forces(hatch, hinge=float(own["hinge"][row]))
        if held["L"][0] == pytest.approx(one["nodes"]["L"]):
            alike(own[text][row], held[text][0], 1e-6)
            known += 1
    assert known > 0


def test_forces_at_rest_are_those_of_the_potential(hatch, found):
    """Efforts on the circuit are those of the equilibria's own equations, without the effort of the input itself."""
    m = gimcli.load(MODELS / "snap_hinge.yaml")
    curve, own = gimcli.equilibrium(m).curve(), gimcli.equilibrium(m)
    inputs, effort = curve["motor"][5:60:9], curve["effort"][5:60:9]
    held = [gimcli.holding_forces(m, motor=float(value))["motor.effort"][0] for value in inputs]
    np.testing.assert_allclose(np.abs(held), np.abs(effort), atol=1e-9)
    for one in own, found["equilibrium"]:  # in the first row of the hatch the hand works
        alike(one["energy.potential"][1:], one["potential"][1:])
    np.testing.assert_allclose(found["equilibrium"]["hinge.effort"][1:], 0.0, atol=1e-9)
    np.testing.assert_allclose(own["motor.effort"], 0.0, atol=1e-9)
    np.testing.assert_allclose(0.5 * own["snap.torque"] ** 2 / 0.6, own["potential"], atol=1e-9)


@asked("simulate", "yes")
def test_simulations_have_those_of_positions_and_their_differences(found, text):
    own = found["simulate"]
    assert len(own[text]) == len(own.times)
    assert np.isfinite(own[text]).any() or "curvature" in text
    if "." in text and text.split(".")[-1] in ("x", "angle"):
        rate = {"x": text[:-1] + "vx", "angle": text.replace("angle", "omega")}[text.split(".")[-1]]
        inner = np.gradient(own[text], own["time"])[2:-2]
        np.testing.assert_allclose(own[rate][2:-2], inner, atol=5e-3 * np.max(np.abs(inner)))


def test_springs_and_dampers_have_their_law(hatch, traced):
    """Of the strut: force = rate (length - free), its damping 1500 N s/m of the rate of its length, by differences."""
    free = 45.0 + 100.0 * 600.0 / 400.0
    length = np.hypot(traced.xy["S"][:, 0] - 72.0, traced.xy["S"][:, 1] + 22.0)
    alike(traced["strut.length"], length)
    alike(traced["strut.force"], 400.0 * (length - free) / 100.0)
    fine = gimcli.trace(hatch, 2000)
    slope = np.gradient(fine["strut.length"], fine["time"]) / 100.0
    np.testing.assert_allclose(fine["strut.damping"][5:-5], 1500.0 * slope[5:-5], atol=1e-2)


PLACES = ("solve", "circuit", "at rest", "equilibrium", "simulate")


@pytest.mark.parametrize(("text", "place"), [(t, p) for t, own in QUANTITIES for p in PLACES if own[p] == "no"])
def test_elsewhere_a_result_names_the_place_that_has_it(found, circuit, text, place):
    with pytest.raises(KeyError) as error:
        (circuit if place == "circuit" else found[place])[text]
    assert re.fullmatch(r"'[^\n]*`gim \w+[^\n]*'", str(error.value).replace('"', "'")), error.value


@asked("of", "yes")
@pytest.mark.few(15)
def test_derivatives_are_those_of_differences(hatch, traced, text):
    """By a mass, a stiffness and a place; differences of changed files, of the second order."""
    result = gimcli.sensitivity(hatch, of=text, by=list(CHANGES), steps=STEPS, samples=0)
    for name in result.names:
        alike(result.value[name], traced[name])
        for dimension, step in CHANGES.items():
            value = hatch.written.dimensions[dimension].value
            high, low = (
                gimcli.trace(hatch.with_({dimension: value + h}), STEPS, measure=[text] if name in traced else [])[name]
                for h in (step, -step)
            )
            found, defined = result.derivatives[name][dimension], text != "hypot(L.vx, L.vy)"  # not where it is 0
            inner = ... if defined else slice(1, -1)
            alike(np.asarray(found)[inner], np.asarray((high - low) / (2.0 * step))[inner], 1e-5)


@asked("of", "no")
def test_elsewhere_sensitivities_name_the_place_that_has_it(hatch, text):
    with pytest.raises(GimError, match="`gim sweep"):
        gimcli.sensitivity(hatch, of=text, at={"hinge": FAR}, samples=0)


@asked("trace", "Python")
def test_columns_are_no_numbers(hatch, text):
    with pytest.raises(GimError, match="`gim sweep --keep` have numbers of a motion"):
        gimcli.trace(hatch, STEPS, measure=text)
    with pytest.raises(GimError, match="`gim sweep --keep` have numbers of a motion"):
        gimcli.forces(hatch, STEPS, measure=text)


@asked("trace", "Python")
def test_numbers_of_a_motion_are_those_of_its_rows(hatch, found, traced, text):
    rows = gimcli.trace(hatch, STEPS)
    expected = {
        "stroke:L.x": np.ptp(rows["L.x"]), "max(L.x)": np.max(rows["L.x"]),
        "mean(lid.angle)": np.mean(rows["lid.angle"]),
        "worst_transmission": min(np.min(rows["transmission"]), 180.0 - np.max(rows["transmission"])),
    }  # fmt: skip
    if text in expected:
        assert traced[text] == pytest.approx(expected[text], rel=1e-9)
    assert found["forces"][text] == pytest.approx(traced[text], rel=1e-9)
    assert isinstance(found["simulate"][text], float)


def test_pages_and_the_view_show_the_graphs_of_expressions(hatch, traced):
    texts = ["hypot(L.x - 50, L.y)", "|A.f|", "lid.omega"]
    shown = gimcli.trace(hatch, STEPS, plot=texts).animation()
    assert [graph.columns for graph in shown.graphs] == [(text,) for text in texts]
    alike(shown.clips[0].table["|A.f|"], traced["hypot(A.fx, A.fy)"])
    alike(shown.clips[0].table[texts[0]], traced[texts[0]])
    motion = gimcli.simulate(hatch, 0.2, plot=texts).animation()
    assert [graph.columns for graph in motion.graphs] == [(text,) for text in texts]
    settings = {"steps": STEPS, "plot": ",".join(texts), "measure": ["strut.length"]}
    with running(MODELS / "hatch.yaml", **settings) as client:
        values = client.solve(hinge=float(traced["hinge"][ROW]))["values"]
    for name, text in {**dict.fromkeys(["strut.length", *texts]), "|A.f|": "hypot(A.fx, A.fy)"}.items():
        assert values[name] == pytest.approx(gimcli.trace(hatch, STEPS)[text or name][ROW], rel=1e-7)


def test_files_of_forces_have_the_measures(hatch, traced, tmp_path):
    names = ["L.x", "lid.omega", "strut.length", "hypot(A.fx, A.fy)"]
    found = gimcli.forces(hatch, STEPS, measure=names)
    for name in names:
        alike(found.table()[name], traced[name])
    assert list(gimcli.simulate(hatch, 0.1, measure=names).table().names[-3:]) == names[1:]
