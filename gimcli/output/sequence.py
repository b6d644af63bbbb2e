"""The picture of a sequence: numbered moves on the mechanism, coloured by group, and a table of the moves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output import symbols
from gimcli.output.labels import extent
from gimcli.output.picture import LAYOUT, Frame, Picture, PictureLayout, Sheet, Text, composition
from gimcli.output.pose import Drawing, part_names, solved
from gimcli.output.style import SOFT, Fill, Mark, Pen, group_colour, tint

DENSE = 12
"""A group with more moves has the numbers of its moves at their nodes, in place of arrows."""

ARMS = 6
"""In groups with more moves, only the first arrow of a move is drawn: the table names all nodes."""

NUMBER = 6.5
"""Size of the numbers of moves [pt]."""

ROW, COLUMN, BORDER = 12.0, 12.0, 6.0
"""Height of a row of the table, distance of its columns, and its border [pt]."""

TABLE, LETTERS = 475.0, 7.0
"""Largest width of the table, and size of its texts [pt]."""


@dataclass(frozen=True)
class DrawnMove:
    """A move: the node that it moves, the other nodes of its constraint, and its line in the table."""

    node: int
    about: tuple[int, ...]
    text: str


@dataclass(frozen=True)
class MoveGroup:
    """The moves of a group, and its line in the legend."""

    name: str
    moves: tuple[DrawnMove, ...]


def sequence_sheet(mechanism: Mechanism, position: ComplexArray, groups: Sequence[MoveGroup], title: str) -> Sheet:
    """Return the mechanism with its moves, above the table of all moves, if there are any."""
    return Sheet("", (sequence_picture(mechanism, position, groups, title), *([moves_table(groups)] if groups else [])))


@composition
def sequence_picture(
    mechanism: Mechanism, position: ComplexArray, groups: Sequence[MoveGroup], title: str, *,
    layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return one pose in light colours; numbered arrows go from the nodes of a constraint to the node that it moves."""
    scene = solved(mechanism, position)
    drawing = Drawing.around(mechanism, scene, title, [position], layout)
    if not scene:
        return drawing.picture
    drawing.poses(colours=dict.fromkeys(part_names(scene), SOFT))
    arcs, first = Counter[tuple[int, int]](), 1
    for number, group in enumerate(groups, start=1):
        _draw_group(drawing, scene.poses[0], group, (number, first), arcs)
        first += len(group.moves)
    return drawing.write(range(len(mechanism.nodes)), {})


def _draw_group(
    drawing: Drawing, z: ComplexArray, group: MoveGroup, numbers: tuple[int, int], arcs: Counter[tuple[int, int]]
) -> None:  # fmt: skip
    """Draw the nodes and moves of a group; `numbers` are its own and that of its first move."""
    colour, picture, labels = group_colour(numbers[0]), drawing.picture, drawing.labels
    moved = dict.fromkeys(move.node for move in group.moves)
    picture.draw(Mark("o", 8.0, tint(colour), colour, 1.6, layer=9), *z[list(moved)].tolist())
    picture.legend.append((group.name, Pen(2.6, colour)))
    if len(group.moves) > DENSE:
        for node in moved:
            own = [str(k) for k, move in enumerate(group.moves, start=numbers[1]) if move.node == node]
            labels.beside(complex(z[node]), ", ".join(own), colour, NUMBER)
        return
    for k, move in enumerate(group.moves, start=numbers[1]):
        offers = _draw_move(picture, z, move, arcs, colour, len(group.moves) <= ARMS)
        labels.at_best(offers, str(k), colour, NUMBER)


def _draw_move(
    picture: Picture, z: ComplexArray, move: DrawnMove, drawn: Counter[tuple[int, int]], colour: str, arms: bool
) -> ComplexArray:
    """Draw the arrows of a move; return possible places of its number: on the first arrow, or around the node."""
    around = np.exp(1j * np.radians(np.arange(60, 420, 30)))
    offers = [complex(z[move.node]) + distance * picture.frame.point * around for distance in (12.0, 20.0, 28.0)]
    head = Fill(colour, colour, 0.3, layer=7)
    for order, start in enumerate(move.about):
        path = _bow(picture, z, start, move.node, drawn) if order == 0 or arms else np.zeros(0, dtype=np.complex128)
        if len(path):
            pen = Pen(0.8, colour, (1.0, 1.8), layer=7) if order else Pen(1.0, colour, layer=7)
            line, tip = symbols.arrow_lines(path, 5.0 * picture.frame.point)
            picture.draw(pen, line)
            picture.draw(head, tip)
        if len(path) and order == 0:
            ahead = np.array([0.72, 0.6, 0.5, 0.4, 0.3, 0.2, 0.8])
            offers.insert(0, path[(ahead * (len(path) - 1)).astype(int)])
    return np.concatenate(offers)


def _bow(picture: Picture, z: ComplexArray, start: int, end: int, drawn: Counter[tuple[int, int]]) -> ComplexArray:
    """Return an arc from one node to another that avoids their pins and the arcs already `drawn`."""
    first, span, pt = complex(z[start]), complex(z[end] - z[start]), picture.frame.point
    if abs(span) < 14.0 * pt:
        return np.zeros(0, dtype=np.complex128)
    between = min(start, end), max(start, end)
    again = drawn[between]
    drawn[between] += 1
    side = (1.0 if (again % 2 == 0) == (start < end) else -1.0) * (9.0 + 9.0 * (again // 2)) * pt
    clear = 5.5 * pt / abs(span)
    t = np.linspace(clear, 1.0 - clear, 33)
    return np.asarray(first + span * (t + 4.0j * side / abs(span) * t * (1 - t)))


@composition
def moves_table(groups: Sequence[MoveGroup], *, layout: PictureLayout = LAYOUT) -> Picture:
    """Return the numbered moves of all groups as lines of text in columns, in the colours of the groups."""
    lines = [(move.text, group_colour(k)) for k, group in enumerate(groups, start=1) for move in group.moves]
    texts = [f"{k}  {text}" for k, (text, _) in enumerate(lines, start=1)]
    wide, high = max(extent(text, LETTERS * layout.font)[0] for text in texts) + COLUMN, ROW * layout.font
    columns = max(1, min(-(-len(texts) // 3), int((TABLE - 2 * BORDER) / wide)))
    rows = -(-len(texts) // columns)
    size = complex(columns * wide, rows * high) + 2 * BORDER * (1 + 1j)
    room = 72.0 * complex(layout.width, layout.height) if layout.fills else size
    scale = min(1.0, room.real / size.real, room.imag / size.imag)
    half = room / scale / 2
    frame = Frame(size / 2 - half, size / 2 + half, room.real / 72.0, room.imag / 72.0, layout.font)
    picture = Picture("", frame, ("", ""), bare=True)
    for k, (text, (_, colour)) in enumerate(zip(texts, lines, strict=True)):
        column, row = divmod(k, rows)
        at = complex(BORDER + column * wide, size.imag - BORDER - (row + 0.5) * high)
        picture.texts.append(Text(at, text, LETTERS * scale, colour, begins=True))
    return picture
