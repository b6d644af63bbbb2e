"""Archives of named arrays in numpy's format."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.output.atomic import written_bytes
from gimcli.output.csv import refuse_repeated
from gimcli.table import Table

COPIED = 1 << 20
"""Bytes that are copied at once."""


def write_npz(arrays: Mapping[str, NDArray[Any]], path: Path | str) -> None:
    """Write named arrays into one uncompressed archive."""
    with written_bytes(path) as handle:
        np.savez(handle, **dict(arrays))  # type: ignore[arg-type]  # mypy: a name could be that of a parameter of savez


class NpzStream:
    """An archive of the columns of tables that are appended; memory is limited by the largest table.

    The file appears when the `with` block ends without an error. Texts must have the same type in all tables.
    """

    def __init__(self, target: Path | str, names: Sequence[str]) -> None:
        refuse_repeated(names)
        self._target, self._names, self._stack = target, tuple(names), ExitStack()
        self._columns: list[Any] = []  # temporary files with the values
        self._types: list[np.dtype[Any]] = []
        self._rows = 0

    def __enter__(self) -> NpzStream:
        from tempfile import TemporaryFile  # imported late, as zipfile: few commands write these files

        self._columns = [self._stack.enter_context(TemporaryFile()) for _ in self._names]  # noqa: SIM115 - closed by the stack
        return self

    def __exit__(self, *fault: Any) -> None:
        with self._stack:
            if fault[0] is None:
                self._write()

    def append(self, table: Table) -> None:
        """Add the rows of a table with the stream's columns."""
        types = [column.values.dtype for column in table.columns]
        if table.names != self._names or types != (self._types or types):
            raise ValueError(f"the table has columns {table.names}, not {self._names}, or other types")
        self._types = types
        self._rows += len(table)
        for handle, column in zip(self._columns, table.columns, strict=True):
            handle.write(np.ascontiguousarray(column.values).tobytes())

    def _write(self) -> None:
        from zipfile import ZipFile

        with written_bytes(self._target) as target, ZipFile(target, "w", allowZip64=True) as archive:
            for name, kind, column in zip(self._names, self._types, self._columns, strict=False):
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    descr = np.lib.format.dtype_to_descr(kind)
                    head = {"descr": descr, "fortran_order": False, "shape": (self._rows,)}
                    np.lib.format.write_array_header_1_0(member, head)
                    column.seek(0)
                    while part := column.read(COPIED):
                        member.write(part)
