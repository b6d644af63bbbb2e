"""`gim convert`: a model file from another program's file, or the other way round."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from gimcli.cli.arguments import MODEL, NONE, OUTPUT, Assembly, Json, ModelPath, Set, changed
from gimcli.cli.console import end_bars, note, print_json, print_written, printable
from gimcli.cli.outputs import read, started
from gimcli.library.convert import MODEL_FILE, Conversion, convert, filed, target_of

HELP = (
    "Reads PMKS text and addresses, PMKS+ addresses and files, Linkage, Pyslvs and pylinkage files (`gim manual"
    " other-programs`); addresses are decoded, never fetched. Without -o the text is printed. Every command also takes"
    " such a file or address in place of a model file."
)
EXAMPLES = (
    "gim convert models/crank_rocker.yaml --set crank.length=35 -o changed.yaml",
    "gim convert models/crank_rocker.yaml --to pmks+",
)


def command(
    model: ModelPath = MODEL,
    changes: Set = NONE,
    assembly: Assembly = "",
    to: Annotated[
        str,
        typer.Option(
            "--to", metavar="FORMAT", rich_help_panel=OUTPUT,
            help="yaml (model file), pmks (PMKS text), pmks+ (an address), pmks+file; default: that of -o, else yaml.\n"
            "The address opens the mechanism in PMKS+, and so does the file.",
        ),
    ] = "",
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FILE", rich_help_panel=OUTPUT,
            help="File: .yaml, .txt or .pmks.\nAlso .yml; .txt is PMKS text, .pmks a file of PMKS+.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:  # fmt: skip
    """Convert a mechanism."""
    chosen = to or (MODEL_FILE if out is None else target_of(out))
    if out is not None:
        chosen = filed(chosen, out)
    found = convert(started(changed(read(model), changes), assembly), chosen)
    if out is not None:
        found.save(out)
    end_bars()
    _print(found, out, as_json)


def _print(found: Conversion, out: Path | None, as_json: bool) -> None:
    if as_json:
        text = {} if out else {"text": found.text}
        print_json({
            "name": found.mechanism.name, "to": found.to, "left_out": list(found.left_out), **text,
            "files": [str(out)] if out else [],
        })  # fmt: skip
        return
    for sentence in found.left_out[len(found.mechanism.left_out) :]:  # the others have been printed
        note(printable(f"{found.mechanism.name}: {sentence}"))
    if out:
        print_written([out])
    else:
        typer.echo(found.text, nl=not found.text.endswith("\n"))
