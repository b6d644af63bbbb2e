"""`--measure` and `--plot` of `gim trace`."""

from __future__ import annotations

from typing import Any

import typer

from gimcli.cli.arguments import OUTPUT
from gimcli.cli.console import print_more, print_remarks, print_table
from gimcli.errors import refuse
from gimcli.mechanism import Mechanism
from gimcli.rounding import aligned, greatest, length, number

QUANTITIES = "Quantities"

POINTS = 12
"""Greatest number of points whose ranges are printed."""

MEASURES = typer.Option(
    "--measure",
    "-m",
    metavar="QUANTITY",
    rich_help_panel=OUTPUT,
    help="Add a quantity, such as |A.f|; repeatable.\n"
    "A kind of `-m help`, a column or a formula, see [measures](#measures).",
)
PLOT = typer.Option(
    "--plot",
    metavar="GRAPH,...",
    rich_help_panel=QUANTITIES,
    help="Graphs, such as P.vx,|P.v|,omega; gim manual graphs.",
)  # fmt: skip
PLOTS_ONLY = typer.Option("--plot", metavar="GRAPH,...", rich_help_panel=OUTPUT, help=PLOT.help)
"""For commands whose picture has only the graphs that are named."""


def refuse_unseen(plot: list[str] | None, draws: bool) -> None:
    """Raise UsageError for graphs if no picture is written."""
    refuse(
        (
            plot and not draws,
            "--plot adds graphs to the picture, but no picture is written: use -o FILE.png, or remove --no-png",
        )
    )


def measures_of(given: list[str]) -> list[str]:
    """Return the values of --measure; if one is `help`, print the kinds of measures and end."""
    if "help" not in given:
        return given
    from gimcli.quantities.kinds import help_lines

    print_table("Measures", ("measure", "result"), help_lines())
    raise typer.Exit


def print_ranges(mechanism: Mechanism, report: dict[str, Any]) -> None:
    """Print the measures' ranges."""
    size = mechanism.size * mechanism.scale
    rows = []
    for spec, found in report.get("measures", {}).items():
        for name, column in found["columns"].items():
            least = size if column["unit"] in ("", mechanism.length_unit) else 0.0
            own = greatest((least, column["least"], column["greatest"]))
            most = "inf" if column["infinite"] else number(column["greatest"], own)
            empty = f"{column['empty']} empty rows" if column["empty"] else ""
            rows.append((name, column["unit"], number(column["least"], own), most, empty))
        if "area" in found:
            area = f"{number(found['area'], size**2)} ± {found['error']:.1g}"
            rows.append((f"{spec} (region)", found["unit"], "", area, "region swept in the whole motion"))
        if "worst" in found:
            unit = found["columns"][spec]["unit"]
            rows.append((f"{spec} (least deviation from 0 or 180 deg)", unit, number(found["worst"]), "", ""))
    if rows:
        print_table("", ("measure", "unit", "least", "greatest", ""), rows, right=(2, 3))


def print_points(mechanism: Mechanism, points: dict[str, dict[str, Any]]) -> None:
    """Print the ranges of the traced points, and whether their curves are closed."""
    unit = "" if mechanism.length_unit == "unit" else f" [{mechanism.length_unit}]"
    rows = [("point", f"x{unit}", f"y{unit}", "curve")]
    for name, one in points.items():
        x, y = (" to ".join(dict.fromkeys(length(mechanism, value) for value in one[axis])) for axis in "xy")
        rows.append((name, x, y, one["curve"]))
    print_remarks(*aligned(rows[: POINTS + 1] if points else []))
    print_more(len(points), POINTS)
