"""Writers of files: one module per format, with one line for each in `formats.py`.

The other modules compose pictures; `write` writes them. This package imports fast: matplotlib is imported when the
first picture is written.
"""

from gimcli.output.atomic import refuse_unwritable, written_bytes, written_text
from gimcli.output.formats import FORMATS, Destinations, Format, destinations, format_of, write
from gimcli.output.json import json_text

__all__ = [
    "FORMATS", "Destinations", "Format", "destinations", "format_of", "json_text",
    "refuse_unwritable", "write", "written_bytes", "written_text",
]  # fmt: skip
