"""Every key of the reports and every column of the tables that was there before is there still, also inside lists."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator
from typing import Any

import pytest
from bundled import MODELS, TABLES
from in_process import gim

KNOWN: dict[str, Any] = json.loads((TABLES / "declared.json").read_text(encoding="utf-8"))
"""Commands with the paths of their keys and the names of their columns, written down when lists were made records."""


def paths(report: Any, head: str = "") -> Iterator[str]:
    """Yield the paths of the keys of a report; the entries of a list have `[]` and are taken together."""
    if isinstance(report, list):
        for one in report:
            yield from paths(one, f"{head}[]")
    elif isinstance(report, dict):
        for name, value in report.items():
            path = f"{head}.{name}" if head else name
            yield path
            yield from paths(value, path)


@pytest.mark.parametrize("command", KNOWN)
def test_no_key_and_no_column_is_missing(command, tmp_path):
    verb, model, *rest = command.split()
    table = [] if KNOWN[command]["columns"] is None else ["-o", tmp_path / "table.csv"]
    report = gim(verb, MODELS / f"{model}.yaml", *rest, *table, "--json").json
    missing = set(KNOWN[command]["keys"]) - set(paths(report))
    assert not missing
    if table:
        with (tmp_path / "table.csv").open(encoding="utf-8", newline="") as handle:
            assert next(csv.reader(handle)) == KNOWN[command]["columns"]
