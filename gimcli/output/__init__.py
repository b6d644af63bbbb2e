"""Writers of files: one module per format, with one line for each in `formats.py`; the other modules compose pictures.

Knows: symbols, pictures, pages and sheets; only here matplotlib is imported, when the first picture is written.
Asks: branching, dynamics, structure.
Asked by: cli, families, graphs, library, view.
"""

from gimcli.output.atomic import refuse_unwritable, written_bytes, written_text
from gimcli.output.formats import FORMATS, Destinations, Format, destinations, format_of, write
from gimcli.output.json import json_text

__all__ = [
    "FORMATS", "Destinations", "Format", "destinations", "format_of", "json_text",
    "refuse_unwritable", "write", "written_bytes", "written_text",
]  # fmt: skip
