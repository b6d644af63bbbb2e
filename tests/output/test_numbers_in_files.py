"""The numbers of every result in every format: equal, and numbers for other programs, never the text of Python."""

import csv
import json

import numpy as np
import openpyxl
import pyarrow.parquet as pq
import pytest

import gimcli
from gimcli.library.result import Result
from gimcli.table import labelled

RESULTS = {
    "check": "crank_rocker", "circuits": "crank_rocker", "configurations": "crank_rocker", "equilibrium": "snap_hinge",
    "fit": "crank_rocker", "forces": "rack_lift", "groups": "crank_rocker", "holding_forces": "rack_lift",
    "mobility": "crank_rocker", "modes": "swing", "reduce": "rack_lift", "sensitivity": "crank_rocker",
    "sequence": "crank_rocker", "simulate": "swing", "singularities": "crank_rocker", "solve": "crank_rocker",
    "sweep": "crank_rocker", "trace": "crank_rocker", "tradeoff": "crank_rocker", "workspace": "crank_rocker",
}  # fmt: skip
ARGUMENTS = {
    "fit": [{"crank": (35, 45)}, {"x": [64.6, 71.4], "y": [67.8, 86.1]}], "sweep": [{"crank": (30, 50, 3)}],
    "modes": [{"angle": -1.5707963267948966}],
}  # fmt: skip
OPTIONS = {"fit": {"starts": 200}, "tradeoff": {"tolerances": [1e-4]}}
OTHERS = {"evaluator", "Mechanism", "assembled", "convert", "load", "loads", "shipped_models"}
"""Public names that give no result with numbers."""


def no_number(text):
    raise AssertionError(text)


def numbers(part):
    """Yield the numbers of a report."""
    if isinstance(part, dict | list):
        for value in part.values() if isinstance(part, dict) else part:
            yield from numbers(value)
    elif isinstance(part, int | float) and not isinstance(part, bool):
        yield float(part)


def same(values, found):
    """Return whether a column that was read back has the values: equal numbers, an empty cell for NaN, equal words."""
    if values.dtype.kind not in "fiu":
        return [str(a) for a in values] == [str("" if b is None else b) for b in found]
    read = np.array([np.nan if b in (None, "") else float(b) for b in found])
    return np.array_equal(np.asarray(values, dtype=float), read, equal_nan=True)


def test_every_result_is_here():
    public = {name for name in gimcli.__all__ if not name.endswith("Error")}
    assert public - OTHERS == set(RESULTS)


@pytest.mark.parametrize("verb", RESULTS)
def test_every_format_has_the_same_numbers(verb, tmp_path):
    result = getattr(gimcli, verb)(gimcli.load(RESULTS[verb]), *ARGUMENTS.get(verb, []), **OPTIONS.get(verb, {}))
    assert isinstance(result, Result)
    known = [s for s in (".xlsx", ".json", ".csv", ".npz", ".parquet") if s in result.suffixes()]
    paths = {suffix: tmp_path / f"r{suffix}" for suffix in known}
    result.save(*paths.values())
    report = json.loads(paths[".json"].read_text(encoding="utf-8"), parse_constant=no_number)
    book = openpyxl.load_workbook(paths[".xlsx"])
    cells = [c.value for row in book["Report"].iter_rows() for c in row]
    assert set(numbers(report)) <= {float(c) for c in cells if isinstance(c, int | float)}
    assert not [text for text in cells if isinstance(text, str) and ("np." in text or "array(" in text)]
    with paths[".csv"].open(encoding="utf-8", newline="") as handle:
        texts = {name: values for name, *values in zip(*csv.reader(handle), strict=True)}
    sheets = [list(zip(*sheet.iter_rows(values_only=True), strict=True)) for sheet in book if sheet.title != "Report"]
    in_sheets = {column[0]: column[1:] for sheet in sheets for column in sheet}
    arrays, table, columns = dict(np.load(paths[".npz"])), pq.read_table(paths[".parquet"]), result.table().columns
    for column in columns:
        found = {
            "csv": texts[column.name], "xlsx": in_sheets[labelled(column.name, column.unit)],
            "parquet": table[column.name].to_pylist(), "npz": arrays.get(column.name, column.values),
        }  # fmt: skip
        assert [name for name, values in found.items() if not same(column.values, values)] == [], column.name
    assert len(texts) == table.num_columns == len(columns)
