"""`--measure` and `--plot` of `gim trace`."""

from __future__ import annotations

from typing import Annotated, Any

import typer

QUANTITIES = "Quantities"

MeasureOption = Annotated[
    list[str],
    typer.Option(
        "--measure", "-m", metavar="KIND:ARGS", rich_help_panel=QUANTITIES,
        help="Add a measure; repeatable; `-m help` lists them.",
    ),
]  # fmt: skip
PlotOption = Annotated[
    str,
    typer.Option(
        "--plot", metavar="QUANTITY,...", rich_help_panel=QUANTITIES,
        help="Graphs of velocity, omega ..., or of measures.",
    ),
]  # fmt: skip


def print_measures() -> None:
    """Print the kinds of measures and end."""
    from gimcli.cli.console import print_table
    from gimcli.measures import help_lines

    print_table("Measures", ("write", "to get"), help_lines())
    raise typer.Exit


def print_ranges(report: dict[str, Any]) -> None:
    """Print the measures' ranges."""
    from gimcli.cli.console import number, print_table

    rows = []
    for spec, found in report.get("measures", {}).items():
        for name, told in found["columns"].items():
            most = "inf" if told["infinite"] else number(told["greatest"], 8)
            empty = f"{told['empty']} rows empty" if told["empty"] else ""
            rows.append((name, told["unit"].replace("unit", ""), number(told["least"], 8), most, empty))
        if "area" in found:
            told = f"{number(found['area'], 6)} ± {found['error']:.1g}"
            rows.append((f"{spec} (region)", found["unit"], "", told, "passed over by the whole motion"))
        if "worst" in found:
            unit = found["columns"][spec]["unit"]
            rows.append((f"{spec} (nearest to 0 or 180 deg)", unit, number(found["worst"], 8), "", ""))
    if rows:
        print_table("", ("measure", "unit", "least", "greatest", ""), rows, right=(2, 3))
