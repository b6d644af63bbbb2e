"""The formats of other programs, the detection of a format from the content, and its reader or writer.

The module of a format that can be read defines `recognises(text)`, whether a text is probably in this format, be it
damaged or not, and `read(text, source)`, which returns the Draft of a text; `source` names the file in messages. It
raises ModelError for a damaged text, and for a part that the motion depends on but that models of gim cannot express.
That of a format that can be written defines `PROGRAM` and `write(drawn)`, which returns the text of a DrawnLinkage and
appends to its `left_out` what the format cannot express.
"""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from gimcli.exchange.draft import Draft


class ForeignFormat(NamedTuple):
    """A format of another program."""

    name: str  # as users know it
    module: str  # in this package
    reads: bool = True
    writes: str = ""  # word of `gim convert --to`; empty: the format is not written
    writer: str = "write"  # function of the module
    suffix: str = ""  # of files that are written in this format
    text_of: str = ""  # word of the format whose text it is a file of: `--to` this word writes such files, too


FORMATS: tuple[ForeignFormat, ...] = (
    ForeignFormat("PMKS text", "pmks_text", writes="pmks", suffix=".txt"),
    ForeignFormat("PMKS JSON", "pmks"),
    ForeignFormat("PMKS+ of 2020-2023", "pmks_plus_v0"),
    ForeignFormat("PMKS+", "pmks_plus"),
    ForeignFormat("PMKS+ address", "pmks_plus_writer", reads=False, writes="pmks+", writer="address"),
    ForeignFormat("PMKS+ file", "pmks_plus_writer", reads=False, writes="pmks+file", suffix=".pmks", text_of="pmks+"),
    ForeignFormat("Linkage", "linkage"),
    ForeignFormat("Pyslvs", "pyslvs"),
    ForeignFormat("pylinkage", "pylinkage"),
)
"""All formats; content is offered to them in this order."""


def module_of(form: ForeignFormat) -> ModuleType:
    """Import the module of a format."""
    return import_module(f"gimcli.exchange.{form.module}")


def draft_of(text: str, source: str) -> Draft | None:
    """Return the mechanism of a text in the format of another program; None if it is in none of them.

    `source` names the file in messages. Raises ModelError for a damaged text and for parts that cannot be converted.
    """
    for form in FORMATS:
        if form.reads and (module := module_of(form)).recognises(text):
            return module.read(text, source)  # type: ignore[no-any-return]  # names of modules are Any
    return None
