"""The joints of a mechanism, derived once: chains, lower pairs, reactions and textbook equations are views of them.

The kind of a joint is the freedoms that it leaves between its bodies in series, R for each rotation and P for each
translation. A body is a member, or a node without a member, which does not turn.
"""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.connected import grouped
from gimcli.mechanism import ANGLE, HEIGHT, SPAN, Input, Mechanism, PairRow
from gimcli.structure.derived import derived
from gimcli.structure.kinematic_nodes import loose_nodes
from gimcli.structure.rotation import PARALLEL, members_of
from gimcli.structure.steps import NONE

REVOLUTE, PRISMATIC, SLOT, TURNLESS = "R", "P", "PR", "PP"
"""Kinds: revolute pair; prismatic pair; pin in a slot; two members without relative rotation."""

CYLINDER, TRAVEL, TURN = "RPR", "PPR", "RPP"
"""Kinds of inputs that drive no sliding pair, with all freedoms of the plane: distance of two nodes; travel of a node
on a line; angle of two members."""

INPUTS = {SPAN: CYLINDER, HEIGHT: TRAVEL, ANGLE: TURN}
"""Kinds of inputs by the kinds of their rows."""


@dataclass(frozen=True)
class Joint:
    """The freedoms between bodies, and the actuator that drives one of them, if any."""

    kind: str
    name: str  # of the node, the sliding pair, the row of a pair, or the actuator
    bodies: tuple[int, ...]  # the guide first; of a revolute pair all that have the node
    nodes: tuple[int, ...] = ()  # on the axis of rotation; that slide; the ends of a distance
    slides: tuple[int, ...] = ()  # of a sliding pair: numbers in Mechanism.slides
    actuator: int = NONE

    @property
    def node(self) -> int:
        """The first node."""
        return self.nodes[0]

    @property
    def pairs(self) -> int:
        """Number of pairs: one less than the number of bodies."""
        return len(self.bodies) - 1


@derived
def bodies_at(mechanism: Mechanism) -> tuple[tuple[int, ...], ...]:
    """Return, for every node, the bodies that contain it; nodes without a member are numbered after the members."""
    loose = {node: k for k, node in enumerate(loose_nodes(mechanism), start=len(mechanism.members))}
    return tuple(held or (loose[node],) for node, held in enumerate(members_of(mechanism)))


@derived
def joints(mechanism: Mechanism) -> tuple[Joint, ...]:
    """Return revolute pairs by node, sliding pairs in the order of the file, fixed angles, and the other inputs."""
    at, sliding = bodies_at(mechanism), sliding_pairs(mechanism)
    revolute = [Joint(REVOLUTE, mechanism.nodes[n], own, (n,)) for n, own in enumerate(at) if len(own) > 1]
    turnless = [Joint(TURNLESS, row.name, row.members) for row in mechanism.pairs if row.rotary]
    driven = {pair.actuator for pair in sliding}
    inputs = [
        Joint(INPUTS[a.kind], a.name, a.members if a.rotary else (*a.members, *(at[n][0] for n in a.nodes)), a.nodes,
              actuator=k)
        for k, a in enumerate(mechanism.actuators) if k not in driven
    ]  # fmt: skip
    return (*revolute, *sliding, *turnless, *inputs)


@derived
def sliding_pairs(mechanism: Mechanism) -> tuple[Joint, ...]:
    """Return the sliding pairs in the order of the file: true prismatic pairs of two nodes, and pins in slots."""
    at, found = bodies_at(mechanism), list[Joint]()
    for name, slides in grouped((slide.pair, k) for k, slide in enumerate(mechanism.slides)).items():
        rows = [mechanism.slides[k] for k in slides]
        taken, guide, nodes = {pair.actuator for pair in found}, rows[0].guide, tuple(row.node for row in rows)
        drivers = (k for k, a in enumerate(mechanism.actuators) if k not in taken and _along(a, rows))
        body = next(m for m in at[nodes[0]] if m != guide and all(m in at[n] for n in nodes))
        kind = PRISMATIC if len(nodes) > 1 else SLOT
        found.append(Joint(kind, name, (guide, body), nodes, tuple(slides), next(drivers, NONE)))
    return tuple(found)


def pair_of(mechanism: Mechanism, slide: int) -> Joint:
    """Return the pair that a slide belongs to."""
    return next(pair for pair in sliding_pairs(mechanism) if slide in pair.slides)


def _along(actuator: Input, slides: list[PairRow]) -> bool:
    """Return whether an actuator drives a node of a pair along its guide."""
    return actuator.kind == HEIGHT and any(
        s.node == actuator.node and s.guide == actuator.guide
        and abs((s.along.conjugate() * actuator.normal).imag) < PARALLEL for s in slides
    )  # fmt: skip
