"""One headless Chromium for all tests of pages."""

import os

import pytest
from chromium import NotInstalledError, started

REQUIRED = os.environ.get("GIM_BROWSER") == "required"
"""Whether a missing browser is a failure (.ci/run) and not a skip."""


@pytest.fixture(scope="session")
def chromium():
    """A WebDriver of the system's Chromium."""
    try:
        with started() as browser:
            yield browser
    except NotInstalledError as missing:
        text = f"{missing} is not installed: pages are not tested (apt-get install chromium chromium-driver)"
        if REQUIRED:
            pytest.fail(text)
        pytest.skip(text)


@pytest.fixture
def browser(chromium):
    """The browser with a window of 1280 x 900 pixels and empty logs."""
    chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    chromium.get("about:blank")
    for kind in ("browser", "performance"):
        chromium.get_log(kind)
    return chromium
