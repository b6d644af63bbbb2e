"""A sweep that is being computed: its chunks in order, kept in a folder so that an interrupted run can be resumed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress

import numpy as np

from gimcli.families.sweep_job import Rows, SweepJob, packed
from gimcli.families.workers import run_here, run_on_cluster, run_on_processes
from gimcli.output.parts import Parts
from gimcli.progress import Progress, no_progress
from gimcli.status import Status

Run = Callable[[Sequence[int]], Iterator[tuple[int, Rows]]]


class SweepRun:
    """The chunks of a job: computed by workers in any order, given in order."""

    def __init__(
        self, job: SweepJob, store: Parts | None = None, workers: int = 1, scheduler: str = "",
        progress: Progress = no_progress,
    ) -> None:  # fmt: skip
        self.job, self.store, self.workers, self.scheduler, self.progress = job, store, workers, scheduler, progress
        self.resumed = len(store.done) if store is not None else 0
        self.done = self.resumed

    def chunks(self) -> Iterator[Rows]:
        """Yield the chunks in order."""
        store, ready = self.store, dict[int, Rows]()
        known = store.done if store is not None else set[int]()
        computed = self._run([k for k in range(self.job.chunks) if k not in known])
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

    def _run(self, missing: Sequence[int]) -> Iterator[tuple[int, Rows]]:
        if self.scheduler:
            return run_on_cluster(self.job, missing, self.scheduler)
        if self.workers > 1 and len(missing) > 1:
            return run_on_processes(self.job, missing, min(self.workers, len(missing)))
        return run_here(self.job, missing)

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
