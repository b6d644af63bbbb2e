"""Exceptions for invalid input, for structures that cannot be driven and for failed output.

The numerical outcome of a solution is not an exception but a `Status` (see `gimcli.status`).
"""

from __future__ import annotations


class GimError(Exception):
    """An error that the user can correct; the message states where it is, its cause and the correction."""

    exit_code = 1


class UsageError(GimError):
    """An argument or option that is invalid, or does not fit the model."""

    exit_code = 2


class ModelError(GimError):
    """An invalid model file; the message has one line for each error in the file."""

    exit_code = 3

    def __init__(self, faults: list[str]) -> None:
        self.faults = list(faults)
        super().__init__("\n".join(self.faults))


class StructureError(GimError):
    """A mechanism that its actuators cannot drive: undriven, over-driven or contradictory."""

    exit_code = 4


class UnassembledError(StructureError):
    """A mechanism for which no assembled start position was found."""

    exit_code = 5


class OutputError(GimError):
    """An output file that could not be written."""

    exit_code = 6
