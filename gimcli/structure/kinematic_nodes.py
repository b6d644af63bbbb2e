"""Kinematic nodes, which take part in the solution; the other nodes of members are only carried."""

from __future__ import annotations

from gimcli.mechanism import FRAME, ComplexArray, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.pair_rows import pair_rows
from gimcli.structure.rotation import members_of


@derived
def kinematic_nodes(mechanism: Mechanism) -> tuple[tuple[int, ...], ...]:
    """Return, for every member, its nodes that occur in constraints, at least two.

    A node of only one member that is in no sliding pair and no actuator is carried: it does not enter the solution.
    """
    members = members_of(mechanism)
    constrained = {node for row in pair_rows(mechanism) for node in row.nodes}
    result = []
    for index, member in enumerate(mechanism.members):
        chosen = [n for n in member.nodes if index == FRAME or n in constrained or len(members[n]) > 1]
        spare = sorted((n for n in member.nodes if n not in chosen), key=lambda n: n in member.remote)
        while len(chosen) < 2 and spare:
            chosen.append(spare.pop(0))
        result.append(tuple(n for n in member.nodes if n in chosen))
    return tuple(result)


@derived
def loose_nodes(mechanism: Mechanism) -> tuple[int, ...]:
    """Return the nodes that belong to no member but to a sliding pair or an actuator."""
    members = members_of(mechanism)
    constrained = (node for row in pair_rows(mechanism) for node in row.nodes)
    return tuple(n for n in dict.fromkeys(constrained) if not members[n])


@derived
def free_nodes(mechanism: Mechanism) -> tuple[int, ...]:
    """Return the nodes whose coordinates are unknown: kinematic and loose nodes, without the frame's."""
    active = {n for nodes in kinematic_nodes(mechanism) for n in nodes} | set(loose_nodes(mechanism))
    return tuple(sorted(active - set(mechanism.members[FRAME].nodes)))


@derived
def moving_nodes(mechanism: Mechanism) -> tuple[int, ...]:
    """Return the nodes of members, pairs and actuators, without those of the frame and carried remote ones."""
    members, rows = members_of(mechanism), (*mechanism.pairs, *mechanism.actuators)
    tied = {n for n, holders in enumerate(members) if holders} | {n for row in rows for n in row.nodes}
    return tuple(sorted(tied - set(mechanism.members[FRAME].nodes) - set(mechanism.carried)))


def base_first(mechanism: Mechanism) -> list[list[int]]:
    """Return, for every member, its nodes that are not carried remote ones, those of its base first."""
    ends = [member.ends[:2] if len(member.nodes) > 1 else () for member in mechanism.members]
    own = zip(ends, mechanism.members, strict=True)
    return [[*two, *(n for n in m.nodes if n not in two and n not in m.carried)] for two, m in own]


def carry(mechanism: Mechanism, z: ComplexArray) -> ComplexArray:
    """Return positions z with the carried nodes computed from two kinematic nodes of their member.

    z: positions or velocities, (nodes,) or (nodes, columns).
    """
    z = z.copy()
    for member, nodes in zip(mechanism.members, kinematic_nodes(mechanism), strict=True):
        for node in set(member.nodes) - set(nodes):
            u, v = nodes[:2]
            z[node] = z[u] + (member.reach(u, node) / member.reach(u, v)) * (z[v] - z[u])
    return z
