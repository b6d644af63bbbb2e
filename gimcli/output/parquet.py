"""Apache Parquet files, if pyarrow is installed; columns carry their units as metadata."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from gimcli.errors import OutputError
from gimcli.output.atomic import written_bytes
from gimcli.output.csv import refuse_repeated
from gimcli.table import Table


def require_pyarrow(path: Path) -> None:
    """Raise OutputError if pyarrow is not installed."""
    try:
        import pyarrow.parquet  # noqa: F401 - only whether it is installed
    except ImportError:
        raise OutputError(f"{path}: Parquet files need pyarrow; run: pip install 'gimcli[parquet]'") from None


class ParquetStream:
    """A Parquet file to which tables are appended; it appears when the `with` block ends without an error."""

    def __init__(self, target: Path | str, names: Sequence[str]) -> None:
        refuse_repeated(names)
        self._target, self._stack, self._names = target, ExitStack(), tuple(names)
        self._handle: Any = None
        self._writer: Any = None

    def __enter__(self) -> ParquetStream:
        self._handle = self._stack.enter_context(written_bytes(self._target))
        return self

    def __exit__(self, *fault: Any) -> None:
        if self._writer is not None:
            self._writer.close()
        self._stack.__exit__(*fault)

    def append(self, table: Table) -> None:
        """Write the rows of a table with the stream's columns."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        types = [_type(c.values) for c in table.columns]
        if self._writer is None:
            fields = [pa.field(c.name, t, metadata={"unit": c.unit}) for c, t in zip(table.columns, types, strict=True)]
            self._writer = pq.ParquetWriter(self._handle, pa.schema(fields))
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
    import pyarrow as pa

    return pa.string() if values.dtype.kind == "U" else pa.int64() if values.dtype.kind in "iu" else pa.float64()
