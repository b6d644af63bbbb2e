"""`gim groups`: of which driving links and Assur groups a mechanism is formed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import MODEL, Json, ModelPath

if TYPE_CHECKING:
    from gimcli.mechanism import Mechanism
    from gimcli.structure.assur import Formation

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


def command(
    model: ModelPath = MODEL,
    png: Annotated[Path | None, typer.Option("--png", help="Draw the groups and what joins them.")] = None,
    as_json: Json = False,
) -> None:
    """Show the formation."""
    from gimcli.cli.console import print_json
    from gimcli.model import load
    from gimcli.output import refuse_files
    from gimcli.structure import formation_report
    from gimcli.structure.assur import formation
    from gimcli.structure.drive_check import explained
    from gimcli.structure.mobility import refuse_unfit
    from gimcli.structure.plan import make_plan

    mechanism = load(model)
    refuse_files(mechanism.files, None, png)
    with explained(mechanism):
        make_plan(mechanism)
        refuse_unfit(mechanism)
        found = formation(mechanism)
    if png is not None:
        _draw(mechanism, found, png)
    if as_json:
        print_json({**formation_report.as_json(mechanism, found), "png": str(png) if png else None})
        return
    _print(mechanism, found)
    if png is not None:
        typer.echo(f"wrote {png}")


def _print(mechanism: Mechanism, found: Formation) -> None:
    from gimcli.cli.console import print_table
    from gimcli.structure.formation_report import class_of, described, drivers, joined

    rows = []
    for group, formula in zip(found.groups, found.formula, strict=True):
        on = ", ".join(f"{found.links[k]} at {' '.join(names)}" for k, names in joined(found, group).items())
        note = f", {group.surplus} redundant" if group.surplus else ""
        links = ", ".join(found.links[k] for k in group.links)
        rows.append(
            (formula, described(group) + note, class_of(group), str(group.order), links, on,
             ", ".join(drivers(mechanism, group)))
        )  # fmt: skip
    head = ("", "", "class", "order", "links", "joined to", "driven by")
    print_table(f"{mechanism.name}: {'  '.join(found.formula)}", head, rows, (3,))


def _draw(mechanism: Mechanism, found: Formation, path: Path) -> None:
    from gimcli.mechanism import FRAME
    from gimcli.output import draw_groups
    from gimcli.output.groups import Box, BoxJoint
    from gimcli.structure.formation_report import class_of, described, drivers, joined, layers

    home = {link: k for k, group in enumerate(found.groups, start=1) for link in group.links} | {FRAME: 0}
    boxes, joints = [Box((f"0: {found.links[FRAME]}",), 0, "frame")], []
    for k, (group, layer, formula) in enumerate(zip(found.groups, layers(found), found.formula, strict=True), start=1):
        own = [f"{found.numbers[link]}: {found.links[link]}" for link in group.links]
        driven = [f"driven by {', '.join(drivers(mechanism, group))}"] if group.drivers else []
        lines = (formula, f"{described(group)}, class {class_of(group)}, order {group.order}", *_short(own), *driven)
        boxes.append(Box(lines, layer, "driving" if group.driving else "group"))
        above: dict[int, tuple[list[str], list[str]]] = {}
        for base, names in joined(found, group).items():
            pairs, tags = above.setdefault(home[base], ([], []))
            pairs += names
            tags.append(str(found.numbers[base]))
        joints += [BoxJoint(upper, k, " ".join(pairs), ", ".join(tags)) for upper, (pairs, tags) in above.items()]
    draw_groups(boxes, joints, path, f"{mechanism.name}: formation")


def _short(names: list[str], width: int = 3) -> list[str]:
    """Return names in lines of a few."""
    return [", ".join(names[k : k + width]) for k in range(0, len(names), width)]
