"""When a search ends early: after some seconds, or at Ctrl-C; the best designs are then those found so far."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from gimcli.progress import deadline


class SearchStop:
    """Says whether a search shall end; `interrupted` is set by the first Ctrl-C."""

    def __init__(self, seconds: float | None = None) -> None:
        self.late, self.interrupted, self.ended = deadline(seconds), False, False

    def __call__(self) -> bool:
        """Return whether the search shall end now."""
        self.ended = self.ended or self.interrupted or self.late()
        return self.ended

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Turn the first Ctrl-C into an end of the search; the second one interrupts as usual."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.getsignal(signal.SIGINT)

        def heard(*_: Any) -> None:
            self.interrupted = True
            signal.signal(signal.SIGINT, before)

        signal.signal(signal.SIGINT, heard)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)
