"""Arguments and options that several commands share."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from gimcli.errors import UsageError


class Method(StrEnum):
    """How positions are found."""

    AUTO = "auto"
    GIM = "gim"
    NEWTON = "newton"


class Strategy(StrEnum):
    """How the sequence is chosen."""

    SPECTRAL = "spectral"
    CLASSIC = "classic"


class Jit(StrEnum):
    """Whether kernels are compiled."""

    AUTO = "auto"
    ON = "on"
    OFF = "off"


ModelPath = Annotated[Path, typer.Argument(metavar="MODEL", help="Model file.", show_default=True)]
MODEL = Path("model.yaml")
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
Out = Annotated[Path, typer.Option("--out", "-o", help="Folder to write into.")]
Png = Annotated[bool, typer.Option("--png/--no-png", help="Draw the picture.")]
MethodOption = Annotated[
    Method,
    typer.Option(
        "--method", help="auto: closed forms, then Newton-Raphson; gim: sweeps only; newton: no closed forms."
    ),
]
StrategyOption = Annotated[
    Strategy, typer.Option("--strategy", help="Sequence for sweeps: best spectral radius, or the paper's rules alone.")
]
Tolerance = Annotated[
    float, typer.Option("--tolerance", help="Relative to the mechanism's size; with --method gim eqs (1) and (2).")
]
JitOption = Annotated[Jit, typer.Option("--jit", help="Compile the kernels; auto decides by the amount of work.")]
SequenceText = Annotated[
    str,
    typer.Option(
        "--sequence", help='Moves of a sweep for --method gim, such as "A>B D>C C^B>E" (FROM>TO, ARM^VERTEX>TO).'
    ),
]
At = Annotated[
    list[str], typer.Option("--at", metavar="ACTUATOR=VALUE", help="Input in the file's unit; may be repeated.")
]


def pairs(given: list[str]) -> dict[str, str]:
    """Return what --at gives by the names of the actuators."""
    values: dict[str, str] = {}
    for text in given:
        name, equals, number = text.partition("=")
        if not equals:
            raise UsageError(f"--at {text}: write ACTUATOR=VALUE")
        if name in values:
            raise UsageError(f"--at {text}: '{name}' has a value already; give it once")
        values[name] = number
    return values
