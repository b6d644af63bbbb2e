"""The page of a sweep: one slider for each dimension chooses the design, which is drawn with its own dimensions."""

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim, refused
from pages import OpenPage

import gimcli

VALUES = {"crank.length": [20.0, 35.0, 50.0], "P.y": [20.0, 60.0]}


@pytest.fixture(scope="module")
def family(tmp_path_factory):
    path = tmp_path_factory.mktemp("family") / "a.html"
    vary = [f"--vary={name}={','.join(map(str, values))}" for name, values in VALUES.items()]
    assert gim("sweep", MODELS / "crank_rocker.yaml", *vary, "--steps", 36, "--keep=max(P.y)", "-o", path).code == 0
    return path


def slide(page, number, place):
    page.script(
        "const i = document.getElementById(arguments[0]); i.value = arguments[1]; i.dispatchEvent(new Event('input'));"
        " gim.draw();", f"design-{number}", place,
    )  # fmt: skip


def test_sliders_choose_the_design(browser, family):
    """Node and point of the page are where a trace of the design has them."""
    page, m = OpenPage(browser, family), gimcli.load(MODELS / "crank_rocker.yaml")
    page.set(playing=False, row=9)
    for first, second in ((0, 0), (2, 0), (2, 1), (1, 1)):
        slide(page, 0, first)
        slide(page, 1, second)
        design = {"crank.length": VALUES["crank.length"][first], "P.y": VALUES["P.y"][second]}
        t = gimcli.trace(m.with_(design), 36)
        origin, other = page.screen("O2"), page.screen("O4")
        size = (other - origin).real / 100.0
        for name in "AP":
            x, y = t.xy[name][9]
            assert abs(page.screen(name) - (origin + size * complex(x, -y))) < 1.0, (name, design)
        assert page.texts(".design-row label") == [f"crank.length = {design['crank.length']:g} mm",
                                                   f"P.y = {design['P.y']:g} mm"]  # fmt: skip
        assert f"max(P.y) = {np.max(t.xy['P'][:, 1]):.6g} mm" in page.text("#note")
        assert page.state["clip"] == 2 * first + second
    assert page.faults() == []


def test_ghosts_and_curves_are_drawn(browser, family):
    page = OpenPage(browser, family)
    page.set(toggles={"ghosts": True})
    slide(page, 0, 1)
    assert page.hidden("#clip")
    assert page.faults() == []


def test_pages_without_a_family_have_no_sliders(browser, tmp_path):
    assert gim("trace", MODELS / "crank_rocker.yaml", "-n", 12, "-o", tmp_path / "a.html").code == 0
    page = OpenPage(browser, tmp_path / "a.html")
    assert page.hidden("#designs")
    assert page.faults() == []


def test_a_sample_has_one_slider_and_large_families_fewer_values(tmp_path):
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    found = gimcli.sweep(m, {"crank.length": "uniform(30,50)"}, samples=5, steps=12).animation()
    assert [(s.name, s.values) for s in found.sliders] == [("design", (1.0, 2.0, 3.0, 4.0, 5.0))]
    found = gimcli.sweep(m, {"crank.length": "30:50:41", "O4.x": "105:95:31"}, steps=2).animation()
    first, second = (s.values for s in found.sliders)
    assert len(first) * len(second) == len(found.clips) <= 400
    assert (first[0], first[-1], second[0], second[-1]) == (30.0, 50.0, 95.0, 105.0)
    assert found.notes == (f"{len(found.clips)} of 1271 designs are shown; a table has all.",)
    for name in (found.clips[0].name, found.clips[-1].name):
        assert name.startswith("design ")


def test_there_is_no_film(tmp_path):
    assert "a sweep has no film" in refused(
        "sweep", MODELS / "crank_rocker.yaml", "--vary", "crank=30,40", "-o", tmp_path / "a.gif"
    )
