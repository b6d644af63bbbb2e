"""Files of Pyslvs (`.pyslvs`), YAML with a mechanism as an expression, and such expressions alone.

The slot of a P or RP joint belongs to the link that is named first. Pyslvs stores which angles are inputs, but no
motion, no time and no unit of length.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from gimcli.exchange.draft import GROUND, STROKE, Draft, DrawnJoint
from gimcli.exchange.pyslvs_expression import joints_of
from gimcli.exchange.refusing import FilePlace

PROGRAM = "Pyslvs"
DIGIT = 1e-4
"""Last digit of the coordinates in an expression."""
MOST_INPUTS = 50
Where = tuple[str | int, ...]
"""Keys of a value in the file."""

_EXPRESSION = re.compile(r"(?:\s|#[^\n]*\n)*M\s*\[\s*(?:J\s*\[|\]|$)")
_YAML = re.compile(r"""(?:^|[{,]\s*)(?:pyslvs_ver\s*:|mechanism\s*:\s*['"]?M\[)""", re.MULTILINE)
_BINARY = {"€": ("pyslvs_ver", "pickle"), "\x80": ("pyslvs_ver", "pickle"), "SQLite format": ("commitmodel", "SQLite"),
           "‰HDF": ("pyslvs_ver", "HDF5")}  # fmt: skip
_UNUSED = re.compile(r"^(?:path|slider_path|algorithm|collection|triangle|background):.*\n(?:[ -].*\n)*", re.MULTILINE)
_LEFT_OUT = {"path": "recorded paths", "algorithm": "synthesis results", "collection": "structures",
             "triangle": "synthesis settings", "background": "background picture"}  # fmt: skip


def recognises(text: str) -> bool:
    """Return whether a text is probably an expression or a file of Pyslvs."""
    return bool(_EXPRESSION.match(text) or _binary(text) or _YAML.search(text))


def _binary(text: str) -> str:
    """Return the name of the binary format of a file of Pyslvs; "" if it is text."""
    forms = (form for start, (word, form) in _BINARY.items() if text.startswith(start) and word in text.lower())
    return next(forms, "")


def read(text: str, source: str) -> Draft:
    """Return the mechanism of a file of Pyslvs; `source` names it in messages."""
    draft = Draft(PROGRAM, source, resolution=2.0 * DIGIT)
    cure = "open it with Pyslvs and save it as YAML (preferences: file type)"
    form = _binary(text)
    draft.refuse(form, f"a Pyslvs file in the binary format {form} is not read; {cure}")
    if _EXPRESSION.match(text):
        _Pyslvs(joints_of(text, source), draft).convert([])
        return draft
    _from_yaml(text, draft)
    return draft


def _from_yaml(text: str, draft: Draft) -> None:
    from gimcli.model.source import read_yaml

    for key, what in _LEFT_OUT.items():
        if re.search(rf"(?:^|[{{,]\s*){key}\s*:", text, re.MULTILINE):
            draft.left_out.append(f"{what} are left out" if what.endswith("s") else f"the {what} is left out")
    own = read_yaml(_UNUSED.sub(lambda m: "\n" * m[0].count("\n"), text), Path(draft.source))
    if own.faults:
        raise own.error()
    data = own.data
    name, expression, where = _mechanism(data, draft)
    joints = joints_of(expression, draft.source, own.values.get(where, (1, 1))[0])
    inputs = data.get("input") if where == ("mechanism",) else None
    draft.name = name
    _Pyslvs(joints, draft).convert(_pairs(inputs, draft, own.values.get(("input",), (1, 1))[0]))


def _mechanism(data: dict[str, Any], draft: Draft) -> tuple[str, str, Where]:
    """Return the name, the expression and the keys of the mechanism: the drawn one, or else the first stored one."""
    stored = {name: text for name, text in _items(data.get("storage")) if isinstance(text, str)}
    drawn = data.get("mechanism")
    listed: list[tuple[str, str, Where]] = [(name, text, ("storage", name)) for name, text in stored.items()]
    if isinstance(drawn, str) and re.sub(r"\s", "", drawn) != "M[]":
        listed.insert(0, ("", drawn, ("mechanism",)))
    draft.refuse(not listed, "the file has no mechanism; draw one in Pyslvs and save the file again")
    if listed[1:]:
        draft.left_out.append(f"stored mechanisms are left out: {', '.join(name for name, _, _ in listed[1:])}")
    return listed[0]


def _items(storage: Any) -> list[tuple[str, Any]]:
    """Return the names and expressions of stored mechanisms, which are a mapping or a list of pairs."""
    if isinstance(storage, dict):
        return list(storage.items())
    pairs = storage if isinstance(storage, list) else []
    return [(str(pair[0]), pair[1]) for pair in pairs if isinstance(pair, list) and len(pair) == 2]


def _pairs(inputs: Any, draft: Draft, line: int) -> list[tuple[int, int]]:
    """Return the pairs of joints of the inputs."""
    found, place = [], FilePlace(f"{draft.source}:{line}: input")
    for pair in inputs if isinstance(inputs, list) else [] if inputs is None else [inputs]:
        own = pair[:2] if isinstance(pair, list) else []
        good = len(own) == 2 and all(isinstance(k, int) and not isinstance(k, bool) for k in own)
        place.refuse(not good, "expected pairs of joint numbers such as [0, 1]")
        found.append((own[0], own[1]))
    place.refuse(len(found) > MOST_INPUTS, f"more than {MOST_INPUTS} inputs are too many")
    return found


class _Pyslvs:
    """The conversion of one list of joints; `names` are those of the joints in the draft, "" for a point."""

    def __init__(self, joints: list[DrawnJoint], draft: Draft) -> None:
        self.draft = draft
        self.same: dict[str, str] = {}
        draft.refuse(
            joints and not any(GROUND in joint.links for joint in joints),
            "no joint is on the link 'ground'; name the frame so",
        )
        self._weld_blocks(joints)
        links = dict.fromkeys(self._first(link) for joint in joints for link in joint.links)
        bodies = {link: GROUND if link == GROUND else draft.body(link, ()) for link in links}
        whole = [dict.fromkeys(bodies[self._first(link)] for link in joint.links) for joint in joints]
        self.joints = [replace(joint, links=tuple(links)) for joint, links in zip(joints, whole, strict=True)]
        self.names = [self._add_joint(f"Point{number}", joint) for number, joint in enumerate(self.joints)]

    def convert(self, inputs: list[tuple[int, int]]) -> None:
        """Add the inputs."""
        for number, (base, driver) in enumerate(inputs):
            self._add_input(number, base, driver)
        if not inputs:
            self.draft.suggest_input()

    def _weld_blocks(self, joints: list[DrawnJoint]) -> None:
        """Make one body of the links that a P joint joins to its slot: none of them turns against it."""
        for joint in joints:
            slot, *blocks = joint.links if joint.kind == "P" and joint.links else [""]
            for link in blocks[1:]:
                first, second = self._first(blocks[0]), self._first(link)
                if second == GROUND:
                    first, second = second, first
                if first != second:
                    self.same[second] = first
            same = bool(blocks) and self._first(blocks[0]) == self._first(slot)
            FilePlace(joint.where).refuse(same, f"the block and the slot of this P joint are one link, {slot}")

    def _first(self, link: str) -> str:
        """Return the link that stands for the links of a body."""
        while link in self.same:
            link = self.same[link]
        return link

    def _add_joint(self, name: str, joint: DrawnJoint) -> str:
        links = joint.links
        if joint.kind == "R" and len(links) == 1 and links[0] != GROUND and self._has_joints(links[0]):
            self.draft.point(name, links[0], joint.place)
            return ""
        return self.draft.listed(name, joint, "slot")

    def _has_joints(self, link: str) -> bool:
        """Return whether a link has two places without its points: joints, or a slot, which has two."""
        own = [joint for joint in self.joints if len(joint.links) > 1 and link in joint.links]
        return sum(2 if joint.kind != "R" and joint.links[0] == link else 1 for joint in own) > 1

    # -- inputs ---------------------------------------------------------------------------------

    def _add_input(self, number: int, base: int, driver: int) -> None:
        what = f"input Point{base}->Point{driver}"
        self.draft.refuse(
            not (0 <= base < len(self.joints) and 0 <= driver < len(self.joints)),
            f"{what}: there is no such joint; the last one is Point{len(self.joints) - 1}",
        )
        if base == driver:
            self._add_travel(number, base)
            return
        if GROUND not in self._pinned(base):
            base, driver = driver, base
        shared = [link for link in self._pinned(base) if link in self._pinned(driver) and link != GROUND]
        self.draft.refuse(
            GROUND not in self._pinned(base) or not shared,
            f"{what}: one of the two must be fixed, and a link must join both",
        )
        if not self.names[driver]:  # a point: it becomes a joint of its link
            place = self.draft.tracers.pop(f"Point{driver}")[1]
            self.names[driver] = self.draft.joint(f"Point{driver}", place, shared[0])
        law = {"by": 0.0 if number else 360.0}
        name = "motor" if not number else f"motor_{number + 1}"
        self.draft.rotary(name, self.names[base], shared[0], arm=self.names[driver], law=law)
        if number:
            self.draft.left_out.append(f"{name} ({what}) is constant: Pyslvs stores no motion; change its law")

    def _pinned(self, number: int) -> tuple[str, ...]:
        """Return the links that a joint is a pin of."""
        joint = self.joints[number]
        return joint.links if joint.kind == "R" else joint.links[1:]

    def _add_travel(self, number: int, base: int) -> None:
        self.draft.refuse(
            self.joints[base].kind == "R" or not self._pinned(base),
            f"input Point{base}->Point{base}: it is no slider (P or RP)",
        )
        travel = STROKE * self.draft.size()
        name = f"slide_{number + 1}" if number else "slide"
        self.draft.travel(name, slot=f"slot_{self.names[base]}", law={"by": 0.0 if number else travel})
        moves = "is constant" if number else f"moves by {travel:g}"
        self.draft.left_out.append(
            f"{name} (input Point{base}->Point{base}) {moves}: Pyslvs stores no motion; change its law"
        )
