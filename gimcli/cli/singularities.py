"""`gim singularities`: limits, dead points, change points and stationary positions of a circuit."""

from __future__ import annotations

from gimcli.branching.singularities import STATIONARY
from gimcli.cli.console import print_records, print_remarks
from gimcli.cli.from_verb import from_verb
from gimcli.library.singularities import SingularitiesResult, singularities
from gimcli.rounding import how_it_ends, intervals

HELP = (
    "The circuit of the initial configuration is followed, and every branch that crosses it. limit: the input turns"
    " back. dead point: the input rate is zero while the mechanism moves. change point: branches cross. tangency: the"
    " constraints lose rank, but only one branch continues. stationary: a rocker or slider turns back."
)
EXAMPLES = ("gim singularities parallelogram -o positions.png",)


def _print(result: SingularitiesResult) -> None:
    found, mechanism = result._found, result.mechanism
    print_records(mechanism.name, result._records, "number", "kind", "at", "branches", "about", "rates")
    print_remarks(
        (
            all(one.what.kind == STATIONARY for one in found.found),
            "no limit, dead point, change point or tangency",
        ),
        *(
            f"branch {k}: {how_it_ends(one.closed, one.ended, one.turns)}; range of"
            f" {intervals(mechanism, result._interval(k - 1), one.turns)}"
            for k, one in enumerate(found.branches.circuits, 1)
        ),
        (not found.complete, "there are more branches than were followed"),
    )


command = from_verb(singularities, SingularitiesResult, _print)
