"""The mechanism above the graphs of a simulation: its first position, some later ones, and paths of points."""

from __future__ import annotations

from gimcli.dynamics.simulation_types import Simulation
from gimcli.output.drawing import motion_picture
from gimcli.output.picture import Content, Sheet
from gimcli.structure.carried import carried_point


def with_mechanism(found: Simulation, graphs: Sheet) -> Content:
    """Return the graphs of a simulation below the mechanism with the paths of the traced points."""
    mechanism, z = found.mechanism, found.nodes[0]
    paths = {name: mechanism.to_file(carried_point(mechanism, name, z)) for name in mechanism.traced}
    return Sheet("", (motion_picture(mechanism, mechanism.to_file(z).T, paths, graphs.title), *graphs.pictures))
