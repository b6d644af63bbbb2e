"""Parts of files that are refused with a message that names their place."""

from __future__ import annotations

from gimcli.errors import ModelError


class Refusing:
    """A part of a file."""

    def refused(self, text: str) -> ModelError:
        """Return the error for this part, with its place."""
        raise NotImplementedError

    def refuse(self, bad: object, text: str) -> None:
        """Raise ModelError if something is wrong with this part."""
        if bad:
            raise self.refused(text)
