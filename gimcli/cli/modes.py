"""`gim modes`: natural frequencies and shapes of small vibrations."""

from __future__ import annotations

import cmath
import math

import typer

from gimcli.cli.arguments import INPUTS
from gimcli.cli.console import note_doubtful_loading, print_more, print_records, print_remarks, print_table
from gimcli.cli.from_verb import from_verb
from gimcli.library.modes import ModesResult, modes
from gimcli.rounding import number
from gimcli.table import labelled

HELP = (
    "Inputs with `free: true`, or named by --free, are released, the others are held at --at. The position must be an"
    " equilibrium; --settle goes to one first. Natural frequencies, damping and shapes of small vibrations about it;"
    " -o NAME.png draws the shapes, -o NAME.html shows them in motion. The model needs `masses`."
)
EXAMPLES = (
    "gim modes swing --settle -o swing.png",
    "gim modes double_pendulum -o shapes.html",
)
SHOWN = 12
"""Greatest number of modes whose shapes are printed."""
SEEN = (
    "number", "kind", "frequency", "omega", "period", "damping_ratio", "damped_omega", "decay", "modal_mass",
    "modal_stiffness",
)  # fmt: skip
"""Fields of the table of modes."""


def _print(result: ModesResult) -> None:
    typer.echo(result.headline())
    if not result.complete:
        typer.echo(result.reason)
        return
    print_records("", result._records, *SEEN)
    _print_shapes(result)
    names = ", ".join(result.left_out)
    print_remarks(
        f"equilibrium: the remaining efforts are {result.unbalance:.1e} of the forces that act",
        (names, f"dry friction of {names} is left out: it would hold small motions, the modes are those without it"),
    )


def _print_shapes(result: ModesResult) -> None:
    shapes = result._shapes[:SHOWN]
    head = ["shape", *(f"mode {k}" for k in range(1, len(shapes) + 1))]
    rows = [
        [labelled(name, unit), *(_participation(shape.values[k]) for shape in shapes)]
        for k, (name, unit) in enumerate(shapes[0].columns)
    ]
    print_table("", head, rows, range(1, len(head)))
    print_more(len(result._shapes), SHOWN)


def _participation(value: complex) -> str:
    """Return a participation, of a shape with phases with its angle."""
    if abs(value.imag) <= 1e-9 * abs(value):
        return number(value.real, 1.0)
    return f"{number(abs(value), 1.0)} at {math.degrees(cmath.phase(value)):.1f} deg"


OPTIONS = {
    "free": typer.Option(
        "--free",
        metavar="ACTUATOR",
        rich_help_panel=INPUTS,
        help="Input that is released; repeatable, or with commas.\n"
        "Besides those with `free: true`; a single input needs no name.",
    ),
    "time": typer.Option("--time", metavar="T", rich_help_panel=INPUTS),
    "settle": typer.Option("--settle", rich_help_panel=INPUTS),
}
command = from_verb(modes, ModesResult, _print, OPTIONS, files="csv png", loaded=(note_doubtful_loading,))
