"""The live page in a real browser: saved files and dragged sliders move the drawing."""

import time

import pytest
from bundled import MODELS
from live_server import running
from pages import OpenPage

import gimcli

PATIENCE = 10.0
"""Seconds after which a condition that is not fulfilled fails; a condition takes some hundredths of a second."""

LIMITED = """\
nodes: {A: [0, 0], B: [4, 0.5], C: [5.2, 2.4], D: [4, 0]}
ground: [A, D]
links: {a: {nodes: [A, B], length: 4}, b: {nodes: [B, C], length: 1.5}, c: {nodes: [D, C], length: 2}}
actuators: {"<img src=x onerror=alert(1)>": {type: rotary, pivot: A, arm: B, law: {from: 20, to: 40}}}
"""


class LivePage(OpenPage):
    """The page of a live view, with its motion."""

    def __init__(self, browser, client, solved=True):
        self.browser = browser
        browser.get(client.server.url)
        self.until("!gim.data" if not solved else "gim.state().rows > 0 && !document.getElementById('live').hidden")

    def until(self, condition):
        """Wait until a condition of the page is true."""
        end = time.monotonic() + PATIENCE
        while not self.script(f"return Boolean({condition})"):
            assert time.monotonic() < end, condition
            time.sleep(0.01)

    def drag(self, value, kind="range", event="input"):
        """Move the first slider, or write into its number field."""
        self.script(
            "const e = document.querySelector('#live input[type=' + arguments[1] + ']'); e.value = arguments[0];"
            "e.dispatchEvent(new Event(arguments[2]))", value, kind, event,
        )  # fmt: skip

    def read(self, kind="number"):
        """Return the value of the first slider or number field."""
        return float(self.script("return document.querySelector('#live input[type=' + arguments[0] + ']').value", kind))

    def follows(self, positions, name):
        """Wait until a node is within a pixel of its position, scaled by the nodes O2 and O4 of Norton's model."""
        x, y = positions[name]
        end = time.monotonic() + PATIENCE
        while True:
            first, second = self.screen("O2"), self.screen("O4")
            if abs(self.screen(name) - (first + (second - first).real / 100.0 * complex(x, -y))) < 1.0:
                return
            assert time.monotonic() < end, name
            time.sleep(0.01)


@pytest.fixture
def norton(tmp_path):
    path = tmp_path / "norton.yaml"
    path.write_text((MODELS / "crank_rocker.yaml").read_text())
    return path


def test_a_slider_moves_the_mechanism_to_the_positions_of_solve(browser, norton):
    mechanism = gimcli.load(norton)
    with running(norton, steps=36) as client:
        page = LivePage(browser, client)
        for angle in (15.0, 200.0, 340.5):
            page.drag(angle)
            page.follows(gimcli.solve(mechanism, motor=angle).xy, "B")
            assert page.read() == angle
        page.until(f"document.getElementById('readout').textContent.includes('motor = {angle:g} deg')")
        page.drag(-100, kind="number", event="change")
        page.follows(gimcli.solve(mechanism, motor=-100).xy, "B")
        page.script("gim.set({row: 9})")
        page.follows(gimcli.solve(mechanism, motor=90).xy, "B")
        page.until("document.querySelector('#live input').value === '90'")
        page.drag(91)
        page.follows(gimcli.solve(mechanism, motor=91).xy, "B")
        page.script("[...document.querySelectorAll('#live button')].pop().click()")
        page.follows(gimcli.solve(mechanism, motor=90).xy, "B")
        page.drag(93)
        page.follows(gimcli.solve(mechanism, motor=93).xy, "B")
        page.script("gim.set({row: 9})")  # the row that it was before
        page.until("document.querySelector('#live input').value === '90'")
        assert {url.split("/")[2] for url in page.requests()} == {f"127.0.0.1:{client.port}"}
        assert page.faults() == []


def test_a_row_chosen_before_a_position_by_hand_is_drawn_is_reported(browser, norton):
    with running(norton, steps=36) as client:
        page = LivePage(browser, client)
        page.script("gim.set({row: 9})")
        page.until("document.querySelector('#live input').value === '90'")
        page.script(
            "window.heard = 0; gim.addEventListener('row', () => window.heard++);"
            "gim.pose([[0, 0], [100, 0], [30, 30], [90, 60]]); gim.set({row: 9})"
        )
        page.until("window.heard === 1")


def test_a_saved_file_is_shown_and_its_errors(browser, norton):
    text = norton.read_text()
    with running(norton, steps=36) as client:
        page = LivePage(browser, client)
        page.set(row=9, toggles={"ghosts": True})
        norton.write_text(text.replace("length: 120}", "length: 115}"))
        changed = gimcli.solve(gimcli.load(norton), motor=90).xy
        page.follows(changed, "B")
        assert page.state["row"] == 9
        assert page.state["toggles"]["ghosts"]
        norton.write_text(text.replace("ground: [O2, O4]", "ground: [O2, <b>]"))
        page.until("document.getElementById('message').textContent")
        assert "norton.yaml:13:14: node '<b>' is not declared" in page.text("#message")
        assert not page.hidden("#message")
        page.tick()
        page.follows(changed, "B")
        page.drag(30)
        page.until("gim.state().row === 9")
        norton.write_text(text)
        page.until("!document.getElementById('message').textContent")
        page.follows(gimcli.solve(gimcli.load(norton), motor=30).xy, "B")  # still as set by hand
        assert page.faults() == []


def test_an_input_stops_at_its_limit_and_names_are_inert(browser, tmp_path):
    (tmp_path / "m.yaml").write_text(LIMITED)
    with running(tmp_path / "m.yaml", steps=36) as client:
        page = LivePage(browser, client)
        page.drag(70, kind="number", event="change")
        page.until("document.querySelector('#live .reason').textContent.includes('ends at a limit')")
        assert "ends at a limit, <img src=x onerror=alert(1)> = 51.889 deg" in page.text("#live .reason")
        assert page.read() == pytest.approx(51.889, abs=1e-3)
        assert page.text("#live label") == "<img src=x onerror=alert(1)>"
        page.drag(40)
        page.until("!document.querySelector('#live .reason').textContent")
        assert page.script("return document.images.length") == 0
        assert page.faults() == []


def test_a_file_with_errors_at_the_start_is_waited_for(browser, norton):
    text = norton.read_text()
    norton.write_text(text.replace("ground", "grounds"))
    with running(norton, steps=36) as client:
        page = LivePage(browser, client, solved=False)
        page.until("document.getElementById('message').textContent.includes('norton.yaml:13:1: ')")
        norton.write_text(text)
        page.until("gim.state().rows === 37")
        assert page.hidden("#message")
        assert page.faults() == []


def test_keys_move_a_slider_by_its_step(browser, norton):
    from selenium.webdriver import Keys

    with running(norton, steps=36) as client:
        page = LivePage(browser, client)
        page.script("document.querySelector('#live input').focus()")
        page.press(Keys.ARROW_RIGHT, Keys.ARROW_RIGHT, Keys.PAGE_UP)
        page.follows(gimcli.solve(gimcli.load(norton), motor=page.read()).xy, "B")
        assert page.read() > 30.0
        assert page.state["row"] == 0


def test_the_end_of_the_server_is_reported_and_a_new_one_is_shown(browser, norton):
    with running(norton, steps=36) as client:
        page, port = LivePage(browser, client), client.port
    page.until("document.getElementById('message').textContent.includes('Start it again')")
    norton.write_text(norton.read_text().replace("length: 120}", "length: 115}"))
    with running(norton, port=port, steps=24):
        page.until("window.gim && gim.state().rows === 25")
        assert page.hidden("#message")


def test_a_parameter_has_a_slider(browser, norton):
    norton.write_text(norton.read_text().replace("length: 40}", "length: r}") + "parameters: {r: 40, x: 1}\n")
    mechanism = gimcli.load(norton)
    with running(norton, steps=36) as client:
        page = LivePage(browser, client)
        page.drag(90.0)
        page.follows(gimcli.solve(mechanism, motor=90).xy, "B")
        page.script("window.first = document.getElementById('parameter-0')")
        for value in (35.0, 30.0):
            page.script(
                "first.value = arguments[0]; first.dispatchEvent(new Event('input'))", value
            )  # the input stays at 90 deg as it was set by hand
            page.follows(gimcli.solve(mechanism.with_({"r": value}), motor=90).xy, "B")
        assert page.script("return first.isConnected && [first.min, first.max].join()") == "20,80"
        assert page.script("return document.getElementById('parameter-0-value').value") == "30"
        write = "const e = document.getElementById('parameter-0-value'); e.value = arguments[0];"
        write += "e.dispatchEvent(new Event('change'))"
        page.script(write, -1)
        page.until("document.getElementById('message').textContent.includes('crank.length: expected a number above')")
        page.script("[...document.querySelectorAll('#live button')].pop().click()")
        page.until("!document.getElementById('message').textContent")
        page.until("first.value === '40'")
        page.follows(gimcli.solve(mechanism, motor=90).xy, "B")
        page.script(write, 45)
        page.follows(gimcli.solve(mechanism.with_({"r": 45}), motor=90).xy, "B")
        norton.write_text(norton.read_text().replace("x: 1}", "y: 1, x: 1}"))
        page.until("document.querySelectorAll('#live input[type=range]').length === 4")
        page.until("document.getElementById('parameter-0').value === '45'")
        assert [fault for fault in page.faults() if "409" not in fault] == []  # 409: of the motion before
