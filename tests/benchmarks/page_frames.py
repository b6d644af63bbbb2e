"""Time of the script of an animated page for one frame, in a browser: a scissor lift of 13 stages, 40 moving nodes.

Run: python tests/benchmarks/page_frames.py [--frames 400] [--out FOLDER]

The rows are drawn as the page starts, and with names, curves, ghost poses and vectors. The time is that of the script;
the browser then paints in other threads. The goal is at most 4 ms for 95 % of the frames.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from machine import RESULTS, Row, keep, show  # isort: skip - first: one thread
from chains import scissor
from chromium import NotInstalledError, started
from pages import OpenPage

import gimcli

__all__ = ["NotInstalledError", "main"]

STAGES = 13
GOAL = 4.0
"""Time for 95 % of the frames [ms]."""

SWITCHED = {"names": True, "curves": True, "ghosts": True, "velocity": True, "acceleration": True}

FRAMES = """
const done = arguments[1], times = [], rows = gim.state().rows;
let left = arguments[0];
function frame() {
  gim.set({row: (7 * left) % rows});
  const begin = performance.now();
  gim.draw();
  times.push(performance.now() - begin);
  left -= 1;
  left ? requestAnimationFrame(frame) : done(times);
}
requestAnimationFrame(frame);
"""


def measured(frames: int, folder: Path) -> list[Row]:
    """Return the times of frames [ms] with the switches at the start, and with all on."""
    mechanism = gimcli.load(scissor(STAGES) | {"trace": [f"L{STAGES}", f"C{STAGES}"]})
    path = folder / "scissor.html"
    gimcli.trace(mechanism, 360).save(path)
    rows: list[Row] = []
    with started() as browser:
        for label, toggles in (("at the start", {}), ("all switches on", SWITCHED)):
            page = OpenPage(browser, path)
            page.set(toggles=toggles)
            times = sorted(browser.execute_async_script(FRAMES, frames))
            at = [times[int(part * (len(times) - 1))] for part in (0.5, 0.95)]
            moving = len(mechanism.nodes) - len(mechanism.members[0].nodes)
            rows.append({"page": label, "moving nodes": moving, "median [ms]": at[0], "95 % [ms]": at[1], "goal": GOAL})
    return rows


def main(arguments: list[str] | None = None) -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--out", type=Path, default=RESULTS)
    chosen = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as folder:
        rows = measured(chosen.frames, Path(folder))
    show("script of a page for one frame", rows)
    keep("page_frames", rows, chosen.out)


if __name__ == "__main__":
    main()
