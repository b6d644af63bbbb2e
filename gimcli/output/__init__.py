"""Writers of files: one module per format, with one line for each in `formats.py`.

The other modules compose pictures; `write` writes them. This package imports fast: matplotlib is imported when the
first picture is written.
"""

from gimcli.output.atomic import refuse_unwritable, written_bytes, written_text
from gimcli.output.csv import CsvStream, refuse_repeated, write_csv
from gimcli.output.destinations import Destinations, destinations
from gimcli.output.formats import FORMATS, Format, format_of, write
from gimcli.output.json import json_text
from gimcli.output.parts import Parts

__all__ = [
    "FORMATS", "CsvStream", "Destinations", "Format", "Parts", "destinations", "format_of", "json_text",
    "refuse_repeated", "refuse_unwritable", "write", "write_csv", "written_bytes", "written_text",
]  # fmt: skip
