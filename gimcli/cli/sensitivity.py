"""`gim sensitivity`: how positions depend on the dimensions, and their spread within tolerances."""

from __future__ import annotations

from typing import Any

import numpy as np
import typer

from gimcli.canonical import first_greatest
from gimcli.cli.arguments import INPUTS
from gimcli.cli.console import print_records, print_remarks, print_table
from gimcli.cli.from_verb import from_verb
from gimcli.library.record import Records, RowField
from gimcli.library.sensitivity import sensitivity
from gimcli.library.sensitivity_result import SensitivityResult
from gimcli.mechanism import FloatArray
from gimcli.rounding import at_inputs, number, spaced
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
    more = f" and {len(found.fixed) - DIMENSIONS} more" * (len(found.fixed) > DIMENSIONS)
    left_out = f"left out, as redundant constraints fix them: {', '.join(found.fixed[:DIMENSIONS])}{more}"
    print_remarks(found.headline(), (found.reason, found.reason), (found.fixed, left_out))
    if not found.good.any():
        return
    report = found.report()["quantities"]
    for k, name in enumerate(found.names):
        head, rows, right = _dimensions(found, k, report[name]["derivatives"]).cells()
        print_table(_title(found, k), head, rows[:DIMENSIONS], right)
        smaller = f"... and {len(rows) - DIMENSIONS} smaller ones (the table and --json list all)"
        print_remarks((len(rows) > DIMENSIONS, smaller))
    if found.spread is not None:
        _print_spread(found, report)
    print_remarks(*(most.text for most in found.most.values()))


def _title(found: SensitivityResult, k: int) -> str:
    unit = spaced(found.units[k])
    value = found.value[found.names[k]]
    if not found.by_rows:
        return f"{found.names[k]} = {number(value)}{unit}"
    return f"{found.names[k]}: {number(float(np.nanmin(value)))} to {number(float(np.nanmax(value)))}{unit}"


def _dimensions(found: SensitivityResult, k: int, derivatives: dict[str, Any]) -> Records:
    """Return the dimensions of a quantity, one row each, the one with the largest effect first."""
    order = np.argsort(-found.effects[k], kind="stable").tolist()
    names, tolerated, moves = [list(derivatives)[n] for n in order], found.spread is not None, found.by_rows
    own, allowed = [derivatives[name] for name in names], [found.tolerances[n] or None for n in order]
    effects = [found.effects[k, n] if found.tolerances[n] else None for n in order]
    heads = ("largest derivative", "effect (rms)") if moves else ("derivative", "effect")
    return Records(
        RowField("dimension", names, head="dimension"),
        RowField("value", own, float, head=heads[0], text=[_short(one["value"]) for one in own]),
        RowField("tolerance", allowed, float, head="tolerance" if tolerated else None, text="{:.4g}".format),
        RowField("effect", effects, float, head=heads[1] if tolerated else None, text="{:.4g}".format),
        RowField("unit", [one["unit"] for one in own], head="unit"),
        RowField("at", [at_inputs(found.mechanism, one.get("at", {})) for one in own], head="at" if moves else None),
    )


def _short(value: float | None) -> str:
    return "-" if value is None else f"{value:.6g}" if abs(value) > 1e-12 else "0"


def _print_spread(found: SensitivityResult, report: dict[str, Any]) -> None:
    """Print the spread of each quantity; of a motion where the first-order standard deviation is largest."""
    sampled, spread, moves = found.sampled, found.spread, found.by_rows
    assert spread is not None
    rows = [first_greatest(deviations) for deviations in spread.deviation]

    def field(head: str, values: FloatArray, text: str, errors: FloatArray | None = None) -> RowField:
        own = values if errors is None else errors
        cells = [text.format(values[k, row], own[k, row]) for k, row in enumerate(rows)]
        return RowField(head, rows, float, head=head, text=cells)

    heads = [labelled(name, unit) for name, unit in zip(found.names, found.units, strict=True)]
    fields = [
        RowField("quantity", heads, head="quantity"),
        field("worst case", spread.worst, "±{:.4g}"),
        field("RSS", spread.rss, "±{:.4g}"),
        field("sd, first order", spread.deviation, "{:.4g}"),
    ]
    if sampled is not None:
        fields.append(field("sd, random designs", sampled.deviation, "{:.4g} ± {:.2g}", sampled.deviation_error))
        fields.append(field("mean shift", sampled.mean, "{:.4g} ± {:.2g}", sampled.mean_error))
    at = [at_inputs(found.mechanism, report[name]["sd"].get("at", {})) for name in found.names]
    title = "Spread within the tolerances" + ", where it is largest" * moves
    print_records(title, Records(*fields, RowField("at", at, head="at" if moves else None)))
    drawn = sampled and (
        f"{sampled.samples} random designs, {found.distribution} distribution, seed {found.seed};"
        f" {int(sampled.samples - sampled.solved.min())} without a position; ±: standard error"
    )
    print_remarks(
        (found.left_out, f"without the tolerances of {', '.join(found.left_out)}"),
        (drawn, drawn or ""),
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
