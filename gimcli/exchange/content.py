"""The text of a file that may come from another program."""

from __future__ import annotations

from pathlib import Path

from gimcli.model.source import MOST_BYTES, refuse_size


def content_of(path: Path) -> str:
    """Return the text of a file; "" if it cannot be read or is no text. Older programs write no UTF-8."""
    try:
        with path.open("rb") as handle:
            raw = handle.read(MOST_BYTES + 1)
    except (OSError, ValueError):  # ValueError: a path with a null byte
        return ""
    refuse_size(len(raw), path)
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16", errors="replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")
