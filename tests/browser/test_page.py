"""The animated page in a real browser: it shows the table's positions and values, and loads nothing else."""

import csv
import re
import time

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim, read_rows
from pages import OpenPage

import gimcli

HOSTILE = ("</script><img src=x onerror=alert(1)>", '"><svg onload=alert(2)>', "a & b <!-- <script>")
"""Names that would run a script if they were written as HTML."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("pages")


@pytest.fixture(scope="module")
def crank(folder):
    """Page and table of a crank-rocker."""
    path = folder / "crank.html"
    assert gim("trace", MODELS / "crank_rocker.yaml", "-d", 2, "-o", path, "-o", path.with_suffix(".csv")).code == 0
    return path


@pytest.fixture(scope="module")
def cut(folder):
    """Page of a law that exceeds a limit of the input; its rows between the limits are missing."""
    model = folder / "cut.yaml"
    model.write_text(re.sub("law: .*", "law: {from: 90, to: 200}", (MODELS / "chebyshev.yaml").read_text()))
    assert gim("trace", model, "-n", 110, "-o", folder / "cut.html").code == 5
    return folder / "cut.html"


def scale(page):
    """Return pixels per unit, and the pixel of the origin, from two fixed nodes of the crank-rocker."""
    first, second = page.screen("O2"), page.screen("O4")
    return (second - first).real / 100.0, first


def test_loads_without_error_or_request(browser, crank):
    page = OpenPage(browser, crank)
    page.click("#play")
    page.tick()
    assert page.requests() == [crank.resolve().as_uri()]
    assert page.faults() == []
    assert page.state["rows"] == 361


def test_slider_moves_the_nodes_to_the_positions_of_the_table(browser, crank):
    """All nodes are within a pixel of the CSV's coordinates, scaled by two nodes of the frame."""
    page, rows = OpenPage(browser, crank), read_rows(crank.with_suffix(".csv"))
    size, origin = scale(page)
    for row in (0, 57, 180, 300):
        page.script(
            "const s = document.getElementById('slider'); s.value = arguments[0]; s.dispatchEvent(new Event('input'))",
            row,
        )
        page.tick()
        for name in ("P", "B"):
            x, y = float(rows[row][f"{name}.x"]), float(rows[row][f"{name}.y"])
            assert abs(page.screen(name) - (origin + size * complex(x, -y))) < 1.0
    assert f"row {301} of 361" in page.text("#readout")


def test_the_drawing_has_the_pin_at_its_place(browser, crank):
    """The pin's circle is found in the picture of the screen, without the page's own transformation."""
    page, rows = OpenPage(browser, crank), read_rows(crank.with_suffix(".csv"))
    page.set(row=120, toggles={"names": False, "curves": False})
    page.tick()
    size, origin = scale(page)
    at = origin + size * complex(float(rows[120]["B.x"]), -float(rows[120]["B.y"]))
    left, top, _, _ = page.place("#drawing")
    image, x, y = page.pixels(), at.real - left, at.imag - top

    def along(angle):
        """Return the brightness of the pixels at growing distances from the centre."""
        return [image[int(y + r * np.sin(angle)), int(x + r * np.cos(angle))].max() for r in np.arange(0.0, 8.0, 0.5)]

    edges = []
    for angle in np.radians(np.arange(0, 360, 30)):
        dark = np.array(along(angle)) < 190
        edges.append(0.5 * int(np.argmax(dark)) * np.exp(1j * angle))
    assert min(map(abs, edges)) > 2.0  # light inside, and a dark edge in all directions
    assert max(map(abs, edges)) < 7.0
    assert abs(np.mean(edges)) < 0.8  # it is around the place


def test_play_pause_and_repeat(browser, crank):
    page = OpenPage(browser, crank)
    assert not page.state["playing"]  # the browser asks for reduced motion
    page.set(speed=2, row=0)
    page.click("#play")
    browser.execute_async_script(
        "const look = () => gim.state().row > 20 ? arguments[0]() : requestAnimationFrame(look); look()"
    )
    assert page.state["playing"]
    assert page.text("#play") == "Pause"
    page.click("#play")
    stopped = page.state["row"]
    browser.execute_async_script("setTimeout(arguments[0], 100)")
    assert page.state["row"] == stopped


def test_keyboard(browser, crank):
    from selenium.webdriver import Keys

    page = OpenPage(browser, crank)
    steps = [(Keys.ARROW_RIGHT, 1), (Keys.ARROW_RIGHT, 2), (Keys.ARROW_LEFT, 1), (Keys.END, 360), (Keys.HOME, 0)]
    for key, row in steps:
        page.press(key)
        assert page.state["row"] == row
    page.press(Keys.TAB * 30)  # the focus moves through all controls and stays visible
    assert page.script("return document.activeElement !== null")
    page.script("document.activeElement.blur()")
    page.press("g")
    assert page.state["toggles"]["ghosts"]
    speed = page.state["speed"]
    page.press(".")
    assert page.state["speed"] > speed
    page.press(" ")
    assert page.state["playing"]
    page.press(" ")
    assert not page.state["playing"]
    page.press("?")
    assert not page.hidden("#help")
    page.press(Keys.ESCAPE)
    assert page.hidden("#help")
    page.press("i")
    page.tick()
    assert page.text("#tip").startswith("O2\nx = 0")


def test_slider_by_keyboard(browser, crank):
    from selenium.webdriver import Keys

    page = OpenPage(browser, crank)
    page.script("document.getElementById('slider').focus()")
    page.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT)
    assert page.state["row"] == 2


@pytest.mark.parametrize("key", ["names", "curves", "ghosts", "velocity", "acceleration"])
def test_toggles_change_the_drawing(browser, crank, key):
    page = OpenPage(browser, crank)
    before = page.state["toggles"][key]
    page.set(row=40)
    first = page.pixels()
    page.click(f"#toggle-{key}")
    page.tick()
    assert page.state["toggles"][key] is not before
    assert np.any(first != page.pixels())


@pytest.mark.parametrize("name", ["B", "P"])
def test_speeds_of_nodes_and_points(browser, crank, name):
    """The note at a node, or at a point of a member, has the speeds of the table."""
    page, row = OpenPage(browser, crank), read_rows(crank.with_suffix(".csv"))[75]
    page.set(row=75)
    at = page.screen(name)
    page.script(
        "document.getElementById('drawing').dispatchEvent(new PointerEvent('pointermove',"
        " {clientX: arguments[0], clientY: arguments[1], bubbles: true}))", at.real, at.imag,
    )  # fmt: skip
    page.tick()
    words = page.text("#tip").split("\n")
    speed, acceleration = (np.hypot(float(row[f"{name}.{k}x"]), float(row[f"{name}.{k}y"])) for k in "va")
    assert words[0] == name
    assert float(words[1].split()[2]) == pytest.approx(float(row[f"{name}.x"]), rel=1e-5)
    assert float(words[3].split()[1]) == pytest.approx(speed, rel=1e-5)
    assert float(words[4].split()[1]) == pytest.approx(acceleration, rel=1e-5)


def test_hover_shows_lengths(browser, crank):
    page = OpenPage(browser, crank)
    page.set(row=10)
    at = (page.screen("A") + page.screen("O2")) / 2
    page.script(
        "document.getElementById('drawing').dispatchEvent(new PointerEvent('pointermove',"
        " {clientX: arguments[0], clientY: arguments[1], bubbles: true}))", at.real, at.imag,
    )  # fmt: skip
    page.tick()
    assert page.text("#tip") == "crank\nO2 – A: 40 mm"


def test_cursor_of_a_graph_reads_the_table(browser, crank):
    """Six digits of the table, for columns and a row that are chosen on the page."""
    page, rows = OpenPage(browser, crank), read_rows(crank.with_suffix(".csv"))
    page.set(graphs=[{"columns": ["P.vx", "rocker.omega"], "over": "motor"}], row=210)
    for name, words in zip(("P.vx", "rocker.omega"), page.texts(".graph .value"), strict=True):
        found = re.fullmatch(re.escape(name) + r" = (\S+) \S+", words)
        assert found[1] == f"{float(rows[210][name]):.6g}"


def test_an_axis_of_a_graph_has_its_unit_three_ticks_and_zero(browser, crank):
    page = OpenPage(browser, crank)
    page.script(
        "const own = CanvasRenderingContext2D.prototype, write = own.fillText; window.written = [];"
        "own.fillText = function (text, ...at) {"
        " window.written.push([text, this.textAlign]); write.call(this, text, ...at); }"
    )
    for column, unit in (("P.vx", "mm/s"), ("P.ay", "mm/s^2"), ("rocker.angle", "deg"), ("rocker.alpha", "deg/s^2")):
        page.script("window.written.length = 0")
        page.set(graphs=[{"columns": [column], "over": "motor"}])
        written = page.script("return window.written")
        ticks = [text for text, side in written if side == "right"]
        values = [float(row[column]) for row in read_rows(crank.with_suffix(".csv"))]
        assert f"[{unit}]" in [text for text, _ in written]
        assert len(ticks) >= 3
        assert "0" in ticks or min(values) * max(values) > 0.0


def test_a_graph_shows_a_finite_peak_whole(browser, crank):
    """A crank-rocker has no pole: the range of every column is that of its values."""
    page = OpenPage(browser, crank)
    columns = page.script(
        "return JSON.parse(document.getElementById('data').textContent).clips[0].columns.map(c => [c.name, ...c.shown])"
    )
    rows = read_rows(crank.with_suffix(".csv"))
    for name, low, high in columns:
        values = [float(row[name]) for row in rows]
        assert (low, high) == pytest.approx((min(values), max(values)), rel=1e-5, abs=1e-5 * max(map(abs, values)))


def test_a_graph_is_a_slider_too(browser, crank):
    page = OpenPage(browser, crank)
    left, top, width, _ = page.place(".graph canvas[role=img]")
    page.script(
        "document.querySelector('.graph canvas[role=img]').dispatchEvent(new PointerEvent('pointerdown',"
        " {clientX: arguments[0], clientY: arguments[1], pointerId: 1}))", left + 58 + (width - 70) / 4, top + 40,
    )  # fmt: skip
    assert abs(page.state["row"] - 90) <= 1


def test_columns_are_chosen_from_a_list(browser, crank):
    page = OpenPage(browser, crank)
    page.script("document.querySelector('.graph details').open = true")
    page.tick()
    labels = page.texts(".graph fieldset label")
    with open(crank.with_suffix(".csv"), newline="") as handle:
        head = next(csv.reader(handle))
    assert {label.strip().partition(" [")[0] for label in labels} >= set(head) - {"status"}
    box = next(k for k, label in enumerate(labels) if "coupler.alpha" in label)
    page.script("document.querySelectorAll('.graph fieldset input')[arguments[0]].click()", box)
    assert "coupler.alpha" in page.state["graphs"][0]["columns"]


def test_unsolved_rows_show_their_reason_and_no_mechanism(browser, cut):
    page = OpenPage(browser, cut)
    page.set(row=5, toggles={"curves": False, "names": False})
    assert page.hidden("#reason")
    solved = page.pixels()
    page.set(row=60)
    reason = page.text("#reason")
    assert not page.hidden("#reason")
    assert gimcli.trace(gimcli.load(MODELS / "chebyshev.yaml"), 1).status[0] == "ok"
    assert "unreachable" in reason
    assert "ends at a limit" in reason
    page.script("document.getElementById('reason').style.visibility = 'hidden'")
    dark = [np.count_nonzero(image.max(axis=2) < 80) for image in (solved, page.pixels())]
    assert 100 < dark[1] < 0.5 * dark[0]  # only the supports
    assert "no value" in page.text(".graph .value")
    assert len(page.script("return [...document.querySelectorAll('#marks .gap')]")) == 1
    assert any("limit at motor = 101.537 deg" in text for text in page.texts("#events button"))


def played(page, seconds, each=0.05):
    """Return the rows that are shown in some seconds of the clock of the page, without waiting for them."""
    for _ in range(50):
        rows = page.script(
            """
            const [seconds, each] = arguments, rows = [], real = window.requestAnimationFrame, asked = [];
            window.requestAnimationFrame = frame => asked.push(frame);
            gim.set({playing: true});
            for (let now = 0; now <= 1000 * seconds && asked.length; now += 1000 * each) {
              asked.splice(0).forEach(frame => frame(now));
              rows.push(gim.state().row);
            }
            window.requestAnimationFrame = real;
            return rows;
            """, seconds, each,
        )  # fmt: skip
        if rows:
            return rows
        page.set(playing=False, row=0)  # a frame that was asked for before is still to come
        time.sleep(0.1)
    return []


def test_playing_is_in_real_time(browser, crank):
    """At speed 0.5 the law of 1 s takes 2 s: 9 rows of 361 in each twentieth of a second, then from the start."""
    page = OpenPage(browser, crank)
    page.set(speed=0.5, row=0)
    rows = played(page, 2.5)
    assert np.all(np.abs(np.array(rows[:40]) - 9.0 * np.arange(40)) <= 1.0)
    assert abs(rows[50] - 90) <= 1


def test_playing_stays_short_at_a_gap(browser, cut):
    """To and fro over the solved rows: the 99 rows without a position are one pause, not played one by one."""
    page = OpenPage(browser, cut)
    page.set(speed=1, row=0)
    rows = played(page, 5.0)
    assert max(rows) == 12
    assert rows.count(12) >= 10  # a pause of 0.6 s, on both ways
    assert rows.count(0) >= 2  # it came back


def test_names_are_text(browser, folder):
    """Names of the model, nodes and members with HTML are shown as they are, and nothing runs."""
    first, second, third = HOSTILE
    model = {
        "name": first,
        "nodes": {first: [0, 0], "A": [1, 0], second: [3, 2], "D": [4, 0]},
        "ground": [first, "D"],
        "links": {third: [first, "A"], "b": ["A", second], "c": [second, "D"]},
        "actuators": {"m<b>": {"type": "rotary", "pivot": first, "arm": "A", "law": {"by": 90}}},
    }
    path = folder / "hostile.html"
    gimcli.trace(gimcli.load(model), 12).save(path)
    page = OpenPage(browser, path)
    page.set(row=3, toggles={"ghosts": True})
    for key in "iiiiiii":
        page.press(key)
    page.tick()
    assert page.text("#title") == first
    assert page.texts("img, svg, #title *") == []
    assert page.faults() == []
    assert page.requests() == [path.resolve().as_uri()]
    assert page.script("return document.querySelectorAll('script').length") == 2


def test_policy_allows_nothing_from_outside(browser, crank):
    """A script cannot load, connect, or run inline code; the policy refuses each."""
    page = OpenPage(browser, crank)
    refused = browser.execute_async_script(
        """
        const done = arguments[0], seen = [];
        document.addEventListener("securitypolicyviolation", event => seen.push(event.effectiveDirective));
        fetch("http://127.0.0.1:9/x").catch(() => 0);
        new Image().src = "http://127.0.0.1:9/x.png";
        const script = document.createElement("script");
        script.textContent = "window.ran = 1";
        document.body.append(script);
        const frame = document.createElement("iframe");
        frame.src = "http://127.0.0.1:9/";
        document.body.append(frame);
        setTimeout(() => done([...seen, window.ran || 0]), 300);
        """
    )
    assert refused[-1] == 0
    assert {"connect-src", "img-src", "script-src-elem", "frame-src"} <= set(refused[:-1])
    page.faults()


def test_dark_and_light(browser, crank):
    page = OpenPage(browser, crank)
    light = page.pixels()[5, 5]
    page.press("d")
    page.tick()
    dark = page.pixels()[5, 5]
    assert page.state["theme"] == "dark"
    assert light.min() > 240
    assert dark.max() < 60
    browser.execute_cdp_cmd(
        "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": "dark"}]}
    )
    assert OpenPage(browser, crank).state["theme"] == "dark"


def test_telephone(browser, crank):
    """At a width of 360 pixels nothing is wider than the screen, and controls can be hit by a finger."""
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride", {"width": 360, "height": 740, "deviceScaleFactor": 2, "mobile": True}
    )
    page = OpenPage(browser, crank)
    assert page.script("return document.documentElement.scrollWidth") == 360
    for selector in ("#play", "#back", "#forth", "#toggle-velocity", "#speed"):
        left, _, width, height = page.place(selector)
        assert left >= 0
        assert left + width <= 360
        assert height >= 36
    page.set(row=90)
    assert page.state["row"] == 90


def test_circuits_are_chosen_from_a_list(browser, folder):
    path = folder / "circuits.html"
    found = gimcli.circuits(gimcli.load(MODELS / "chebyshev.yaml"), values=8)
    found.save(path)
    page = OpenPage(browser, path)
    names = page.texts("#clip option")
    assert len(names) == len(found.report()["curves"])
    page.script("const s = document.getElementById('clip'); s.value = '1'; s.dispatchEvent(new Event('change'))")
    assert page.state["clip"] == 1
    assert page.script("return document.getElementById('toggle-velocity').disabled")
    assert "no velocities" in page.text("#toggles")


def test_configurations_are_chosen_from_a_list(browser, folder):
    path = folder / "configurations.html"
    found = gimcli.configurations(gimcli.load(MODELS / "crank_rocker.yaml"), motor=30)
    found.save(path)
    page = OpenPage(browser, path)
    size, origin = scale(page)
    for k in range(found.count):
        page.set(clip=k)
        x, y = found.xy["B"][k]
        assert abs(page.screen("B") - (origin + size * complex(x, -y))) < 1.0
    assert page.hidden("#slider")
    assert found.count == 2


def test_a_notebook_shows_the_page_in_a_frame(browser, folder):
    """The frame draws the mechanism, and its scripts have no access to the notebook."""
    path = folder / "notebook.html"
    cell = gimcli.trace(gimcli.load(MODELS / "crank_rocker.yaml"), 24)._repr_html_()
    path.write_text(f"<!DOCTYPE html><meta charset='utf-8'><link rel='icon' href='data:,'>{cell}", encoding="utf-8")
    page = OpenPage(browser, path)
    look = "try { return frames[0].document.title } catch (refused) { return refused.name }"
    assert page.script(look) == "SecurityError"
    browser.switch_to.frame(0)
    assert page.state["rows"] == 25
    page.click("#play")
    assert page.state["playing"]
    browser.switch_to.default_content()
    assert page.faults() == []
    assert page.requests() == [path.resolve().as_uri()]
