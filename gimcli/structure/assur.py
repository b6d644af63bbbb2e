"""The formation of a mechanism: its driving links and Assur groups, each joined to links formed before.

Every constraint of a pair, and every input, is matched to a freedom of a link; the strongly connected components of the
resulting dependencies are the groups. Source: Assur 1914; Servatius, Shai & Whiteley 2010. Order and class follow
Artobolevskii 1988: the order is the number of pairs that join a group to links formed before; the class is that of its
highest contour (a link with n pairs, or a closed loop of n links, has class n).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import accumulate, permutations

from gimcli.connected import grouped
from gimcli.errors import StructureError
from gimcli.mechanism import FRAME, Mechanism
from gimcli.structure.dulmage_mendelsohn import split
from gimcli.structure.joints import CYLINDER, PRISMATIC, REVOLUTE, TRAVEL, TURN, TURNLESS, Joint, joints
from gimcli.structure.kinematic_chain import Links
from gimcli.structure.steps import NONE

DYADS = ("RRR", "RRP", "RPR", "PRP", "RPP")
"""The kinds of groups of class II, by outer, inner and outer pair."""

ROMAN = {1: "I", 2: "II", 3: "III", 4: "IV", 5: "V", 6: "VI", 7: "VII", 8: "VIII", 9: "IX", 10: "X"}


@dataclass(frozen=True)
class LowerPairs:
    """Links by number, the frame first: members, then sliders and rams (linear actuators), then pins.

    A pin in a slot is a separate link (a slider); a linear actuator between two nodes is a binary link of variable
    length. At a node of three or more links the pin is a separate link, until the order of formation decides which of
    these links the others are joined to.
    """

    links: tuple[str, ...]
    pairs: tuple[Joint, ...]  # of two links each
    turns: tuple[Joint, ...]  # fixed angles and inputs that are angles
    rams: dict[int, int]  # {link: actuator} of the links whose length is an input
    pins: frozenset[int]  # links that are only pins


def lower_pairs(mechanism: Mechanism) -> LowerPairs:
    """Return the links and lower pairs of a mechanism."""
    links, rams = Links(mechanism), dict[int, int]()
    for joint in joints(mechanism):
        if joint.slides:
            links.slide(joint, joint.name)
        elif joint.kind == CYLINDER:
            rams[links.add(joint.name, *joint.nodes)] = joint.actuator
        elif joint.kind == TRAVEL:  # a driven block on the guide, and a slider across it: the node may leave the line
            block, across = links.add(joint.name), links.add(f"{joint.name} across", *joint.nodes)
            links.joints.append(replace(joint, kind=PRISMATIC, bodies=(joint.bodies[0], block)))
            links.joints.append(Joint(PRISMATIC, f"{joint.name} across", (block, across)))
    pairs, pins = links.joints, frozenset[int]()
    for joint in links.revolute:
        hub = joint.bodies[0]
        if joint.pairs > 1 and hub != FRAME:
            hub = links.add(joint.name)
            pins |= {hub}
        pairs += [replace(joint, bodies=(hub, link)) for link in joint.bodies if link != hub]
    turns = tuple(joint for joint in joints(mechanism) if joint.kind in (TURNLESS, TURN))
    return LowerPairs(tuple(links.names), tuple(pairs), turns, rams, pins)


@dataclass(frozen=True)
class AssurGroup:
    """A driving link or an Assur group: links that are added together."""

    links: tuple[int, ...]
    outer: tuple[Joint, ...]  # pairs with links formed before
    inner: tuple[Joint, ...]
    drivers: tuple[int, ...]  # actuators whose inputs determine it
    surplus: int  # constraints minus freedoms

    @property
    def driving(self) -> bool:
        """Whether it is a driving link: one link whose position an input determines."""
        return len(self.links) == 1 and bool(self.drivers)

    @property
    def order(self) -> int:
        """Number of pairs that join it to links formed before."""
        return len(self.outer)

    @property
    def grade(self) -> int:
        """Its class: 1 for a driving link, else the class of its highest contour."""
        if self.driving:
            return 1
        pairs = (*self.outer, *self.inner)
        most = max((sum(link in p.bodies for p in pairs) for link in self.links), default=2)
        return max(2, most, _longest_loop(self.links, self.inner))

    @property
    def dyad(self) -> str:
        """The kind of a dyad, such as RRP; "" for any other group."""
        if len(self.links) != 2 or len(self.inner) != 1 or len(self.outer) != 2:
            return ""
        first, last = (pair.kind for pair in self.outer)
        ahead, back = first + self.inner[0].kind + last, last + self.inner[0].kind + first
        return back if back in DYADS and ahead not in DYADS else ahead

    @property
    def description(self) -> str:
        """A short description, such as "dyad RRP"."""
        if self.driving:
            return "driving link, turning" if self.outer and self.outer[0].kind == REVOLUTE else "driving link, sliding"
        return f"dyad {self.dyad}" if self.dyad else f"group of {len(self.links)} links"

    @property
    def numeral(self) -> str:
        """Its class in Roman numerals."""
        return ROMAN.get(self.grade, str(self.grade))


@dataclass(frozen=True)
class Formation:
    """The groups in the order of formation."""

    links: tuple[str, ...]  # names
    groups: tuple[AssurGroup, ...]
    independent: tuple[int, ...]  # actuators that do not follow others

    @property
    def numbers(self) -> dict[int, int]:
        """Numbers of the links: the frame 0, the others from 2 in the order of formation."""
        order = [link for group in self.groups for link in group.links]
        return {FRAME: 0} | {link: k for k, link in enumerate(order, start=2)}

    def bases(self, group: AssurGroup) -> list[int]:
        """Return the links that a group is joined to, one for each outer pair."""
        return [next(k for k in pair.bodies if k not in group.links) for pair in group.outer]

    def joined(self, group: AssurGroup) -> dict[int, list[str]]:
        """Return, for each link formed before, the names of the pairs that join a group to it."""
        return grouped((base, pair.name) for pair, base in zip(group.outer, self.bases(group), strict=True))

    @property
    def layers(self) -> list[int]:
        """The layer of every group: 1 if it is joined to the frame only, else 1 + the layer of its bases."""
        layer: dict[int, int] = {FRAME: 0}
        for group in self.groups:
            layer |= dict.fromkeys(group.links, 1 + max((layer[base] for base in self.bases(group)), default=0))
        return [layer[group.links[0]] for group in self.groups]

    @property
    def formula(self) -> tuple[str, ...]:
        """Each group as n,f^(LINKS): n links by their numbers, f freedoms that it adds (Durango et al. 2014, eq. 7)."""
        numbers = self.numbers
        return tuple(
            f"{len(group.links)},{len({*group.drivers} & {*self.independent})}^({','.join(links)})"
            for group in self.groups
            for links in [[str(numbers[link]) for link in group.links]]
        )


def formation(mechanism: Mechanism) -> Formation:
    """Return the driving links and Assur groups; raises StructureError if a freedom is not driven."""
    parts = lower_pairs(mechanism)
    ends = _rows(parts)
    columns, drivers = _constraints(parts, ends)
    blocks = split(sum(len(rows) for rows in ends.values()), columns, list(ends.values()))
    loose = [row for block in blocks if len(block.columns) < len(block.rows) for row in block.rows]
    if loose:
        names = [parts.links[k] for k, rows in ends.items() if set(rows) & set(loose)]
        raise StructureError(
            f"nothing drives {', '.join(names)}: add an actuator for each freedom, or fix nodes in `ground`"
        )
    found = []
    for block in reversed(blocks):
        links = [link for link, rows in ends.items() if set(rows) & set(block.rows)]
        found.append((links, [drivers[c] for c in block.columns if c in drivers], len(block.columns) - len(block.rows)))
    return Formation(parts.links, tuple(_ordered(_groups(parts, found))), tuple(mechanism.drivers))


def _rows(parts: LowerPairs) -> dict[int, list[int]]:
    """Return the numbers of the freedoms of every moving link: x, y and an angle (a pin has no angle)."""
    sizes = [2 if link in parts.pins else 3 for link in range(1, len(parts.links))]
    starts = accumulate(sizes, initial=0)
    return {link: list(range(k, k + size)) for link, (k, size) in enumerate(zip(starts, sizes, strict=False), start=1)}


BOUND: dict[str, tuple[tuple[int, ...], ...]] = {
    REVOLUTE: ((0, 2), (1, 2)), PRISMATIC: ((0, 1, 2), (2,)), TURNLESS: ((2,),), TURN: (),
}  # fmt: skip
"""Freedoms of both links (0 and 1 are x and y, 2 is the angle) in each constraint of a joint."""

DRIVEN = {PRISMATIC: (0, 1, 2), TURN: (2,)}
"""Those in the constraint of an input."""


def _constraints(parts: LowerPairs, ends: dict[int, list[int]]) -> tuple[list[list[int]], dict[int, int]]:
    """Return the freedoms in each constraint, and {constraint: actuator} of those that are inputs."""
    columns, drivers = list[list[int]](), dict[int, int]()
    for joint in (*parts.pairs, *parts.turns):
        own, held = [ends[k] for k in joint.bodies if k != FRAME], BOUND[joint.kind]
        if joint.actuator != NONE:
            drivers[len(columns) + len(held)] = joint.actuator
            held = (*held, DRIVEN[joint.kind])
        columns += [[link[axis] for link in own for axis in axes if axis < len(link)] for axes in held]
    return columns, drivers


def _groups(parts: LowerPairs, found: list[tuple[list[int], list[int], int]]) -> list[AssurGroup]:
    """Return the groups with their pairs; links at a pin are joined to that of them which is formed first."""
    rank = {link: k for k, (links, _, _) in enumerate(found) for link in links} | {FRAME: -1}
    base = {
        pin: min((pair.bodies[1] for pair in parts.pairs if pair.bodies[0] == pin), key=lambda k: (rank[k], k))
        for pin in parts.pins
    }
    joined = ((base.get(pair.bodies[0], pair.bodies[0]), pair.bodies[1], pair) for pair in parts.pairs)
    pairs = [replace(pair, bodies=(a, b)) for a, b, pair in joined if a != b]
    groups = []
    for links, drivers, surplus in found:
        own = {link for link in links if link not in parts.pins}
        if own:
            rams = [parts.rams[link] for link in links if link in parts.rams]
            ends = [(p, sorted(p.bodies, key=own.__contains__)) for p in pairs if len(own & {*p.bodies}) == 1]
            outer = [p for p, (outside, inside) in ends if rank[outside] < rank[inside]]  # formed before
            inner = [p for p in pairs if own.issuperset(p.bodies)]
            groups.append(AssurGroup(tuple(sorted(own)), tuple(outer), tuple(inner), tuple(drivers + rams), surplus))
    return groups


def _ordered(groups: list[AssurGroup]) -> list[AssurGroup]:
    """Return the groups in the order of formation, each as early as possible: driving links first, then by number."""
    formed, rest, result = {FRAME}, list(groups), []
    while rest:
        ready = [g for g in rest if all({*p.bodies} <= formed | set(g.links) for p in g.outer)] or rest[:1]
        group = min(ready, key=lambda g: (not g.driving, g.links))
        rest.remove(group)
        result.append(group)
        formed |= set(group.links)
    return result


def _longest_loop(links: tuple[int, ...], inner: tuple[Joint, ...]) -> int:
    """Return the number of links in the longest of the shortest loops through each inner pair; 0 without loops."""
    near: dict[int, set[int]] = {link: set() for link in links}
    for pair in inner:
        for a, b in permutations(pair.bodies):
            near[a].add(b)
    longest = 0
    for start, end in (pair.bodies for pair in inner):
        depth, front = {start: 1}, [start]
        while front and end not in depth:
            step = [(n, m) for n in front for m in near[n] if m not in depth and {n, m} != {start, end}]
            depth |= {m: depth[n] + 1 for n, m in step}
            front = list(dict.fromkeys(m for _, m in step))
        longest = max(longest, depth.get(end, 0))
    return longest
