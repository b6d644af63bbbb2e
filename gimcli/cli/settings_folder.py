"""A folder for the settings and fonts of matplotlib, where the user's own folders cannot be written."""

from __future__ import annotations

import os
import sys

FOLDER = "matplotlib"


def provide_settings_folder() -> None:
    """Let matplotlib use a folder in our cache if it cannot write to its own, as a user without own folders.

    Otherwise it would warn in each run, and search for fonts again.
    """
    if "MPLCONFIGDIR" in os.environ or all(map(_can_be_written, _usual_folders())):
        return
    from gimcli.kernels.jit import user_folder

    folder = user_folder(FOLDER)
    if folder is not None:
        os.environ["MPLCONFIGDIR"] = str(folder)


def _usual_folders() -> list[str]:
    """Return the folders of matplotlib's settings and of its cache."""
    own = os.path.expanduser("~")
    if not sys.platform.startswith(("linux", "freebsd")):
        return [os.path.join(own, ".matplotlib")]
    usual = {"XDG_CONFIG_HOME": ".config", "XDG_CACHE_HOME": ".cache"}
    return [os.path.join(os.environ.get(name) or os.path.join(own, part), FOLDER) for name, part in usual.items()]


def _can_be_written(folder: str) -> bool:
    """Return whether a folder can be written, or be created."""
    while folder and not os.path.lexists(folder):
        folder = os.path.dirname(folder)
    return os.path.isdir(folder) and os.access(folder, os.W_OK)
