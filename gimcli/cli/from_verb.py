"""Commands that are made from the verbs of the library.

The signature of a verb gives the options of its command: names, types, bounds and defaults. The `Args:` of its
docstring give the text of an option: the first part is its help, all of it stands in the manual. A command may have a
text of its own: alone if it has a second line, which is for the manual, else in place of the first part.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from enum import Enum, StrEnum
from functools import cached_property, partial
from inspect import getdoc, signature, unwrap
from types import NoneType
from typing import Annotated, Any, cast, get_args, get_origin

from typer.models import OptionInfo

from gimcli.cli.arguments import (
    DRAWN,
    MODEL,
    NONE,
    SHARED,
    Assembly,
    CsvFile,
    Json,
    ModelPath,
    Out,
    Png,
    PngFile,
    Set,
    declared,
    pairs,
)
from gimcli.cli.console import note, progress_bar
from gimcli.cli.measures import MEASURES, measures_of, refuse_unseen
from gimcli.cli.outputs import Outputs
from gimcli.errors import UsageError, refuse
from gimcli.library.inputs import OneOf, Range, hints_of
from gimcli.library.result import Result
from gimcli.mechanism import Mechanism

REPORTERS = {"notify": note, "progress": progress_bar}
OUTPUTS = ("out", "csv", "png", "as_json")
COMMON = (("model", ModelPath, MODEL), ("changes", Set, NONE))
"""Name, annotation and default of the options of every command that reads a model file."""


@dataclass
class Run:
    """One run of a command, as its options have it; the function `run` of a command may change all of it.

    `arguments` are those of the verb, `switches` the options of the terminal, which `show` gets by name. `given` has
    the flags of the options that differ from their defaults. `open`: the side of a node may be open.
    """

    verb: Callable[..., Any]
    kind: type[Result]
    show: Callable[..., None]
    model: str
    changes: list[str]
    assembly: str
    arguments: dict[str, Any]
    switches: dict[str, Any]
    files: dict[str, Any]
    loaded: Sequence[Callable[[Mechanism], None]]
    given: dict[str, str]
    open: bool = False

    @cached_property
    def outputs(self) -> Outputs:
        """The files of the command."""
        return Outputs(self.kind, self.model, **self.files)

    @cached_property
    def mechanism(self) -> Mechanism:
        """The mechanism of the model file."""
        refuse_unseen(self.arguments.get("plot"), self.outputs.draws)
        at, tolerance = self.arguments.get("at"), self.arguments.get("tolerance", 1e-10)
        mechanism = self.outputs.loaded(self.assembly, at, tolerance, changes=self.changes, every=self.open)
        for noted in self.loaded:
            noted(mechanism)
        return mechanism

    def found(self) -> Any:
        """Return what the verb returns, or what it begins if its rows come in parts."""
        known = signature(self.verb).parameters
        reporters = {key: value for key, value in REPORTERS.items() if key in known}
        begin = getattr(self.verb, "begin", self.verb)
        return begin(self.mechanism, **self.arguments, **reporters)

    def written(self) -> Any:
        """Return the result of the verb; its files are written, while it is computed if its rows come in pieces."""
        found = self.found()
        if not isinstance(found, Result):
            return self.outputs.stream(found)
        self.outputs.write(found)
        return found

    def instead(self, verb: Callable[..., Any], kind: type[Result], show: Callable[..., None], what: str) -> None:
        """Run the verb that an option chooses; refuse options that it does not have: those are for `what`."""
        known, every = signature(verb).parameters, {**self.arguments, **self.switches}
        foreign = {*self.given} - {*known, "assembly"}
        refuse(*((name in foreign, f"{flag} is for {what}: remove one of them") for name, flag in self.given.items()))
        self.verb, self.kind, self.show, self.switches, self.loaded = verb, kind, show, {}, ()
        self.arguments = {name: every[name] for name in known if every.get(name) is not None}

    def drop(self, what: str, *names: str) -> None:
        """Leave out options of the verb that is not chosen; refuse those that are given: they are for `what`."""
        for name in names:
            refuse((name in self.given, f"{self.given.get(name)} is for {what}"))
            self.switches.pop(name)


def from_verb(
    verb: Callable[..., Any], kind: type[Result], show: Callable[..., None],
    options: Mapping[str, Any] | None = None, *, writes: bool = False, files: str = "png", assembled: bool = True,
    loaded: Sequence[Callable[[Mechanism], None]] = (), read: Mapping[str, Callable[[Any], Any]] | None = None,
    extra: Mapping[str, Any] | None = None, run: Callable[[Run], Any] = Run.written,
) -> Callable[..., None]:  # fmt: skip
    """Return the command of a verb, with the signature that typer reads; `show` prints its result, of class `kind`.

    `verb`: the function; rows of a result that it begins in parts are written while they are computed. `options`: the
    form of the options that other commands do not have, by the names of the verb's arguments; annotated where the
    terminal has another type. `writes`: without `-o` the usual files are written. `files`: the options for single
    files. `assembled`: whether there is --assembly. `loaded`: functions of the mechanism, before the analysis. `read`:
    functions of the values of options. `extra`: options of the terminal, which `show` gets by name. `run`: what is done
    where it is more than to run the verb and to write its result.
    """
    readers: dict[str, Callable[[Any], Any]] = {"at": pairs, "measure": measures_of, **(read or {})}
    own = own_options(verb, options or {})
    names = [name for name, _, _ in own]
    own += [(name, form, default_of(form, False)) for name, form in (extra or {}).items()]
    own = [("assembly", Assembly, ""), *own] if assembled else own
    last: list[tuple[str, Any, Any]] = [("out", Out, NONE), ("as_json", Json, False)]
    last[1:1] = [("csv", CsvFile, None)] if "csv" in files else []
    if "png" in files:
        last[-1:-1] = [("png", Png, True) if writes else ("png", PngFile, None)]
        last += DRAWN
    flags = {name: (flag_of(form), usual) for name, form, usual in own}

    def command(**given: Any) -> None:
        drawing = {name: value for name, _, _ in DRAWN if (value := given.pop(name, None)) is not None}
        chosen = {key: given.pop(key) for key in OUTPUTS if key in given}
        if writes:
            chosen["picture"] = chosen.pop("png")
        differs = {name: flag for name, (flag, usual) in flags.items() if given[name] != usual}
        model, changes, assembly = given.pop("model"), given.pop("changes"), given.pop("assembly", "")
        values = {key: readers.get(key, plain)(value) for key, value in given.items()}
        arguments = {key: value for key in names if (value := values.pop(key)) is not None}
        written = {**chosen, "writes": writes, "drawing": drawing}
        own_run = Run(verb, kind, show, model, changes, assembly, arguments, values, written, loaded, differs)
        try:
            result = run(own_run)
        except UsageError as error:
            name, colon, what = str(error).partition(": ")
            raise UsageError(f"{flags[name][0]}{colon}{what}") if name in flags else error from None
        own_run.outputs.show(result, partial(own_run.show, **own_run.switches))

    command.kind = kind  # type: ignore[attr-defined]  # read by the help
    return declared(command, *COMMON, *own, *last)


def plain(value: Any) -> Any:
    """Return a value of an option as the library has it: words are texts."""
    return value.value if isinstance(value, Enum) else value


def own_options(verb: Callable[..., Any], options: Mapping[str, Any]) -> list[tuple[str, Any, Any]]:
    """Return name, annotation and default of the options of a verb, in its order; reports and inputs are none."""
    verb = unwrap(verb)
    forms, hints, found = {**SHARED, "measure": MEASURES, **options}, hints_of(verb), []
    texts = argument_texts(verb, {name: flag_of(form) for name, form in forms.items() if name in hints})
    for name, parameter in signature(verb).parameters.items():
        if name in forms:
            form, usual = forms[name], parameter.default
            kind = option_kind(name, hints[name], copy(form), texts, usual) if isinstance(form, OptionInfo) else form
            found.append((name, kind, default_of(kind, usual)))
    return found


def default_of(form: Any, value: Any) -> Any:
    """Return the default of an option with an annotation; `value` is that of an argument, false if there is none."""
    kind = get_args(form)[0]
    if kind == list[str]:
        return NONE
    if NoneType in get_args(kind):
        return value or None
    return kind(value or "") if kind is str or issubclass(kind, Enum) else value


def option_kind(name: str, hint: Any, form: OptionInfo, texts: Mapping[str, tuple[str, str]], usual: Any) -> Any:
    """Return the annotation of an option: the type, bounds and words of the argument, and the form of the option.

    Where the default `usual` is none of the words the option may be left out.
    """
    kind, *limits = get_args(hint) if get_origin(hint) is Annotated else (hint,)
    first, further = texts[name]
    if "\n" not in (form.help or ""):
        form.help = f"{form.help or first}\n{further}"
    for limit in limits:
        if isinstance(limit, Range):
            form.min, form.max = limit.least, limit.most
        elif isinstance(limit, OneOf):
            words: Any = cast(Any, StrEnum)(name, {word: word for word in limit.known})
            kind = words if usual in limit.known else words | None
    if {Sequence, Mapping} & {get_origin(one) for one in (kind, *get_args(kind))}:
        kind = str if get_origin(kind) is Sequence else list[str]
    return Annotated[kind, form]


def flag_of(form: Any) -> str:
    """Return the flag of an option, of an annotation or of its form."""
    return str(getattr(form, "__metadata__", (form,))[0].default)


def argument_texts(verb: Callable[..., Any], flags: Mapping[str, str]) -> dict[str, tuple[str, str]]:
    """Return the text of each argument in the docstring of a verb: up to the first semicolon or full stop, the rest.

    Names of arguments in the text are replaced by `flags`.
    """
    text = (getdoc(verb) or "").partition("Args:\n")[2].partition("\n\n")[0]
    text = re.sub(r"`(\w+)`", lambda word: f"`{flags.get(word[1], word[1])}`", text)
    each = re.findall(r"^    (\w+): (.*(?:\n     .*)*)", text, re.MULTILINE)
    parts = {name: re.match(r"(.*?)[;.](?: (.*))?$", " ".join(words.split())) for name, words in each}
    return {name: (sentence(part[1]), sentence(part[2])) for name, part in parts.items() if part}


def sentence(words: str | None) -> str:
    """Return words as a sentence."""
    return f"{words[0].upper()}{words[1:].removesuffix('.')}." if words else ""
