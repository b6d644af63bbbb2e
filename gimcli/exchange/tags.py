"""Tags with attributes, read from XML that need not be well formed.

Programs that write XML by hand neither escape the text of attributes nor always leave a blank between two of them.
Entities and document types are refused, so that no text is expanded.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, field

from gimcli.errors import ModelError
from gimcli.exchange.records import Refusing

MOST_TAGS = 50_000
"""Most tags, with those that end others, comments and other signs '<'."""
DEEPEST = 20
LONGEST_TAG = 20_000
"""Most characters from the name of a tag to its end; pictures are texts between tags."""

_NAME = re.compile(r"[A-Za-z][\w.-]*")
_ATTRIBUTE = re.compile(
    r"""(?P<key>[A-Za-z_][\w.:-]*)\s*=\s*
    (?: "(?P<whole>[^\n]{0,500}?)"(?=\s*(?:/?>|[A-Za-z_][\w.:-]*\s*=\s*["'])) | "(?P<double>[^"\n]{0,500})"
      | '(?P<single>[^'\n]{0,500})' | (?P<bare>[^\s"'<>/]{1,500}) )
    | (?P<end>>) | [\w.:-]+ | [^<]""",
    re.VERBOSE,
)
"""An attribute, the end of the tag, or part of a text with quotes.

The value of an attribute may have quotes, if it ends where the tag or another attribute follows.
"""
_ESCAPES = {"&lt;": "<", "&gt;": ">", "&quot;": '"', "&apos;": "'", "&amp;": "&"}
_ESCAPE = re.compile("|".join(_ESCAPES))
_ENDS = {"!--": "-->", "?": "?>", "/": ">"}
"""What ends comments, instructions, and the ends of tags, by the signs after '<'."""


@dataclass
class Tag:
    """A tag with its line in the file, its attributes without blanks around them, and the tags in it."""

    name: str
    line: int
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[Tag] = field(default_factory=list)

    def inside(self, *names: str) -> list[Tag]:
        """Return the tags of some names in this one."""
        return [child for child in self.children if child.name in names]


def read_tags(text: str, source: str, parents: Mapping[str, tuple[str, ...]]) -> Tag:
    """Return the first tag of a text with all tags in it; text between tags is ignored.

    `parents` names the tags that a tag may be in: a tag whose end is missing ends where another one begins that cannot
    be in it. Raises ModelError for a text that ends too early, and for entities.
    """
    return _TagReading(text, source, parents).root()


class _TagReading(Refusing):
    """The text from `at` on; `open` are the tags that are not ended."""

    def __init__(self, text: str, source: str, parents: Mapping[str, tuple[str, ...]]) -> None:
        self.text, self.source, self.parents = text, source, parents
        self.at = 0
        self.lines = [match.start() for match in re.finditer("\n", text)]
        self.open: list[Tag] = []

    def refused(self, text: str) -> ModelError:
        return ModelError([f"{self.source}:{self.line()}: {text}"])

    def line(self) -> int:
        return bisect_left(self.lines, self.at) + 1

    def find(self, mark: str, missing: str) -> int:
        """Return the index of the next mark."""
        found = self.text.find(mark, self.at)
        self.refuse(found < 0, f"the text ends before {missing}: the file is not complete")
        return found

    def root(self) -> Tag:
        found: Tag | None = None
        for _ in range(MOST_TAGS):
            self.at = self.find("<", f"</{self.open[0].name}>" if self.open else "its first tag")
            found = self.next() or found
            if found and not self.open:
                return found
        raise self.refused(f"more than {MOST_TAGS} tags are too many")

    def next(self) -> Tag | None:
        """Read what starts at a '<'; return the outermost tag if it is one."""
        if name := _NAME.match(self.text, self.at + 1):
            return self.start(name[0])
        sign = next((sign for sign in _ENDS if self.text.startswith(sign, self.at + 1)), "")
        if sign == "/" and (name := _NAME.match(self.text, self.at + 2)):
            self.end(name[0])
        self.refuse(
            not sign and self.text.startswith("!", self.at + 1),
            "document types, entities and marked sections ('<!') are not read; remove them",
        )
        self.at = self.find(_ENDS[sign], f"'{_ENDS[sign]}'") + len(_ENDS[sign]) if sign else self.at + 1
        return None

    def start(self, name: str) -> Tag:
        tag = Tag(name, self.line())
        end = self.attributes(tag, self.at + 1 + len(name))
        allowed = self.parents.get(name, ())
        while any(one.name in allowed for one in self.open) and self.open[-1].name not in allowed:
            self.open.pop()
        if self.open:
            self.open[-1].children.append(tag)
        self.open += [] if self.text[end - 2] == "/" else [tag]
        self.refuse(len(self.open) > DEEPEST, f"<{name}>: tags are nested more than {DEEPEST} deep")
        self.at = end
        return self.open[0] if self.open else tag

    def attributes(self, tag: Tag, at: int) -> int:
        """Read the attributes up to the end of a tag; return the index behind the end."""
        last = at + LONGEST_TAG
        while (match := _ATTRIBUTE.match(self.text, at)) and not match["end"] and match.end() < last:
            if match["key"]:
                value = next((v for v in match.groups()[1:5] if v is not None), "")
                tag.attributes.setdefault(match["key"], _ESCAPE.sub(lambda m: _ESCAPES[m[0]], value).strip())
            at = match.end()
        if match and match["end"]:
            return match.end()
        cure = f"has no end ('>') within {LONGEST_TAG} characters: the file is damaged or not complete"
        raise self.refused(f"<{tag.name} {cure}")

    def end(self, name: str) -> None:
        """Close a tag, and those in it whose end is missing."""
        while any(tag.name == name for tag in self.open) and self.open.pop().name != name:
            pass
