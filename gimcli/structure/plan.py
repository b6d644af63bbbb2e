"""The order of solution: carried nodes and dyads in closed form, all others in coupled groups.

Starting from the frame, nodes are placed in closed form as long as possible. When no node can be placed, the smallest
coupled group is added and the search continues. Source: Petuya et al. 2004, sections 3-4; Servatius, Shai & Whiteley
2010 for the groups.
"""

from __future__ import annotations

from gimcli.mechanism import FRAME, Mechanism
from gimcli.structure.closed_form_order import Layout
from gimcli.structure.derived import derived
from gimcli.structure.drive_check import explained
from gimcli.structure.kinematic_nodes import free_nodes
from gimcli.structure.pair_rows import pair_rows
from gimcli.structure.steps import Plan


def make_plan(mechanism: Mechanism, closed_forms: bool = True) -> Plan:
    """Return the order of solution of a mechanism.

    Without `closed_forms`, only carried nodes are placed directly; dyads are then solved as coupled groups too, by
    Newton-Raphson. Raises StructureError if a part is not driven, or is driven twice.
    """
    return _planned(mechanism, closed_forms)


@derived
def _planned(mechanism: Mechanism, closed_forms: bool) -> Plan:
    with explained(mechanism):  # the numerical rank finds causes that counting cannot
        return _plan(Layout(mechanism), closed_forms)


def _plan(layout: Layout, closed_forms: bool) -> Plan:
    while True:
        while layout.carry() or (closed_forms and (layout.tilt() or layout.dyad())):
            pass
        if not layout.missing:
            break
        from gimcli.structure.coupled import next_group

        next_group(layout)
    _carried(layout)
    return Plan(tuple(layout.steps), layout.registers, layout.branches, surplus(layout))


def _carried(layout: Layout) -> None:
    """Place the remaining nodes, which members only carry."""
    for index, member in enumerate(layout.mechanism.members):
        for step in layout.carried(index, [n for n in member.nodes if n not in layout.placed]):
            layout.place(step)


def surplus(layout: Layout) -> int:
    """Return constraints minus free coordinates among the kinematic nodes."""
    mechanism = layout.mechanism
    frame = set(mechanism.members[FRAME].nodes)
    count = len(pair_rows(mechanism)) - 2 * len(free_nodes(mechanism))
    for index, nodes in enumerate(layout.kinematic):
        if index != FRAME:
            count += 2 * len(nodes) - 3
            if sum(n in frame for n in nodes) > 1:  # distances between frame nodes are not constraints
                count -= 2 * sum(n in frame for n in nodes) - 3
    return count
