"""Progress on a terminal: a bar that appears after a second and names the phase of the computation.

A spinner and the time turn whether or not the work reports how far it has come.
"""

from __future__ import annotations

import sys
from threading import RLock, Timer
from typing import Any

from gimcli.progress import Progress, no_progress

DRAWING = "drawing"
"""Name of the last phase of most commands."""

DELAY = 1.0
"""Seconds before the bar appears."""

_phases: list[_Phase] = []
_bars: list[Any] = []
_lock = RLock()


def progress_bar(label: str) -> Progress:
    """Begin a phase and end the previous one; return a function of (done, total) that moves its bar."""
    if not sys.stderr.isatty():
        return no_progress
    end_bars()
    phase = _Phase(label)
    _phases.append(phase)
    phase.timer.start()
    return phase.show


def end_bars() -> None:
    """Remove the bar and show the cursor again: before a report, and whenever the program ends."""
    with _lock:
        while _phases:
            _phases.pop().timer.cancel()
        while _bars:
            _bars.pop().stop()


def print_above(text: str) -> None:
    """Print a line on standard error, above the bar if there is one."""
    with _lock:
        if _bars:
            _bars[-1].console.print(text, markup=False, highlight=False, soft_wrap=True)
        else:
            print(text, file=sys.stderr, flush=True)


class _Phase:
    """A phase that may take long; a timer opens its bar, also if the computation does not report progress."""

    def __init__(self, label: str) -> None:
        import time

        self.label, self.clock, self.start = label, time.monotonic, time.monotonic()
        self.bar: Any = None
        self.known = 0, 0
        self.timer = Timer(DELAY, self.open)
        self.timer.daemon = True

    def open(self) -> None:
        """Show the bar, unless the phase has ended."""
        with _lock:
            if self not in _phases or self.bar is not None:
                return
            self.bar = _started()
            self.task = self.bar.add_task(self.label, total=None, part="")
            self.report()

    def show(self, done: int, of: int) -> None:
        """Report the progress: `done` of `of` parts."""
        with _lock:
            self.known = done, of
            if self.bar is not None:
                self.report()
            elif self.clock() - self.start >= DELAY:
                self.open()

    def report(self) -> None:
        """Move the bar; after the last part it shows activity only, as the rest of the phase does not report."""
        done, of = self.known
        if done < of:
            self.bar.update(self.task, completed=done, total=of, part=f"{100 * done // of} %")
        else:
            self.bar.update(self.task, total=None, part="")


def _started() -> Any:
    """Return a bar on the terminal; standard output is not changed."""
    import atexit

    from rich.console import Console
    from rich.progress import BarColumn, Progress as Bar, SpinnerColumn, TextColumn, TimeElapsedColumn

    atexit.register(end_bars)
    part = TextColumn("{task.fields[part]}")
    columns = (SpinnerColumn(), "{task.description}", BarColumn(), part, TimeElapsedColumn())
    bar = Bar(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False, redirect_stderr=False)
    bar.start()
    _bars.append(bar)
    return bar
