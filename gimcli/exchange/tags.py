"""Tags with attributes, read from XML that need not be well formed.

Programs that write XML by hand neither escape the text of attributes nor always leave a blank between two of them.
Entities and document types are refused, so that no text is expanded.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from gimcli.errors import ModelError
from gimcli.exchange.refusing import Refusing

MOST_TAGS = 50_000
"""Most tags, with those that end others, comments and other signs '<'."""
DEEPEST = 20
LONGEST_TAG = 20_000
"""Most characters from the name of a tag to its end; pictures are texts between tags."""

_NAME = re.compile(r"[A-Za-z][\w.-]*")
_ATTRIBUTE = re.compile(
    r"""(?P<key>[A-Za-z_][\w.:-]*)\s*=\s*
    (?: "(?P<whole>[^\n]{0,500}?)"(?=\s*(?:/?>|[A-Za-z_][\w.:-]*\s*=\s*["'])) | "(?P<double>[^"\n]{0,500})"
      | '(?P<single>[^'\n]{0,500})' | (?P<bare>[^\s"'<>/]{1,500}) )""",
    re.VERBOSE,
)
"""An attribute; its value may have quotes, if it ends where the tag or another attribute follows."""
_WORD = re.compile(r"[\w.:-]+|.", re.DOTALL)
_ESCAPES = {"&lt;": "<", "&gt;": ">", "&quot;": '"', "&apos;": "'", "&amp;": "&"}
_ESCAPE = re.compile("|".join(_ESCAPES))


@dataclass
class Tag:
    """A tag with its line in the file, its attributes as written, and the tags in it."""

    name: str
    line: int
    attributes: dict[str, str] = field(default_factory=dict)
    children: list[Tag] = field(default_factory=list)


def read_tags(text: str, source: str, parents: Mapping[str, tuple[str, ...]]) -> Tag:
    """Return the first tag of a text with all tags in it; text between tags is ignored.

    `parents` names the tags that a tag may be in: a tag whose end is missing ends where another one begins that cannot
    be in it. Raises ModelError for a text that ends too early, and for entities.
    """
    return _Reading(text, source, parents).root()


class _Reading(Refusing):
    def __init__(self, text: str, source: str, parents: Mapping[str, tuple[str, ...]]) -> None:
        self.text, self.source, self.parents = text, source, parents
        self.at = self.counted = 0
        self.line = 1
        self.open: list[Tag] = []
        self.tags = 0

    def refused(self, text: str) -> ModelError:
        return ModelError([f"{self.source}:{self.line}: {text}"])

    def move(self, to: int) -> None:
        """Go on at a place of the text; count the lines up to it."""
        self.line += self.text.count("\n", self.counted, to)
        self.at = self.counted = to

    def past(self, mark: str) -> None:
        """Go on after a mark."""
        end = self.text.find(mark, self.at)
        self.refuse(end < 0, f"the text ends before '{mark}': the file is not complete")
        self.move(end + len(mark))

    def root(self) -> Tag:
        found: Tag | None = None
        while found is None or self.open:
            start = self.text.find("<", self.at)
            missing = f"</{self.open[0].name}>" if self.open else "its first tag"
            self.refuse(start < 0, f"the text ends before {missing}: the file is not complete")
            self.move(start)
            self.tags += 1
            self.refuse(self.tags > MOST_TAGS, f"more than {MOST_TAGS} tags are too many")
            tag = self.next()
            found = found or tag
        return found

    def next(self) -> Tag | None:
        """Read what starts at a '<'; return the tag if it is one."""
        if self.text.startswith("<!--", self.at):
            self.past("-->")
        elif self.text.startswith("<?", self.at):
            self.past("?>")
        elif self.text.startswith("<!", self.at):
            raise self.refused("document types, entities and marked sections ('<!') are not read; remove them")
        elif self.text.startswith("</", self.at):
            name = _NAME.match(self.text, self.at + 2)
            self.past(">")
            self.end(name[0] if name else "")
        elif match := _NAME.match(self.text, self.at + 1):
            return self.start(match)
        else:
            self.move(self.at + 1)  # a '<' in a text
        return None

    def start(self, name: re.Match[str]) -> Tag:
        tag = Tag(name[0], self.line)
        closed = self.attributes(tag, name.end())
        allowed = self.parents.get(tag.name, ())
        if any(parent.name in allowed for parent in self.open):
            while self.open[-1].name not in allowed:
                self.open.pop()
        if self.open:
            self.open[-1].children.append(tag)
        if not closed:
            self.open.append(tag)
        self.refuse(len(self.open) > DEEPEST, f"<{tag.name}>: tags are nested more than {DEEPEST} deep")
        return tag

    def attributes(self, tag: Tag, at: int) -> bool:
        """Read the attributes up to the end of a tag; return whether the tag closes itself."""
        start = at
        while at < min(len(self.text), start + LONGEST_TAG):
            if match := _ATTRIBUTE.match(self.text, at):
                value = next((v for v in match.groups()[1:] if v is not None), "")
                tag.attributes.setdefault(match["key"], _ESCAPE.sub(lambda m: _ESCAPES[m[0]], value))
                at = match.end()
            elif self.text[at] == ">":
                self.move(at + 1)
                return self.text[at - 1] == "/"
            elif self.text[at] == "<":
                break
            else:  # part of a text with quotes
                word = _WORD.match(self.text, at)
                at = word.end() if word else at + 1
        raise self.refused(
            f"<{tag.name} has no end ('>') within {LONGEST_TAG} characters: the file is damaged or not complete"
        )

    def end(self, name: str) -> None:
        """Close a tag, and those in it whose end is missing."""
        if any(tag.name == name for tag in self.open):
            while self.open.pop().name != name:
                pass
