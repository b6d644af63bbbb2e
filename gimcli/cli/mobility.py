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
    from gimcli.errors import UnassembledError
    from gimcli.model import load
    from gimcli.structure.mobility import assembled, mobility

    mechanism = load(model)
    z = assembled(mechanism)
    if z is None:
        raise UnassembledError(
            f"{mechanism.name} cannot be assembled near its drawn position: draw it closer, or see `gim solve` for the"
            " constraint that is worst off"
        )
    found = mobility(mechanism, z, mechanism.drawn_inputs)
    start = "regular"
    if found.stuck:
        from gimcli.branching.singular_start import singular_start

        start = singular_start(mechanism, z)
    if as_json:
        print_json(
            {
                "gruebler": found.gruebler, "rank": found.rank, "mobility": found.mobility,
                "redundant": list(found.redundant), "undriven": list(found.undriven),
                "actuators": len(found.actuators), "start": start,
                "overdriven": list(found.overdriven), "apparent": found.apparent, "singular": found.singular,
            }
        )  # fmt: skip
        return
    rows = [
        ("Grübler's count", str(found.gruebler)),
        ("rank of the constraint Jacobian", str(found.rank)),
        ("mobility", str(found.mobility)),
        ("redundant constraints", ", ".join(found.redundant) or "none"),
        ("actuators", ", ".join(a.name for a in mechanism.actuators) or "none"),
        ("undriven nodes", ", ".join(found.undriven) or "none"),
        ("over-driven by", ", ".join(found.overdriven) or "none"),
    ]
    print_table(mechanism.name, ("", ""), rows)
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
