"""Convert a mechanism to a model file, or to a file of another program."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from gimcli import output
from gimcli.errors import ModelError, StructureError, UnassembledError, refuse
from gimcli.exchange.registry import FORMATS, module_of
from gimcli.library.inputs import OneOf
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.rounding import titled

MODEL_FILE = "yaml"
SUFFIXES = (".yaml", ".yml")


def targets() -> dict[str, str]:
    """Return the words for `to`, and the name of the format of each."""
    return {MODEL_FILE: "model file", **{form.writes: form.name for form in FORMATS if form.writes}}


def target_of(path: Path) -> str:
    """Return the word for `to` that the suffix of a file stands for; raise UsageError for another suffix."""
    known = {suffix: MODEL_FILE for suffix in SUFFIXES} | {form.suffix: form.writes for form in FORMATS if form.suffix}
    refuse(
        (
            path.suffix.lower() not in known,
            f"{path}: expected one of the formats {', '.join(known)}, got '{path.suffix}'",
        )
    )
    return known[path.suffix.lower()]


def filed(to: str, path: Path) -> str:
    """Return the word for the format of a file: an address, for example, is written into a `.pmks` file as its text."""
    suffix = path.suffix.lower()
    found = [form.writes for form in FORMATS if form.text_of == to and form.suffix == suffix]
    return found[0] if to and found else to


@dataclass(frozen=True)
class Conversion:
    """The text of a mechanism in another format.

    `left_out`: sentences about what the format cannot express, or what did not come over from the file that was read.
    """

    mechanism: Mechanism
    text: str = field(repr=False)
    to: str
    left_out: tuple[str, ...]

    def save(self, path: Path | str) -> None:
        """Write the text to a file, atomically; raise UsageError if the mechanism was read from it."""
        output.refuse_unwritable(self.mechanism.files, Path(path))
        with output.written_text(path) as handle:
            handle.write(self.text)


def convert(mechanism: Mechanism, to: str = MODEL_FILE) -> Conversion:
    """Convert a mechanism, for example `convert(load("leg.linkage2")).save("leg.yaml")`.

    Other programs take all dimensions from one drawn position: it is the one at the start of the laws.

    Args:
        mechanism: from `load` or `loads`, which also read files of other programs.
        to: "yaml" (a model file), "pmks" (PMKS text), "pmks+" (an address that opens the mechanism in PMKS+) or
            "pmks+file" (a file that PMKS+ opens).

    Returns:
        A Conversion: `.text`, `.left_out`, `.save(path)`.

    Raises:
        UsageError: an unknown format.
        UnassembledError: the mechanism cannot be assembled at the start of its laws.
        ModelError: the format cannot express a part on which the motion depends.
    """
    OneOf(targets()).refuse("to", to)
    if to == MODEL_FILE:
        return _model_file(mechanism)
    from gimcli.exchange.drawn_linkage import DrawnLinkage

    form = next(form for form in FORMATS if form.writes == to)
    module = module_of(form)
    drawn = DrawnLinkage(mechanism, mechanism.to_file(_start(mechanism)), module.PROGRAM)
    text = getattr(module, form.writer)(drawn)
    _refuse_unreadable(mechanism, form.name, text)
    return Conversion(mechanism, text, to, (*mechanism.left_out, *drawn.left_out))


def _refuse_unreadable(mechanism: Mechanism, name: str, text: str) -> None:
    """Raise ModelError if a text cannot be read back, as with a number that the format cannot hold."""
    from gimcli.library.load import read_by_others

    try:
        read_by_others(text, name)
    except ModelError:
        text = f"a number is too large or too small for a {name}, which could not be read back; change it"
        raise ModelError([f"{mechanism.name}: {text}"]) from None


def _model_file(mechanism: Mechanism) -> Conversion:
    """Return the text of a model file; it has other coordinates if another assembly has been chosen."""
    model = mechanism.written.model
    given = np.array([complex(*model.nodes[name]) for name in mechanism.nodes])
    if np.array_equal((given - mechanism.origin) / mechanism.scale, mechanism.drawn):
        from gimcli.model.edited_text import written_with

        return Conversion(mechanism, written_with(mechanism), MODEL_FILE, mechanism.left_out)
    from gimcli.library.model_text import model_text

    found = model_text(mechanism, mechanism.drawn)
    return Conversion(mechanism, found.text, MODEL_FILE, (*mechanism.left_out, *found.remarks))


def _start(mechanism: Mechanism) -> ComplexArray:
    """Return the position (nodes,) at the start of the laws; the drawn one of a mechanism that is not fully driven."""
    from gimcli.library.solve import solve

    try:
        found = solve(mechanism)
    except StructureError:
        return mechanism.drawn
    if found._found.status.value or not np.all(np.isfinite(found._found.z)):
        raise UnassembledError(f"{titled(mechanism, found.inputs)}: no position to convert: {found.reason}")
    return np.asarray(found._found.z)
