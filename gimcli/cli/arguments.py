"""Arguments and options that several commands share."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gimcli.errors import UsageError
from gimcli.positions.options import Options

if TYPE_CHECKING:
    from gimcli.mechanism import FloatArray, Mechanism


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


def options(
    method: Method, strategy: Strategy, tolerance: float, jit: Jit, moves: str = "", seed: int | None = None
) -> Options:
    """Return the solver's options; refuse a tolerance that means nothing."""
    if not 1e-14 <= tolerance < 1.0:
        raise UsageError(f"--tolerance {tolerance:g}: a number from 1e-14 to below 1 is needed")
    if moves and method is not Method.GIM:
        raise UsageError("--sequence belongs to --method gim")
    return Options(method.value, strategy.value, tolerance, jit.value, seed=seed, moves=moves)


def inputs_at(mechanism: Mechanism, given: list[str]) -> FloatArray:
    """Return the inputs: the start of every law, replaced by what --at gives."""
    import difflib

    values = mechanism.start_inputs
    names = [a.name for a in mechanism.actuators]
    told: set[str] = set()
    for text in given:
        name, equals, number = text.partition("=")
        if not equals:
            raise UsageError(f"--at {text}: write ACTUATOR=VALUE; actuators: {', '.join(names) or 'none'}")
        if name not in names:
            near = difflib.get_close_matches(name, names, 1)
            hint = f"; did you mean '{near[0]}'?" if near else f"; actuators: {', '.join(names) or 'none'}"
            raise UsageError(f"--at {text}: no actuator '{name}'{hint}")
        if name in told:
            raise UsageError(f"--at {text}: '{name}' has a value already; give it once")
        told.add(name)
        values[names.index(name)] = _input_value(mechanism, names.index(name), text, number)
    return values


def _input_value(mechanism: Mechanism, k: int, text: str, number: str) -> float:
    """Return an input in the normal frame; refuse what no law may reach either."""
    import math

    from gimcli.mechanism import Drive
    from gimcli.model.check_inputs import MOST_TURNS

    try:
        given = float(number)
    except ValueError:
        given = math.nan
    if not math.isfinite(given):
        raise UsageError(f"--at {text}: '{number}' is not a finite number")
    drive, value = mechanism.actuators[k].drive, float(mechanism.value_from_file(k, given))
    if drive is Drive.DISTANCE and value <= 0.0:
        raise UsageError(f"--at {text}: a distance must be above 0")
    if abs(value) > MOST_TURNS * (2.0 * math.pi if drive is Drive.ROTARY else mechanism.size):
        raise UsageError(f"--at {text}: more than {MOST_TURNS:g} turns, or sizes of the mechanism, from 0")
    return value
