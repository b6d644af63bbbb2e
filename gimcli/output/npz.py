"""Archives of named arrays in numpy's format."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from gimcli.output.atomic import written_bytes
from gimcli.output.csv import TableStream
from gimcli.table import Table

COPIED = 1 << 20
"""Bytes that are copied at once."""


def write_npz(arrays: Mapping[str, NDArray[Any]], path: Path | str) -> None:
    """Write named arrays into one uncompressed archive."""
    with written_bytes(path) as handle:
        np.savez(handle, **dict(arrays))  # type: ignore[arg-type]  # mypy: a name could be that of a parameter of savez


class NpzStream(TableStream):
    """An archive of the columns of tables that are appended; memory is limited by the largest table.

    The file appears when the `with` block ends without an error. Texts must have the same type in all tables.
    """

    def _opened(self) -> list[Any]:
        self._types: list[np.dtype[Any]] = []
        self._rows = 0
        columns = [self.enter_context(TemporaryFile()) for _ in self._names]  # noqa: SIM115 - closed by the stack
        self.push(self._write)
        return columns

    def _add(self, table: Table) -> None:
        types = [column.values.dtype for column in table.columns]
        if types != (self._types or types):
            raise ValueError(f"the table has columns of other types than {self._types}")
        self._types = types
        self._rows += len(table)
        for handle, column in zip(self._file, table.columns, strict=True):
            handle.write(np.ascontiguousarray(column.values).tobytes())

    def _write(self, *fault: Any) -> None:
        """Write the archive, unless an error has ended the block."""
        if fault[0] is not None:
            return
        with written_bytes(self._target) as target, ZipFile(target, "w", allowZip64=True) as archive:
            for name, kind, column in zip(self._names, self._types, self._file, strict=False):
                with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                    descr = np.lib.format.dtype_to_descr(kind)
                    head = {"descr": descr, "fortran_order": False, "shape": (self._rows,)}
                    np.lib.format.write_array_header_1_0(member, head)
                    column.seek(0)
                    shutil.copyfileobj(column, member, COPIED)
