"""`gim circuits`: the circuits, and the configurations that each connects."""

from __future__ import annotations

import typer

from gimcli.cli.arguments import METHOD
from gimcli.cli.console import print_records, print_remarks
from gimcli.cli.from_verb import from_verb
from gimcli.library.circuits import CircuitsResult, circuits, verdict
from gimcli.structure.rigid_triangles import triangle_hints

HELP = (
    "All configurations are found at --samples values of the input, and each is followed through limits and change"
    " points until the circuit closes. A branch is the part of a circuit between two limits of the input."
)
EXAMPLES = ("gim circuits stephenson_2 -o circuits.png",)


def _print(result: CircuitsResult) -> None:
    print_records(result.headline(), result._curves)
    print_remarks(
        (result.initial is not None, "*: the circuit of the initial configuration"),
        verdict(result._found),
        *triangle_hints(result.mechanism),
    )


command = from_verb(
    circuits, CircuitsResult, _print, {"values": typer.Option("--samples", metavar="N", rich_help_panel=METHOD)}
)
