"""What results give to the writers of files: the kinds of contents, and what a picture is printed with."""

from gimcli.output.animation import Animation
from gimcli.output.formats import Destinations
from gimcli.output.geometry import Geometry
from gimcli.output.graph import CurveGraph
from gimcli.output.model import ModelText
from gimcli.output.picture import Content
from gimcli.output.printed import PictureOptions
from gimcli.output.xlsx import Workbook

__all__ = [
    "Animation", "Content", "CurveGraph", "Destinations", "Geometry", "ModelText", "PictureOptions", "Workbook",
]  # fmt: skip
