"""One headless Chromium for all tests of pages."""

import os
import shutil
import tempfile

import pytest

REQUIRED = os.environ.get("GIM_BROWSER") == "required"
"""Whether a missing browser is a failure (.ci/run) and not a skip."""

OPTIONS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-extensions",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
    "--force-prefers-reduced-motion", "--window-size=1280,900",
)  # fmt: skip
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")


def _missing(what):
    text = f"{what} is not installed: the pages are not tested in a browser (apt-get install chromium chromium-driver)"
    if REQUIRED:
        pytest.fail(text)
    pytest.skip(text)


@pytest.fixture(scope="session")
def chromium():
    """A WebDriver of the system's Chromium; a new profile that is removed at the end."""
    try:
        from selenium.webdriver import Chrome, ChromeOptions, ChromeService
    except ImportError:
        _missing("selenium")
    program, driver = next(filter(None, map(shutil.which, NAMES)), None), shutil.which("chromedriver")
    if program is None or driver is None:
        _missing("Chromium" if program is None else "chromedriver")
    options = ChromeOptions()
    options.binary_location = program
    for option in OPTIONS:
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        options.add_argument(f"--user-data-dir={profile}")
        browser = Chrome(options=options, service=ChromeService(driver))
        browser.set_script_timeout(20)
        yield browser
        browser.quit()


@pytest.fixture
def browser(chromium):
    """The browser with a window of 1280 x 900 pixels and empty logs."""
    chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
    chromium.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    chromium.get("about:blank")
    for kind in ("browser", "performance"):
        chromium.get_log(kind)
    return chromium
