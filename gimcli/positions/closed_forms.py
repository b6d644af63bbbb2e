"""Carried nodes, turned lines and dyads in closed form, over all rows of a block at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gimcli.kernels import loci
from gimcli.kernels.loci import Meeting
from gimcli.mechanism import FloatArray
from gimcli.positions.block import RowBlock
from gimcli.structure.steps import NONE, Circle, Dyad, Line, Locus, Orient, Place, Tilt

Flags = NDArray[np.bool_]


def place(step: Place, block: RowBlock) -> None:
    """Carry a node along."""
    rows = block.span
    ex, ey = block.vector(step.vector, rows)
    block.x[step.node, rows] = block.x[step.anchor, rows] + ex
    block.y[step.node, rows] = block.y[step.anchor, rows] + ey


def orient(step: Orient, block: RowBlock) -> None:
    """Keep a direction in its register, of the history too: whether lines have turned is told from it."""
    rows = slice(0, block.end)
    block.rx[step.register, rows], block.ry[step.register, rows] = block.vector(step.vector, rows)


def tilt(step: Tilt, block: RowBlock, sign: FloatArray, tolerance: float) -> None:
    """Turn a line so that it passes a node."""
    rows = slice(0, block.end)
    wx = block.x[step.b, rows] - block.x[step.a, rows]
    wy = block.y[step.b, rows] - block.y[step.a, rows]
    e = np.asarray(step.distance)
    ux, uy, *measure = loci.tilt(wx, wy, e, sign[step.branch])
    block.rx[step.register, rows], block.ry[step.register, rows] = ux, uy  # of the history too, as `orient`
    new = block.history
    g, g2, noise = (part[new:] for part in measure)
    guard(block, step.branch, (ux[new:], uy[new:], g, g2, noise), tolerance)


def dyad(step: Dyad, block: RowBlock, sign: FloatArray, tolerance: float) -> None:
    """Place a node where its two loci meet."""
    rows = block.span
    s = 1.0 if step.branch == NONE else float(sign[step.branch])
    meeting = meet(step.first, step.second, block, rows, s)
    block.x[step.node, rows], block.y[step.node, rows] = meeting[:2]
    guard(block, step.branch, meeting, tolerance, _turned(step.first, step.second, block))


def meet(first: Locus, second: Locus, block: RowBlock, rows: slice, s: float) -> Meeting:
    """Meet two loci of any kinds."""
    if isinstance(first, Line) and isinstance(second, Circle):
        first, second = second, first
    if isinstance(first, Circle) and isinstance(second, Circle):
        return loci.circle_circle(*circle(first, block, rows), *circle(second, block, rows), s)
    if isinstance(first, Circle) and isinstance(second, Line):
        return loci.circle_line(*circle(first, block, rows), *line(second, block, rows), s)
    assert isinstance(first, Line)
    assert isinstance(second, Line)
    return loci.line_line(*line(first, block, rows), *line(second, block, rows))


def centre(node: int, locus: Locus, block: RowBlock, rows: slice) -> tuple[FloatArray, FloatArray]:
    """Return the node that a locus hangs on, shifted by the locus's offset."""
    x, y = block.x[node, rows], block.y[node, rows]
    if locus.offset is None:
        return x, y
    ex, ey = block.vector(locus.offset, rows)
    return x + ex, y + ey


def circle(locus: Circle, block: RowBlock, rows: slice) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return centre and radius."""
    x, y = centre(locus.centre, locus, block, rows)
    return x, y, np.asarray(locus.radius.at(block.inputs[:, rows]))


def line(
    locus: Line, block: RowBlock, rows: slice
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return a point, the unit normal and the height of a line."""
    x, y = centre(locus.anchor, locus, block, rows)
    nx, ny = block.vector(locus.normal, rows)
    return x, y, nx, ny, np.asarray(locus.distance.at(block.inputs[:, rows]))


def guard(block: RowBlock, branch: int, meeting: Meeting, tolerance: float, turned: Flags | None = None) -> None:
    """End the block before the first row that has no solution, is singular, or may have jumped."""
    _, _, g, g2, noise = meeting
    rows = block.span
    with np.errstate(divide="ignore", invalid="ignore"):
        error, quality = loci.doubt(g, noise), g2 / noise
    block.error[rows] = np.fmax(block.error[rows], error)
    blocked = ~(g2 >= -noise)
    singular = quality <= 1.0 if block.lenient else ~(error <= tolerance)
    bad = blocked | singular
    if branch != NONE:
        block.g[branch, rows], block.quality[branch, rows] = g, quality
        bad |= _jumps(block.g[branch], block)
    if turned is not None:
        bad |= turned
    if bad.any():
        k = int(np.argmax(bad))
        block.stop(rows.start + k, bool(blocked[k]), bool(singular[k] and not blocked[k]), branch)


def _turned(first: Locus, second: Locus, block: RowBlock) -> Flags:
    """Tell the rows since whose last what the sides refer to has turned by more than a right angle.

    Two lines: where the sine between them has changed its sign, the point has passed infinity.
    """
    begin = max(block.history - 1, 0)
    rows = slice(begin, block.end)
    if isinstance(first, Line) and isinstance(second, Circle):
        first, second = second, first
    if isinstance(first, Line):
        assert isinstance(second, Line)
        (nx, ny), (mx, my) = block.vector(first.normal, rows), block.vector(second.normal, rows)
        wx, wy = nx * my - ny * mx, np.zeros(block.end - begin)
    elif isinstance(second, Line):
        wx, wy = block.vector(second.normal, rows)
    else:
        ax, ay = centre(first.nodes[0], first, block, rows)
        bx, by = centre(second.nodes[0], second, block, rows)
        wx, wy = bx - ax, by - ay
    flags = np.zeros(block.end - block.history, dtype=bool)
    turned = wx[1:] * wx[:-1] + wy[1:] * wy[:-1] < 0.0
    if len(turned):
        flags[-len(turned) :] = turned
    return flags


def _jumps(g: FloatArray, block: RowBlock) -> Flags:
    """Tell the rows whose measure is not clearly nearer to the one foreseen than its mirror is."""
    first, end, t = block.history, block.end, block.time
    if first == 0:
        return np.zeros(end, dtype=bool)
    last = g[first - 1 : end - 1]
    before = np.concatenate(
        [g[first - 2 : first - 1] if first > 1 else last[:1], g[first - 1 : max(end - 2, first - 1)]]
    )
    when = np.concatenate([t[first - 2 : first - 1] if first > 1 else [-np.inf], t[first - 1 : end]])
    step = np.diff(when)
    return np.asarray(loci.leaps(g[first:end], last, before[: end - first], step[1:], step[:-1]))
