"""A model as written in its file: the places of its keys, its dimensions, and other values for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

from gimcli.calculus.numbers import FUNCTIONS
from gimcli.mechanism import Machine, Mechanism
from gimcli.model.schema import Model
from gimcli.model.source import Source, Where

if TYPE_CHECKING:
    from gimcli.calculus.recorded import Recording
    from gimcli.model.dimensions import Dimension


@dataclass(frozen=True)
class Written:
    """A model as written, and the places of its keys."""

    model: Model
    source: Source
    changes: Mapping[str, float | str] = field(default_factory=dict)  # of dimensions, by name, since it was read

    @cached_property
    def dimensions(self) -> dict[str, Dimension]:
        """The dimensions by name, parameters first."""
        from gimcli.model.dimensions import dimensions_of  # imported late: many commands need no names

        return dimensions_of(self.model)

    def dimension(self, name: str) -> Dimension:
        """Return a dimension by its name; the name of a link stands for its length. Raise UsageError for others."""
        from gimcli.model.dimensions import found

        return found(self.dimensions, name, self.model.open.parts)

    def substituted(self, changes: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]) -> Model:
        """Return the model with other dimensions, without any check; see `substitution.substituted`."""
        from gimcli.model.substitution import substituted

        return substituted(self.model, changes, functions)

    def changed(self, mechanism: Mechanism, changes: Mapping[str, float | str]) -> Mechanism:
        """Return the mechanism of this model with other dimensions; see `Mechanism.with_`."""
        from gimcli.model.changed_model import changed

        return changed(self, mechanism, changes)

    def machines(self, mechanism: Mechanism, structures: bool, loaded: bool = False) -> tuple[Machine, ...]:
        """Return the independent machines of the mechanism of this model; see `machine_models.machines`."""
        from gimcli.model.machine_models import machines

        return machines(self, mechanism, structures, loaded)

    def recorded(
        self, mechanism: Mechanism, names: Sequence[str], dynamics: bool = False
    ) -> tuple[Mechanism, Recording]:
        """Return the mechanism with recorded numbers as dimensions, in its normal frame, and the recording.

        The variables of the recording are the dimensions, in the file's units. Without `dynamics` it has no masses and
        forces.
        """
        from gimcli.calculus.recorded import Recording
        from gimcli.model.compile import compile_model
        from gimcli.model.substitution import without_dynamics

        recording = Recording()
        changes = {name: recording.variable(self.dimension(name).value) for name in names}
        model = self.placed(self.substituted(changes, FUNCTIONS))
        model = model if dynamics else without_dynamics(model)
        return compile_model(model, self.source.folder, (mechanism.origin, mechanism.scale)), recording

    def placed(self, model: Model) -> Model:
        """Return a model with other dimensions, with new positions of the nodes without coordinates."""
        if not self.model.open.parts:
            return model
        from gimcli.model.placing import placed_again

        return placed_again(model, self.source.folder)

    def place(self, where: Where) -> str:
        """Return file and line of a part, or its path of keys if the model was not read from a file."""
        if not self.source.by_line:
            return f"{self.source.path}: {'.'.join(map(str, where))}" if where else str(self.source.path)
        while where and where not in self.source.keys:
            where = where[:-1]
        line, _ = self.source.keys.get(where, (1, 1))
        return f"{self.source.path}:{line}"

    def member(self, name: str) -> Where:
        """Return the path of a member's key."""
        return ("ground",) if name == "ground" else ("links" if name in self.model.links else "elements", name)
