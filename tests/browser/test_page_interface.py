"""`window.gim`: other data, single poses and messages, as the live view uses them; reports on the page."""

import json
from dataclasses import replace

import numpy as np
import pytest
from bundled import MODELS
from pages import OpenPage

import gimcli
from gimcli.output.page import page, page_json
from gimcli.rounding import Section


@pytest.fixture(scope="module")
def crank():
    return gimcli.load(MODELS / "crank_rocker.yaml")


@pytest.fixture
def opened(browser, crank, tmp_path):
    """The page of a crank-rocker."""
    gimcli.trace(crank, 36).save(tmp_path / "crank.html")
    return OpenPage(browser, tmp_path / "crank.html")


def data(mechanism, steps=36):
    return json.loads(page_json(gimcli.trace(mechanism, steps).animation()))


def test_other_data_keep_row_switches_and_graphs(opened, crank):
    opened.set(row=18, toggles={"ghosts": True, "names": False}, graphs=[{"columns": ["B.x"], "over": "time"}])
    opened.press("++")
    before, size = opened.state, opened.screen("O4") - opened.screen("O2")
    opened.script("gim.show(arguments[0]); gim.draw();", data(crank, 72))
    after = opened.state
    assert (after["row"], after["rows"]) == (36, 73)
    assert after["toggles"] == before["toggles"]
    assert after["graphs"] == before["graphs"]
    assert abs(opened.screen("O4") - opened.screen("O2") - size) < 0.01  # the same window
    assert opened.faults() == []


def test_a_pose_by_hand(opened, crank):
    """Nodes are at the given coordinates; a pose that is not solved shows its reason."""
    found = gimcli.solve(crank, motor=133)
    nodes = [found.xy[name].tolist() for name in crank.nodes]
    scale = (opened.screen("O4") - opened.screen("O2")).real / 100.0
    opened.script("gim.pose(arguments[0], {text: 'motor = 133 deg'}); gim.draw();", nodes)
    x, y = found.xy["B"]
    assert abs(opened.screen("B") - opened.screen("O2") - scale * complex(x, -y)) < 0.5
    assert opened.text("#readout") == "motor = 133 deg"
    lost = {"text": "motor = 133 deg", "status": "unreachable", "reason": "beyond a limit"}
    opened.script("gim.pose(arguments[0], arguments[1]); gim.draw();", nodes, lost)
    assert opened.text("#reason") == "unreachable: beyond a limit"
    opened.script("gim.pose(null); gim.draw();")
    assert opened.hidden("#reason")
    assert opened.text("#readout").startswith("row 1 of 37")


def test_messages_are_text(opened):
    words = "model.yaml:3:1: <b>unknown</b> key\nmodel.yaml:9:2: expected a number"
    opened.script("gim.message(arguments[0], 'error')", words)
    assert opened.text("#message") == words
    assert opened.texts("#message *") == []
    assert not opened.hidden("#message")
    opened.script("gim.message(null)")
    assert opened.hidden("#message")


def test_an_empty_page_waits_for_data(browser, crank, tmp_path):
    path = tmp_path / "empty.html"
    path.write_text(page(None, scripts=["window.ready = Boolean(window.gim);"], connect=True), encoding="utf-8")
    opened = OpenPage(browser, path)
    assert opened.script("return window.ready")
    assert opened.hidden("#player")
    opened.script("gim.message('model.yaml:1:1: expected a name', 'error')")
    opened.press("n")  # keys do nothing without data
    opened.script("gim.show(arguments[0]); gim.draw();", data(crank))
    assert not opened.hidden("#player")
    assert opened.hidden("#message")
    assert opened.text("#title") == crank.name
    assert abs(opened.screen("O4") - opened.screen("O2")) > 100
    assert opened.faults() == []


def test_a_listener_hears_of_rows(opened):
    opened.script("window.seen = []; gim.addEventListener('row', row => seen.push(row));")
    opened.set(row=7)
    opened.set(row=7)
    opened.set(row=9)
    assert opened.script("return seen") == [7, 9]


def test_a_report_is_on_the_page(browser, crank, tmp_path):
    rows = [("<i>swing</i>", "12.3457"), ("ratio", "")]
    report = (
        Section("Type", ("quantity", "value [deg]"), rows, left_out=3),
        Section("Warning", warnings=("Grashof <b>crank-rocker</b>", "no duration")),
    )
    motion = replace(gimcli.trace(crank, 12).animation(), report=report)
    path = tmp_path / "report.html"
    path.write_text(page(motion), encoding="utf-8")
    opened = OpenPage(browser, path)
    assert opened.texts("#report h2") == ["Type", "Warning"]
    assert opened.texts("#report p") == [
        "and 3 more: the file .json or .csv lists all", "Grashof <b>crank-rocker</b>", "no duration",
    ]  # fmt: skip
    assert opened.texts("#report th") == ["quantity", "value [deg]"]
    assert opened.texts("#report td") == ["<i>swing</i>", "12.3457", "ratio", ""]
    assert opened.texts("#report .warning h2") == ["Warning"]
    assert opened.script("return document.documentElement.scrollWidth <= innerWidth")


def test_zoom_and_fit(opened):
    """The wheel enlarges about the pointer; Fit shows everything again."""
    first = opened.screen("B"), opened.screen("O2")
    turn = "new WheelEvent('wheel', {deltaY: -100, clientX: arguments[0], clientY: arguments[1], cancelable: true})"
    opened.script(f"document.getElementById('drawing').dispatchEvent({turn})", first[0].real, first[0].imag)
    assert abs(opened.screen("B") - first[0]) < 0.5  # places of the pointer are whole pixels
    assert abs(opened.screen("O2") - first[0]) > 1.1 * abs(first[1] - first[0])
    opened.click("#fit")
    assert abs(opened.screen("O2") - first[1]) < 0.01


def test_two_fingers_enlarge(opened):
    distance = abs(opened.screen("O4") - opened.screen("O2"))
    opened.script(
        """
        const canvas = document.getElementById("drawing"), box = canvas.getBoundingClientRect();
        canvas.setPointerCapture = () => 0;
        const touch = (kind, id, x) => canvas.dispatchEvent(new PointerEvent(kind,
          {pointerId: id, pointerType: "touch", clientX: box.left + x, clientY: box.top + 200, bubbles: true}));
        touch("pointerdown", 1, 200); touch("pointerdown", 2, 300); touch("pointermove", 2, 400);
        touch("pointerup", 1, 200); touch("pointerup", 2, 400);
        """
    )
    assert abs(opened.screen("O4") - opened.screen("O2")) == pytest.approx(2.0 * distance, rel=1e-6)


def test_nothing_is_drawn_between_rows_that_do_not_follow_each_other(browser, crank, tmp_path):
    """Curves are lines from row to row, but not over a row without a position, nor to the start of another branch."""
    found = gimcli.trace(crank, 12)
    motion, coupler = found.animation(), found.xy["P"] @ [1, 1j]
    clip = motion.clips[0]
    places, status = clip.positions.copy(), list(clip.status)
    places[3], status[3] = np.nan, "unreachable"
    broken = replace(clip, positions=places, status=tuple(status), breaks=(8,))
    path = tmp_path / "broken.html"
    path.write_text(page(replace(motion, clips=(broken,))), encoding="utf-8")
    opened = OpenPage(browser, path)
    opened.set(row=12, toggles={"names": False, "curves": False})
    left, top, _, _ = opened.place("#drawing")
    corner, scale = opened.screen("O2") - complex(left, top), (opened.screen("O4") - opened.screen("O2")).real / 100.0
    without = opened.pixels()
    opened.set(toggles={"curves": True})
    changed = np.any(opened.pixels() != without, axis=2)

    def drawn(first, second):
        """Whether something of the curve is at the middle of two rows."""
        at = corner + scale * np.conj((coupler[first] + coupler[second]) / 2)
        x, y = int(at.real), int(at.imag)
        return bool(changed[y - 4 : y + 5, x - 4 : x + 5].any())

    assert not drawn(7, 8)
    assert not drawn(2, 4)
    assert not drawn(2, 3)
    assert drawn(5, 6)
    assert drawn(8, 9)
