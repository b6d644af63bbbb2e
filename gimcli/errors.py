"""What bad input, an impossible structure and a failed output raise.

A numerical outcome is not an error: it is a `Status` (see `gimcli.status`).
"""

from __future__ import annotations


class GimError(Exception):
    """Something that the user can cure; its text says where, what was met and what to do."""

    exit_code = 1


class UsageError(GimError):
    """The command line asks for something that does not exist or does not fit."""

    exit_code = 2


class ModelError(GimError):
    """A model file that cannot be accepted; every fault of the file is one line."""

    exit_code = 3

    def __init__(self, faults: list[str]) -> None:
        self.faults = list(faults)
        super().__init__("\n".join(self.faults))


class StructureError(GimError):
    """A mechanism whose structure cannot be driven: free, over-driven or contradictory."""

    exit_code = 4


class UnassembledError(StructureError):
    """A mechanism for which no assembled position was found to begin with: a position that was not solved."""

    exit_code = 5


class OutputError(GimError):
    """A result that could not be written."""

    exit_code = 6
