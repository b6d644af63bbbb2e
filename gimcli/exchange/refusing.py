"""Parts of files that are refused with a message that names their place."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from gimcli.errors import ModelError


class Refusing(ABC):
    """A part of a file."""

    @abstractmethod
    def refused(self, text: str) -> ModelError:
        """Return the error for this part, with its place."""

    def refuse(self, bad: object, text: str) -> None:
        """Raise ModelError if something is wrong with this part."""
        if bad:
            raise self.refused(text)


@dataclass(frozen=True)
class FilePlace(Refusing):
    """A place in a file, such as `file:3`."""

    where: str

    def refused(self, text: str) -> ModelError:
        """Return the error for this place."""
        return ModelError([f"{self.where}: {text}"])
