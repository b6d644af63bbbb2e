"""The live view as a whole: the model that follows its file, and the server."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import Any

from gimcli.errors import UsageError, reason
from gimcli.progress import Notify, Phases, no_phases
from gimcli.view.live_model import LiveModel
from gimcli.view.server import USUAL_PORT, ViewServer


@contextmanager
def served(
    path: Path, changes: Mapping[str, str], assembly: str, port: int | None, settings: Mapping[str, Any], note: Notify,
    progress: Phases = no_phases,
) -> Iterator[ViewServer]:  # fmt: skip
    """Solve a model file, follow its changes and listen on a port (context manager); the caller runs the server.

    `changes` are values of dimensions by name, as for `Mechanism.with_`. Without a port it is the usual one, or a free
    one if that is in use. Raises UsageError if the given port is in use, and the errors of `LiveModel.begin`.
    """
    model = LiveModel(path, changes, assembly, settings, note)
    with bound(model, port) as server:
        model.begin(progress)
        follower = Thread(target=model.follow, name="follow the file", daemon=True)
        follower.start()
        try:
            yield server
        finally:
            model.end()
            follower.join(1.0)


def bound(model: LiveModel, port: int | None) -> ViewServer:
    """Return a server that listens on a port, or on the usual or a free one."""
    try:
        return ViewServer(model, USUAL_PORT if port is None else port)
    except OSError as error:
        if port is None:
            return ViewServer(model)
        raise UsageError(f"port {port}: {reason(error)}; choose another, or 0 for any free port") from None
