"""`gim groups`: the driving links and Assur groups of a mechanism."""

from __future__ import annotations

from gimcli.cli.arguments import MODEL, NONE, Json, ModelPath, Out, PngFile, Set
from gimcli.cli.console import print_table
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options

HELP = (
    "Groups are listed in the order of formation, with class and order. 2,0^(3,4) is a group of 2 links that adds 0"
    " degrees of freedom: links 3 and 4. Links are numbered in the order of formation; the frame is 0."
)
EXAMPLES = ("gim groups watt_1 -o watt_1.groups.png",)
HEAD = ("", "", "class", "order", "links", "joined to", "driven by")


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    out: Out = NONE,
    png: PngFile = None,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:
    """Print the groups in the order of formation."""
    from gimcli.cli.outputs import Outputs, by_machine
    from gimcli.library.groups import GroupsResult, groups

    outputs = Outputs(GroupsResult, model, out, png=png, as_json=as_json, drawing=drawing)
    found = groups(outputs.loaded(changes=changes))
    outputs.finish(found, by_machine(lambda f: print_table(f.headline(), HEAD, f.rows(), (3,))))
