"""`gim modes`: natural frequencies and shapes of small vibrations."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.cli.arguments import (
    INPUTS,
    MODEL,
    NONE,
    Assembly,
    At,
    CsvFile,
    Json,
    ModelPath,
    Out,
    PngFile,
    Set,
    Tolerance,
    pairs,
)
from gimcli.cli.console import print_more, print_records, print_table
from gimcli.cli.picture_options import NO_OPTIONS, Drawing, with_picture_options

if TYPE_CHECKING:
    from gimcli.library.modes import ModesResult

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
SEEN = (
    "number", "kind", "frequency", "omega", "period", "damping_ratio", "damped_omega", "decay", "modal_mass",
    "modal_stiffness",
)  # fmt: skip
"""Fields of the table of modes."""
"""Greatest number of modes whose shapes are printed."""

MODES = "Modes"


@with_picture_options
def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    free: Annotated[
        list[str],
        typer.Option(
            "--free", metavar="ACTUATOR", help="Input that is released; repeatable, or with commas.",
            rich_help_panel=INPUTS,
        ),
    ] = NONE,
    at: At = NONE,
    time: Annotated[
        float, typer.Option("--time", metavar="T", help="Time of tables over the time [s].", rich_help_panel=INPUTS)
    ] = 0.0,
    settle: Annotated[
        bool,
        typer.Option("--settle", help="Follow the forces to an equilibrium first.", rich_help_panel=INPUTS),
    ] = False,
    assembly: Assembly = "",
    tolerance: Tolerance = 1e-10,
    out: Out = NONE,
    csv: CsvFile = None,
    png: PngFile = None,
    as_json: Json = False,
    drawing: Drawing = NO_OPTIONS,
) -> None:  # fmt: skip
    """Find the modes."""
    from gimcli.cli.console import note_doubtful_loading
    from gimcli.cli.outputs import Outputs, by_machine
    from gimcli.library.modes import ModesResult, modes

    outputs = Outputs(ModesResult, model, out, csv=csv, png=png, as_json=as_json, drawing=drawing)
    inputs = pairs(at)
    mechanism = outputs.loaded(assembly, inputs, tolerance, changes=changes)
    note_doubtful_loading(mechanism)
    found = modes(mechanism, free, inputs, time=time, settle=settle, tolerance=tolerance)
    outputs.finish(found, by_machine(_print))


def _print(result: ModesResult) -> None:
    typer.echo(result.headline())
    if not result.complete:
        typer.echo(result.reason)
        return
    print_records("", result.records, *SEEN)
    _print_shapes(result)
    typer.echo(f"equilibrium: the remaining efforts are {result.unbalance:.1e} of the forces that act")
    if result.left_out:
        names = ", ".join(result.left_out)
        typer.echo(f"dry friction of {names} is left out: it would hold small motions, the modes are those without it")


def _print_shapes(result: ModesResult) -> None:
    from gimcli.table import labelled

    shapes = result.shapes[:SHOWN]
    head = ["shape", *(f"mode {k}" for k in range(1, len(shapes) + 1))]
    rows = [
        [labelled(name, unit), *(_participation(shape.values[k]) for shape in shapes)]
        for k, (name, unit) in enumerate(shapes[0].columns)
    ]
    print_table("", head, rows, range(1, len(head)))
    print_more(len(result.shapes), SHOWN)


def _participation(value: complex) -> str:
    """Return a participation, of a shape with phases with its angle."""
    import cmath
    import math

    from gimcli.library.rounding import number

    if abs(value.imag) <= 1e-9 * abs(value):
        return number(value.real, 1.0)
    return f"{number(abs(value), 1.0)} at {math.degrees(cmath.phase(value)):.1f} deg"
