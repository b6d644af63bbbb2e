"""A model file that is solved again whenever it, or one of its tables, is saved.

The last motion that could be solved stays while the file has errors. Changes are found by polling, so that every way of
saving is noticed: a file written in place, replaced by another one, or deleted and written again.
"""

from __future__ import annotations

import time
import traceback
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from threading import Condition, Lock
from typing import Any

from gimcli.errors import GimError, ModelError, StructureError, UsageError
from gimcli.library.load import decided, load, load_undecided, model_path
from gimcli.library.trace import MotionTraceResult, trace
from gimcli.mechanism import Mechanism
from gimcli.output.page.document import page_json
from gimcli.progress import Notify, Phases, no_phases
from gimcli.table import Table

POLL = 0.03
"""Seconds between two looks at the files."""

SETTLED = 0.1
"""Seconds without a change after which an error is shown: a file may be read while an editor writes it."""

RETRY = 1.0
"""Seconds after which a file with errors is read again: their cause may be another file that is not known."""

Stamp = tuple[int, int, int] | None
"""Time of the last change [ns], size in bytes and inode; None: there is no such file."""


@dataclass(frozen=True)
class LiveContent:
    """What the page shows: the last motion that was solved, and the errors of the file as it is now."""

    version: int = 0  # increases with every change of the other fields
    motion: int = 0  # number of the motion; 0: no motion has been solved yet
    result: MotionTraceResult | None = None
    data: str = "null"  # the motion as JSON, for the page
    table: Table | None = None  # the columns of the page
    parameters: Mapping[str, float] = field(default_factory=dict)  # given by numbers, not by hand
    errors: tuple[str, ...] = ()

    @property
    def motion_data(self) -> str:
        """The motion and its number as JSON."""
        return f'{{"motion": {self.motion}, "data": {self.data}}}'


class Superseded(Exception):  # noqa: N818  # an outcome, not an error
    """The file was saved again while its motion was solved."""


class LiveModel:
    """The motion of a model file; `shown` is what the page shows. `solving` is held while the solver works."""

    def __init__(
        self, path: Path, changes: Mapping[str, str], assembly: str, settings: Mapping[str, Any], note: Notify
    ) -> None:
        """Prepare to trace a file with settings (arguments of `trace`); `note` gets a line about every change.

        changes: values of dimensions by name, as for `Mechanism.with_`.
        assembly: number or signs of the configuration from which the motion starts; "": the one that is drawn.
        """
        self.path, self.assembly, self.settings, self.note = model_path(path), assembly, dict(settings), note
        self.changes = dict(changes)
        self.shown, self.solving, self.ended = LiveContent(), Lock(), False
        self._by_hand: dict[str, float] = {}  # parameters
        self._updating = Lock()  # held from reading the file to showing its motion
        self._changed = Condition()
        self._seen = stamps([self.path.absolute()])
        self._unread, self._looked = False, 0.0

    def begin(self, progress: Phases = no_phases) -> None:
        """Solve for the first time.

        Raises ModelError if it is no file, UsageError if the settings do not fit the model. Other errors are
        shown on the page.
        """
        if not self.path.is_file():
            load(self.path)
        try:
            first = self._solved(progress)
            for sentence in first.result.mechanism.left_out if first.result else ():
                self.note(sentence)
            self._show_motion(first)
        except UsageError:
            raise
        except GimError as error:
            self._show_error(error)

    def follow(self) -> None:
        """Solve again whenever a file changes, until `end` is called."""
        while self._wait_for_save():
            with self._updating:
                try:
                    self._show_motion(self._solved(lambda phase: self._stop_if_saved))
                except Superseded:
                    continue
                except Exception as error:
                    if not self._is_saved_within(SETTLED):
                        self._show_error(error)

    def set_parameters(self, values: Mapping[str, float]) -> None:
        """Set parameters by hand and solve again; they keep their values until the file gives others.

        Raises UsageError for an unknown name. Other errors are shown beside the last motion.
        """
        for name in values:
            if name not in self.shown.parameters:
                raise UsageError(f"'{name}' is not a parameter with a number")
        with self._updating:
            self._by_hand |= values
            try:
                self._show_motion(self._solved(no_phases, quiet=True))
            except Exception as error:
                self._show_error(error)

    def end(self) -> None:
        """End `follow` and all waiting."""
        with self._changed:
            self.ended = True
            self._changed.notify_all()

    def wait(self, version: int, seconds: float) -> LiveContent | None:
        """Return what is shown as soon as it is not of this version; None after some seconds, or at the end."""
        with self._changed:
            self._changed.wait_for(lambda: self.ended or self.shown.version != version, seconds)
            return self.shown if self.shown.version != version and not self.ended else None

    # -- files ---------------------------------------------------------------------------

    def _wait_for_save(self) -> bool:
        """Wait until a file has changed, or a file that could not be read is due again; return False at the end."""
        while not self.ended:
            if self._is_saved_within(RETRY):
                return True
            if self._unread:
                return not self.ended
        return False

    def _is_saved_within(self, seconds: float) -> bool:
        """Return whether a file changes within some seconds."""
        end = time.monotonic() + seconds
        while stamps(self._seen) == self._seen:
            if self.ended or time.monotonic() >= end:
                return False
            time.sleep(POLL)
        return True

    def _stop_if_saved(self, done: int, of: int) -> None:
        """Stop solving if a file has changed; called again and again while a motion is solved."""
        if time.monotonic() - self._looked >= POLL:
            self._looked = time.monotonic()
            if self.ended or stamps(self._seen) != self._seen:
                raise Superseded

    def _solved(self, progress: Phases, quiet: bool = False) -> LiveContent:
        """Read and solve the file; return what the page shows then. The line about it is left out if `quiet`.

        Raises GimError if it cannot be read or solved.
        """
        self._seen = before = stamps(self._seen)
        begun = time.perf_counter()
        with self.solving:
            if self.path.exists() and not self.path.is_file():
                raise ModelError([f"{self.path}: is not a regular file; save the model file under this name"])
            mechanism = load_undecided(self.path)
            self._seen = {**stamps(mechanism.files), **{f: before[f] for f in mechanism.files if f in before}}
            mechanism = mechanism.with_(self.changes) if self.changes else mechanism
            parameters = numbers_of(mechanism)
            mechanism = mechanism.with_(self._kept(parameters))
            if not self.assembly:
                mechanism = decided(mechanism)
            else:
                from gimcli.library.assembled import assembled  # imported late: few ask for it

                mechanism = assembled(mechanism, assembly=self.assembly, progress=progress)
            result = trace(mechanism, **self.settings, progress=progress)
            if not isinstance(result, MotionTraceResult) or not result.solved:
                raise StructureError(unsolved(result))
            animation = result.animation()
            data = "null" if animation is None else page_json(animation)
        if not quiet:
            self.note(f"{result.headline()} ({time.perf_counter() - begun:.2f} s)")
        table = None if animation is None else animation.clips[0].table
        return LiveContent(result=result, data=data, table=table, parameters=parameters)

    def _kept(self, parameters: Mapping[str, float]) -> dict[str, float]:
        """Return the parameters set by hand; those of which the file has another value than before are forgotten."""
        before = self.shown.parameters
        same = {name for name in self._by_hand if parameters.get(name) == before.get(name)}
        self._by_hand = {name: value for name, value in self._by_hand.items() if name in same}
        return self._by_hand

    # -- results -------------------------------------------------------------------------

    def _show_motion(self, new: LiveContent) -> None:
        self._unread = False
        self._show(replace(new, motion=self.shown.motion + 1))

    def _show_error(self, error: Exception) -> None:
        """Show an error beside the last motion; an error that is shown already is not a change."""
        self._unread = isinstance(error, ModelError)
        lines = tuple(error.faults) if isinstance(error, ModelError) else (str(error),)
        if not isinstance(error, GimError):
            lines = (f"internal error: {type(error).__name__}: {error}; the terminal shows where",)
        if lines != self.shown.errors:
            self._show(replace(self.shown, errors=lines))
            own = isinstance(error, GimError)
            self.note("\n".join(lines) if own else "".join(traceback.format_exception(error)).rstrip())

    def _show(self, new: LiveContent) -> None:
        with self._changed:
            self.shown = replace(new, version=self.shown.version + 1)
            self._changed.notify_all()


def numbers_of(mechanism: Mechanism) -> dict[str, float]:
    """Return the values of the parameters that are numbers, not formulas."""
    dimensions = mechanism.written.dimensions.values()
    return {one.name: one.value for one in dimensions if one.where[0] == "parameters" and not one.formula}


def unsolved(result: Any) -> str:
    """Return why no row of a motion is solved."""
    from gimcli.motion.unassembled import motion_reason

    return f"{result._motion.overall.word}: {motion_reason(result._motion)}"


def stamps(paths: Iterable[Path]) -> dict[Path, Stamp]:
    """Return the present stamp of each file."""
    return {path: _stamp(path) for path in paths}


def _stamp(path: Path) -> Stamp:
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_mtime_ns, found.st_size, found.st_ino
