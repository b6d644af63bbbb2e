"""`gim groups`: the driving links and Assur groups of a mechanism."""

from __future__ import annotations

from gimcli.cli.console import print_records
from gimcli.cli.from_verb import from_verb
from gimcli.library.groups import GroupsResult, groups

HELP = (
    "Groups are listed in the order of formation, with class and order. 2,0^(3,4) is a group of 2 links that adds 0"
    " degrees of freedom: links 3 and 4. Links are numbered in the order of formation; the frame is 0."
)
EXAMPLES = ("gim groups watt_1 -o watt_1.groups.png",)


def _print(result: GroupsResult) -> None:
    print_records(result.headline(), result._records)


command = from_verb(groups, GroupsResult, _print, assembled=False)
