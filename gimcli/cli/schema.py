"""`gim schema`: the JSON Schema of the model file."""

from __future__ import annotations

import json

import typer

NAME = "schema"
HELP = (
    "Print the JSON Schema of the model file, with which editors complete and check it.\n\n"
    "Example: gim schema > gim.schema.json, and in the model's first line:\n"
    "# yaml-language-server: $schema=gim.schema.json"
)


def command() -> None:
    """Print the schema."""
    from gimcli.cli.progress import end_bars
    from gimcli.model.json_schema import json_schema

    end_bars()
    typer.echo(json.dumps(json_schema(), indent=2))
