"""The name that was probably meant by a misspelt one."""

from __future__ import annotations

from collections.abc import Collection, Iterable

MOST_WORDS = 5_000
"""Most names that are searched for a similar one: the search is slow."""


def nearest(word: str, words: Collection[str]) -> str | None:
    """Return the most similar of some words; None if none is similar."""
    if len(words) > MOST_WORDS:
        return None
    import difflib

    folded = [w for w in words if w.lower() == word.lower()]
    best = folded or difflib.get_close_matches(word, list(words), 1, 0.6)
    return best[0] if best else None


def near(word: str, words: Collection[str]) -> str:
    """Return '; did you mean X?' if one of some words is similar, else ''."""
    best = nearest(word, words)
    return f"; did you mean '{best}'?" if best else ""


def guess(word: str, known: Iterable[str], what: str = "known", most: int | None = None) -> str:
    """Return 'did you mean X?' with a similar word, else all words after a heading, or the first ones of them."""
    words = list(dict.fromkeys(known))
    best = nearest(word, words)
    listed = f"{', '.join(words[:most]) or 'none'}{', ...' * (len(words) > len(words[:most]))}"
    return f"did you mean '{best}'?" if best else f"{what}: {listed}"
