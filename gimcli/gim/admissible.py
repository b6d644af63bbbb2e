"""Admissible sequences: all that satisfy both fundamental conditions of Petuya et al. 2004, in an order of priority.

This goes further than the rules of the paper (`rules`): every free node is moved twice and every restriction imposed
once by a matching, so a walk never ends before the sequence is complete. Each next move has the first of these labels
that is possible: `settle`, a node P1 is moved about settled nodes (P or P2); `start`, a node P0 is moved about a node
carried by an input, or about nodes P2; `extend`, a node P0 is moved about a node P1; `other`, another move.
"""

from __future__ import annotations

from collections.abc import Iterator, Set

from gimcli.structure.restrictions import Move, Restriction

VISITS = 20_000
"""Greatest number of states visited in the search for sequences."""

Owner = dict[int, int]
"""{number of restriction: node that it moves}, for all moves that are still needed."""


class Walk:
    """Depth-first enumeration of the sequences of one group."""

    def __init__(self, restrictions: list[Restriction], inside: set[int], carried: Set[int]) -> None:
        self.restrictions, self.inside, self.carried = restrictions, inside, carried
        self.movable = [tuple(n for n in r.movable if n in inside) for r in restrictions]
        self.offers = {n: [k for k, at in enumerate(self.movable) if n in at] for n in inside}
        self.visits = 0

    def sequences(self) -> Iterator[tuple[Move, ...]]:
        """Yield the sequences; those that differ only in the order of independent moves are yielded once."""
        owner: Owner = {}
        if all(self._augment(node, owner, set(), set()) for node in sorted(self.inside) for _ in range(2)):
            yield from self._walk(dict.fromkeys(self.inside, 0), [], owner, set(), [])

    def _augment(self, node: int, owner: Owner, gone: set[int], seen: set[int]) -> bool:
        """Match one more restriction to a node by an alternating path; return whether there is one."""
        for k in self.offers[node]:
            if k in seen or k in gone or owner.get(k) == node:
                continue
            seen.add(k)
            if k not in owner or self._augment(owner[k], owner, gone, seen):
                owner[k] = node
                return True
        return False

    def _after(self, k: int, node: int, owner: Owner, gone: set[int]) -> Owner | None:
        """Return the matching after a move; None if a node could not get its two moves then."""
        after = {r: n for r, n in owner.items() if r != k}
        loser = owner.get(k, -1)
        if loser not in (node, -1):  # the moved node has one restriction more than it needs, for the other node
            return self._shed(after, node, loser, k, gone)
        if loser == -1:
            del after[next(r for r, n in after.items() if n == node)]
        return after

    def _shed(self, after: Owner, node: int, loser: int, k: int, gone: set[int]) -> Owner | None:
        """Remove each restriction of the moved node in turn and try to match the node `loser` again."""
        trials = ({q: n for q, n in after.items() if q != r} for r, n in after.items() if n == node)
        return next((trial for trial in trials if self._augment(loser, trial, gone | {k}, set())), None)

    def _options(self, counts: dict[int, int], gone: set[int]) -> list[tuple[int, int, str]]:
        """Return the possible moves (restriction, node, label) of the highest priority."""
        found = [
            (self._tier(r, node, counts), k, node)
            for k, r in enumerate(self.restrictions)
            if k not in gone
            for node in self.movable[k]
            if counts[node] < 2
        ]
        best = min(found)[0] if found else None
        return [(k, node, tier[1]) for tier, k, node in found if tier == best]

    def _tier(self, r: Restriction, node: int, counts: dict[int, int]) -> tuple[int, str]:
        others = [n for n in r.nodes if n != node]
        done = min((counts.get(n, 2) for n in others), default=2)
        if counts[node] == 1:
            return (0, "settle") if done == 2 else (4 - done, "other")
        leads = r.driven or any(n in self.carried or n in self.inside for n in others)
        if done == 2 and leads:
            return 1, "start"
        return (2, "extend") if done == 1 else (4, "other")

    def _walk(
        self, counts: dict[int, int], moves: list[tuple[int, int, str]], owner: Owner, gone: set[int],
        asleep: list[tuple[int, int, str]],
    ) -> Iterator[tuple[Move, ...]]:  # fmt: skip
        self.visits += 1
        if all(c == 2 for c in counts.values()):
            yield self._finished(moves, gone)
            return
        asleep = list(asleep)  # sleep set: moves whose orders an earlier sibling has already enumerated
        for move in self._options(counts, gone):
            if self.visits > VISITS:
                return
            if move in asleep:
                continue
            k, node, _ = move
            after = self._after(k, node, owner, gone)
            if after is not None:
                still = [m for m in asleep if self._independent(m, move)]
                more = {**counts, node: counts[node] + 1}
                yield from self._walk(more, [*moves, move], after, gone | {k}, still)
            asleep.append(move)

    def _independent(self, a: tuple[int, int, str], b: tuple[int, int, str]) -> bool:
        return a[1] not in self.restrictions[b[0]].nodes and b[1] not in self.restrictions[a[0]].nodes

    def _finished(self, moves: list[tuple[int, int, str]], gone: set[int]) -> tuple[Move, ...]:
        """Return the moves; restrictions beyond two for each node are redundant and are imposed last."""
        done = (Move(self.restrictions[k], node, rule) for k, node, rule in moves)
        spare = (k for k in range(len(self.restrictions)) if k not in gone and self.movable[k])
        return (*done, *(Move(self.restrictions[k], self.movable[k][0], "surplus") for k in spare))
