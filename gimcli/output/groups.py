"""The picture of a formation: groups as boxes in layers below the frame, and the pairs that join them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from gimcli.output.picture import Frame, Picture, Text
from gimcli.output.style import ARROW, FONT, HEAD, INK, PAPER, Fill

LINE = 0.17
"""Height of a line of text [in]."""

LETTER = 0.0092
"""Width of a letter [in] per point of its size."""

PAD, ACROSS, DOWN = 0.14, 0.35, 0.62
"""Border inside a box, and horizontal and vertical distances between boxes [in]."""

EDGE = 0.35
"""Free border of the picture [in]."""

BOX = Fill(PAPER, INK, 1.2, layer=5)
GROUND = Fill("#d9d9d9", INK, 1.2, layer=5)
DRIVING = Fill("#efefef", INK, 2.2, layer=5)
FILLS = {"frame": GROUND, "driving": DRIVING, "group": BOX}


@dataclass(frozen=True)
class Box:
    """The frame or a group: its lines of text, and the number of layers above it."""

    lines: tuple[str, ...]
    layer: int
    kind: str = "group"  # frame, driving or group

    @property
    def size(self) -> complex:
        """Width and height [in]."""
        longest = max(len(line) for line in self.lines)
        return complex(LETTER * FONT * longest + 2 * PAD, LINE * len(self.lines) + 2 * PAD)


@dataclass(frozen=True)
class BoxJoint:
    """Pairs that join a box to one above it."""

    upper: int
    lower: int
    label: str
    tag: str = ""  # short name that is drawn instead of the upper box if that is not in the next layer


def groups_picture(boxes: Sequence[Box], joints: Sequence[BoxJoint], title: str) -> Picture:
    """Return the boxes in layers, with an arrow from each box to the boxes that are joined to it."""
    centres, size = _places(boxes)
    picture = Picture(title, Frame(0.0j, size, size.real, size.imag), ("", ""), bare=True)
    for box, centre in zip(boxes, centres, strict=True):
        half = box.size / 2
        corners = [centre + complex(x * half.real, y * half.imag) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        picture.area(FILLS[box.kind], corners)
        top = centre.imag + LINE * (len(box.lines) - 1) / 2
        picture.texts += [Text(complex(centre.real, top - LINE * k), line) for k, line in enumerate(box.lines)]
    lanes: dict[int, int] = {}
    for joint in joints:
        total = sum(j.lower == joint.lower for j in joints)
        lane = lanes.get(joint.lower, 0)
        lanes[joint.lower] = lane + 1
        _arrow(picture, boxes, centres, joint, (lane + 1) / (total + 1))
    return picture


def _places(boxes: Sequence[Box]) -> tuple[list[complex], complex]:
    """Return the centres of the boxes, y upwards, and the size of the picture [in]."""
    layers = [[k for k, b in enumerate(boxes) if b.layer == n] for n in range(max(b.layer for b in boxes) + 1)]
    layers = [layer for layer in layers if layer]
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
        corners = [complex(x * half.real, y * half.imag) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        picture.area(FILLS[upper.kind], [start + 0.10j + corner for corner in corners])
        picture.texts.append(Text(start + 0.10j, joint.tag))
    else:
        start = centres[joint.upper] - 0.5j * upper.size.imag
        start += max(-0.4 * upper.size.real, min(0.4 * upper.size.real, to.real - start.real))
    turn = (to - start) / abs(to - start)
    picture.stroke(ARROW, [start, to - 0.07 * turn])
    picture.area(HEAD, [to, to + 0.09 * turn * (-1 + 0.4j), to + 0.09 * turn * (-1 - 0.4j)])
    beside = turn * 1j if (turn * 1j).real >= 0.0 else turn / 1j
    away = LETTER * FONT * len(joint.label) / 2 * beside.real + 0.08 * abs(beside.imag) + 0.05
    picture.texts.append(Text(to + 0.45 * (start - to) + away * beside, joint.label))
