"""The kinematic chain of a mechanism: its links and lower pairs, multiple joints included, and Grübler's formula.

A pin in a slot is a link of its own (a block) with a revolute and a prismatic pair; a linear actuator between two nodes
is two links (cylinder and rod) with a prismatic pair. A node of k links is a multiple joint: k - 1 revolute pairs.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

from gimcli.mechanism import FRAME, SPAN, ComplexArray, Mechanism
from gimcli.structure.derived import derived
from gimcli.structure.lower_pairs import PRISMATIC, REVOLUTE
from gimcli.structure.pair_rows import sliding_pairs
from gimcli.structure.residual import pose
from gimcli.structure.rotation import members_of
from gimcli.structure.steps import NONE


@dataclass(frozen=True)
class ChainJoint:
    """A revolute joint at a node, of two or more links, or a prismatic pair of two links."""

    kind: str
    name: str  # of the node, the sliding pair or the actuator
    links: tuple[int, ...]
    node: int = NONE  # of a revolute joint
    slide: int = NONE  # of a prismatic pair: number in Mechanism.slides
    ends: tuple[int, int] = (NONE, NONE)  # of a linear actuator: its nodes

    @property
    def pairs(self) -> int:
        """Number of pairs: one less than the number of links."""
        return len(self.links) - 1

    def direction(self, mechanism: Mechanism, z: ComplexArray) -> complex:
        """Return the direction of a prismatic pair, of modulus 1, at a position z (nodes,)."""
        if self.slide == NONE:
            run = complex(z[self.ends[1]] - z[self.ends[0]])
            return run / abs(run)
        row = mechanism.slides[self.slide]
        return complex(row.along * pose(mechanism, row.guide, z[:, None])[1][0])


@dataclass(frozen=True)
class KinematicChain:
    """Links by number (members, the frame first, then blocks, then cylinders and rods) and their joints."""

    links: tuple[str, ...]
    joints: tuple[ChainJoint, ...]
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

    def at(self, link: int) -> list[ChainJoint]:
        """Return the joints of a link."""
        return [joint for joint in self.joints if link in joint.links]


@derived
def kinematic_chain(mechanism: Mechanism) -> KinematicChain:
    """Return the links and joints of a mechanism."""
    links = [m.name for m in mechanism.members]
    parts = [list(members) for members in members_of(mechanism)]  # links at each node
    joints: list[ChainJoint] = []
    for pair in sliding_pairs(mechanism):
        slider = pair.body
        if slider == NONE:
            slider = len(links)
            links.append(f"block {pair.name}")
            parts[mechanism.slides[pair.slides[0]].node].append(slider)
        joints.append(ChainJoint(PRISMATIC, pair.name, (pair.guide, slider), slide=pair.slides[0]))
    for actuator in mechanism.actuators:
        if actuator.kind == SPAN:
            cylinder = len(links)
            links += [f"cylinder {actuator.name}", f"rod {actuator.name}"]
            first, last = actuator.nodes
            parts[first].append(cylinder)
            parts[last].append(cylinder + 1)
            joints.append(ChainJoint(PRISMATIC, actuator.name, (cylinder, cylinder + 1), ends=(first, last)))
    pins = [
        ChainJoint(REVOLUTE, mechanism.nodes[node], tuple(there), node)
        for node, there in enumerate(parts)
        if len(there) > 1
    ]
    coupled = [row.name for row in mechanism.pairs if row.rotary]
    coupled += [mechanism.actuators[coupling.follower].name for coupling in mechanism.couplings]
    return KinematicChain(tuple(links), (*pins, *joints), tuple(coupled))


@dataclass(frozen=True)
class LinkLoop:
    """A closed loop of links: joint k joins link k to the next one, the last joint joins the last link to the first."""

    links: tuple[int, ...]
    joints: tuple[ChainJoint, ...]

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

    def extend(links: tuple[int, ...], joints: tuple[ChainJoint, ...]) -> None:
        for joint in chain.at(links[-1]):
            if joint in joints:
                continue
            if len(links) == length and FRAME in joint.links:
                found.setdefault(frozenset(links), LinkLoop(links, (*joints, joint)))
            elif len(links) < length:
                for link in joint.links:
                    if link not in links:
                        extend((*links, link), (*joints, joint))

    extend((FRAME,), ())
    return [loop for loop in found.values() if _simple(chain, loop)]


def _simple(chain: KinematicChain, loop: LinkLoop) -> bool:
    """Return whether no two links of a loop that do not follow each other are joined, which would make it rigid."""
    size = len(loop.links)
    for (i, a), (k, b) in combinations(enumerate(loop.links), 2):
        if (k - i) % size not in (1, size - 1) and any({a, b} <= set(joint.links) for joint in chain.joints):
            return False
    return True
