"""`gim schema`: the JSON Schema of the model file."""

from __future__ import annotations

import json

import typer

from gimcli.cli.console import end_bars

HELP = (
    "Editors complete and check model files with it: save it as gim.schema.json and write in the first line of the"
    " model file `# yaml-language-server: $schema=gim.schema.json`."
)
EXAMPLES = ("gim schema > gim.schema.json",)


def command() -> None:
    """Print the schema."""
    from gimcli.model.json_schema import json_schema

    end_bars()
    typer.echo(json.dumps(json_schema(), indent=2))
