"""When a search ends early: after some seconds, or at Ctrl-C; the best designs are then those found so far."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from gimcli.progress import WorkLimit


class SearchStop(WorkLimit):
    """The bound on a search in seconds; the first Ctrl-C reaches it too, and sets `interrupted`."""

    interrupted = False

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Turn the first Ctrl-C into an end of the search; the second one interrupts as usual."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        before = signal.getsignal(signal.SIGINT)

        def heard(*_: Any) -> None:
            self.interrupted = self.reached = True
            signal.signal(signal.SIGINT, before)

        signal.signal(signal.SIGINT, heard)
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)
