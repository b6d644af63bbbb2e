"""A sweep that is being computed: its chunks in order, kept in a folder so that an interrupted run can be resumed.

Chunks are computed by this process, by processes on this machine, or by a Dask cluster. Every chunk is the same array
whoever computes it. A chunk that is lost because a worker ended is computed again.

Its tables have the rows of each chunk; what is known of the designs so far is counted beside.
"""

from __future__ import annotations

import os
import pickle
import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any

import numpy as np

from gimcli.errors import UsageError
from gimcli.families.sweep_job import GOAL, STATUS, Rows, SweepJob, packed
from gimcli.motion.scatter import as_finished
from gimcli.output.parts import Parts
from gimcli.progress import Progress, no_progress
from gimcli.quantities.quantity import ColumnRange
from gimcli.status import Status
from gimcli.table import Column, Table
from gimcli.version import __version__

RESTARTS = 3
"""Number of times that workers are started again without a finished chunk in between."""

GUARD = 'a script that uses workers needs the line: if __name__ == "__main__":'

ANSWER = "10s"
"""Time in which a Dask scheduler must answer."""

AHEAD = 3
"""Chunks that are handed out for each worker, so that memory is limited."""


def run_on_processes(job: SweepJob, numbers: Sequence[int], workers: int) -> Iterator[tuple[int, Rows]]:
    """Yield chunks in the order in which local processes finish them; new processes replace those that end."""
    from concurrent.futures.process import BrokenProcessPool
    from multiprocessing import current_process

    if getattr(current_process(), "_inheriting", False):  # a new worker that imports a script without this line
        raise UsageError(f"workers: a worker starts no workers; {GUARD}")
    threads = max(1, (os.cpu_count() or 1) // workers)
    left, restarts = list(numbers), 0
    with TemporaryDirectory() as folder:  # a long message to a process that ended would block for ever
        sent = Path(folder) / "job"
        sent.write_bytes(pickle.dumps(replace(job, threads=threads)))
        while left:
            try:
                for number, rows in _of_processes(sent, list(left), workers):
                    left.remove(number)
                    restarts = 0
                    yield number, rows
            except BrokenProcessPool:
                restarts += 1
            if restarts > RESTARTS:
                raise UsageError(
                    f"workers: the processes ended {restarts} times without a result, for lack of memory for example:"
                    f" use fewer workers; {GUARD}"
                )


def _of_processes(sent: Path, numbers: Sequence[int], workers: int) -> Iterator[tuple[int, Rows]]:
    """Yield chunks of the job in a file; raise BrokenProcessPool if a process ends."""
    from concurrent.futures import ProcessPoolExecutor
    from multiprocessing import get_context

    pool = ProcessPoolExecutor(workers, get_context("spawn"), _begin, (sent,))
    yield from as_finished(pool, _run, numbers, AHEAD * workers)


def run_on_cluster(job: SweepJob, numbers: Sequence[int], scheduler: str) -> Iterator[tuple[int, Rows]]:
    """Yield chunks in the order in which the workers of a Dask cluster finish them."""
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise UsageError("scheduler: Dask is not installed; run: pip install 'gimcli[dask]'") from None
    try:
        client = distributed.Client(scheduler, timeout=ANSWER)
    except (OSError, ValueError, TimeoutError) as error:
        name = type(error).__name__
        raise UsageError(f"scheduler {scheduler}: no Dask scheduler answers there ({name}); start one there") from None
    with client:
        sent = client.scatter(pickle.dumps(job), broadcast=True)
        waiting = iter(numbers)
        count = AHEAD * max(1, len(client.scheduler_info()["workers"]))
        owner: dict[Any, int] = {}

        def submit(k: int) -> Any:
            future = client.submit(_run_sent, sent, k, __version__, pure=False)
            owner[future.key] = k
            return future

        running = distributed.as_completed([submit(k) for k in islice(waiting, count)])
        for future in running:
            yield owner.pop(future.key), future.result()
            future.release()
            for k in islice(waiting, 1):
                running.add(submit(k))


_job: SweepJob | None = None
_sent: bytes = b""


def _begin(sent: Path) -> None:
    """Begin a local process: an interrupt from the terminal ends the main process only, which ends the others."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()
    try:
        _receive(sent.read_bytes())
    except FileNotFoundError:  # the main process has ended and removed its folder
        os._exit(1)


def _end_with_parent() -> None:
    """End this process when the main process has ended without ending it, such as by SIGKILL."""
    from multiprocessing import parent_process

    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _receive(sent: bytes) -> SweepJob:
    global _job, _sent
    if _job is None or sent != _sent:
        _job, _sent = pickle.loads(sent), sent
    return _job


def _run(number: int) -> Rows:
    assert _job is not None
    return _job.run(number)


def _run_sent(sent: bytes, number: int, version: str) -> Rows:
    """Compute a chunk on a worker of a cluster."""
    if version != __version__:
        raise UsageError(f"scheduler: a worker has gimcli {__version__}, this is {version}; install one version")
    return _receive(sent).run(number)


def best_of(job: SweepJob, chunks: Iterator[Rows]) -> Iterator[Rows]:
    """Yield the chunks, or one chunk with the best designs of all."""
    if not job.best:
        yield from chunks
        return
    best, counts, careful = np.empty(0, dtype=job.row), np.zeros(len(Status), dtype=np.int64), 0
    for chunk in chunks:
        best = job.chosen(np.concatenate([best, chunk["rows"]]))
        counts += chunk["counts"]
        careful += int(chunk["careful"])
    yield packed(counts, careful, best)


STEP = "step"
"""Column of the number of the row in each motion, if whole columns are kept."""

DRAWN = 1_000_000
"""Largest number of designs that are kept for a picture."""


class SweepTables:
    """A sweep that is being computed: its chunks by workers in any order, its tables in the order of the designs."""

    def __init__(
        self, job: SweepJob, units: Mapping[str, str], store: Parts | None = None, workers: int = 1,
        scheduler: str = "", progress: Progress = no_progress,
    ) -> None:  # fmt: skip
        self.job, self.mechanism = job, job.mechanism
        self.store, self.workers, self.scheduler, self.progress = store, workers, scheduler, progress
        self.done = self.resumed = len(store.done) if store is not None else 0
        own = {"length": self.mechanism.length_unit, "angle": self.mechanism.angle_unit}
        self.units = {name: own.get(unit, "") for name, unit in units.items()}
        self.counts = np.zeros(len(Status), dtype=np.int64)
        self.careful, self.rows = 0, 0
        self.ranges: dict[str, ColumnRange] = {}
        self.draws = True
        self.drawn: list[Rows] = []  # rows for the picture, if it is drawn
        self.best: Table | None = None  # the best designs, if they are requested

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        own = self.job.row.names or ()
        return (*own[:-1], STEP, own[-1]) if self.job.rows else own

    def tables(self) -> Iterator[Table]:
        """Yield the table of each chunk, in the order of the designs; with `best` one table."""
        for chunk in best_of(self.job, self.chunks()):
            rows = chunk["rows"]
            self.counts += chunk["counts"]
            self.careful += int(chunk["careful"])
            self.rows += len(rows)
            for name in self.job.row.names or ():
                if rows[name].dtype.kind == "f":
                    self.ranges.setdefault(name, ColumnRange()).add(rows[name])
            if self.draws and sum(map(len, self.drawn)) < DRAWN:
                self.drawn.append(rows)
            table = self._table(rows)
            self.best = table if self.job.best else None
            yield table

    def unit(self, name: str) -> str:
        """Return the unit of a column."""
        own = {q.text: q.kind.unit or "" for q in self.job.kept} | self.units
        return (self.job.aim.kind.unit or "") if name == GOAL and self.job.aim is not None else own.get(name, "")

    def _table(self, rows: Rows) -> Table:
        each = self.job.steps + 1 if self.job.rows else 1
        own = {name: rows[name] for name in self.job.row.names or ()}
        flat = {name: values.ravel() if values.ndim > 1 else np.repeat(values, each) for name, values in own.items()}
        flat[STATUS] = np.array([status.word for status in Status])[flat[STATUS]]
        if self.job.rows:
            flat[STEP] = np.tile(np.arange(each), len(rows))
        return Table(tuple(Column(name, np.ascontiguousarray(flat[name]), self.unit(name)) for name in self.names))

    def chunks(self) -> Iterator[Rows]:
        """Yield the chunks in order."""
        store, ready = self.store, dict[int, Rows]()
        known = store.done if store is not None else set[int]()
        computed = self._computed([k for k in range(self.job.chunks) if k not in known])
        self._report()
        for number in range(self.job.chunks):
            while number not in known and number not in ready:
                k, rows = next(computed)
                self.done += 1
                self._report()
                if store is None:
                    ready[k] = rows
                else:
                    store.put(k, rows)
                    known.add(k)
            yield ready.pop(number) if store is None else self._read(store, number)

    def _computed(self, missing: Sequence[int]) -> Iterator[tuple[int, Rows]]:
        if self.scheduler:
            return run_on_cluster(self.job, missing, self.scheduler)
        if self.workers > 1 and len(missing) > 1:
            return run_on_processes(self.job, missing, min(self.workers, len(missing)))
        return ((number, self.job.run(number)) for number in missing)

    def _read(self, store: Parts, number: int) -> Rows:
        """Return a chunk of the folder; a damaged one is computed again."""
        with suppress(OSError, ValueError, EOFError):
            return store.get(number)
        rows = self.job.run(number)
        store.put(number, rows)
        return rows

    def _report(self) -> None:
        job = self.job
        self.progress(min(self.done * job.size, job.table.count), job.table.count)

    def clear(self) -> None:
        """Remove the folder of the parts, after everything was written."""
        if self.store is not None:
            self.store.clear()
