"""Exceptions for invalid input, for structures that cannot be driven and for failed output.

The numerical outcome of a solution is not an exception but a `Status` (see `gimcli.status`).
"""

from __future__ import annotations

import errno

REASONS = {
    errno.ENOENT: "no such file or folder", errno.EACCES: "no permission", errno.EPERM: "no permission",
    errno.EROFS: "the disk is read-only", errno.EISDIR: "it is a folder",
    errno.ENOTDIR: "a part of the path is a file, not a folder", errno.EEXIST: "the name exists",
    errno.ENOSPC: "the disk is full", errno.EDQUOT: "the disk is full", errno.ENAMETOOLONG: "the name is too long",
    errno.ELOOP: "its links lead to each other", errno.EMFILE: "too many open files", errno.EIO: "the disk fails",
    errno.EADDRINUSE: "the port is in use", errno.EADDRNOTAVAIL: "no such address",
    errno.EPIPE: "the reader has ended",
}  # fmt: skip
"""Errors of the operating system, whose own texts depend on the machine."""

SYNTAX = "check brackets, quotes, commas and colons here and before"
"""What to do in a place where a text cannot be read."""


def reason(error: OSError) -> str:
    """Return why the operating system refuses a file or a port."""
    return REASONS.get(error.errno or 0, f"the operating system refuses it (error {error.errno})")


class GimError(Exception):
    """An error that the user can correct; the message states where it is, its cause and the correction."""

    exit_code = 1


class UsageError(GimError):
    """An argument or option that is invalid, or does not fit the model."""

    exit_code = 2


def refuse(*cases: tuple[object, str], error: type[Exception] = UsageError) -> None:
    """Raise an error with the text of the first case whose condition holds."""
    for holds, text in cases:
        if holds:
            raise error(text)


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
