"""Find what a point reaches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gimcli.errors import UsageError
from gimcli.library.grid import Grid, Kept, solve_grid
from gimcli.library.inputs import MOST_STEPS, near, refuse_choice, refuse_count, refuse_unmoved
from gimcli.library.result import Result
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.motion.coupler_points import carried_point
from gimcli.positions.options import JIT
from gimcli.progress import Notify, Phases, no_phases
from gimcli.reach.boundary import Workspace, survey, task_of
from gimcli.reach.reach import Reach, reach
from gimcli.reach.report import outlines, placed, reach_report, reach_table, region_report, region_table
from gimcli.structure.drive_check import explained
from gimcli.structure.mobility import assembled
from gimcli.structure.plan import make_plan
from gimcli.table import Table

if TYPE_CHECKING:
    from gimcli.output.picture import Content


def workspace(
    mechanism: Mechanism, point: str = "", *, orientation: Mapping[str, float] | None = None, grid: int = 0,
    jit: str = "auto", keep: Path | str | None = None, resume: bool = False, notify: Notify | None = None,
    progress: Phases = no_phases,
) -> WorkspaceResult:  # fmt: skip
    """Find what a node or point reaches, over all configurations: by default the first that is traced.

    `orientation` keeps the directions of members, in the file's angle unit. `grid` also solves so many values of every
    input in all combinations; their parts are kept in the folder `keep` until all are done, and `resume` goes on with
    them. Raises UsageError, and StructureError where the mechanism is over-driven or not driven.
    """
    refuse_choice("jit", jit, JIT)
    refuse_count("grid", grid, 0, MOST_STEPS)
    name, held = _point(mechanism, point), _held(mechanism, orientation or {})
    if resume and not (grid and keep is not None):
        raise UsageError("--resume goes on with a grid: add --grid N as before")
    if grid and held:
        raise UsageError("--grid spaces the inputs evenly, which --orientation does not leave free: choose one of them")
    with explained(mechanism):
        make_plan(mechanism)
    refuse_unmoved(mechanism, "add one")
    freedoms = task_of(mechanism, name, held).freedoms
    kept = None if keep is None else Kept(Path(keep), resume)
    solved = solve_grid(mechanism, name, grid, jit, kept, notify, progress("positions")) if grid else None
    found: Workspace | Reach
    if freedoms == 1:
        found = reach(mechanism, name, held, progress("configurations and their circuits"))
    else:
        found = survey(mechanism, name, held, progress("curves"))
    return WorkspaceResult(found, solved)


class WorkspaceResult(Result):
    """The region that a point reaches, or its paths where one input moves it (`found`), and the `grid` solved."""

    KIND = "workspace"

    def __init__(self, found: Workspace | Reach, grid: Grid | None) -> None:
        self.mechanism, self.found, self.grid = found.task.mechanism, found, grid

    @property
    def complete(self) -> bool:
        """Tell whether nothing is missing of the boundary, or of the list of paths."""
        return bool(self.report()["complete"])

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: what {self.found.task.point} reaches"

    @cached_property
    def _report(self) -> dict[str, Any]:
        return reach_report(self.found) if isinstance(self.found, Reach) else region_report(self.found)

    def report(self) -> dict[str, Any]:
        """Return what --json prints."""
        return self._report | ({"grid": self.grid.report()} if self.grid else {})

    def table(self) -> Table:
        """Return one row a point of a curve."""
        return reach_table(self.found) if isinstance(self.found, Reach) else region_table(self.found)

    def arrays(self) -> dict[str, Any]:
        """Return the places that the grid reaches, if there is one, else the columns."""
        return self.grid.arrays() if self.grid else super().arrays()

    def picture(self) -> Content:
        """Return the region, or the paths, over a position."""
        from gimcli.output.workspace import path_picture, workspace_picture

        found, mechanism, name = self.found, self.mechanism, self.found.task.point
        places = self.grid.places.ravel() if self.grid else None
        pose, at = _pose(found.task)
        if isinstance(found, Reach):
            paths = [placed(mechanism, run.points()) for run in found.runs]
            return path_picture(mechanism, pose, paths, (name, at), self.headline())
        if not found.loops:  # nothing else would show what is reached
            reached = placed(mechanism, found.positions)
            at = complex(reached.mean()) if found.single is not None else at
            places = reached if places is None and found.single is None else places
        return workspace_picture(mechanism, pose, outlines(found), (name, at), places, self.headline())


def _point(mechanism: Mechanism, given: str) -> str:
    """Return the point asked for, or the first that is traced."""
    names = [*mechanism.nodes, *(p.name for p in mechanism.points)]
    if not given:
        return mechanism.traced[0]
    if given not in names:
        raise UsageError(f"--point {given}: no such node or point{near(given, names, 'nodes and points')}")
    return given


def _held(mechanism: Mechanism, given: Mapping[str, float]) -> dict[str, float]:
    """Return the members whose direction is held, and the angles [rad]."""
    for name, angle in given.items():
        if not math.isfinite(angle):
            raise UsageError(f"--orientation {name}={angle}: write MEMBER=ANGLE, such as platform=0")
    return {name: math.radians(angle) if mechanism.angle_unit == "deg" else angle for name, angle in given.items()}


def _pose(task: Any) -> tuple[ComplexArray | None, complex | None]:
    """Return an assembled pose next to the drawn one and where the point is in it; none where directions are held."""
    mechanism = task.mechanism
    z = None if task.orientation else assembled(mechanism)
    if z is None:
        return None, None
    return mechanism.to_file(z), complex(mechanism.to_file(carried_point(mechanism, task.point, z[:, None]))[0])
