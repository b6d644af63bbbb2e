"""Figures of the package on a canvas of matplotlib, to read what was drawn."""

from gimcli.output.figure import drawn


def canvas_of(canvas, content):
    """Return the figure of a content on a matplotlib canvas of the given class."""
    with drawn(canvas, content) as found:
        return found
