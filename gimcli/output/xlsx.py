"""Spreadsheets (Office Open XML, ECMA-376): the report, and a sheet for each kind of column of the table.

The file is an archive of XML parts. Numbers have all digits, and the same content always gives the same bytes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.errors import OutputError
from gimcli.output.atomic import written_bytes
from gimcli.output.csv import refuse_repeated
from gimcli.output.json import single
from gimcli.table import Column, Table, labelled

FIRST = ("step", "time", "branch", "design", "configuration", "curve", "circuit", "node")
"""Columns that stand first on each sheet, besides the inputs and columns of words."""

PAIRS = {"fx": "Reactions", "fy": "Reactions", "moment": "Reactions"}
ENDS = {
    "x": "Positions", "y": "Positions", "vx": "Velocities", "vy": "Velocities", "ax": "Accelerations",
    "ay": "Accelerations", "jx": "Jerks", "jy": "Jerks",
    "angle": "Angles", "omega": "Angular velocities", "alpha": "Angular accelerations", "jerk": "Angular jerks",
    "speed": "Inputs", "acceleration": "Inputs", "effort": "Efforts", "torque": "Efforts",
}  # fmt: skip
"""Kinds by the part of a column's name after the last dot."""

WHOLE = {"shaking": "Shaking", "power": "Power", "energy": "Energy"}
"""Kinds by the part of a column's name before the first dot."""

OWN = {"residual": "Solution", "sweeps": "Solution"}
OTHER, ALL = "Values", "Table"

LISTED = 1000
"""Largest number of values in a row of the report."""


@dataclass(frozen=True)
class Workbook:
    """The content of a spreadsheet file."""

    headline: str
    report: Mapping[str, Any]
    table: Table
    inputs: tuple[str, ...] = ()  # names of the actuators

    @property
    def sheets(self) -> dict[str, tuple[Column, ...]]:
        """The columns of each sheet of the table by its title, in the order in which they come.

        Each begins with the same columns. A table whose columns have no kind is one sheet.
        """
        first, kinds = list[Column](), dict[str, list[Column]]()
        for column in self.table.columns:
            if column.name in (*FIRST, *self.inputs) or column.values.dtype.kind == "U":
                first.append(column)
            else:
                kinds.setdefault(kind_of(column.name), []).append(column)
        if set(kinds) <= {OTHER}:
            return {ALL: self.table.columns}
        return {kind: (*first, *own) for kind, own in kinds.items()}

    @property
    def facts(self) -> Iterator[tuple[str, Sequence[Any]]]:
        """The entries of the report: their path such as "points.P.x", and their values."""
        return _facts(self.report, "")


def kind_of(name: str) -> str:
    """Return the kind of a column by its name."""
    if ":" in name:
        return "Measures"
    if "/" in name:
        return "Derivatives"
    start, end = name.partition(".")[0], name.rpartition(".")[2]
    return OWN.get(name) or ENDS.get(end) or WHOLE.get(start) or PAIRS.get(end) or OTHER


def _facts(value: Any, path: str) -> Iterator[tuple[str, Sequence[Any]]]:
    """Yield the single values and lists of single values of a report."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _facts(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list | tuple) and any(isinstance(inner, Mapping | list | tuple) for inner in value):
        for number, inner in enumerate(value, start=1):
            yield from _facts(inner, f"{path}.{number}")
    else:
        values = value if isinstance(value, list | tuple) else [value]
        yield path, values if len(values) <= LISTED else [*values[:LISTED], "..."]


ROWS, COLUMNS = 1_048_575, 16_384
"""Largest numbers of rows below the heading and of columns on a sheet."""

LETTERS = 32_767
"""Largest number of letters in a cell."""

NARROWEST, WIDEST = 10, 100
"""Least and largest width of a column [letters]."""

ROWS_AT_ONCE = 20_000
"""Rows that are converted to text at the same time, to limit memory."""

REPORT = "Report"

HEAD = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
MAIN = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
RELATIONS = "http://schemas.openxmlformats.org/package/2006/relationships"
OFFICE = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
TYPES = "http://schemas.openxmlformats.org/package/2006/content-types"
KIND = "application/vnd.openxmlformats-officedocument.spreadsheetml."

STYLES = (
    f'{HEAD}<styleSheet xmlns="{MAIN}">'
    '<fonts count="2"><font><sz val="11"/><name val="Calibri"/></font>'
    '<font><b/><sz val="11"/><name val="Calibri"/></font></fonts>'
    '<fills count="2"><fill><patternFill patternType="none"/></fill><fill><patternFill patternType="gray125"/></fill>'
    '</fills><borders count="1"><border><left/><right/><top/><bottom/><diagonal/></border></borders>'
    '<cellStyleXfs count="1"><xf numFmtId="0" fontId="0" fillId="0" borderId="0"/></cellStyleXfs>'
    '<cellXfs count="2"><xf numFmtId="0" fontId="0" fillId="0" borderId="0" xfId="0"/>'
    '<xf numFmtId="0" fontId="1" fillId="0" borderId="0" xfId="0" applyFont="1"/></cellXfs>'
    '<cellStyles count="1"><cellStyle name="Normal" xfId="0" builtinId="0"/></cellStyles></styleSheet>'
)
"""Two styles of cells: 0 plain, 1 bold."""


def write_xlsx(content: Workbook, path: Path | str) -> None:
    """Write the report and the sheets of a table.

    Raises:
        OutputError: a sheet would have too many rows or columns.
    """
    from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

    refuse_repeated(content.table.names)
    sheets, facts = content.sheets, list(content.facts)
    _refuse_large(path, len(facts), max((len(values) + 1 for _, values in facts), default=0))
    _refuse_large(path, len(content.table), max(map(len, sheets.values())))
    titles = [REPORT, *sheets]
    texts: list[Iterable[str]] = [[text] for text in _frame(titles).values()]
    texts += [_report_sheet(content.headline, facts), *map(_table_sheet, sheets.values())]
    names = [*_frame(titles), *(f"xl/worksheets/sheet{k}.xml" for k in range(1, len(titles) + 1))]
    with written_bytes(path) as handle, ZipFile(handle, "w", ZIP_DEFLATED) as archive:
        for name, pieces in zip(names, texts, strict=True):
            part = ZipInfo(name)  # without the time of writing
            part.compress_type = ZIP_DEFLATED
            with archive.open(part, "w", force_zip64=True) as target:
                for piece in pieces:
                    target.write(piece.encode())


def _refuse_large(path: Path | str, rows: int, columns: int) -> None:
    if rows > ROWS or columns > COLUMNS:
        raise OutputError(
            f"{path}: {rows} rows and {columns} columns; a sheet has at most {ROWS} rows below its heading and"
            f" {COLUMNS} columns: write .csv or .parquet, or fewer rows"
        )


def _frame(titles: Sequence[str]) -> dict[str, str]:
    """Return the parts of a file without its sheets, by name."""
    numbers = range(1, len(titles) + 1)
    sheets = "".join(f'<sheet name="{t}" sheetId="{k}" r:id="rId{k}"/>' for k, t in zip(numbers, titles, strict=True))
    parts = "".join(
        f'<Override PartName="/xl/worksheets/sheet{k}.xml" ContentType="{KIND}worksheet+xml"/>' for k in numbers
    )
    places = [("worksheet", f"worksheets/sheet{k}.xml") for k in numbers] + [("styles", "styles.xml")]
    return {
        "[Content_Types].xml": f'{HEAD}<Types xmlns="{TYPES}">'
        '<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>'
        f'<Override PartName="/xl/workbook.xml" ContentType="{KIND}sheet.main+xml"/>'
        f'<Override PartName="/xl/styles.xml" ContentType="{KIND}styles+xml"/>{parts}</Types>',
        "_rels/.rels": _relations([("officeDocument", "xl/workbook.xml")]),
        "xl/workbook.xml": f'{HEAD}<workbook xmlns="{MAIN}" xmlns:r="{OFFICE}">'
        f"<bookViews><workbookView/></bookViews><sheets>{sheets}</sheets></workbook>",
        "xl/_rels/workbook.xml.rels": _relations(places),
        "xl/styles.xml": STYLES,
    }


def _relations(targets: Sequence[tuple[str, str]]) -> str:
    """Return the part that names other parts, each with its kind."""
    entries = "".join(
        f'<Relationship Id="rId{k}" Type="{OFFICE}/{kind}" Target="{target}"/>'
        for k, (kind, target) in enumerate(targets, start=1)
    )
    return f'{HEAD}<Relationships xmlns="{RELATIONS}">{entries}</Relationships>'


def _report_sheet(headline: str, facts: Sequence[tuple[str, Sequence[Any]]]) -> Iterator[str]:
    """Yield the text of the report's sheet: the headline, then a row for each entry."""
    yield _start([max((len(name) + 2 for name, _ in facts), default=NARROWEST)], 0)
    yield _row(1, [_text(headline, bold=True)])
    for number, (name, values) in enumerate(facts, start=2):
        yield _row(number, [_text(name), *map(_single, values)])
    yield "</sheetData></worksheet>"


def _table_sheet(columns: Sequence[Column]) -> Iterator[str]:
    """Yield the text of a sheet of columns; the heading stays visible."""
    heads = [labelled(column.name, column.unit) for column in columns]
    yield _start([len(head) + 2 for head in heads], 1)
    yield _row(1, [_text(head, bold=True) for head in heads])
    count = len(columns[0].values) if columns else 0
    for first in range(0, count, ROWS_AT_ONCE):
        rows = slice(first, first + ROWS_AT_ONCE)
        texts = [_cells(column.values[rows]) for column in columns]
        yield "".join(_row(number, cells) for number, cells in enumerate(zip(*texts, strict=True), start=first + 2))
    yield "</sheetData></worksheet>"


def _start(widths: Sequence[int], frozen: int) -> str:
    """Return the start of a sheet with columns of some widths [letters] and a number of rows that stay visible."""
    pane = f'<pane ySplit="{frozen}" topLeftCell="A{frozen + 1}" activePane="bottomLeft" state="frozen"/>'
    columns = "".join(
        f'<col min="{k}" max="{k}" width="{min(max(width, NARROWEST), WIDEST)}" customWidth="1"/>'
        for k, width in enumerate(widths, start=1)
    )
    return (
        f'{HEAD}<worksheet xmlns="{MAIN}"><sheetViews><sheetView workbookViewId="0">{pane if frozen else ""}'
        f"</sheetView></sheetViews>{f'<cols>{columns}</cols>' if columns else ''}<sheetData>"
    )


def _row(number: int, cells: Iterable[str]) -> str:
    return f'<row r="{number}">{"".join(cells)}</row>'


def _cells(values: NDArray[Any]) -> list[str]:
    """Return the cells of a column."""
    if values.dtype.kind in "fiu":
        return list(map(_number, values.tolist()))
    known = {value: _text(str(value)) for value in np.unique(values).tolist()}
    return [known[value] for value in values.tolist()]


def _number(value: float) -> str:
    """Return the cell of a number; NaN is an empty cell. A sheet has no infinite numbers: they are texts."""
    if math.isfinite(value):
        return f"<c><v>{value!r}</v></c>"
    return "<c/>" if math.isnan(value) else _text(str(value))


def _text(text: str, bold: bool = False) -> str:
    """Return the cell of a text, without the letters that XML does not allow."""
    from xml.sax.saxutils import escape

    allowed = re.sub("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]", "", text)[:LETTERS]
    style = ' s="1"' if bold else ""
    return f'<c{style} t="inlineStr"><is><t xml:space="preserve">{escape(allowed)}</t></is></c>'


def _single(value: Any) -> str:
    """Return the cell of one value of the report."""
    value = single(value)
    if value is None:
        return "<c/>"
    return _number(value) if isinstance(value, float | int) and not isinstance(value, bool) else _text(str(value))
