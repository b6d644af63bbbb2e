"""Animated pages in a browser: opening, requests, pixels of the drawing."""

import base64
import io
import json

import numpy as np
from matplotlib.image import imread


class OpenPage:
    """A page that is open in a browser."""

    def __init__(self, browser, path):
        self.browser = browser
        browser.get(path.resolve().as_uri())

    def script(self, text, *arguments):
        """Run a script and return its value."""
        return self.browser.execute_script(text, *arguments)

    def set(self, **state):
        """Set clip, row, toggles ... and draw."""
        self.script("gim.set(arguments[0]); gim.draw();", state)

    @property
    def state(self):
        return self.script("return gim.state()")

    def text(self, selector):
        """Return the text of an element, also if it is hidden."""
        return self.script("return document.querySelector(arguments[0]).textContent", selector)

    def texts(self, selector):
        return self.script("return [...document.querySelectorAll(arguments[0])].map(e => e.textContent)", selector)

    def hidden(self, selector):
        return not self.script("return document.querySelector(arguments[0]).checkVisibility()", selector)

    def click(self, selector):
        self.script("document.querySelector(arguments[0]).click()", selector)

    def press(self, *keys):
        """Press keys as a user does, where the focus is."""
        from selenium.webdriver import ActionChains

        ActionChains(self.browser, duration=0).send_keys(*keys).perform()

    def tick(self):
        """Wait for two refreshes of the screen."""
        self.browser.execute_async_script(
            "const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()))"
        )

    def screen(self, name):
        """Return the pixel of a node as a complex number, y down."""
        return complex(*self.script("return gim.screen(arguments[0])", name))

    def place(self, selector):
        """Return left, top, width and height of an element in pixels of the window."""
        return self.script(
            "const b = document.querySelector(arguments[0]).getBoundingClientRect();"
            "return [b.left, b.top, b.width, b.height]", selector
        )  # fmt: skip

    def pixels(self, selector="#drawing"):
        """Return the pixels (height, width, 3) of a canvas as it is on the screen."""
        left, top, width, height = self.place(selector)
        shot = self.browser.execute_cdp_cmd(
            "Page.captureScreenshot",
            {"format": "png", "clip": {"x": left, "y": top, "width": width, "height": height, "scale": 1}},
        )
        image = imread(io.BytesIO(base64.b64decode(shot["data"])), format="png")
        return np.rint(255 * image[..., :3]).astype(int)

    def faults(self):
        """Return the errors of the console, such as exceptions and refused loads."""
        return [entry["message"] for entry in self.browser.get_log("browser") if entry["level"] != "INFO"]

    def requests(self):
        """Return the addresses that were requested since the last call."""
        events = [json.loads(entry["message"])["message"] for entry in self.browser.get_log("performance")]
        sent = [e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"]
        return [url for url in sent if not url.startswith("data:")]
