"""The report's numbers of every command in every format of tables: numbers for other programs, never Python's text."""

import json

import openpyxl
import pyarrow.parquet as pq
import pytest

import gimcli

RESULTS = {
    "check": "crank_rocker", "circuits": "crank_rocker", "configurations": "crank_rocker", "equilibrium": "snap_hinge",
    "forces": "rack_lift", "groups": "crank_rocker", "mobility": "crank_rocker", "reduce": "rack_lift",
    "sensitivity": "crank_rocker", "sequence": "crank_rocker", "simulate": "swing", "singularities": "crank_rocker",
    "solve": "crank_rocker", "trace": "crank_rocker", "workspace": "crank_rocker",
}  # fmt: skip


def no_number(text):
    raise AssertionError(text)


@pytest.mark.parametrize("verb", RESULTS)
def test_every_format_has_numbers(verb, tmp_path):
    result = getattr(gimcli, verb)(gimcli.load(RESULTS[verb]))
    paths = [tmp_path / f"r{suffix}" for suffix in (".xlsx", ".json", ".csv", ".npz", ".parquet")]
    result.save(*paths)
    json.loads(paths[1].read_text(encoding="utf-8"), parse_constant=no_number)
    assert pq.read_table(paths[4]).num_rows == len(result.table())
    cells = [c.value for sheet in openpyxl.load_workbook(paths[0]) for row in sheet.iter_rows() for c in row]
    texts = [value for value in cells if isinstance(value, str)]
    assert len(texts) < len(cells)
    assert not [text for text in texts if "np." in text or "array(" in text]
