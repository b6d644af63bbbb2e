"""Model files: the text of the file that was read, with other coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from gimcli.errors import UsageError
from gimcli.output.atomic import written_text


@dataclass(frozen=True)
class ModelText:
    """The text of a model file, and the tables that it names."""

    text: str
    tables: tuple[tuple[str, Path], ...] = ()  # name in the text, and the file that was read
    remarks: tuple[str, ...] = ()  # what else is different, as sentences


def write_model(content: ModelText, path: Path) -> None:
    """Write a model file; raise UsageError if its tables are not found from the folder of the new file."""
    for name, table in content.tables:
        if (path.parent / name).resolve() != table.resolve():
            raise UsageError(f"{path}: the model reads the table {name}: write to the folder of the model file")
    with written_text(path) as handle:
        handle.write(content.text)
