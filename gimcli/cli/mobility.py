"""`gim mobility`: what can move, what is held twice, what nothing drives."""

from __future__ import annotations

import typer

from gimcli.cli.arguments import MODEL, Json, ModelPath

NAME = "mobility"
HELP = (
    "Count freedoms: Gruebler's formula, rank of the constraint Jacobian, confirmed mobility; name redundant"
    " constraints and undriven nodes.\n\n"
    "Example: gim mobility models/parallelogram_third_crank.yaml"
)


def command(model: ModelPath = MODEL, as_json: Json = False) -> None:
    """Analyse the mobility at the assembled position nearest to the drawn one."""
    from gimcli.cli.console import print_json, print_table
    from gimcli.library.load import load
    from gimcli.library.mobility import mobility

    result = mobility(load(model))
    if as_json:
        print_json(result.report())
        return
    found, start = result.found, result.start
    print_table(result.mechanism.name, ("", ""), result.rows())
    if found.stuck:
        typer.echo(
            f"The inputs do not determine the drawn position: {start}. `gim singularities` lists such positions;"
            " draw the start elsewhere to avoid it."
        )
    if found.singular:
        typer.echo(
            f"The drawn position is singular: it seems to have {found.apparent} freedoms, its neighbours have"
            f" {found.mobility}."
        )
