"""The live view in Chromium: from saving a file to seeing its motion, and positions a second while a slider is dragged.

The first time is from the replacement of the file to the end of the first frame that shows the new motion; the goal is
at most 0.3 s for a six-bar. The second is the number of answers that are drawn while the slider moves in every frame;
the goal is at least 30 a second. Needs selenium, Chromium and chromedriver.

Run: PYTHONPATH=tests/oracles python tests/benchmarks/view.py [--saves 15] [--seconds 3]
"""

from __future__ import annotations

import argparse
import re
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import machine
from chromium import NotInstalledError, started

__all__ = ["NotInstalledError", "main"]

NAMES = ("crank_rocker", "watt_1", "stephenson_2", "stephenson_3", "jansen", "excavator", "ten_bar", "plantigrade")
SEEN = """
const old = gim.data;
window.seen = 0;
function look() {
  if (gim.data === old) requestAnimationFrame(look);
  else setTimeout(() => { window.seen = Date.now(); });
}
requestAnimationFrame(look);
"""
"""Notes the time after the first frame with other data [ms]."""

DRAG = """
const [seconds, done] = arguments, slider = document.querySelector("#live input[type=range]");
const pose = gim.pose, times = [];
const low = Number(slider.min), span = Number(slider.max) - low, begin = performance.now();
gim.pose = (...given) => { times.push(performance.now()); return pose(...given); };
function move() {
  const part = (performance.now() - begin) / 1000 / seconds;
  if (part >= 1) { gim.pose = pose; done(times); return; }
  slider.value = low + span * (0.5 - 0.4 * Math.cos(2 * Math.PI * part));
  slider.dispatchEvent(new Event("input"));
  requestAnimationFrame(move);
}
move();
"""
"""Moves the slider to and fro; returns the times at which positions were drawn [ms]."""


@contextmanager
def viewing(path: Path) -> Iterator[str]:
    """Run `gim view` (context manager); yields the address of the page."""
    command = [sys.executable, "-m", "gimcli", "view", str(path), "--no-browser", "--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    assert process.stdout is not None
    found = re.search(r"http\S+", process.stdout.readline())
    assert found is not None
    try:
        yield found[0]
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate()


def until(browser: Any, condition: str) -> None:
    """Wait until a condition of the page is true."""
    while not browser.execute_script(f"return Boolean({condition})"):
        time.sleep(0.01)


def saved(browser: Any, path: Path, text: str) -> float:
    """Save a file; return the time until its motion is seen [s]."""
    browser.execute_script(SEEN)
    other = path.with_suffix(".tmp")
    other.write_text(text)
    begin = time.time()
    other.replace(path)
    until(browser, "window.seen")
    return float(browser.execute_script("return window.seen")) / 1000.0 - begin


def measured(browser: Any, path: Path, saves: int, seconds: float) -> machine.Row:
    """Return the times of one mechanism."""
    text = path.read_text()
    with viewing(path) as url:
        browser.get(url)
        until(browser, "gim.data")
        times = sorted(saved(browser, path, f"{text}\n# {k}\n") for k in range(saves))
        drawn = browser.execute_async_script(DRAG, seconds)
    pauses = [(after - before) / 1000.0 for before, after in pairwise(drawn)]
    return {
        "mechanism": path.stem,
        "save to seeing, median [s]": statistics.median(times), "95 % [s]": times[-1 - saves // 20],
        "positions a second": len(drawn) / seconds, "longest pause [s]": max(pauses),
    }  # fmt: skip


def main(arguments: list[str] | None = None) -> None:
    """Measure the mechanisms; print and write the rows."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--saves", type=int, default=15)
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--out", type=Path, default=machine.RESULTS)
    parser.add_argument("names", nargs="*", default=NAMES)
    chosen = parser.parse_args(arguments)
    rows = []
    with tempfile.TemporaryDirectory() as folder, started() as browser:
        for name in chosen.names:
            path = Path(shutil.copy(machine.MODELS / f"{name}.yaml", folder))
            rows.append(measured(browser, path, chosen.saves, chosen.seconds))
    machine.show("live view", rows)
    print(f"\nwritten to {machine.keep('view', rows, chosen.out)}")


if __name__ == "__main__":
    main()
