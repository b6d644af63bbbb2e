"""The type of a mechanism: the name of its chain, and the types of its loops of four links with the frame."""

from __future__ import annotations

from dataclasses import dataclass

from gimcli.errors import StructureError
from gimcli.mechanism import FRAME, ComplexArray, Mechanism
from gimcli.structure.assur import Formation, formation
from gimcli.structure.chain_names import ChainName, chain_name
from gimcli.structure.kinematic_chain import KinematicChain, kinematic_chain, loops_of_frame
from gimcli.structure.loop_types import LoopType, loop_type

COUNTS = {2: "two", 3: "three", 4: "four", 5: "five", 6: "six", 7: "seven", 8: "eight", 9: "nine", 10: "ten"}


@dataclass(frozen=True)
class MechanismType:
    """The chain, its name, its loops of four links that contain the frame, and its groups."""

    chain: KinematicChain
    named: ChainName
    loops: tuple[LoopType, ...]
    formation: Formation | None  # None if the inputs do not drive all freedoms

    @property
    def name(self) -> str:
        """The type in words, such as "four-bar linkage: crank-rocker" or "Watt II six-bar"."""
        if self.named.name == "4-bar loop" and self.loops:
            first = self.loops[0]
            return f"{first.name}: {first.kind}" if first.kind else first.name
        if self.named.name == "3-bar loop":
            return "triangle of three links, a rigid structure"
        if self.named.name.endswith("-bar loop"):
            return f"{self._count()}-bar linkage"
        return self.named.name or f"{self._count()}-link mechanism"

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
