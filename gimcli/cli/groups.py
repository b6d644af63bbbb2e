"""`gim groups`: of which driving links and Assur groups a mechanism is formed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gimcli.cli.arguments import MODEL, Json, ModelPath

NAME = "groups"
HELP = (
    "Show the formation sequence: driving links and Assur groups with class and order, each joined to what was formed"
    " before it.\n\n"
    "2,0^(3,4) is the group of links 3 and 4, joined to links 2 and 0; the frame is 0, the others are numbered from 2"
    " in the order of formation. The order of a group is the number of pairs that join it, its class that of its"
    " highest contour: a link of n pairs, or a loop of n links. A pin in a slot is a slider of its own, a linear"
    " actuator between two nodes a link.\n\n"
    "Example: gim groups models/watt_1.yaml --png watt_1.groups.png"
)
HEAD = ("", "", "class", "order", "links", "joined to", "driven by")


def command(
    model: ModelPath = MODEL,
    png: Annotated[Path | None, typer.Option("--png", help="Draw the groups and what joins them.")] = None,
    as_json: Json = False,
) -> None:
    """Show the formation."""
    from gimcli.cli.console import finish, loaded, print_table, write_picture
    from gimcli.library.groups import groups

    found = groups(loaded(model, None, png))
    finish(found, write_picture(found, png), as_json, lambda f: print_table(f.headline(), HEAD, f.rows(), (3,)))
