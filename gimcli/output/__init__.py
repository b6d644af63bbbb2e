"""Writers of files: one module per format, with one line for each in `formats.py`; the other modules compose pictures.

Knows: symbols, pictures, pages and sheets; only here matplotlib is imported, when the first picture is written.
Asks: branching, dynamics, structure.
Asked by: cli, families, graphs, library, view.

Its modules are imported when they are first used, as `output.drawing.motion_picture`: most commands use few of them.
"""

from typing import TYPE_CHECKING

from gimcli.door import modules_of
from gimcli.output.atomic import refuse_unwritable, written_bytes, written_text
from gimcli.output.formats import FORMATS, Destinations, Format, destinations, format_of, write
from gimcli.output.json import json_text

__all__ = [
    "FORMATS", "Destinations", "Format", "destinations", "format_of", "json_text",
    "refuse_unwritable", "write", "written_bytes", "written_text",
]  # fmt: skip

if TYPE_CHECKING:
    from gimcli.output import (
        animation as animation,
        circuits as circuits,
        drawing as drawing,
        gallery as gallery,
        geometry as geometry,
        graph as graph,
        model as model,
        modes as modes,
        page as page,
        panels as panels,
        picture as picture,
        pose as pose,
        printed as printed,
        sensitivity as sensitivity,
        structure as structure,
        tradeoff as tradeoff,
        vectors as vectors,
        workspace as workspace,
        xlsx as xlsx,
    )

__getattr__ = modules_of(__name__)
