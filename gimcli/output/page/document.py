"""The HTML document: template, style, scripts and data in one file that loads nothing else.

All names are inert: they are in the JSON data with `<`, `>` and `&` escaped, and the scripts write them as text only. A
content security policy allows the style and the scripts of the document by their hashes, and nothing from outside.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path
from string import Template

from gimcli.output.animation import Animation
from gimcli.output.atomic import written_text
from gimcli.output.page.data import page_data

FOLDER = Path(__file__).parent

SCRIPTS = (
    "theme", "decode", "camera", "pose", "ink", "symbols", "curves", "vectors", "names", "hover",
    "stage", "graph", "timebar", "player", "panel", "designs", "keys", "pointer", "main",
)  # fmt: skip
"""The scripts in their order; together they are one function."""

EMPTY = "Mechanism"
"""The title of a page without an animation."""


def page(animation: Animation | None, *, scripts: Sequence[str] = (), connect: bool = False) -> str:
    """Return the HTML document of an animation.

    Args:
        animation: None for an empty page that waits for data.
        scripts: texts of further scripts, which run after those of the page and use `window.gim`.
        connect: allow the scripts to connect to the server that the page comes from.
    """
    data = page_json(animation) if animation is not None else "null"
    style, own = _text("page.css"), _script()
    parts = {
        "policy": _policy(style, (own, *scripts), connect),
        "title": escape(animation.title if animation is not None else EMPTY),
        "style": style,
        "data": data,
        "script": "</script>\n<script>".join((own, *scripts)),
    }
    return Template(_text("page.html")).substitute(parts)


def write_html(animation: Animation, path: Path | str) -> None:
    """Write an animation as one HTML file that loads nothing else."""
    with written_text(path) as handle:
        handle.write(page(animation))


def page_json(animation: Animation) -> str:
    """Return the data of the page as JSON that cannot end a script element."""
    text = json.dumps(page_data(animation), allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _policy(style: str, scripts: Sequence[str], connect: bool) -> str:
    allowed = " ".join(_hash(script) for script in scripts)
    rules = ["default-src 'none'", f"script-src {allowed}", f"style-src {_hash(style)}", "img-src data:"]
    rules += ["connect-src 'self'"] * connect
    return "; ".join([*rules, "base-uri 'none'", "form-action 'none'"])


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


@cache
def _script() -> str:
    parts = "\n".join(_text(f"script/{name}.js") for name in SCRIPTS)
    return f'"use strict";\n(() => {{\n{parts}\n}})();'


@cache
def _text(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")
