"""`gim sensitivity`: how positions depend on the dimensions, and their spread within tolerances."""

from __future__ import annotations

from typing import Any

import numpy as np
import typer

from gimcli.canonical import first_greatest
from gimcli.cli.arguments import INPUTS
from gimcli.cli.console import print_table
from gimcli.cli.from_verb import from_verb
from gimcli.library.sensitivity import sensitivity
from gimcli.library.sensitivity_result import SensitivityResult
from gimcli.rounding import at_inputs, number
from gimcli.table import labelled

HELP = (
    "Exact derivatives of points, angles and transmission angles by the numbers of the model file, at one position"
    " (--at) or along the motion. If the model has `tolerances`, also the worst case, the root of the sum of squares"
    " (RSS) and random designs. Writes MODEL.sensitivity.csv and .png."
)
EXAMPLES = (
    "gim sensitivity crank_rocker --of P --at motor=30",
    'gim sensitivity crank_rocker --of "range(rocker.angle)"',
    "gim sensitivity jansen --of foot.y --by m,j -o foot.png",
)
TOLERANCES = "Tolerances"
DIMENSIONS = 12
"""Largest number of dimensions of a quantity that are printed."""


def _print(found: SensitivityResult) -> None:
    typer.echo(found.headline())
    if found.reason:
        typer.echo(found.reason)
    if found.fixed:
        more = f" and {len(found.fixed) - DIMENSIONS} more" if len(found.fixed) > DIMENSIONS else ""
        typer.echo(f"left out, as redundant constraints fix them: {', '.join(found.fixed[:DIMENSIONS])}{more}")
    if not found.good.any():
        return
    report = found.report()["quantities"]
    for k, name in enumerate(found.names):
        rows = _rows(found, k, report[name]["derivatives"])
        print_table(_title(found, k), _head(found), rows[:DIMENSIONS], right=(1, 2, 3) if found.spread else (1,))
        if len(rows) > DIMENSIONS:
            typer.echo(f"... and {len(rows) - DIMENSIONS} smaller ones (the table and --json list all)")
    if found.spread is not None:
        _print_spread(found, report)
    for most in found.most.values():
        typer.echo(most.text)


def _title(found: SensitivityResult, k: int) -> str:
    unit = "" if found.units[k] == "unit" else f" {found.units[k]}"
    value = found.value[found.names[k]]
    if not found.by_rows:
        return f"{found.names[k]} = {number(value)}{unit}"
    return f"{found.names[k]}: {number(float(np.nanmin(value)))} to {number(float(np.nanmax(value)))}{unit}"


def _head(found: SensitivityResult) -> tuple[str, ...]:
    derivative = "largest derivative" if found.by_rows else "derivative"
    effect = "effect (rms)" if found.by_rows else "effect"
    return (
        "dimension", derivative, *(("tolerance", effect) if found.spread else ()), "unit",
        *(("at",) if found.by_rows else ()),
    )  # fmt: skip


def _rows(found: SensitivityResult, k: int, derivatives: dict[str, Any]) -> list[tuple[str, ...]]:
    """Return the dimensions of a quantity, the one with the largest effect first."""
    rows = []
    for n in np.argsort(-found.effects[k], kind="stable").tolist():
        one, own = found.dimensions[n], derivatives[found.dimensions[n].name]
        allowed = found.tolerances[n]
        tolerance = (f"{allowed:.4g}", f"{found.effects[k, n]:.4g}") if allowed else ("", "")
        where = (_where(found, own),) if found.by_rows else ()
        rows.append((one.name, _short(own["value"]), *(tolerance if found.spread else ()), own["unit"], *where))
    return rows


def _where(found: SensitivityResult, own: dict[str, Any]) -> str:
    return at_inputs(found.mechanism, own.get("at", {}))


def _short(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}" if abs(value) > 1e-12 else "0"


def _print_spread(found: SensitivityResult, report: dict[str, Any]) -> None:
    """Print the spread of each quantity; of a motion where the first-order standard deviation is largest."""
    head = ["quantity", "worst case", "RSS", "sd, first order"]
    sampled, spread = found.sampled, found.spread
    if spread is None:
        return
    if sampled is not None:
        head[4:4] = ["sd, random designs", "mean shift"]
    rows = []
    for k, name in enumerate(found.names):
        row = first_greatest(spread.deviation[k])
        cells = [f"±{spread.worst[k, row]:.4g}", f"±{spread.rss[k, row]:.4g}", f"{spread.deviation[k, row]:.4g}"]
        if sampled is not None:
            for value, error in ((sampled.deviation, sampled.deviation_error), (sampled.mean, sampled.mean_error)):
                cells.append(f"{value[k, row]:.4g} ± {error[k, row]:.2g}")
        where = (_where(found, report[name]["sd"]),) if found.by_rows else ()
        rows.append((labelled(name, found.units[k]), *cells, *where))
    title = "Spread within the tolerances" + (", where it is largest" if found.by_rows else "")
    print_table(title, (*head, *(("at",) if found.by_rows else ())), rows, right=range(1, len(head)))
    if found.left_out:
        typer.echo(f"without the tolerances of {', '.join(found.left_out)}")
    if sampled is not None:
        typer.echo(
            f"{sampled.samples} random designs, {found.distribution} distribution, seed {found.seed};"
            f" {int(sampled.samples - sampled.solved.min())} without a position; ±: standard error"
        )


OPTIONS = {
    "of": typer.Option(
        "--of", metavar="QUANTITY", rich_help_panel=INPUTS,
        help='P, P.x, member, transmission, angle:A/B; of a motion also numbers as in `gim sweep --keep`, such as'
        ' "max(P.y)"; repeatable; default: the traced points.\n'
        '`P`: x and y of a node or point; a member: its direction;'
        " `transmission:B`: at a node; also velocities, accelerations and jerks, such as `P.vx` or"
        " `rocker.alpha`.",
    ),
    "by": typer.Option(
        "--by", metavar="NAME,NAME", rich_help_panel=INPUTS,
        help="Dimensions or actuators; repeatable; default: all numbers of the file that move a node.\n"
        "Of those the ones that are not given by a formula, and all inputs. An actuator stands for its input.",
    ),
    "samples": typer.Option(
        "--samples", metavar="N", rich_help_panel=TOLERANCES,
        help="Random designs within the tolerances (default 10000; 0: none).\n"
        "Only if the model has `tolerances`.",
    ),
    "seed": typer.Option("--seed", metavar="N", rich_help_panel=TOLERANCES),
    "distribution": typer.Option(
        "--distribution", metavar="NAME", rich_help_panel=TOLERANCES, show_default=False,
        help="normal (default; the tolerance is 3 standard deviations) or uniform.\n"
        "Of each dimension within its tolerance, independent of the others; uniform: the tolerance is half the"
        " width.",
    ),
}  # fmt: skip
command = from_verb(sensitivity, SensitivityResult, _print, OPTIONS, writes=True)
