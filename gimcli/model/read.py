"""Reading a mechanism from a model file, YAML text or plain data, with the same checks and the same compiler."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gimcli.calculus.numbers import FUNCTIONS
from gimcli.errors import ModelError
from gimcli.mechanism import Machine, Mechanism
from gimcli.model.check import checked
from gimcli.model.compile import compile_model
from gimcli.model.schema import Model
from gimcli.model.source import DEEPEST, PlacedError, Source, Where, read_source, read_yaml
from gimcli.model.tables import files_read

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
        """Return the model with other dimensions, without any check; formulas are evaluated again where they change.

        Args:
            changes: values by the names of dimensions: numbers, or any objects with Python's operators.
            functions: the functions of formulas for these objects, by name.
        """
        from gimcli.model.arithmetic import with_numbers

        wanted = {self.dimension(name).where: value for name, value in changes.items()}
        return with_numbers(self.model, wanted, lambda _, formula, values: formula.value(values, functions))[0]

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

        recording = Recording()
        changes = {name: recording.variable(self.dimension(name).value) for name in names}
        model = self.substituted(changes, FUNCTIONS)
        if model.open.parts:
            from gimcli.model.placing import placed_again

            model = placed_again(model, self.source.folder)
        model = model if dynamics else model.without_dynamics()
        return compile_model(model, self.source.folder, (mechanism.origin, mechanism.scale)), recording

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


NAME = "mechanism"
PLAIN: Sequence[tuple[Any, Callable[[Any], Any]]] = (
    (bool | None, lambda value: value), (str, str.__str__), (Integral, int), (Real, float), (Path, str),
)  # fmt: skip
"""The functions that return a scalar value as one that YAML can write, by its type."""


def read_file(path: Path, folder: Path | None = None) -> Mechanism:
    """Read, validate and compile a model file; the paths of tables start at `folder`, by default the file's folder.

    Raises ModelError with all errors of the file.
    """
    folder = path.parent if folder is None else folder
    return _mechanism(read_source(path), folder, path.stem, path)


def read_text(text: str, folder: Path) -> Mechanism:
    """Read, validate and compile a model given as YAML text; raise ModelError with all errors."""
    return _mechanism(read_yaml(text, Path("<text>")), folder, NAME)


def read_data(
    data: Mapping[str, Any],
    folder: Path,
    source: str = "<dict>",
    left_out: Sequence[str] = (),
    path: Path | None = None,
) -> Mechanism:
    """Validate and compile a model given as plain data; errors name keys instead of lines.

    Of a mechanism of another program, `source` names the file in messages, `left_out` what did not come over; `path` is
    None for an address.
    """
    from gimcli.model.yaml_text import yaml_text

    own = read_yaml(yaml_text(_plain(data, ()), left_out) or "{}", Path(source))
    own.by_line = False
    return replace(_mechanism(own, folder, path.stem if path else NAME, path), left_out=tuple(left_out))


def _mechanism(source: Source, folder: Path, name: str, path: Path | None = None) -> Mechanism:
    source.folder = folder
    model = checked(source)
    model.name = model.name or name
    try:
        compiled, files = compile_model(model, folder), files_read(model, path, folder)
    except PlacedError as error:
        source.fault(error.where, str(error), key=True)
        raise source.error() from None
    return replace(compiled, files=files, path=path, written=Written(model, source))


def _plain(value: Any, where: tuple[Any, ...]) -> Any:
    """Return a value as dicts, lists, text and Python numbers, which YAML can write; `where` is its path of keys."""
    if len(where) > DEEPEST:
        raise ModelError([f"<dict>: {'.'.join(map(str, where[:4]))}...: nested too deeply for a model"])
    if isinstance(value, Mapping):
        names = ["on" if key is True else str(key) for key in value]  # YAML 1.1 parsers read the key `on` as true
        for twice in (name for name, count in Counter(names).items() if count > 1):
            raise ModelError([f"<dict>: {'.'.join(map(str, (*where, twice)))}: given twice; remove one"])
        return {name: _plain(part, (*where, name)) for name, part in zip(names, value.values(), strict=True)}
    for kind, plain in PLAIN:
        if isinstance(value, kind):
            return plain(value)
    if hasattr(value, "tolist"):
        return _plain(value.tolist(), where)
    if isinstance(value, Sequence) and not isinstance(value, bytes | bytearray):
        return [_plain(part, (*where, k)) for k, part in enumerate(value)]
    text = f"expected a number, text, a list or a dict, got a value of type {type(value).__name__}"
    raise ModelError([f"<dict>: {'.'.join(map(str, where))}: {text}"])
