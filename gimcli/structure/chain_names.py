"""Names of kinematic chains by their structure: loops, Watt's and Stephenson's chains, parallel platforms.

Six links and seven pairs with two ternary links: in Watt's chain the ternary links are joined to each other, and two
more paths of two binary links join them; in Stephenson's chain the paths have one, one and two binary links. The fixed
link distinguishes Watt I (binary) and II (ternary), and Stephenson I (the only link of its path), II (one of the two
links of its path) and III (ternary). Sources: Paul, Kinematics and Dynamics of Planar Machinery, 1979, section 1.4;
Norton, Design of Machinery, section 2.14 and figure 2-16.

A multiple joint is the limit of a chain with simple joints, in which one of its links carries all other ones. All such
chains are compared; if they differ, the name has all of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise, product

from gimcli.mechanism import FRAME
from gimcli.structure.kinematic_chain import ChainJoint, KinematicChain

Edge = tuple[int, int]


@dataclass(frozen=True)
class ChainName:
    """The name of a chain, empty if it has none, and the nodes of its multiple joints."""

    name: str
    multiple: tuple[str, ...]


def chain_name(chain: KinematicChain) -> ChainName:
    """Return the name of a chain by its structure."""
    multiple = tuple(joint.name for joint in chain.joints if joint.pairs > 1)
    names = {_simple_name(chain, edges) for edges in _resolved(chain)} if not chain.couplings else {""}
    known = sorted(names - {""})
    return ChainName(" or ".join(known) if known else "", multiple)


def _resolved(chain: KinematicChain) -> Iterator[dict[Edge, str]]:
    """Yield the pairs {(link, link): kind} for every choice of the link that carries the others at a multiple joint."""
    choices = [joint.links if joint.pairs > 1 else joint.links[:1] for joint in chain.joints]
    if sum(joint.pairs > 1 for joint in chain.joints) > 3:
        return
    for bases in product(*choices):
        edges: dict[Edge, str] = {}
        for joint, base in zip(chain.joints, bases, strict=True):
            edges |= _star(joint, base)
        if len(edges) == chain.pairs:  # otherwise two links are joined twice
            yield edges


def _star(joint: ChainJoint, base: int) -> dict[Edge, str]:
    return {(min(base, link), max(base, link)): joint.kind for link in joint.links if link != base}


def _simple_name(chain: KinematicChain, edges: dict[Edge, str]) -> str:
    near: dict[int, list[int]] = {link: [] for link in range(len(chain.links))}
    for a, b in edges:
        near[a].append(b)
        near[b].append(a)
    if min(map(len, near.values())) < 2:
        return ""
    hubs = [link for link in near if len(near[link]) > 2]
    if not hubs:
        return f"{len(near)}-bar loop" if _connected(near) else ""
    if len(hubs) != 2:
        return ""
    paths = _paths(near, *hubs)
    if sum(map(len, paths)) + 2 != len(near):
        return ""
    if len(near) == 6 and len(edges) == 7:
        return _six_bar(hubs, paths)
    return _platform(hubs, paths, edges)


def _connected(near: dict[int, list[int]]) -> bool:
    seen, front = {FRAME}, [FRAME]
    while front:
        front = list({other for link in front for other in near[link]} - seen)
        seen |= set(front)
    return len(seen) == len(near)


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


def _six_bar(hubs: list[int], paths: list[list[int]]) -> str:
    sizes = sorted(map(len, paths))
    if sizes == [0, 2, 2]:
        return "Watt II six-bar" if FRAME in hubs else "Watt I six-bar"
    if sizes != [1, 1, 2]:
        return ""
    if FRAME in hubs:
        return "Stephenson III six-bar"
    own = next(path for path in paths if FRAME in path)
    return "Stephenson I six-bar" if len(own) == 1 else "Stephenson II six-bar"


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
