"""Printing: tables, JSON and notes; rich is loaded only when a table is drawn."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import typer


def clean(value: Any) -> Any:
    """Return a value that JSON can hold: NaN and infinity become null."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {k: clean(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [clean(v) for v in value]
    return value


def print_json(data: dict[str, Any]) -> None:
    """Print one JSON object."""
    typer.echo(json.dumps(clean(data), ensure_ascii=False))


def print_table(title: str, head: Sequence[str], rows: Iterable[Iterable[str]], right: Iterable[int] = ()) -> None:
    """Print a table; columns named in `right` are numbers."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(title=title or None, box=box.SIMPLE_HEAD, title_justify="left", title_style="bold", pad_edge=False)
    table.show_header = any(head)
    numbers = set(right)
    for k, name in enumerate(head):
        table.add_column(name, justify="right" if k in numbers else "left", overflow="fold")
    for row in rows:
        table.add_row(*row)
    console = Console(highlight=False, markup=False, soft_wrap=False)
    if not console.is_terminal:
        console = Console(highlight=False, markup=False, width=160)
    with console.capture() as drawn:  # rich itself would end the program where the reader has gone away
        console.print(table)
    typer.echo(drawn.get(), nl=False)


def note(text: str) -> None:
    """Print a line for the user's eyes; standard output stays clean."""
    typer.echo(text, err=True)


def number(value: float, digits: int = 10) -> str:
    """Return a number readable in a table."""
    return f"{value:.{digits}g}" if math.isfinite(value) else "-"


Progress = Callable[[int, int], None]


def progress_bar(label: str) -> Progress:
    """Return a function of (done, of) that shows a bar after one second, on a terminal only."""
    import time

    if not sys.stderr.isatty():
        return lambda done, of: None
    start = time.monotonic()
    state: dict[str, Any] = {}

    def show(done: int, of: int) -> None:
        if "bar" not in state:
            if time.monotonic() - start < 1.0 or done >= of:
                return
            from rich.console import Console
            from rich.progress import Progress as Bar

            state["bar"] = Bar(console=Console(stderr=True), transient=True)
            state["bar"].start()
            state["task"] = state["bar"].add_task(label, total=of)
        state["bar"].update(state["task"], completed=done)
        if done >= of:
            state["bar"].stop()

    return show
