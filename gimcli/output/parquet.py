"""Apache Parquet files, written by pyarrow; columns carry their units as metadata."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from gimcli.output.atomic import written_bytes
from gimcli.output.csv import TableStream
from gimcli.table import Table


class ParquetStream(TableStream):
    """A Parquet file to which tables are appended; it appears when the `with` block ends without an error."""

    _writer: Any = None

    def _opened(self) -> Any:
        return self.enter_context(written_bytes(self._target))

    def _add(self, table: Table) -> None:
        types = [_type(c.values) for c in table.columns]
        if self._writer is None:
            fields = [pa.field(c.name, t, metadata={"unit": c.unit}) for c, t in zip(table.columns, types, strict=True)]
            self._writer = self.enter_context(pq.ParquetWriter(self._file, pa.schema(fields)))
        arrays = [
            pa.array(c.values.tolist() if pa.types.is_string(t) else c.values, t)
            for c, t in zip(table.columns, types, strict=True)
        ]
        if len(table):
            self._writer.write_table(pa.Table.from_arrays(arrays, schema=self._writer.schema))


def write_parquet(table: Table, path: Path | str) -> None:
    """Write a table as a Parquet file."""
    with ParquetStream(path, table.names) as stream:
        stream.append(table)


def _type(values: Any) -> Any:
    """Return the type of a column: text, whole numbers or numbers."""
    return pa.string() if values.dtype.kind == "U" else pa.int64() if values.dtype.kind in "iu" else pa.float64()
