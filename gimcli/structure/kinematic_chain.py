"""The kinematic chain of a mechanism: its links and lower pairs, multiple joints included, and Grübler's formula.

A pin in a slot is a link of its own (a block) with a revolute and a prismatic pair; a linear actuator between two nodes
is two links (cylinder and rod) with a prismatic pair. A node of k links is a multiple joint: k - 1 revolute pairs.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import combinations

from gimcli.mechanism import FRAME, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.joints import CYLINDER, PRISMATIC, REVOLUTE, SLOT, TURNLESS, Joint, joints
from gimcli.structure.rotation import members_of


class Links:
    """Links and their joints: the members first, then those between the freedoms of a joint."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.names = [member.name for member in mechanism.members]
        self.nodes, self.at = mechanism.nodes, [list(members) for members in members_of(mechanism)]
        self.joints: list[Joint] = []

    def add(self, name: str, *nodes: int) -> int:
        """Add a link that has some nodes; return its number."""
        self.names.append(name)
        for node in nodes:
            self.at[node].append(len(self.names) - 1)
        return len(self.names) - 1

    def slide(self, pair: Joint, block: str) -> None:
        """Add a sliding pair, with a block for a pin in a slot."""
        slider = self.add(block, *pair.nodes) if pair.kind == SLOT else pair.bodies[1]
        self.joints.append(replace(pair, kind=PRISMATIC, bodies=(pair.bodies[0], slider)))

    @property
    def revolute(self) -> list[Joint]:
        """The revolute joints at the nodes, of two or more links."""
        shared = ((node, tuple(links)) for node, links in enumerate(self.at) if len(links) > 1)
        return [Joint(REVOLUTE, self.nodes[node], links, (node,)) for node, links in shared]


@dataclass(frozen=True)
class KinematicChain:
    """Links by number (members, the frame first, then blocks, then cylinders and rods) and their joints."""

    links: tuple[str, ...]
    joints: tuple[Joint, ...]
    couplings: tuple[str, ...]  # names of single constraints: angles of two members, gears, inputs that follow others

    @property
    def pairs(self) -> int:
        """Number of lower pairs, with one freedom each."""
        return sum(joint.pairs for joint in self.joints)

    @property
    def gruebler(self) -> int:
        """Grübler's count 3 (n - 1) - 2 j1 - j2."""
        return 3 * (len(self.links) - 1) - 2 * self.pairs - len(self.couplings)

    @property
    def formula(self) -> str:
        """Grübler's formula with its numbers."""
        n, j1, j2 = len(self.links), self.pairs, len(self.couplings)
        higher = f" - {j2}" if j2 else ""
        return f"F = 3 (n - 1) - 2 j1 - j2 = 3 ({n} - 1) - 2 · {j1}{higher} = {self.gruebler}"

    @property
    def multiple(self) -> tuple[str, ...]:
        """The nodes of the multiple joints."""
        return tuple(joint.name for joint in self.joints if joint.pairs > 1)


@derived
def kinematic_chain(mechanism: Mechanism) -> KinematicChain:
    """Return the links and joints of a mechanism."""
    links, coupled = Links(mechanism), [mechanism.actuators[one.follower].name for one in mechanism.couplings]
    for joint in joints(mechanism):
        if joint.slides:
            links.slide(joint, f"block {joint.name}")
        elif joint.kind == CYLINDER:
            parts = zip(("cylinder", "rod"), joint.nodes, strict=True)
            bodies = tuple(links.add(f"{part} {joint.name}", node) for part, node in parts)
            links.joints.append(replace(joint, kind=PRISMATIC, bodies=bodies))
    turnless = [joint.name for joint in joints(mechanism) if joint.kind == TURNLESS]
    return KinematicChain(tuple(links.names), (*links.revolute, *links.joints), (*turnless, *coupled))


@dataclass(frozen=True)
class LinkLoop:
    """A closed loop of links: joint k joins link k to the next one, the last joint joins the last link to the first."""

    links: tuple[int, ...]
    joints: tuple[Joint, ...]

    @property
    def kinds(self) -> str:
        """The kinds of the joints in order, such as RRRP."""
        return "".join(joint.kind for joint in self.joints)

    @property
    def backwards(self) -> LinkLoop:
        """The same loop in the other sense, with the same first link."""
        return LinkLoop((self.links[0], *self.links[:0:-1]), self.joints[::-1])


def loops_of_frame(chain: KinematicChain, length: int) -> list[LinkLoop]:
    """Return the loops of `length` links that contain the frame, each once."""
    found: dict[frozenset[int], LinkLoop] = {}

    def extend(links: tuple[int, ...], joints: tuple[Joint, ...]) -> None:
        for joint in chain.joints:
            if joint in joints or links[-1] not in joint.bodies:
                continue
            if len(links) == length and FRAME in joint.bodies:
                found.setdefault(frozenset(links), LinkLoop(links, (*joints, joint)))
            elif len(links) < length:
                for link in joint.bodies:
                    if link not in links:
                        extend((*links, link), (*joints, joint))

    extend((FRAME,), ())
    return [loop for loop in found.values() if _simple(chain, loop)]


def _simple(chain: KinematicChain, loop: LinkLoop) -> bool:
    """Return whether no two links of a loop that do not follow each other are joined, which would make it rigid."""
    size = len(loop.links)
    for (i, a), (k, b) in combinations(enumerate(loop.links), 2):
        if (k - i) % size not in (1, size - 1) and any({a, b} <= set(joint.bodies) for joint in chain.joints):
            return False
    return True
