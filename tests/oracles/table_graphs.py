"""The graph of a table, for tests of panels."""

from gimcli.output.graph import Axis, Curve, CurveGraph


def graph_of(name, table):
    """Return the graph of a table's columns over its first column."""
    across, *columns = table.columns
    curves = [Curve(c.name, across.values, c.values) for c in columns]
    return CurveGraph(Axis(across.name, across.unit), Axis(name, columns[0].unit), curves)
