"""Pictures of the structure: a formation of groups, and the sequence in which positions are solved.

A formation is the mechanism coloured by groups, and the groups as boxes with the pairs that join them. A sequence is
numbered moves on the mechanism, coloured by group, and a table of the moves.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gimcli.connected import grouped
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.output import symbols
from gimcli.output.labels import Labels, extent
from gimcli.output.picture import LAYOUT, Frame, Picture, PictureLayout, Sheet, Text, composition, rectangle
from gimcli.output.pose import Drawing, part_names, solved
from gimcli.output.scene import Scene
from gimcli.output.style import ARROW, FONT, HEAD, INK, SOFT, Fill, Mark, Pen, group_colour, tint

LINE = 0.17
"""Height of a line of text [in]."""

LETTER = 0.0092
"""Width of a letter [in] per point of its size."""

PAD, ACROSS, DOWN = 0.14, 0.35, 0.62
"""Border inside a box, and horizontal and vertical distances between boxes [in]."""

EDGE = 0.2
"""Free border of the diagram [in]."""

GROUND = Fill("#d9d9d9", INK, 1.2, layer=5)

KEY = 2.6
"""Width of the lines in the legend [pt]."""

NUMBER = 6.5
"""Size of the numbers of groups and moves [pt]."""


@dataclass(frozen=True)
class Box:
    """The frame or a group: its number (0: the frame), lines of text, the number of layers above it, its links."""

    number: int
    lines: tuple[str, ...]
    layer: int
    name: str = ""  # in the legend
    links: tuple[str, ...] = ()

    @property
    def size(self) -> complex:
        """Width and height [in]."""
        longest = max(len(line) for line in self.lines)
        return complex(LETTER * FONT * longest + 2 * PAD, LINE * len(self.lines) + 2 * PAD)

    @property
    def fill(self) -> Fill:
        """Colours of the box: those of its links in the drawing."""
        if not self.number:
            return GROUND
        colour = group_colour(self.number)
        return Fill(tint(colour), colour, 1.6, layer=5)


@dataclass(frozen=True)
class BoxJoint:
    """Pairs that join a box to one above it."""

    upper: int
    lower: int
    label: str
    tag: str = ""  # short name that is drawn instead of the upper box if that is not in the next layer


@composition
def coloured_picture(
    mechanism: Mechanism, position: ComplexArray, boxes: Sequence[Box], title: str, *, layout: PictureLayout = LAYOUT
) -> Picture:
    """Return the mechanism with each link in the colour of its group, and the number of the group at each link."""
    scene = solved(mechanism, position)
    drawing = Drawing.around(mechanism, scene, title, [position], layout)
    groups = [box for box in boxes if box.number]
    numbers = {link: box.number for box in groups for link in box.links}
    drawing.poses(colours={link: group_colour(number) for link, number in numbers.items()})
    if scene:
        _number(drawing.labels, scene, numbers)
    drawing.picture.legend += [(f"{box.number}: {box.name}", Pen(KEY, group_colour(box.number))) for box in groups]
    return drawing.write(range(len(mechanism.nodes)), {})


def _number(labels: Labels, scene: Scene, numbers: Mapping[str, int]) -> None:
    """Request the number of its group on each link."""
    z = scene.poses[0]
    places = {symbol.name: scene.line(symbol.ends, z) for symbol in (*scene.bodies, *scene.cylinders)}
    along = np.array([0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74])
    for link, number in numbers.items():
        corners = places.get(link, np.zeros(0))
        if len(corners) == 2:
            labels.at_best(corners[0] + along * (corners[1] - corners[0]), str(number), group_colour(number), NUMBER)
        elif len(corners):
            middle = corners.mean()
            offers = np.append(middle, middle + 0.35 * (corners - middle))
            labels.at_best(offers, str(number), group_colour(number), NUMBER)


@composition
def formation_picture(boxes: Sequence[Box], joints: Sequence[BoxJoint], *, layout: PictureLayout = LAYOUT) -> Picture:
    """Return the boxes in layers, with an arrow from each box to the boxes that are joined to it."""
    centres, size = _places(boxes)
    picture = Picture("", _frame(size, layout), ("", ""), bare=True)
    for box, centre in zip(boxes, centres, strict=True):
        picture.draw(box.fill, rectangle(centre, box.size / 2))
        top = centre.imag + LINE * (len(box.lines) - 1) / 2
        picture.texts += [Text(complex(centre.real, top - LINE * k), line) for k, line in enumerate(box.lines)]
    for together in grouped((joint.lower, joint) for joint in joints).values():
        for lane, joint in enumerate(together, start=1):
            _arrow(picture, boxes, centres, joint, lane / (len(together) + 1))
    shrunk = min(1.0, picture.frame.width / (picture.frame.high - picture.frame.low).real)
    return replace(picture, texts=[replace(text, size=shrunk * text.size) for text in picture.texts])


def _frame(size: complex, layout: PictureLayout) -> Frame:
    """Return a window around the diagram, whose unit is an inch; it shrinks to fit."""
    scale = min(1.0, layout.width / size.real, (layout.height / size.imag) if layout.fills else 1.0)
    width, height = (layout.width, layout.height) if layout.fills else (scale * size.real, scale * size.imag)
    half = complex(width, height) / scale / 2
    return Frame(size / 2 - half, size / 2 + half, width, height, min(1.0, layout.font))


def _places(boxes: Sequence[Box]) -> tuple[list[complex], complex]:
    """Return the centres of the boxes, y upwards, and the size of the picture [in]."""
    layers = list(grouped(sorted((box.layer, k) for k, box in enumerate(boxes))).values())
    widths = [sum(boxes[k].size.real for k in layer) + ACROSS * (len(layer) - 1) for layer in layers]
    heights = [max(boxes[k].size.imag for k in layer) for layer in layers]
    width = max(widths) + 2 * EDGE
    height = sum(heights) + DOWN * (len(layers) - 1) + 2 * EDGE
    centres, y = [0.0j] * len(boxes), height - EDGE
    for layer, own, tall in zip(layers, widths, heights, strict=True):
        x = (width - own) / 2
        for k in layer:
            centres[k] = complex(x + boxes[k].size.real / 2, y - tall / 2)
            x += boxes[k].size.real + ACROSS
        y -= tall + DOWN
    return centres, complex(width, height)


def _arrow(picture: Picture, boxes: Sequence[Box], centres: list[complex], joint: BoxJoint, share: float) -> None:
    """Draw the arrow of a joint to the upper side of the lower box, at the part `share` of its width; name the pairs.

    If the upper box is more than one layer above, the arrow starts at a tag, so that it does not cross other boxes.
    """
    upper, lower = boxes[joint.upper], boxes[joint.lower]
    to = centres[joint.lower] + complex(lower.size.real * (share - 0.5), lower.size.imag / 2)
    if lower.layer - upper.layer > 1:
        start = to + 0.30j
        half = complex(LETTER * FONT * len(joint.tag) / 2 + 0.08, 0.10)
        picture.draw(upper.fill, rectangle(start + 0.10j, half))
        picture.texts.append(Text(start + 0.10j, joint.tag))
    else:
        start = centres[joint.upper] - 0.5j * upper.size.imag
        start += max(-0.4 * upper.size.real, min(0.4 * upper.size.real, to.real - start.real))
    turn = (to - start) / abs(to - start)
    picture.draw(ARROW, [start, to - 0.07 * turn])
    picture.draw(HEAD, [to, to + 0.09 * turn * (-1 + 0.4j), to + 0.09 * turn * (-1 - 0.4j)])
    beside = turn * 1j if (turn * 1j).real >= 0.0 else turn / 1j
    away = LETTER * FONT * len(joint.label) / 2 * beside.real + 0.08 * abs(beside.imag) + 0.05
    picture.texts.append(Text(to + 0.45 * (start - to) + away * beside, joint.label))


DENSE = 12
"""A group with more moves has the numbers of its moves at their nodes, in place of arrows."""

ARMS = 6
"""In groups with more moves, only the first arrow of a move is drawn: the table names all nodes."""

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


MovesByGroup = Mapping[str, Sequence[DrawnMove]]
"""The moves of each group by its name in the legend."""


def sequence_sheet(mechanism: Mechanism, position: ComplexArray, groups: MovesByGroup, title: str) -> Sheet:
    """Return the mechanism with its moves, above the table of all moves, if there are any."""
    return Sheet("", (sequence_picture(mechanism, position, groups, title), *([moves_table(groups)] if groups else [])))


@composition
def sequence_picture(
    mechanism: Mechanism, position: ComplexArray, groups: MovesByGroup, title: str, *,
    layout: PictureLayout = LAYOUT,
) -> Picture:  # fmt: skip
    """Return one pose in light colours; numbered arrows go from the nodes of a constraint to the node that it moves."""
    scene = solved(mechanism, position)
    drawing = Drawing.around(mechanism, scene, title, [position], layout)
    if not scene:
        return drawing.picture
    drawing.poses(colours=dict.fromkeys(part_names(scene), SOFT))
    arcs, first = Counter[tuple[int, int]](), 1
    for number, (name, moves) in enumerate(groups.items(), start=1):
        drawing.picture.legend.append((name, Pen(KEY, group_colour(number))))
        _draw_group(drawing, scene.poses[0], moves, (number, first), arcs)
        first += len(moves)
    return drawing.write(range(len(mechanism.nodes)), {})


def _draw_group(
    drawing: Drawing, z: ComplexArray, moves: Sequence[DrawnMove], numbers: tuple[int, int],
    arcs: Counter[tuple[int, int]],
) -> None:  # fmt: skip
    """Draw the nodes and moves of a group; `numbers` are its own and that of its first move."""
    colour, picture, labels = group_colour(numbers[0]), drawing.picture, drawing.labels
    moved = dict.fromkeys(move.node for move in moves)
    picture.draw(Mark("o", 8.0, tint(colour), colour, 1.6, layer=9), *z[list(moved)].tolist())
    if len(moves) > DENSE:
        for node in moved:
            own = [str(k) for k, move in enumerate(moves, start=numbers[1]) if move.node == node]
            labels.beside(complex(z[node]), ", ".join(own), colour, NUMBER)
        return
    for k, move in enumerate(moves, start=numbers[1]):
        offers = _draw_move(picture, z, move, arcs, colour, len(moves) <= ARMS)
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
def moves_table(groups: MovesByGroup, *, layout: PictureLayout = LAYOUT) -> Picture:
    """Return the numbered moves of all groups as lines of text in columns, in the colours of the groups."""
    lines = [(move.text, group_colour(k)) for k, moves in enumerate(groups.values(), start=1) for move in moves]
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
