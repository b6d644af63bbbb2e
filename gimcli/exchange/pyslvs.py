"""Files of Pyslvs (`.pyslvs`), YAML with a mechanism as an expression, and such expressions alone.

An expression is `M[J[R, P[0, 0], L[ground, L1]], ...]`: a joint has a type (R, P or RP), for a slot its angle `A[...]`,
a colour, its place and its links. The slot of a P or RP joint belongs to the link that is named first. Pyslvs stores
which angles are inputs, but no motion, no time and no unit of length.

Source: expression_parser.py of the program, whose grammar this is; the parts of a joint may come in any order here.
"""

from __future__ import annotations

import cmath
import math
import re
from collections import Counter
from pathlib import Path
from typing import Any

from gimcli.connected import connected
from gimcli.exchange.draft import GROUND, MOST, STROKE, Draft, DrawnJoint, coordinates
from gimcli.exchange.records import LARGEST, FilePart, number_of, read as read_part

PROGRAM = "Pyslvs"
DIGIT = 1e-4
"""Last digit of the coordinates in an expression."""
MOST_CHARACTERS = 300_000
TYPES = ("R", "P", "RP")
FORMS = {"P": "P[x, y]", "L": "L[...]", "A": "A[angle]", "color": "color[...]"}
"""The parts of a joint; A only for slots, and a colour may be missing."""

_COMMENT = re.compile(r"#[^\n]*")
_START = re.compile(r"\s*M\s*\[")
_JOINT = re.compile(
    r"\s*(?P<start>J)\s*\[\s*(?P<kind>[^\s\[\],]*)\s*(?P<parts>(?:[^\[\]]++|\[[^\[\]]*+\])*+)\]\s*(?:,|(?=\]))"
)
_PART = re.compile(r"\s*,\s*([^\s\[\],]+)\s*\[([^\[\]]*)\]")
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
    else:
        _from_yaml(text, draft)
    return draft


def _from_yaml(text: str, draft: Draft) -> None:
    from gimcli.model.source import read_yaml

    for key, what in _LEFT_OUT.items():
        found = re.search(rf"(?:^|[{{,]\s*){key}\s*:", text, re.MULTILINE)
        draft.note(found, f"{what} are left out" if what.endswith("s") else f"the {what} is left out")
    own = read_yaml(_UNUSED.sub(lambda m: "\n" * m[0].count("\n"), text), Path(draft.source))
    if own.faults:
        raise own.error()
    listed = _mechanisms(own.data)
    draft.refuse(not listed, "the file has no mechanism; draw one in Pyslvs and save the file again")
    draft.name, expression, where = listed[0]
    draft.note(listed[1:], f"stored mechanisms are left out: {', '.join(name for name, _, _ in listed[1:])}")
    joints = joints_of(expression, draft.source, own.values.get(where, (1, 1))[0])
    given = own.data.get("input") if where == ("mechanism",) else None
    inputs = FilePart(f"{draft.source}:{own.values.get(('input',), (1, 1))[0]}: input", given or [])
    _Pyslvs(joints, draft).convert(read_part([[int]], inputs))


def _mechanisms(data: dict[str, Any]) -> list[tuple[str, str, Where]]:
    """Return the names, the expressions and the keys of the mechanisms: the drawn one, and those that are stored."""
    drawn, stored = data.get("mechanism"), data.get("storage")
    if not isinstance(stored, dict):  # a list of pairs
        pairs = stored if isinstance(stored, list) else []
        stored = {str(pair[0]): pair[1] for pair in pairs if isinstance(pair, list) and len(pair) == 2}
    found: list[tuple[str, Any, Where]] = [("", drawn, ("mechanism",))]
    found += [(name, text, ("storage", name)) for name, text in stored.items()]
    return [one for one in found if isinstance(one[1], str) and (one[0] or re.sub(r"\s", "", one[1]) != "M[]")]


class _Pyslvs:
    """The conversion of one list of joints; `names` are those of the joints in the draft, "" for a point."""

    def __init__(self, joints: list[DrawnJoint], draft: Draft) -> None:
        self.draft = draft
        grounded = any(GROUND in joint.bodies for joint in joints)
        draft.refuse(joints and not grounded, "no joint is on the link 'ground'; name the frame so")
        self.same = self._welded(joints)
        self.joints = draft.linked(joints, lambda link: self.same.get(link, link))
        self.names = [self._add_joint(f"Point{number}", joint) for number, joint in enumerate(self.joints)]

    def convert(self, inputs: list[list[int]]) -> None:
        """Add the inputs."""
        for number, pair in enumerate(inputs):
            self._add_input(number, pair)
        if not inputs:
            self.draft.suggest_input()

    def _welded(self, joints: list[DrawnJoint]) -> dict[str, str]:
        """Return the first link of the body of each link: those that a P joint joins to its slot are one body."""
        links = dict.fromkeys([GROUND, *(link for joint in joints for link in joint.bodies)])
        order = {link: k for k, link in enumerate(links)}
        bodies = connected((joint.bodies[1:] for joint in joints if joint.kind == "P"), frozenset())
        same = {link: min(body, key=order.__getitem__) for body in bodies for link in body}
        for joint in joints:
            ends = [same.get(link, link) for link in joint.bodies[:2]] if joint.kind == "P" else []
            fault = f"the block and the slot of this P joint are one link, {', '.join(joint.bodies[:1])}"
            joint.own.refuse(len(set(ends)) < len(ends), fault)
        return same

    def _add_joint(self, name: str, joint: DrawnJoint) -> str:
        links = joint.bodies
        if joint.kind == "R" and len(links) == 1 and links[0] != GROUND and self._has_joints(links[0]):
            self.draft.point(name, links[0], joint.place)
            return ""
        return self.draft.listed(name, joint, "slot")

    def _has_joints(self, link: str) -> bool:
        """Return whether a link has two places without its points: joints, or a slot, which has two."""
        own = [joint for joint in self.joints if len(joint.bodies) > 1 and link in joint.bodies]
        return sum(2 if joint.kind != "R" and joint.bodies[0] == link else 1 for joint in own) > 1

    # -- inputs ---------------------------------------------------------------------------------

    def _add_input(self, number: int, pair: list[int]) -> None:
        base, driver, *_ = *pair, -1, -1
        what = f"input Point{base}->Point{driver}"
        missing = not {base, driver} <= {*range(len(self.joints))}
        self.draft.refuse(missing, f"{what}: there is no such joint; the last one is Point{len(self.joints) - 1}")
        sliding, travel = base == driver, STROKE * self.draft.size()
        name = ("slide" if sliding else "motor") + (f"_{number + 1}" if number else "")
        if sliding:
            slides = self.joints[base].kind != "R" and self._pinned(base)
            self.draft.refuse(not slides, f"{what}: it is no slider (P or RP)")
            self.draft.travel(name, slot=f"slot_{self.names[base]}", law={"by": 0.0 if number else travel})
        else:
            self._add_turn(name, what, base, driver, {"by": 0.0 if number else 360.0})
        moves = "is constant" if number else f"moves by {travel:g}"
        self.draft.note(number or sliding, f"{name} ({what}) {moves}: Pyslvs stores no motion; change its law")

    def _add_turn(self, name: str, what: str, base: int, driver: int, law: dict[str, float]) -> None:
        if GROUND not in self._pinned(base):
            base, driver = driver, base
        shared = [link for link in self._pinned(base) if link in self._pinned(driver) and link != GROUND]
        fixed = GROUND in self._pinned(base) and shared
        self.draft.refuse(not fixed, f"{what}: one of the two must be fixed, and a link must join both")
        if not self.names[driver]:  # a point: it becomes a joint of its link
            place = self.draft.tracers.pop(f"Point{driver}")[1]
            self.names[driver] = self.draft.joint(f"Point{driver}", place, shared[0])
        self.draft.rotary(name, self.names[base], shared[0], arm=self.names[driver], law=law)

    def _pinned(self, number: int) -> tuple[str, ...]:
        """Return the links that a joint is a pin of."""
        joint = self.joints[number]
        return joint.bodies if joint.kind == "R" else joint.bodies[1:]


# -- expressions ----------------------------------------------------------------------------------


def joints_of(expression: str, source: str, line: int = 1) -> list[DrawnJoint]:
    """Return the joints of an expression that starts in a line of the file `source`.

    Raises ModelError, with the line, for what is no expression.
    """

    def place(at: int) -> FilePart:
        lines = text.count("\n", 0, at)
        return FilePart(f"{source}:{line + lines}")

    text, joints = _COMMENT.sub(lambda match: " " * len(match[0]), expression), []
    place(0).refuse(len(text) > MOST_CHARACTERS, f"the expression has more than {MOST_CHARACTERS} characters")
    start = _START.match(text)
    at = start.end() if start else 0
    while start and (match := _JOINT.match(text, at)):
        joints.append(_joint(match["kind"], match["parts"], place(match.start("start"))))
        at = match.end()
    rest = text[at:].lstrip()
    shown = rest.partition("\n")[0][:40]
    found = f"'{shown}'" if rest else "the end of the text"
    form = "M[...]" if start is None else "a joint such as J[R, P[0, 0], L[ground, L1]], or ']' at the end"
    place(len(text) - len(rest)).refuse(not start or rest.rstrip() != "]", f"expected {form}, got {found}")
    place(0).refuse(len(joints) > MOST, f"more than {MOST} joints are too many for one mechanism")
    return joints


def _joint(kind: str, text: str, place: FilePart) -> DrawnJoint:
    """Return a joint from its type and the text of its parts."""
    place.refuse(kind not in TYPES, f"expected a joint type ({', '.join(TYPES)}), got '{kind[:40]}'")
    parts = {word: [item.strip() for item in items.split(",") if item.strip()] for word, items in _PART.findall(text)}
    strange = [*(word for word in parts if word not in FORMS), *_PART.sub("", text).strip(", \t\r\n").split("\n")]
    expected = "A[...], color[...], P[...] or L[...] in a joint"
    place.refuse(any(strange), f"expected {expected}, got '{''.join(strange)[:40]}'")
    counts = {word: len(items) for word, items in parts.items()}
    lacking = {"P": counts.get("P") != 2, "L": "L" not in parts, "A": kind != "R" and counts.get("A") != 1}
    place.check({f"this joint has no {FORMS[word]}; add it": bad for word, bad in lacking.items()})
    numbers = [*parts["P"], *(parts.get("A") or ["0"])[:1]]
    expected = f"expected a number of at most {LARGEST:g}"
    place.check({f"{expected}, got '{text[:40]}'": not abs(number_of(text)) <= LARGEST for text in numbers})
    links, (x, y, angle) = tuple(parts["L"]), map(float, numbers)
    twice = [link for link, count in Counter(links).items() if count > 1]
    place.refuse(twice, f"link {''.join(twice[:1])[:40]} is named twice in one joint")
    return DrawnJoint(kind, links, (x, y), coordinates(cmath.rect(1.0, math.radians(angle % 360.0))), own=place)
