"""Everything that is written to a file: one file per format, one line here for each.

Importing this package is cheap: the drawings, and matplotlib, are imported by the functions that draw.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from gimcli.errors import UsageError
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.output.atomic import refuse_unwritable, written_bytes, written_text
from gimcli.output.csv import CsvStream, refuse_repeated, write_csv
from gimcli.output.npz import write_npz
from gimcli.output.parts import Parts
from gimcli.output.pdf import write_pdf
from gimcli.output.png import write_png
from gimcli.output.svg import write_svg
from gimcli.table import Table

if TYPE_CHECKING:
    from gimcli.output.drawing import Step
    from gimcli.output.groups import Box, BoxJoint
    from gimcli.output.history import Panel
    from gimcli.output.picture import Content
    from gimcli.output.singular import Shown
    from gimcli.output.vectors import Arrows

__all__ = [
    "PICTURE_FORMATS",
    "TABLE_FORMATS",
    "CsvStream",
    "Parts",
    "draw_configurations",
    "draw_forces",
    "draw_groups",
    "draw_history",
    "draw_history_sheet",
    "draw_motion",
    "draw_paths",
    "draw_position",
    "draw_sequence",
    "draw_singularities",
    "draw_tradeoff",
    "draw_workspace",
    "refuse_files",
    "refuse_repeated",
    "refuse_unwritable",
    "write",
    "write_csv",
    "write_npz",
    "written_bytes",
    "written_text",
]

Written = TypeVar("Written")
Formats = dict[str, Callable[[Written, Path], None]]

TABLE_FORMATS: Formats[Table] = {
    ".csv": write_csv,
}
PICTURE_FORMATS: Formats[Content] = {
    ".png": write_png,
    ".svg": write_svg,
    ".pdf": write_pdf,
}


def write(content: Table | Content, path: Path | str) -> None:
    """Write a table or a picture in the format that the suffix of `path` names."""
    if isinstance(content, Table):
        _write(content, Path(path), TABLE_FORMATS, "table")
    else:
        _write(content, Path(path), PICTURE_FORMATS, "picture")


def refuse_files(read: Iterable[Path], table: Path | None, picture: Path | None) -> None:
    """Raise UsageError where a suffix names no format; otherwise as `refuse_unwritable`."""
    if table is not None:
        _writer(table, TABLE_FORMATS, "table")
    if picture is not None:
        _writer(picture, PICTURE_FORMATS, "picture")
    refuse_unwritable(read, *(path for path in (table, picture) if path is not None))


def _write(content: Written, path: Path, formats: Formats[Written], what: str) -> None:
    _writer(path, formats, what)(content, path)


def _writer(path: Path, formats: Formats[Written], what: str) -> Callable[[Written, Path], None]:
    writer = formats.get(path.suffix.lower())
    if writer is None:
        raise UsageError(f"{path}: no {what} is written as '{path.suffix}'; choose {', '.join(formats)}")
    return writer


def draw_motion(
    mechanism: Mechanism,
    positions: ComplexArray,
    curves: Mapping[str, ComplexArray],
    path: Path | str,
    title: str,
    measured: Mapping[str, ComplexArray] | None = None,
    areas: Sequence[ComplexArray] = (),
    panels: Mapping[str, Table] | None = None,
) -> None:
    """Draw some poses (poses, nodes) and the traced curves, both in the file's units.

    Curves that measures add show only as far as there is room; `areas` are regions passed over; `panels` are graphs
    below the drawing, tables whose first column is the abscissa.
    """
    from gimcli.output.drawing import motion_picture
    from gimcli.output.panels import with_panels

    picture = motion_picture(mechanism, positions, curves, title, measured or {}, areas)
    write(with_panels(picture, panels or {}), path)


def draw_position(
    mechanism: Mechanism,
    position: ComplexArray,
    path: Path | str,
    title: str,
    points: Mapping[str, complex] | None = None,
    arrows: Sequence[Arrows] = (),
) -> None:
    """Draw one pose (nodes,) with its names, named points, and vectors at them, in the file's units."""
    from gimcli.output.drawing import position_picture

    write(position_picture(mechanism, position, title, points or {}, arrows), path)


def draw_configurations(
    mechanism: Mechanism, positions: ComplexArray, titles: Sequence[str], path: Path | str, title: str
) -> None:
    """Draw positions (configurations, nodes) in the file's units side by side, each with a title."""
    from gimcli.output.gallery import gallery_picture

    write(gallery_picture(mechanism, positions, titles, title), path)


def draw_sequence(
    mechanism: Mechanism, position: ComplexArray, steps: Sequence[Step], path: Path | str, title: str
) -> None:
    """Draw one pose (nodes,) and the numbered steps (node moved, nodes it is moved about)."""
    from gimcli.output.drawing import sequence_picture

    write(sequence_picture(mechanism, position, steps, title), path)


def draw_singularities(
    mechanism: Mechanism,
    shown: Sequence[Shown],
    curves: Mapping[str, ComplexArray],
    path: Path | str,
    title: str,
) -> None:
    """Draw singular positions, numbered, over the curves of circuits, all in the file's units."""
    from gimcli.output.singular import singular_picture

    write(singular_picture(mechanism, shown, curves, title), path)


def draw_history(
    errors: FloatArray,
    fit: tuple[float, float] | None,
    path: Path | str,
    title: str,
    predicted: float = float("nan"),
    first: int = 0,
) -> None:
    """Draw the error per sweep, the fit C1 exp(-C2 n) and the slope of a predicted factor."""
    from gimcli.output.drawing import history_picture

    write(history_picture(errors, fit, title, predicted, first), path)


def draw_tradeoff(curves: Mapping[str, FloatArray], front: FloatArray, path: Path | str, title: str) -> None:
    """Draw error over time: curves (points, 3) of seconds, error and 1 where all is solved; front (points, 2)."""
    from gimcli.output.tradeoff import tradeoff_picture

    write(tradeoff_picture(curves, front, title), path)


def draw_forces(efforts: Mapping[str, Table], shaking: ComplexArray, path: Path | str, title: str) -> None:
    """Draw driving efforts, tables whose first column is the abscissa, and the path of the shaking force [N]."""
    from gimcli.output.forces import forces_sheet

    write(forces_sheet(efforts, shaking, title), path)


def draw_groups(boxes: Sequence[Box], joints: Sequence[BoxJoint], path: Path | str, title: str) -> None:
    """Draw groups as boxes, each below those that it is joined to, and the pairs that join them."""
    from gimcli.output.groups import groups_picture

    write(groups_picture(boxes, joints, title), path)


def draw_workspace(
    mechanism: Mechanism,
    pose: ComplexArray | None,
    curves: Mapping[str, Sequence[ComplexArray]],
    point: tuple[str, complex | None],
    density: ComplexArray | None,
    path: Path | str,
    title: str,
) -> None:
    """Draw the curves "outer", "hole" and "inner" of a region over a pose (nodes,), in the file's units."""
    from gimcli.output.workspace import workspace_picture

    write(workspace_picture(mechanism, pose, curves, point, density, title), path)


def draw_paths(
    mechanism: Mechanism,
    pose: ComplexArray | None,
    paths: Sequence[ComplexArray],
    point: tuple[str, complex | None],
    path: Path | str,
    title: str,
) -> None:
    """Draw the paths of a point, the drawn configuration's first, over a pose (nodes,), in the file's units."""
    from gimcli.output.workspace import path_picture

    write(path_picture(mechanism, pose, paths, point, title), path)


def draw_history_sheet(panels: Sequence[Panel], over: str, path: Path | str, title: str) -> None:
    """Draw panels of curves that share what they run over, such as the time."""
    from gimcli.output.history import history_sheet

    write(history_sheet(panels, over, title), path)
