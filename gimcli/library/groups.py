"""Find the driving links and Assur groups of a mechanism."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

from gimcli import output
from gimcli.connected import grouped
from gimcli.library.machines import for_each_machine
from gimcli.library.record import Records, RowField
from gimcli.library.result import Result
from gimcli.mechanism import FRAME, Mechanism
from gimcli.structure.assur import AssurGroup, Formation, formation
from gimcli.structure.joints import Joint
from gimcli.structure.mobility import assembled, require_driven

NAMED, ABREAST = 4, 3
"""Largest numbers of links that the legend names, and in a line of a box."""


@for_each_machine()
def groups(mechanism: Mechanism) -> GroupsResult:
    """Find the formation of a mechanism: driving links, then Assur groups, each joined to earlier ones.

    Returns:
        A GroupsResult: a mapping of the columns group, kind, class, order, links, joined to, driven by.

    Raises:
        StructureError: the mechanism is not fully driven, or over-driven.
    """
    require_driven(mechanism)
    return GroupsResult(mechanism, formation(mechanism))


class GroupsResult(Result):
    """The groups in the order of formation, one row each."""

    KIND = "groups"

    def __init__(self, mechanism: Mechanism, found: Formation) -> None:
        self.mechanism, self._found = mechanism, found

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: {'  '.join(self._found.formula)}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found, names = self._found, self._found.links

        def pairs(own: Sequence[Joint]) -> list[dict[str, Any]]:
            return [{"kind": p.kind, "at": p.name, "links": [names[k] for k in p.bodies]} for p in own]

        return {
            "formula": list(found.formula), "links": {names[k]: number for k, number in found.numbers.items()},
            "groups": [
                {
                    "kind": "driving link" if g.driving else "group", "dyad": g.dyad or None,
                    "links": [names[k] for k in g.links], "class": g.grade, "order": g.order,
                    "on": [names[k] for k in found.bases(g)], "outer": pairs(g.outer), "inner": pairs(g.inner),
                    "driven_by": self._drivers(g), "redundant": g.surplus,
                }
                for g in found.groups
            ],
        }  # fmt: skip

    def _drivers(self, group: AssurGroup) -> list[str]:
        """Return the names of the actuators whose inputs determine a group."""
        return [self.mechanism.actuators[k].name for k in group.drivers]

    @cached_property
    def _records(self) -> Records:
        """The groups, one row each."""
        own, every = self._found, self._found.groups
        surplus = [f", {one.surplus} redundant" if one.surplus else "" for one in every]
        joints = [", ".join(f"{own.links[k]} at {' '.join(at)}" for k, at in own.joined(one).items()) for one in every]
        return Records(
            RowField("group", own.formula, str, head=""),
            RowField("kind", [one.description + note for one, note in zip(every, surplus, strict=True)], str, head=""),
            RowField("class", [one.numeral for one in every], str, head="class"),
            RowField("order", [one.order for one in every], int, head="order"),
            RowField("links", [", ".join(own.links[k] for k in one.links) for one in every], str, head="links"),
            RowField("joined to", joints, str, head="joined to"),
            RowField("driven by", [", ".join(self._drivers(one)) for one in every], str, head="driven by"),
        )

    def picture(self) -> output.picture.Content:
        """Return the mechanism coloured by groups, and the groups as boxes, each below those that it is joined to."""
        mechanism, boxes = self.mechanism, self._boxes()
        found = assembled(mechanism)
        z = mechanism.to_file(mechanism.drawn if found is None else found)
        drawing = output.structure.coloured_picture(
            mechanism, z, boxes, f"{mechanism.name}: groups in the order of formation"
        )
        return output.picture.Sheet("", (drawing, output.structure.formation_picture(boxes, self._joints())))

    def _boxes(self) -> list[output.structure.Box]:
        """Return the frame and the groups, with their names for the legend and their lines in the diagram."""
        found, boxes = self._found, [output.structure.Box(0, (f"0: {self._found.links[FRAME]}",), 0)]
        for k, (group, layer, formula) in enumerate(
            zip(found.groups, found.layers, found.formula, strict=True), start=1
        ):
            links = tuple(found.links[link] for link in group.links)
            own = [f"{found.numbers[link]}: {found.links[link]}" for link in group.links]
            driven = [f"driven by {', '.join(self._drivers(group))}"] if group.drivers else []
            head = f"group {k}: {group.description}, class {group.numeral}, order {group.order}"
            name = group.description + (f" ({', '.join(links)})" if len(links) <= NAMED else "")
            short = (", ".join(own[first : first + ABREAST]) for first in range(0, len(own), ABREAST))
            boxes.append(output.structure.Box(k, (head, formula, *short, *driven), layer, name, links))
        return boxes

    def _joints(self) -> list[output.structure.BoxJoint]:
        """Return the pairs between the boxes."""
        found, joints = self._found, list[output.structure.BoxJoint]()
        box_of = {link: k for k, group in enumerate(found.groups, start=1) for link in group.links} | {FRAME: 0}
        for k, group in enumerate(found.groups, start=1):
            above = grouped((box_of[base], (base, names)) for base, names in found.joined(group).items())
            for upper, own in above.items():
                pairs = " ".join(name for _, names in own for name in names)
                joints.append(
                    output.structure.BoxJoint(upper, k, pairs, ", ".join(str(found.numbers[base]) for base, _ in own))
                )
        return joints
