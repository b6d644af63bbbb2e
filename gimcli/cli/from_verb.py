"""Commands that are made from the verbs of the library.

The signature of a verb gives the options of its command: names, types, bounds and defaults. The `Args:` of its
docstring give the help of the options for which the command has no text of its own.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from enum import Enum, StrEnum
from functools import partial
from importlib import import_module
from inspect import Parameter, Signature, getdoc, signature, unwrap
from typing import TYPE_CHECKING, Annotated, Any, cast, get_args, get_origin

from typer.models import OptionInfo

from gimcli.cli.arguments import MODEL, NONE, SHARED, Assembly, CsvFile, Json, ModelPath, Out, Png, PngFile, Set, pairs
from gimcli.cli.console import note
from gimcli.cli.help import RESULTS
from gimcli.cli.measures import MeasuresOnly, measures_of, refuse_unseen
from gimcli.cli.outputs import Outputs
from gimcli.cli.picture_options import OPTIONS
from gimcli.cli.progress import progress_bar
from gimcli.library.inputs import Range, hints_of

if TYPE_CHECKING:
    from gimcli.mechanism import Mechanism

REPORTERS = {"notify": note, "progress": progress_bar}
OUTPUTS = ("out", "csv", "png", "as_json")


def from_verb(
    name: str, show: Callable[..., None], options: Mapping[str, OptionInfo] | None = None, *,
    writes: bool = False, files: str = "png", assembled: bool = True,
    loaded: Sequence[Callable[[Mechanism], None]] = (), read: Mapping[str, Callable[[Any], Any]] | None = None,
    extra: Mapping[str, Any] | None = None, begun: str = "",
) -> Callable[..., None]:  # fmt: skip
    """Return the command of a verb, with the signature that typer reads; `show` prints its result.

    `options`: the form of the options that other commands do not have, by the names of the verb's arguments. `writes`:
    without `-o` the usual files are written. `files`: the options for single files. `assembled`: whether there is
    --assembly. `loaded`: functions of the mechanism, before the analysis. `read`: functions of the values of options.
    `extra`: switches of the terminal, which `show` gets by name. `begun`: the function with the arguments of the verb
    that begins a result whose rows are written while they are computed.
    """
    module, kind = RESULTS[name].split(".")
    verb = getattr(import_module(f"gimcli.library.{name}"), begun or name)
    found = getattr(import_module(f"gimcli.library.{module}"), kind)
    readers: dict[str, Callable[[Any], Any]] = {"at": pairs, "measure": measures_of, **(read or {})}

    def command(**given: Any) -> None:
        drawing = {one.name: given.pop(one.name) for one in OPTIONS if one.name in given}
        chosen = {key: given.pop(key) for key in OUTPUTS if key in given}
        if writes:
            chosen["picture"] = chosen.pop("png")
        drawing = {key: value for key, value in drawing.items() if value is not None}
        outputs = Outputs(found, given.pop("model"), writes=writes, drawing=drawing, **chosen)
        changes, assembly = given.pop("changes"), given.pop("assembly", "")
        shown = {key: given.pop(key) for key in extra or {}}
        arguments = {key: readers.get(key, plain)(value) for key, value in given.items()}
        if "plot" in arguments:
            refuse_unseen(arguments["plot"], outputs.draws)
        at, tolerance = arguments.get("at"), arguments.get("tolerance", 1e-10)
        mechanism = outputs.loaded(assembly, at, tolerance, changes=changes)
        for noted in loaded:
            noted(mechanism)
        reporters = {key: value for key, value in REPORTERS.items() if key in signature(verb).parameters}
        result = verb(mechanism, **arguments, **reporters)
        if begun:
            outputs.show(outputs.stream(result), partial(show, **shown))
        else:
            outputs.finish(result, partial(show, **shown))

    common = [("model", ModelPath, MODEL), ("changes", Set, NONE)]
    common += [("assembly", Assembly, "")] if assembled else []
    last: list[tuple[str, Any, Any]] = [("out", Out, NONE)]
    last += [("csv", CsvFile, None)] if "csv" in files else []
    last += [("png", Png, True) if writes else ("png", PngFile, None)] if "png" in files else []
    own = own_options(unwrap(verb), options or {})
    switches = [(key, kind, False) for key, kind in (extra or {}).items()]
    every = [*common, *own, *switches, *last, ("as_json", Json, False)]
    listed = [Parameter(key, Parameter.KEYWORD_ONLY, annotation=kind, default=value) for key, kind, value in every]
    command.__signature__ = Signature([*listed, *OPTIONS * ("png" in files)])  # type: ignore[attr-defined]  # read by typer
    return command


def plain(value: Any) -> Any:
    """Return a value of an option as the library has it: words are texts."""
    return value.value if isinstance(value, Enum) else value


def own_options(verb: Callable[..., Any], options: Mapping[str, OptionInfo]) -> list[tuple[str, Any, Any]]:
    """Return name, annotation and default of the options of a verb, in its order; reports and inputs are none."""
    helps, hints, found, shared = argument_helps(verb), hints_of(verb), [], {**SHARED, "measure": MeasuresOnly}
    for name, parameter in signature(verb).parameters.items():
        kind: Any = shared.get(name)
        if name in options:
            kind, form = hints[name], options[name]
            kind, *limits = get_args(kind) if get_origin(kind) is Annotated else (kind,)
            form.help = form.help or helps[name]
            for limit in limits:
                if isinstance(limit, Range):
                    form.min, form.max = limit.least, limit.most
                else:
                    kind = cast(Any, StrEnum)(name, {word: word for word in limit.known})
            several = Sequence in [get_origin(one) for one in get_args(kind)]
            kind = Annotated[list[str] if several else str if get_origin(kind) is Sequence else kind, form]
        if kind is None:
            continue
        own, value = get_args(kind)[0], parameter.default
        if own == list[str]:
            value = NONE
        elif own is str or (isinstance(own, type) and issubclass(own, Enum)):
            value = own(value or "")
        found.append((name, kind, value))
    return found


def argument_helps(verb: Callable[..., Any]) -> dict[str, str]:
    """Return the first sentence of each argument in the docstring of a verb."""
    text = (getdoc(verb) or "").partition("Args:\n")[2].partition("\n\n")[0]
    each = re.findall(r"^    (\w+): (.*(?:\n     .*)*)", text, re.MULTILINE)
    first = {name: re.split(r"[;.](?= |$)", " ".join(words.split()))[0] for name, words in each}
    return {name: words[0].upper() + words[1:] + "." for name, words in first.items()}
