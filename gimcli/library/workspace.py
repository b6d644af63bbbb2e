"""Find the workspace of a point."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from gimcli.errors import StructureError, UsageError
from gimcli.families.grid import Grid, Kept, solve_grid
from gimcli.library.inputs import MOST_STEPS, Jit, Range, checked, refuse_linked, refuse_unmoved
from gimcli.library.result import Result
from gimcli.mechanism import FRAME, ComplexArray, Mechanism
from gimcli.nearest import guess
from gimcli.progress import WORK, Notify, Phases, limited, no_phases
from gimcli.reach.boundary import Workspace, survey, task_of
from gimcli.reach.reach import Reach, reach
from gimcli.reach.region import HOLE, INNER, OUTER
from gimcli.reach.report import outlines, placed, reach_report, reach_table, region_report, region_table
from gimcli.structure.carried import carried_point
from gimcli.structure.drive_check import explained
from gimcli.structure.mobility import assembled
from gimcli.structure.plan import make_plan
from gimcli.table import Table

if TYPE_CHECKING:
    from gimcli.output.geometry import Geometry
    from gimcli.output.picture import Content


@checked
def workspace(
    mechanism: Mechanism, point: str = "", *, orientation: Mapping[str, float] | None = None, every: bool = False,
    grid: Annotated[int, Range(0, MOST_STEPS)] = 0, jit: Jit = "auto", folder: Path | str | None = None,
    resume: bool = False, notify: Notify | None = None, progress: Phases = no_phases, seconds: float | None = None,
) -> WorkspaceResult:  # fmt: skip
    """Find the region that a node or point can reach, or its paths if one input moves it.

    A region is that of all assemblies. Paths are those that the initial configuration reaches within the range of the
    input, or those of all assemblies.

    Args:
        mechanism: from `load` or `loads`.
        point: node or point, by default the first of `trace` in the file.
        orientation: dict of members with a fixed direction, in the file's angle unit, such as {"platform": 0}.
        every: with one input: the paths of all assemblies; a region is always that of all.
        grid: also solve all combinations of this number of values of each input; 0: no grid.
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        folder: for the parts of the grid, so that an interrupted run can be resumed.
        resume: use the parts in `folder` of an interrupted run with the same model and options.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        seconds: the search ends after this time with what was found; by default there is a bound in positions only.

    Returns:
        A WorkspaceResult: one row for each point of the curves, in the file's units; `report()` has the area.

    Raises:
        UsageError: an unknown name, an invalid argument, or arguments that exclude each other.
        StructureError: the mechanism has no actuator, or is not fully driven or over-driven.
        UnassembledError: no assembled position within the ranges of the laws was found.
    """
    refuse_linked(mechanism, "workspace")
    if mechanism.couplings:
        raise StructureError(
            f"{mechanism.name} has inputs that follow others: `gim trace` and `gim circuits` give the paths of points"
        )
    name = _point(mechanism, point)
    mechanism = _machine_of(mechanism, name)
    held = _held(mechanism, orientation or {})
    if resume and not (grid and folder is not None):
        raise UsageError("resume: continues a grid; give the same grid and the same folder again")
    if grid and held:
        raise UsageError("grid: needs all inputs, but orientation fixes some of them; remove one of the two")
    with explained(mechanism):
        make_plan(mechanism)
    refuse_unmoved(mechanism, "add an actuator")
    freedoms = task_of(mechanism, name, held).freedoms
    kept = None if folder is None else Kept(Path(folder), resume)
    solved = solve_grid(mechanism, name, grid, jit, kept, notify, progress("positions")) if grid else None
    found: Workspace | Reach
    with limited(WORK, seconds) as limit:
        if freedoms == 1:
            phase = "configurations and their circuits" if every else "circuit"
            found = reach(mechanism, name, held, progress(phase), every=every)
        else:
            found = survey(mechanism, name, held, progress("curves"))
    return WorkspaceResult(found, solved, limit.reached)


class WorkspaceResult(Result):
    """The region that a point can reach, or its paths if one input moves it, and the solved `grid`, or None."""

    KIND = "workspace"

    def __init__(self, found: Workspace | Reach, grid: Grid | None, limited: bool = False) -> None:
        self.mechanism, self._found, self.grid, self.limited = found.task.mechanism, found, grid, limited

    @property
    def complete(self) -> bool:
        """Whether the boundary, or the list of paths, is complete."""
        return bool(self.report()["complete"])

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: workspace of {self._found.task.point}"

    @cached_property
    def _report(self) -> dict[str, Any]:
        return reach_report(self._found) if isinstance(self._found, Reach) else region_report(self._found)

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        return self._report | {"status": self.outcome} | ({"grid": self.grid.report()} if self.grid else {})

    def table(self) -> Table:
        """Return one row for each point of a curve."""
        return reach_table(self._found) if isinstance(self._found, Reach) else region_table(self._found)

    def arrays(self) -> dict[str, Any]:
        """Return the positions of the grid, if there is one, otherwise the columns."""
        return self.grid.arrays() if self.grid else super().arrays()

    def picture(self) -> Content:
        """Return the region or the paths, with one position of the mechanism."""
        from gimcli.output.workspace import path_picture, workspace_picture

        found, mechanism, name = self._found, self.mechanism, self._found.task.point
        places = self.grid.places.ravel() if self.grid else None
        pose, at = _pose(found.task)
        if isinstance(found, Reach):
            paths = [placed(mechanism, run.points()) for run in found.runs]
            return path_picture(mechanism, pose, paths, (name, at), self.headline())
        if not found.loops:  # no boundary: draw the positions themselves
            reached = placed(mechanism, found.positions)
            at = complex(reached.mean()) if found.single is not None else at
            places = reached if places is None and found.single is None else places
        return workspace_picture(mechanism, pose, outlines(found), (name, at), places, self.headline())

    def geometry(self) -> Geometry | None:
        """Return the boundary or the paths, and one position of the mechanism, in true size; None without any."""
        found = _geometry_of(self._found)
        pose, at = _pose(self._found.task)
        if pose is not None:
            found.add_mechanism(self.mechanism, pose, {} if at is None else {self._found.task.point: at})
        return found if found.layers else None


def _geometry_of(found: Workspace | Reach) -> Geometry:
    """Return the boundary or the paths in true size."""
    from gimcli.output.geometry import Geometry

    mechanism, geometry = found.task.mechanism, Geometry(found.task.mechanism.length_unit)
    if isinstance(found, Reach):
        for number, run in enumerate(found.runs, start=1):
            geometry.add_curve(f"curve {found.task.point} path {number}", placed(mechanism, run.points()))
        return geometry
    curves = outlines(found)
    for kind, layer in ((OUTER, "boundary"), (HOLE, "hole")):
        geometry.add_loops(layer, curves[kind])
    for curve in curves[INNER]:
        geometry.add_curve("inner curves", curve)
    return geometry


def _point(mechanism: Mechanism, given: str) -> str:
    """Return the requested point, or the first traced one."""
    names = [*mechanism.nodes, *(p.name for p in mechanism.points)]
    if not given:
        driven = {n for one in mechanism.machines if one.actuators for n in one.mechanism.traced}
        return next((name for name in mechanism.traced if name in driven), mechanism.traced[0])
    if given not in names:
        raise UsageError(f"point: no node or point '{given}'; {guess(given, names, 'nodes and points')}")
    return given


def _machine_of(mechanism: Mechanism, point: str) -> Mechanism:
    """Return the machine that moves a point; the mechanism itself if it is one machine, or if nothing moves the point.

    Raise UsageError for a point of a part without inputs.
    """
    for one in mechanism.machines:
        own = one.mechanism
        moving = [n for n, name in enumerate(own.nodes) if name == point and n not in own.members[FRAME].nodes]
        if moving or any(p.name == point and p.member != FRAME for p in own.points):
            if not one.actuators and mechanism.actuators:
                raise UsageError(f"point: no input moves {point}; give a point of {_listed(mechanism)}")
            return own
    return mechanism


def _listed(mechanism: Mechanism) -> str:
    """Return the machines with inputs, in words."""
    names = [one.name for one in mechanism.machines if one.actuators]
    return f"machine{'s' * (len(names) > 1)} {', '.join(names)}"


def _held(mechanism: Mechanism, given: Mapping[str, float]) -> dict[str, float]:
    """Return the members with a fixed direction, and the directions [rad]."""
    for name, angle in given.items():
        if not math.isfinite(angle):
            raise UsageError(f"orientation {name}: expected a finite angle, got {angle}")
    return {name: math.radians(angle) if mechanism.angle_unit == "deg" else angle for name, angle in given.items()}


def _pose(task: Any) -> tuple[ComplexArray | None, complex | None]:
    """Return an assembled position near the drawn one, and the point in it; None if directions are fixed."""
    mechanism = task.mechanism
    z = None if task.orientation else assembled(mechanism)
    if z is None:
        return None, None
    return mechanism.to_file(z), complex(mechanism.to_file(carried_point(mechanism, task.point, z[:, None]))[0])
