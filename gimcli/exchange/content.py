"""The text of a file or an address that may come from another program."""

from __future__ import annotations

import re
from pathlib import Path

from gimcli.errors import ModelError

MOST_BYTES = 4_000_000
ADDRESS = re.compile(r"https?://", re.IGNORECASE)


def is_address(model: Path | str) -> bool:
    """Return whether a model is given as the address of a web page; pages are never fetched, the address has it all."""
    return isinstance(model, str) and ADDRESS.match(model.strip()) is not None


def content_of(path: Path) -> str:
    """Return the text of a file; "" if it cannot be read or is no text. Older programs write no UTF-8."""
    try:
        with path.open("rb") as handle:
            raw = handle.read(MOST_BYTES + 1)
    except OSError:
        return ""
    if len(raw) > MOST_BYTES:
        raise ModelError([f"{path}: is too large for a model file; at most {MOST_BYTES // 1_000_000} MB are read"])
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16", errors="replace")
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        return raw.decode("cp1252", errors="replace")
