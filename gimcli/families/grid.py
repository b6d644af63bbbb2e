"""Solve a grid of inputs in parts, so that an interrupted run can be resumed.

The grid of inputs for `--grid`, from the ranges of the laws.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gimcli.contents import contents
from gimcli.errors import UsageError
from gimcli.mechanism import FRAME, ComplexArray, Dynamics, FloatArray, Mechanism
from gimcli.motion.scatter import InputGrid, Scatterer, scattered, with_kernel
from gimcli.output.parts import Parts
from gimcli.progress import Notify, Progress
from gimcli.rates.plan_rates import carrier
from gimcli.reach.task import FULL, law_range, periods
from gimcli.version import __version__

MOST = 50_000_000
"""Most positions of a grid."""


def input_grid(mechanism: Mechanism, count: int) -> InputGrid:
    """Return a grid of `count` values per moving input over the range of its law; a full turn has no end value.

    It has the inputs that follow no other. Raises UsageError for more than MOST positions.
    """
    drivers = list(mechanism.drivers)
    spans = [law_range(mechanism, k) for k in drivers]
    low, high = (np.array([getattr(span, end) for span in spans]) for end in ("low", "high"))
    period = periods(mechanism)[drivers]
    turning = high - low >= FULL * period
    grid = InputGrid(low, np.where(turning, low + period, high), tuple(turning.tolist()), count)
    if grid.rows > MOST:
        raise UsageError(f"grid {count}: {grid.rows} combinations of {len(spans)} inputs, more than {MOST}; reduce it")
    return grid


def carried_by(mechanism: Mechanism, name: str) -> tuple[int, int, complex]:
    """Return a node or point as a linear combination of two nodes; raise UsageError for a fixed point."""
    if any(point.name == name and point.member == FRAME for point in mechanism.points):
        raise UsageError(f"'{name}' does not move: give a moving node or point")
    return carrier(mechanism, name)


@dataclass(frozen=True)
class Grid:
    """Positions of a point at all combinations of the inputs; NaN where a configuration does not exist."""

    places: ComplexArray  # (configurations, values of the first input, of the second, ...), the file's coordinates
    axes: dict[str, FloatArray]  # values of each input, the file's units
    resumed: int  # number of parts that were already there
    parts: int
    store: Parts | None = None

    def clear(self) -> None:
        """Remove the parts from the folder, after the whole grid was written."""
        if self.store is not None:
            self.store.clear()

    def report(self) -> dict[str, Any]:
        """Return the numbers of positions, configurations and solved positions."""
        z = self.places.reshape(len(self.places), -1)
        return {
            "positions": z.shape[1], "configurations": len(z), "solved": int(np.isfinite(z).sum()),
            "reached": int(np.isfinite(z).any(axis=0).sum()), "resumed_parts": self.resumed, "parts": self.parts,
        }  # fmt: skip

    def arrays(self) -> dict[str, Any]:
        """Return x, y and the values of the inputs by their names in the .npz file."""
        axes = {f"input_{name}": values for name, values in self.axes.items()}
        return {"x": self.places.real, "y": self.places.imag, **axes}


def solve_grid(
    mechanism: Mechanism, name: str, count: int, jit: str, folder: Path | str | None, resume: bool,
    notify: Notify | None, progress: Progress,
) -> Grid:  # fmt: skip
    """Solve the position of a node or point at all combinations of `count` values of each input.

    Its parts are kept in `folder`, if there is one, until all are done; `resume` uses those that are already there.
    """
    job = with_kernel(Scatterer(mechanism, carried_by(mechanism, name), input_grid(mechanism, count)), jit, notify)
    store = None if folder is None else Parts(Path(folder), _header(job, mechanism, name), resume)
    done = set[int]() if store is None else store.done
    parts: dict[int, ComplexArray] = {}
    missing = [k for k in range(job.parts) if k not in done]
    for solved, (k, values) in enumerate(scattered(job, missing), start=len(done) + 1):
        if store is None:
            parts[k] = values
        else:
            store.put(k, values)
        progress(solved, job.parts)
    z = np.concatenate([parts[k] if store is None else store.get(k) for k in range(job.parts)], axis=1)
    places = mechanism.to_file(z).reshape(len(z), *job.grid.counts)
    axes = {
        mechanism.actuators[k].name: mechanism.value_to_file(k, job.grid.axis(number))
        for number, k in enumerate(mechanism.drivers)
    }
    return Grid(places, axes, len(done), job.parts, store)


def _header(job: Scatterer, mechanism: Mechanism, name: str) -> dict[str, Any]:
    """Return the run that the parts of a grid belong to: the model's content, the ranges of its laws, the options."""
    return {
        "version": __version__, "model": model_hash(mechanism), "point": name,
        "grid": job.grid.count, "low": job.grid.low.tolist(), "high": job.grid.high.tolist(),
        "configurations": len(job.sides), "positions a part": job.part,
    }  # fmt: skip


def model_hash(mechanism: Mechanism) -> str:
    """Return a hash of all numbers and names on which positions depend."""
    return contents_hash(replace(mechanism, files=(), path=None, written=None, dynamics=Dynamics(), gauges=()))


def contents_hash(value: Any) -> str:
    """Return a hash of all numbers and names of a model or a part of one."""
    found = hashlib.sha256()
    for part in contents(value):
        found.update(part)
    return found.hexdigest()
