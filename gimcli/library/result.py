"""Common attributes of all results: columns by name, a table, a report, a picture, and their files.

A result that is computed in parts is under way: its rows can be written while they are computed.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cached_property, wraps
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, NoReturn, ParamSpec, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from gimcli import output
from gimcli.errors import UsageError, refuse
from gimcli.library.by_name import unknown
from gimcli.mechanism import Mechanism
from gimcli.rounding import cells, lines
from gimcli.status import Status
from gimcli.table import Column, Table

if TYPE_CHECKING:
    from gimcli.library.record import Records
    from gimcli.quantities.state import State

FRAME_HEIGHT = 640
"""Height of the animated page in a notebook [px]."""

DICT: Any = dict
"""The class of dicts; for type checkers it would have to come before that of mappings."""


class Columns(Mapping[str, Any], DICT):  # type: ignore[misc]  # a class of type Any
    """A mapping that cannot be changed, and a dict: pandas makes columns of dicts only. The dict itself is not used."""

    def __new__(cls, *_: Any, **__: Any) -> Self:
        """Return the mapping; `json` takes an empty dict for an empty mapping, therefore something is in it."""
        made: Self = super().__new__(cls)
        DICT.__setitem__(made, "", None)
        return made

    def _refuse(self, *_: Any, **__: Any) -> NoReturn:
        raise TypeError("a result does not change; dict(result) is a copy of its columns that can be changed")

    __setitem__ = __delitem__ = __or__ = __ror__ = __ior__ = _refuse
    clear = copy = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> Any:
        return Columns.__new__, (type(self),), self.__getstate__()  # not the items


class Result(Columns):
    """A mapping from the names of the columns to arrays; `print` shows it, a notebook also draws it.

    `len(result)` is therefore the number of columns, not of rows. `save` writes files.
    """

    KIND: ClassVar[str]
    """The word before the suffix in the names of the usual files, such as "forces" in `model.forces.csv`."""

    mechanism: Mechanism
    limited: bool = False
    """Whether the search ended at its bound on work, or at `seconds`."""

    @property
    def outcome(self) -> str:
        """The status word of the search: "ok" or "work-limit"."""
        return (Status.WORK_LIMIT if self.limited else Status.OK).word

    @cached_property
    def status(self) -> Any:
        """The status words of the rows (rows,); one word, that of the search, if its rows have none."""
        return self.table()["status"] if "status" in self else self.outcome

    @cached_property
    def time(self) -> Any:
        """The time of the rows (rows,), or the one of all rows [s]; AttributeError if they have none."""
        return self._of_rows("time", ["time"])["time"]

    @cached_property
    def inputs(self) -> dict[str, Any]:
        """The inputs of the rows (rows,), or those of all rows, by name in the file's units; AttributeError without."""
        return self._of_rows("inputs", [actuator.name for actuator in self.mechanism.actuators])

    def _of_rows(self, attribute: str, names: Sequence[str]) -> dict[str, NDArray[Any]]:
        """Return the columns of some names; raise AttributeError if there are none."""
        found = {column.name: column.values for column in self.table().columns if column.name in names}
        if not found:
            raise AttributeError(f"{attribute}: the rows of a {type(self).__name__} have none")
        return found

    def by_machine(self) -> dict[str, Result]:
        """Return the results that are shown, by the names of their machines; of one machine the name is empty."""
        return {"": self}

    @abstractmethod
    def report(self) -> dict[str, Any]:
        """Return the report that the command prints with --json, without the names of files."""

    @cached_property
    def _records(self) -> Records:
        """The rows of the result; a result without such a list has a table of its own."""
        raise AttributeError("_records")

    def table(self) -> Table:
        """Return the columns with their units."""
        return self._records.table()

    def picture(self) -> output.picture.Content | None:
        """Return the picture, for `save`; None if there is nothing to draw."""
        return None

    def animation(self) -> output.animation.Animation | None:
        """Return the motion for an animated page, for `save`; None if there is nothing to show."""
        return None

    def geometry(self) -> output.geometry.Geometry | None:
        """Return the mechanism and its curves in true size, for a drawing program; None if there is nothing to draw."""
        return None

    def workbook(self) -> output.xlsx.Workbook:
        """Return the report and the table, for a spreadsheet."""
        inputs = tuple(actuator.name for actuator in self.mechanism.actuators)
        return output.xlsx.Workbook(self.headline(), self.report(), self.table(), inputs)

    def model(self) -> output.model.ModelText | None:
        """Return the text of the model file with other coordinates, for `save`; None if there is none."""
        return None

    @property
    def events(self) -> list[dict[str, Any]]:
        """Events, such as limits and change points; empty for results without a motion."""
        return []

    @property
    def complete(self) -> bool:
        """Whether nothing is missing: all rows solved, or a list that is proved complete."""
        return True

    @property
    def answered(self) -> bool:
        """Whether everything that was requested was found; if not, the command ends with exit status 5."""
        return self.complete

    @abstractmethod
    def headline(self) -> str:
        """Return the result in one line."""

    def arrays(self) -> dict[str, NDArray[Any]]:
        """Return the arrays of an .npz file by name: the columns."""
        return {column.name: column.values for column in self.table().columns}

    @classmethod
    def destinations(
        cls, out: Sequence[Path | str], stem: str, picture: bool = True, more: Sequence[str] = ()
    ) -> output.Destinations:
        """Return the output files. A folder gets the usual files: table, picture (if `picture`) and suffixes `more`."""
        known = cls.suffixes()
        usual = [".csv", *([".png"] if ".png" in known and picture else []), *more]
        return output.destinations(out, f"{stem}.{cls.KIND}" if cls.KIND else stem, usual, known)

    @classmethod
    def suffixes(cls) -> tuple[str, ...]:
        """Return the suffixes of the files that are written, in the order of the formats."""
        lacking = [k for k in ("picture", "animation", "geometry", "model") if getattr(cls, k) is getattr(Result, k)]
        return tuple(suffix for suffix, one in output.FORMATS.items() if one.content not in lacking)

    def save(
        self, *paths: Path | str, size: str | None = None, dpi: int | None = None, title: str | None = None,
        ghosts: int | str | None = None, style: Path | str | None = None,
    ) -> None:  # fmt: skip
        """Write files, each in the format of its suffix; each file is written atomically.

        Args:
            paths: files with the suffix .csv, .parquet, .npz, .json, .xlsx, .png, .svg, .pdf, .dxf, .html, .gif or
                .mp4, of `solve` also .yaml (the model file with solved coordinates); a folder gets the files that the
                command writes by default.
            size: width and height of pictures with a unit (mm, cm, in), such as "160x90mm".
            dpi: resolution of PNG pictures, in dots per inch.
            title: title of pictures; "" for none.
            ghosts: largest number of light poses in a picture, or "none".
            style: a matplotlib style file, or the name of a style of matplotlib, such as "grayscale".

        Raises:
            UsageError: a suffix is unknown, an option of pictures is invalid, there is nothing to draw, or the model
                was read from one of the files.
            OutputError: a file cannot be written.
        """
        options = output.printed.PictureOptions.checked(size, dpi, title, ghosts, None if style is None else str(style))
        files = self.destinations(paths, self.mechanism.path.stem if self.mechanism.path else "model")
        refuse(
            (files.stdout, "-: give the name of a file"),
            (
                options != output.printed.PictureOptions() and not files.prints,
                "size, dpi, title, ghosts and style change the picture, but no picture is written",
            ),
        )
        files.refuse(self.mechanism.files)
        contents = self.contents(files.files)
        for path in files.named:
            if contents.get(path, path) is None:
                what = "draw" if path in files.of("picture", "animation", "geometry") else "write"
                raise UsageError(f"{path}: there is nothing to {what}: {self.headline()}")
        write_contents(contents, options)

    def contents(self, paths: Iterable[Path]) -> dict[Path, Any]:
        """Return the content of each file; None if there is nothing to draw."""
        kinds = {path: output.format_of(path).content for path in paths}
        found = {kind: getattr(self, kind)() for kind in set(kinds.values())}
        return {path: found[kind] for path, kind in kinds.items()}

    @cached_property
    def _state(self) -> State | None:
        """The state of which any quantity may be asked by its name; None if there is none."""
        return None

    def to_frame(self) -> Any:
        """Return the columns as a DataFrame of pandas.

        Raises UsageError if pandas is not installed.
        """
        try:
            from pandas import DataFrame
        except ImportError:
            raise UsageError("to_frame needs pandas, which is not installed: pip install pandas") from None
        return DataFrame({column.name: column.values for column in self.table().columns})

    def __getitem__(self, name: str | list[str]) -> Any:
        """Return a quantity by its name (rows,), or those of a list of names (rows, names)."""
        if isinstance(name, list):
            return np.stack([self[one] for one in name], axis=-1)
        table = self.table()
        if name in table.names:
            return table[name]
        state = self._state
        if state is None:
            raise unknown(name, table.names)
        from gimcli.quantities.catalogue import catalogue
        from gimcli.quantities.forces import no_forces
        from gimcli.quantities.state import ApartError

        known = catalogue(self.mechanism)
        try:
            if known.is_number(name):
                return known.number(name, state)
            return self._asked([state.value(*item) for item in known.asked(name)])
        except ApartError as error:
            raise KeyError(f"{name}: {error}") from None
        except UsageError as error:
            alone = not set(name) & set(" ():|+*/") and not no_forces(self.mechanism, name)
            alone = alone and name not in known.members
            raise (
                unknown(name, [*dict.fromkeys((*table.names, *known.columns))]) if alone else KeyError(str(error))
            ) from None

    def _asked(self, columns: list[NDArray[Any]]) -> Any:
        """Return one column (rows,), or several (rows, columns)."""
        return np.stack(columns, axis=-1) if len(columns) > 1 else columns[0]

    def __contains__(self, name: object) -> bool:
        return name in self.table().names

    def __iter__(self) -> Iterator[str]:
        return iter(self.table().names)

    def __len__(self) -> int:
        return len(self.table().names)

    def __eq__(self, other: object) -> bool:
        return self is other

    __hash__ = object.__hash__

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if not getattr(value, "made_again", False)}

    def __repr__(self) -> str:
        return "\n".join([self.headline(), *lines(self.table())])

    def _repr_html_(self) -> str:
        import html

        rows = "".join(f"<tr>{''.join(f'<td>{html.escape(c)}</td>' for c in row)}</tr>" for row in cells(self.table()))
        return f"<p>{html.escape(self.headline())}</p><table>{rows}</table>{self._drawn()}"

    def _drawn(self) -> str:
        """Return the animated page, and the picture folded below it; only the picture where nothing moves."""
        frame, picture = self._frame(), self._svg()
        return (
            f"{frame}<details><summary>Picture</summary>{picture}</details>" if frame and picture else frame + picture
        )

    def _frame(self) -> str:
        """Return the animated page as a frame that a notebook shows; its scripts have no access to the notebook."""
        import html

        motion = self.animation()
        if motion is None:
            return ""
        return (
            f'<iframe sandbox="allow-scripts" title="{html.escape(motion.title)}"'
            f' style="width:100%;height:{FRAME_HEIGHT}px;border:0"'
            f' srcdoc="{html.escape(output.page.page(motion))}"></iframe>'
        )

    def _svg(self) -> str:
        from tempfile import TemporaryDirectory

        content = self.picture()
        if content is None:
            return ""
        with TemporaryDirectory() as folder:
            path = Path(folder) / "picture.svg"
            output.write(content, path)
            text = path.read_text(encoding="utf-8")
        return text[text.index("<svg") :]


class RowsResult(Result):
    """A result with one row for each step; a row that is not solved has a status and NaN."""

    def __init__(self, found: Any, table: Table | None) -> None:
        """Keep what was under way, and its table unless that was written to a file."""
        self.mechanism, self._found, self._table = found.mechanism, found, table

    def table(self) -> Table:
        """Return one row for each step."""
        if self._table is None:
            raise ValueError("the rows were written to a file, not kept")
        return self._table


def write_contents(contents: Mapping[Path, Any], options: output.printed.PictureOptions | None = None) -> list[Path]:
    """Write the contents of files, except None; return the files that were written."""
    written = [path for path, content in contents.items() if content is not None]
    for path in written:
        content, one = contents[path], output.format_of(path)
        if options is not None and one.printed:
            content = options.printed(content) if one.content == "picture" else options.animated(content)
        one.write(content, path)
    return written


def joined(tables: Iterable[Table]) -> Table:
    """Join the rows of tables that have the same columns."""
    parts = list(tables)
    if len(parts) == 1:
        return parts[0]
    rows = zip(*(part.columns for part in parts), strict=True)
    return Table(tuple(Column(c[0].name, np.concatenate([p.values for p in c]), c[0].unit) for c in rows))


P = ParamSpec("P")
Found = TypeVar("Found", covariant=True)


class UnderWay(ABC, Generic[Found]):
    """A result that is being computed: first the table of each part, then the result."""

    expected: int | None = None
    """Number of rows; None if it is not known before the end."""

    keeps = False
    """Whether the parts are kept, so that any quantity may be asked of all rows."""

    made: Callable[[Any, Table | None], Found]  # the class of the result

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""

    @abstractmethod
    def tables(self) -> Iterator[Table]:
        """Yield the table of each part."""

    def result(self, table: Table | None) -> Found:
        """Return the result, after all tables were read; `table` is None if they were written to a file."""
        return self.made(self, table)

    def whole(self) -> Found:
        """Return the result with all rows."""
        self.keeps = True
        return self.result(joined(self.tables()))


def in_parts(begin: Callable[P, UnderWay[Found]]) -> Callable[P, Found]:
    """Return the verb whose result a function begins, which is its attribute `begin` (decorator)."""

    @wraps(begin)
    def verb(*args: P.args, **kwargs: P.kwargs) -> Found:
        return begin(*args, **kwargs).whole()

    form = signature(begin)
    own = form.replace(return_annotation=form.return_annotation.removeprefix("UnderWay[").removesuffix("]"))
    vars(verb).update(begin=begin, __signature__=own)
    return verb
