"""Sweep dimensions: solve the motion of many designs and keep some quantities of each."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from gimcli import output
from gimcli.errors import UsageError, refuse
from gimcli.families.design_table import POINTS, design_table, listed_designs
from gimcli.families.family import ONE, kernel_name, mode_of
from gimcli.families.grid import contents_hash, model_hash
from gimcli.families.quantity_text import texts_of
from gimcli.families.sweep_job import SweepJob, chunk_size, default_keep
from gimcli.families.sweep_run import SweepTables
from gimcli.families.variation import MOST_VALUES, varied
from gimcli.library.inputs import OneOf, Range, Seed, Steps, Tolerance, checked, refuse_unmoved
from gimcli.library.machines import accepted, driven_machines
from gimcli.library.record import Records, RowField
from gimcli.library.result import RowsResult, UnderWay, in_parts
from gimcli.mechanism import Mechanism
from gimcli.model.dimensions import written
from gimcli.output.parts import Parts, header_of
from gimcli.positions.dispatch import choose, plain
from gimcli.progress import Notify, Phases, no_phases
from gimcli.rounding import number
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.table import Table, labelled
from gimcli.version import __version__

MOST_WORKERS = 1024

Vary = Mapping[str, Any] | Sequence[Mapping[str, float]] | Path | str
"""Values by the names of dimensions, or designs."""

FILMS = (".gif", ".mp4")


@in_parts
@checked
def sweep(
    mechanism: Mechanism, vary: Vary, *, steps: Steps = 72,
    samples: Annotated[int | None, Range(1, MOST_VALUES)] = None, points: Annotated[str, OneOf(POINTS)] = "random",
    seed: Seed = 0, keep: str | Sequence[str] = (), where: str = "", goal: str = "",
    best: Annotated[int, Range(0, MOST_VALUES)] = 0, rows: bool = False, tolerance: Tolerance = 1e-10,
    workers: Annotated[int, Range(1, MOST_WORKERS)] = 1, scheduler: str = "", folder: Path | str | None = None,
    resume: bool = False, notify: Notify | None = None, progress: Phases = no_phases,
) -> UnderWay[SweepResult]:  # fmt: skip
    """Solve the motion of many designs, and keep some quantities of each.

    Args:
        mechanism: from `load` or `loads`.
        vary: values by the names of dimensions: a text such as "10:20:21" (21 values from 10 to 20) or "3,4,5", or an
            array: all combinations are solved; or a distribution, "uniform(10,20)" or "normal(40,0.05)". Or designs,
            solved in their order: a list of dicts, a DataFrame, or a CSV file with a column for each dimension.
        steps: number of steps of each motion; 1 to 10 000 000.
        samples: number of designs that are drawn from the distributions.
        points: how samples are drawn: "random", "latin" (hypercube) or "sobol".
        seed: seed of the sample; the same seed gives the same designs.
        keep: one text or a list, such as "range(P.y)", "min(transmission)", "at(P.y, motor=30)", "type"; by default the
            ranges of the traced points and the number of solved rows.
        where: condition that kept designs satisfy; such as "range(P.y) > 40".
        goal: quantity that is least in the best designs; such as "-range(P.y)".
        best: number of best designs kept (0: all); the best one comes first.
        rows: keep whole columns, such as "P.x", with one row for each step of each design; by default the coordinates
            of the traced points.
        tolerance: largest accepted error of a constraint, relative to the mechanism's size; from 1e-14 to below 1.
        workers: number of processes on this machine; 1: this process, with threads.
        scheduler: address of a Dask scheduler; its workers compute the chunks.
        folder: keeps the parts that are done, so that an interrupted sweep can be resumed.
        resume: use the parts in `folder` of an interrupted sweep with the same model and options.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (designs done, all), for a progress bar.

    Returns:
        A SweepResult: one row for each design with its number, its dimensions, what is kept, and its status. With
        `rows`, `.curves[name]` is an array (designs, rows). A script that gives `workers` needs
        `if __name__ == "__main__":`.

    Raises:
        UsageError: an unknown name, an invalid argument, or arguments that exclude each other.
        StructureError: the mechanism has no actuator, or is not fully driven, over-driven or contradictory.
    """
    refuse(
        (
            scheduler and workers > 1,
            "workers are processes on this machine, scheduler uses those of a cluster: remove one of them",
        ),
        (
            resume and folder is None,
            "resume continues a sweep from its folder: give the same folder, or the same output file",
        ),
    )
    full: dict[str, Any] = {}
    for name, given in (vary if isinstance(vary, Mapping) else _designs(vary)).items():
        own = written(mechanism).dimension(name).name
        refuse((own in full, f"vary: '{own}' is given twice"))
        full[own] = given
    table = design_table(varied(full), samples, points, seed) if isinstance(vary, Mapping) else listed_designs(full)
    texts = (keep,) if isinstance(keep, str) else tuple(keep)
    if len(mechanism.machines) > 1:
        job = SweepJob(mechanism, table, steps, texts, where, goal, best, tolerance, rows=rows)
        mechanism = _swept_machine(mechanism, job)
    make_plan(mechanism)
    refuse_unmoved(mechanism, "add an actuator")
    texts = texts_of(texts, SweepJob(mechanism, table).names) or default_keep(mechanism, rows)
    size = chunk_size(mechanism, steps)
    job = SweepJob(mechanism, table, steps, texts, where, goal, best, tolerance, size, rows=rows, notify=notify)
    job.check()
    if notify is not None:
        ends = job.table.rows(0, 1), job.table.rows(table.count - 1, table.count)
        for name in job.family.without_effect(*ends, forces=job.names.forced):
            notify(f"vary {name}: it changes no length, shape or law, so that all its values give the same positions")
    job = _with_kernels(job, folder if resume else None, notify)
    units = {name: written(mechanism).dimension(name).unit for name in table.names}
    store = None if folder is None else Parts(Path(folder), _header(job), resume)
    return SweepUnderWay(job, units, store, workers, scheduler, progress("designs"))


def _designs(given: Any) -> dict[str, Any]:
    """Return the columns of a list of designs: a CSV file, a DataFrame, or a list of dicts."""
    if isinstance(given, str) and "=" in given and not Path(given).exists():
        name, _, values = given.partition("=")
        raise UsageError(f"vary: expected a dict of values, such as {{'{name}': '{values}'}}, got '{given}'")
    if isinstance(given, str | Path):
        from gimcli.library.number_columns import number_columns

        return dict(number_columns(Path(given), "designs"))
    if hasattr(given, "columns") and hasattr(given, "to_numpy"):
        return {str(name): given[name].to_numpy() for name in given.columns}
    rows = [dict(one) if isinstance(one, Mapping) else {} for one in given]
    refuse(
        (
            not rows or not all(rows) or any(one.keys() != rows[0].keys() for one in rows),
            "vary: expected a dict of values, or designs: a CSV file, a DataFrame, or dicts of equal keys",
        )
    )
    return {name: [one[name] for one in rows] for name in rows[0]}


def _swept_machine(mechanism: Mechanism, job: SweepJob) -> Mechanism:
    """Return the machine that has all dimensions and quantities; the mechanism itself if several have some of them."""
    machines = [one.mechanism for one in driven_machines(mechanism)]
    owners = [one for one in machines if any(accepted(one.written.dimension, name) for name in job.table.names)]
    whole = len(owners) != 1 or not all(accepted(owners[0].written.dimension, name) for name in job.table.names)
    return mechanism if whole or not accepted(replace(job, mechanism=owners[0]).check) else owners[0]


def _with_kernels(job: SweepJob, resumed: Path | str | None, notify: Notify | None) -> SweepJob:
    """Return the job with the choice of compiled kernels: once for all chunks, as in a resumed sweep."""
    before = None if resumed is None else header_of(Path(resumed))
    if before is not None and "jit" in before:
        return replace(job, jit=str(before["jit"]))
    count, plan = job.table.count, make_plan(job.mechanism)
    solves = choose(mode_of(plan, "auto"), ONE * count, notify, (kernel_name(plan),)) is not plain
    return replace(job, jit="on" if solves else "off")


def _header(job: SweepJob) -> dict[str, Any]:
    """Return the sweep that parts belong to: the model's content, the designs, what is kept."""
    designs = hashlib.sha256()
    for one in job.table.varied.variations:
        designs.update(f"{one!r}{getattr(one, 'values', np.empty(0)).tobytes()!r}".encode())
    return {
        "version": __version__, "model": model_hash(job.mechanism), "text": contents_hash(job.mechanism.written.model),
        "vary": designs.hexdigest(),
        "designs": job.table.count, "points": job.table.points, "seed": job.table.seed, "steps": job.steps,
        "keep": job.keep, "rows": job.rows, "where": job.where, "goal": job.goal, "best": job.best,
        "tolerance": job.tolerance, "jit": job.jit, "designs a chunk": job.size,
    }  # fmt: skip


class SweepResult(RowsResult):
    """One row for each design: its number, its dimensions, what is kept, and its status."""

    KIND = "sweep"

    _found: SweepTables

    @property
    def designs(self) -> int:
        """The number of designs that were computed, also those that are not kept."""
        return self._found.job.table.count

    @cached_property
    def counts(self) -> dict[str, int]:
        """The number of designs by their status, also of those that are not kept."""
        return {Status(k).word: int(n) for k, n in enumerate(self._found.counts) if n}

    @property
    def solved(self) -> int:
        """The number of designs of which all rows are solved."""
        return int(sum(self._found.counts[: Status.TANGENT + 1]))

    @property
    def complete(self) -> bool:
        """Whether all designs are solved."""
        return self.solved == self.designs

    @property
    def curves(self) -> dict[str, NDArray[Any]]:
        """The kept columns (designs, rows) by name, if `rows` was set."""
        job = self._found.job
        return {q.text: self[q.text].reshape(-1, job.steps + 1) for q in job.kept if q.kind.what == "rows"}

    @property
    def answered(self) -> bool:
        """Whether at least one design is solved."""
        return self.solved > 0

    def headline(self) -> str:
        """Return the result in one line."""
        job, kept = self._found.job, ""
        if job.where or job.best:
            kept = f", {self._found.rows} kept"
        return f"{self.mechanism.name}: {self.solved} of {self.designs} designs solved{kept}"

    @property
    def ranges(self) -> dict[str, dict[str, Any]]:
        """For each dimension and quantity: the least and greatest value of the kept designs, its unit."""
        return self._spans.by("name")

    @cached_property
    def _spans(self) -> Records:
        """The ranges of the dimensions and quantities, one row each."""
        names, units = list(self._found.ranges), [self._found.unit(name) for name in self._found.ranges]
        every = self._found.ranges.values()
        low, high, empty = ([getattr(own, name) for own in every] for name in ("least", "greatest", "empty"))
        sizes = [max(map(abs, ends)) for ends in zip(low, high, strict=True)]
        return Records(
            RowField("name", names, head="", text=list(map(labelled, names, units))),
            RowField("least", low, float, head="least", text=list(map(number, low, sizes))),
            RowField("greatest", high, float, head="greatest", text=list(map(number, high, sizes))),
            RowField("empty", empty, int, head="empty", text=lambda count: str(count or "")),
            RowField("unit", units),
        )

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        job = self._found.job
        best = {} if self._found.best is None else {"best": _listed(self._found.best)}
        return {
            "designs": self.designs, "solved": self.solved, "status": self.counts, "kept": self._found.rows,
            "solved_one_by_one": self._found.careful, "resumed_chunks": self._found.resumed,
            "chunks": job.chunks, "vary": {v.name: v.text for v in job.table.varied.variations},
            "ranges": self.ranges, **best,
        }  # fmt: skip

    def picture(self) -> output.picture.Content | None:
        """Return curves over one dimension, contours over two, otherwise distributions; None if there is nothing."""
        from gimcli.families.sweep_views import sweep_picture

        rows = np.concatenate(self._found.drawn) if self._found.drawn else np.empty(0, self._found.job.row)
        return sweep_picture(self._found, rows)

    def animation(self) -> output.animation.Animation | None:
        """Return the motions of the designs, one slider for each dimension; None if no design is solved."""
        from gimcli.families.sweep_views import sweep_animation

        return sweep_animation(self._found)

    @classmethod
    def suffixes(cls) -> tuple[str, ...]:
        """Return the suffixes of the files that are written: those of a motion without films."""
        return tuple(suffix for suffix in super().suffixes() if suffix not in FILMS)

    @classmethod
    def destinations(
        cls, out: Sequence[Path | str], stem: str, picture: bool = True, more: Sequence[str] = ()
    ) -> output.Destinations:
        """Return the output files; a film of many designs is refused."""
        text = "a sweep has no film; write a page (.html), or trace one design"
        refuse(*((Path(given).suffix.lower() in FILMS, f"{given}: {text}") for given in out))
        return super().destinations(out, stem, picture, more)


class SweepUnderWay(SweepTables, UnderWay[SweepResult]):
    """A sweep that is being computed: first the tables of its chunks, then the result."""

    made = SweepResult

    def whole(self) -> SweepResult:
        """Return the result with all designs; the parts in the folder are removed."""
        found = super().whole()
        self.clear()
        return found


def _listed(table: Table) -> list[dict[str, Any]]:
    """Return the rows of a table as dicts."""
    columns = {column.name: column.values.tolist() for column in table.columns}
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
