"""The shipped models as templates: what each one is, its text, and its files in another folder."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from gimcli import output, shipped
from gimcli.errors import OutputError, UsageError, refuse

THEMES = {
    "Four-bars and slider-cranks": (
        "crank_rocker", "four_bar_lengths", "double_crank", "parallelogram", "parallelogram_third_crank",
        "antiparallelogram", "galloway_kite", "slider_crank", "scotch_yoke", "elliptic_trammel", "gim_fig13a",
    ),
    "Quick return": ("crank_shaper", "whitworth"),
    "Straight lines and copied curves": (
        "hoeken", "chebyshev", "chebyshev_lambda", "watt_straight_line", "scott_russell", "peaucellier",
        "hart_a_frame", "pantograph",
    ),
    "Walking legs": ("jansen", "klann", "plantigrade"),
    "Six-bars": (
        "watt_1", "watt_2", "stephenson_1", "stephenson_2", "stephenson_3", "stephenson_3_far", "gim_fig13b",
    ),
    "Eight and more bars, strongly coupled groups": (
        "double_butterfly", "double_butterfly_symmetric", "gim_fig13c", "ten_bar", "innocenti_group", "dixon_k33",
    ),
    "Several inputs and platforms": ("five_bar", "gim_fig11", "platform_3rpr", "platform_3rrr", "floating_hexagon"),
    "Lifts": ("scissor_lift",),
    "Gears, belts and racks": (
        "geared_five_bar", "cardan_gear", "planetary_gear", "belt_drive", "rack_lift", "deltoid",
    ),
    "Forces and dynamics: engines, presses and machine tools": (
        "engine", "punch", "knuckle_press", "crank_press", "shaper", "pump_jack",
    ),
    "Forces and dynamics: cylinders, springs and dampers": (
        "excavator", "lift_table", "suspension", "hatch", "garage_door", "toggle_clamp", "snap_hinge",
        "balanced_lamp", "spring_block",
    ),
    "Forces and dynamics: swings, legs, robots, wipers": (
        "swing", "double_pendulum", "watt_durango", "strandbeest", "pick_and_place", "wiper",
    ),
}  # fmt: skip
"""The models by theme, in the order of the list."""

OTHER = "Other"
"""Theme of models that no theme names."""


@dataclass(frozen=True)
class ShippedModel:
    """A shipped model: a complete model file with comments, and the tables that it names."""

    name: str
    theme: str
    path: Path

    @cached_property
    def text(self) -> str:
        """The text of the model file."""
        return self.path.read_text(encoding="utf-8")

    @property
    def title(self) -> str:
        """The `name` of the model file."""
        return str(self._data.get("name", self.name))

    @property
    def source(self) -> str:
        """The `source` of the model file."""
        return " ".join(str(self._data.get("source", "")).split())

    @property
    def massive(self) -> bool:
        """Whether the file has masses, so that `forces`, `simulate` and `reduce` can be used."""
        return bool(self._data.get("masses"))

    @property
    def tables(self) -> tuple[str, ...]:
        """Names of the tables that the file reads."""
        from gimcli.model.tables import tables_of

        return tables_of(self._data)

    @cached_property
    def _data(self) -> Mapping[str, Any]:
        from gimcli.model.source import read_yaml

        data: Mapping[str, Any] = read_yaml(self.text, self.path).data
        return data

    def report(self) -> dict[str, Any]:
        """Return what `gim new --list --json` prints of this model."""
        return {
            "name": self.name, "title": self.title, "theme": self.theme, "source": self.source,
            "masses": self.massive, "tables": list(self.tables),
        }  # fmt: skip

    def write(self, path: Path | str, force: bool = False) -> tuple[Path, ...]:
        """Write the model file, and its tables into the same folder; return the files.

        Args:
            path: the new file (`.yaml` or `.yml`), or a folder, which gets `NAME.yaml`. A name with a slash at its end,
                or without a suffix, is a folder.
            force: replace files that exist.

        Raises:
            UsageError: the path has another suffix.
            OutputError: a file exists and has other content, or cannot be written.
        """
        target = _target(path, self.path.name)
        files = {target.parent / table: self.path.parent / table for table in self.tables} | {target: self.path}
        content = {new: own.read_bytes() for new, own in files.items()}
        if not force:
            for new, data in content.items():
                _refuse_other(new, data)
        output.refuse_unwritable(files.values(), *content)
        for new, data in content.items():
            with output.written_bytes(new) as handle:
                handle.write(data)
        return tuple(reversed(content))


def shipped_models() -> tuple[ShippedModel, ...]:
    """Return all shipped models by themes: `.name`, `.title`, `.theme`, `.text`, `.write(path)`."""
    return tuple(_models())


def shipped_model(name: str) -> ShippedModel:
    """Return a shipped model by its name; raise UsageError for an unknown name."""
    path = shipped.path_of(name)
    if path is None:
        from gimcli.nearest import near

        raise UsageError(f"no shipped model is called '{name}'{near(name, shipped.names())} (`gim new --list`)")
    return next(model for model in _models() if model.path == path)


def _models() -> Iterator[ShippedModel]:
    theme_of = {name: theme for theme, own in THEMES.items() for name in own}
    for name in sorted(shipped.names(), key=[*theme_of, *shipped.names()].index):
        path = shipped.path_of(name)
        assert path is not None
        yield ShippedModel(name, theme_of.get(name, OTHER), path)


def _target(given: Path | str, name: str) -> Path:
    """Return the file to write for a path: the path, or the usual name in a folder."""
    path = Path(given)
    if str(given).endswith(("/", "\\")) or path.is_dir() or not path.suffix:
        return path / name
    refuse(
        (
            path.suffix.lower() not in (".yaml", ".yml"),
            f"{given}: expected a model file (.yaml, .yml) or a folder, got '{path.suffix}'",
        )
    )
    return path


def _refuse_other(path: Path, data: bytes) -> None:
    """Raise OutputError if a file exists and has other content."""
    if path.exists() and not (path.is_file() and path.read_bytes() == data):
        raise OutputError(f"{path}: exists already; choose another name or folder, or replace it by force")
