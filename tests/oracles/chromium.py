"""A headless Chromium of the system, driven by selenium."""

import shutil
import tempfile
from contextlib import contextmanager

OPTIONS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-extensions",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage",
    "--force-prefers-reduced-motion", "--window-size=1280,900",
)  # fmt: skip
NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")


class NotInstalledError(Exception):
    """The browser, its driver or selenium is missing."""


@contextmanager
def started():
    """Yield a WebDriver with a new profile that is removed at the end; raise NotInstalledError."""
    try:
        from selenium.webdriver import Chrome, ChromeOptions, ChromeService
    except ImportError:
        raise NotInstalledError("selenium") from None
    program, driver = next(filter(None, map(shutil.which, NAMES)), None), shutil.which("chromedriver")
    if program is None or driver is None:
        raise NotInstalledError("Chromium" if program is None else "chromedriver")
    options = ChromeOptions()
    options.binary_location = program
    for option in OPTIONS:
        options.add_argument(option)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        options.add_argument(f"--user-data-dir={profile}")
        browser = Chrome(options=options, service=ChromeService(driver))
        browser.set_script_timeout(20)
        try:
            yield browser
        finally:
            browser.quit()
