"""The type of a mechanism: the name of its chain, and the types of its loops of four links with the frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, product

from gimcli.connected import connected
from gimcli.errors import StructureError
from gimcli.mechanism import FRAME, ComplexArray, Mechanism
from gimcli.structure.assur import Formation, formation
from gimcli.structure.kinematic_chain import KinematicChain, kinematic_chain, loops_of_frame
from gimcli.structure.loop_types import LoopType, loop_type

COUNTS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six", 7: "seven", 8: "eight", 9: "nine", 10: "ten"}

SIX_BARS: dict[tuple[int, ...], tuple[str, str, str]] = {
    (0, 2, 2): ("Watt II six-bar", "", "Watt I six-bar"),
    (1, 1, 2): ("Stephenson III six-bar", "Stephenson I six-bar", "Stephenson II six-bar"),
}
"""Names by the numbers of binary links on the three paths between the ternary links; by that of the frame's path, 0 if
the frame is a ternary link."""

Edge = tuple[int, int]


@dataclass(frozen=True)
class MechanismType:
    """The chain, its name, its loops of four links that contain the frame, and its groups."""

    chain: KinematicChain
    chain_name: str
    loops: tuple[LoopType, ...]
    formation: Formation | None  # None if the inputs do not drive all freedoms

    @property
    def name(self) -> str:
        """The type in words, such as "four-bar linkage: crank-rocker" or "Watt II six-bar"."""
        if self.chain_name == "4-bar loop" and self.loops:
            first = self.loops[0]
            return f"{first.name}: {first.kind}" if first.kind else first.name
        if self.chain_name == "3-bar loop":
            return "triangle of three links, a rigid structure"
        if self.chain_name.endswith("-bar loop"):
            return f"{self._count()}-bar linkage"
        return self.chain_name or f"{self._count()}-link mechanism"

    def _count(self) -> str:
        return COUNTS.get(len(self.chain.links), str(len(self.chain.links)))


def mechanism_type(mechanism: Mechanism, z: ComplexArray) -> MechanismType:
    """Return the type of a mechanism, with the dimensions of a position z (nodes,)."""
    chain = kinematic_chain(mechanism)
    try:
        found = formation(mechanism)
    except StructureError:
        found = None
    rank = found.numbers if found is not None else {}
    loops = []
    for loop in loops_of_frame(chain, 4):
        first = min((loop.links[1], loop.links[3]), key=lambda link: rank.get(link, len(chain.links) + 2))
        loops.append(loop_type(mechanism, chain, loop, z, first))
    return MechanismType(chain, chain_name(chain), tuple(loops), found)


def driving_links(mechanism: Mechanism) -> set[int]:
    """Return the members that an actuator turns relative to the frame."""
    return {k for a in mechanism.actuators if a.rotary and FRAME in a.members for k in a.members} - {FRAME}


def chain_name(chain: KinematicChain) -> str:
    """Return the name of a chain by its structure; "" if it has none."""
    names = {_simple_name(chain, edges) for edges in _resolved(chain)} if not chain.couplings else {""}
    return " or ".join(sorted(names - {""}))


def _resolved(chain: KinematicChain) -> Iterator[dict[Edge, str]]:
    """Yield the pairs {(link, link): kind} for every choice of the link that carries the others at a multiple joint."""
    choices = [joint.bodies if joint.pairs > 1 else joint.bodies[:1] for joint in chain.joints]
    if sum(joint.pairs > 1 for joint in chain.joints) > 3:
        return
    for bases in product(*choices):
        stars = zip(chain.joints, bases, strict=True)
        edges = {(min(b, k), max(b, k)): joint.kind for joint, b in stars for k in joint.bodies if k != b}
        if len(edges) == chain.pairs:  # otherwise two links are joined twice
            yield edges


def _simple_name(chain: KinematicChain, edges: dict[Edge, str]) -> str:
    near: dict[int, list[int]] = {link: [] for link in range(len(chain.links))}
    for a, b in edges:
        near[a].append(b)
        near[b].append(a)
    if min(map(len, near.values())) < 2:
        return ""
    hubs = [link for link in near if len(near[link]) > 2]
    if not hubs:
        return f"{len(near)}-bar loop" if len(connected(edges, set())) == 1 else ""
    if len(hubs) != 2:
        return ""
    paths = _paths(near, *hubs)
    if sum(map(len, paths)) + 2 != len(near):
        return ""
    if len(near) == 6 and len(edges) == 7:
        names = SIX_BARS.get(tuple(sorted(map(len, paths))))
        return names[next((len(path) for path in paths if FRAME in path), 0)] if names else ""
    return _platform(hubs, paths, edges)


def _paths(near: dict[int, list[int]], start: int, end: int) -> list[list[int]]:
    """Return the binary links of each path from one link with several pairs to the other."""
    paths = []
    for link in near[start]:
        path, before = [], start
        while link not in (start, end):
            path.append(link)
            before, link = link, next(other for other in near[link] if other != before)
        if link == end:
            paths.append(path)
    return paths


def _platform(hubs: list[int], paths: list[list[int]], edges: dict[Edge, str]) -> str:
    """Return the name of a platform on legs of two links, such as "3-RPR platform"; "" for other chains."""
    if FRAME not in hubs or len(paths) < 3 or any(len(path) != 2 for path in paths):
        return ""
    platform = next(link for link in hubs if link != FRAME)
    legs = set()
    for path in paths:
        whole = [FRAME, *(path if (min(FRAME, path[0]), max(FRAME, path[0])) in edges else path[::-1]), platform]
        legs.add("".join(edges[min(a, b), max(a, b)] for a, b in pairwise(whole)))
    return f"{len(paths)}-{legs.pop()} platform" if len(legs) == 1 else f"platform on {len(paths)} legs"
