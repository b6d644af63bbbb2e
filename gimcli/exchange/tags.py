"""Tags with attributes as parts of a file, read from XML that need not be well formed.

Programs that write XML by hand neither escape the text of attributes nor always leave a blank between two of them.
Entities and document types are refused, so that no text is expanded.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xml.sax.saxutils import unescape

from gimcli.exchange.records import FilePart

MOST_TAGS = 50_000
"""Most tags, with those that end others, comments and other signs '<'."""
DEEPEST = 20
LONGEST_TAG = 20_000
"""Most characters from the name of a tag to its end; pictures are texts between tags."""

_START = re.compile(r"(?P<mark>!--|[?/!]?)(?P<name>[A-Za-z][\w.-]*)?")
"""What follows a '<'."""
_ATTRIBUTE = re.compile(
    r"""(?P<key>[A-Za-z_][\w.:-]*)\s*=\s*
    (?: "(?P<whole>[^\n]{0,500}?)"(?=\s*(?:/?>|[A-Za-z_][\w.:-]*\s*=\s*["'])) | "(?P<double>[^"\n]{0,500})"
      | '(?P<single>[^'\n]{0,500})' | (?P<bare>[^\s"'<>/]{1,500}) )
    | (?P<end>/?>) | [\w.:-]+ | [^<]""",
    re.VERBOSE,
)
"""An attribute, the end of the tag, or part of a text with quotes.

The value of an attribute may have quotes, if it ends where the tag or another attribute follows.
"""
_QUOTES = {"&quot;": '"', "&apos;": "'"}
_ENDS = {"!--": "-->", "?": "?>", "/": ">"}
"""What ends comments, instructions, and the ends of tags, by the signs after '<'."""


@dataclass
class Tag(FilePart):
    """A tag: its attributes without blanks around them, and the tags in it by the plural of their names."""

    name: str = ""


def read_tags(text: str, source: str, parents: Mapping[str, tuple[str, ...]]) -> Tag:
    """Return the first tag of a text with all tags in it; text between tags is ignored.

    `parents` names the tags that are read in others, and these: a tag whose end is missing ends where another one
    begins that cannot be in it. Raises ModelError for a text that ends too early, and for entities.
    """
    open_tags, at, first = [Tag(source, {})], 0, None
    lines = [match.start() for match in re.finditer("\n", text)]
    for _ in range(MOST_TAGS):
        start = text.find("<", at)
        line = bisect_left(lines, max(start, at)) + 1
        place = FilePart(f"{source}:{line}")
        missing = f"</{open_tags[1].name}>" if open_tags[1:] else "its first tag"
        match = _START.match(text, start + 1)
        mark, name = (match["mark"], match["name"] or "") if match else ("", "")
        end = text.find(_ENDS.get(mark, ""), start)
        place.check({
            f"the text ends before {missing}: the file is not complete": start < 0,
            f"the text ends before '{_ENDS.get(mark)}': the file is not complete": end < 0,
            "document types, entities and marked sections ('<!') are not read; remove them": mark == "!",
        })  # fmt: skip
        at = max(start + 1, end + len(_ENDS.get(mark, "")))
        if mark == "/" and any(tag.name == name for tag in open_tags[1:]):  # the end of those in it is missing
            while open_tags.pop().name != name:
                pass
        elif not mark and name:
            tag, at = _tag(name, text, start + 1 + len(name), place)
            tag.value |= {f"{child}s": [] for child, owners in parents.items() if name in owners}
            allowed = parents.get(name, ())
            while any(one.name in allowed for one in open_tags) and open_tags[-1].name not in allowed:
                open_tags.pop()
            open_tags[-1].value.get(f"{name}s", []).append(tag)
            open_tags += [] if text[at - 2] == "/" else [tag]
            place.refuse(len(open_tags) > DEEPEST + 1, f"<{name}>: tags are nested more than {DEEPEST} deep")
            first = first or tag
        if first and not open_tags[1:]:
            return first
    raise place.refused(f"more than {MOST_TAGS} tags are too many")


def _tag(name: str, text: str, at: int, place: FilePart) -> tuple[Tag, int]:
    """Return a tag with its attributes, which start at an index of the text, and the index behind its end."""
    own, last = dict[str, Any](), at + LONGEST_TAG
    while (match := _ATTRIBUTE.match(text, at)) and match.end() < last:
        at = match.end()
        if match["end"]:
            return Tag(f"{place.place}: {name} {own.get('id', '')}".strip(), own, texts=True, name=name), at
        if match["key"]:
            value = next((v for v in match.groups()[1:5] if v is not None), "")
            own.setdefault(match["key"], unescape(value, _QUOTES).strip())
    cure = f"has no end ('>') within {LONGEST_TAG} characters: the file is damaged or not complete"
    raise place.refused(f"<{name} {cure}")
