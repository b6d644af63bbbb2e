"""Find the workspace of a point."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from gimcli import output
from gimcli.errors import refuse
from gimcli.families.grid import Grid, solve_grid
from gimcli.library.inputs import MOST_STEPS, Jit, Range, checked, refuse_unmoved
from gimcli.library.record import Records, RowField, fact
from gimcli.library.result import Result
from gimcli.mechanism import FRAME, ComplexArray, Mechanism
from gimcli.nearest import guess
from gimcli.progress import WORK, Notify, Phases, limited, no_phases
from gimcli.reach.boundary import Workspace, survey, task_of
from gimcli.reach.reach import Reach, reach
from gimcli.reach.region import HOLE, INNER, OUTER
from gimcli.reach.report import (
    assemblies,
    bounds_of,
    held_inputs,
    outlines,
    placed,
    ranges_of,
    reach_table,
    region_table,
)  # fmt: skip
from gimcli.rounding import at_inputs, interval, length, number, spaced
from gimcli.structure.carried import carried_point
from gimcli.structure.mobility import assembled
from gimcli.structure.plan import make_plan
from gimcli.table import Table, labelled


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
        grid: also solve all combinations of this number of values of each input that follows no other; 0: no grid.
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
    name = _point(mechanism, point)
    mechanism = _machine_of(mechanism, name)
    held = _held(mechanism, orientation or {})
    refuse(
        (
            resume and not (grid and folder is not None),
            "resume: continues a grid; give the same grid and the same folder again",
        ),
        (grid and held, "grid: needs all inputs, but orientation fixes some of them; remove one of the two"),
    )
    make_plan(mechanism)
    refuse_unmoved(mechanism, "add an actuator")
    freedoms = task_of(mechanism, name, held).freedoms
    solved = solve_grid(mechanism, name, grid, jit, folder, resume, notify, progress("positions")) if grid else None
    found: Workspace | Reach
    with limited(WORK, seconds) as limit:
        if freedoms == 1:
            phase = "configurations and their circuits" if every else "circuit"
            found = reach(mechanism, name, held, progress(phase), every=every)
        else:
            found = survey(mechanism, name, held, progress("curves"))
    return WorkspaceResult(found, solved, limit.reached)


class WorkspaceResult(Result):
    """The region that a point can reach, or its paths if one input moves it; `arrays()` has the solved grid, if any."""

    KIND = "workspace"

    def __init__(self, found: Workspace | Reach, grid: Grid | None, limited: bool = False) -> None:
        self.mechanism, self._found, self._grid, self.limited = found.task.mechanism, found, grid, limited

    @property
    def complete(self) -> bool:
        """Whether the boundary, or the list of paths, is complete."""
        return self._found.complete

    def headline(self) -> str:
        """Return the result in one line."""
        return f"{self.mechanism.name}: workspace of {self._found.task.point}"

    @cached_property
    def _facts(self) -> Records:
        """What is known of the region or of the paths, as a single row."""
        return path_facts(self._found) if isinstance(self._found, Reach) else region_facts(self._found)

    @property
    def _records(self) -> Records:
        """The curves of the region, or the paths, one row each."""
        return path_rows(self._found) if isinstance(self._found, Reach) else region_curves(self._found)

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        return self._facts.entry() | {"status": self.outcome} | ({"grid": self._grid.report()} if self._grid else {})

    def table(self) -> Table:
        """Return one row for each point of a curve."""
        return reach_table(self._found) if isinstance(self._found, Reach) else region_table(self._found)

    def arrays(self) -> dict[str, Any]:
        """Return the positions of the grid, if there is one, otherwise the columns."""
        return self._grid.arrays() if self._grid else super().arrays()

    def picture(self) -> output.picture.Content:
        """Return the region or the paths, with one position of the mechanism."""
        found, mechanism, name = self._found, self.mechanism, self._found.task.point
        places = self._grid.places.ravel() if self._grid else None
        pose, at = _pose(found.task)
        if isinstance(found, Reach):
            paths = [placed(mechanism, run.points()) for run in found.runs]
            return output.workspace.path_picture(mechanism, pose, paths, (name, at), self.headline())
        if not found.loops:  # no boundary: draw the positions themselves
            reached = placed(mechanism, found.positions)
            at = complex(reached.mean()) if found.single is not None else at
            places = reached if places is None and found.single is None else places
        return output.workspace.workspace_picture(mechanism, pose, outlines(found), (name, at), places, self.headline())

    def geometry(self) -> output.geometry.Geometry | None:
        """Return the boundary or the paths, and one position of the mechanism, in true size; None without any."""
        found = _geometry_of(self._found)
        pose, at = _pose(self._found.task)
        if pose is not None:
            found.add_mechanism(self.mechanism, pose, {} if at is None else {self._found.task.point: at})
        return found if found.layers else None


def region_curves(found: Workspace) -> Records:
    """Return the curves of a region, one row each."""
    mechanism, edges, scale = found.task.mechanism, found.edges, found.task.mechanism.scale
    held = [held_inputs(found.task, edge) for edge in edges]
    return Records(
        RowField("curve", range(len(edges)), int, head="curve", key=False),
        RowField("kind", [edge.kind for edge in edges], head="kind"),
        RowField("held", held, head="cause",
                 text=[f"range ends: {at_inputs(mechanism, own)}" if own else "singular" for own in held]),
        RowField("length", [edge.arc.length * scale for edge in edges], float, mechanism.length_unit, head="length",
                 size=mechanism.size * scale),
        RowField("points", [len(edge.arc.y) for edge in edges]),
    )  # fmt: skip


def region_facts(found: Workspace) -> Records:
    """Return area, extent, parts and curves of a region as a single row."""
    mechanism, scale = found.task.mechanism, found.task.mechanism.scale
    unit = spaced(mechanism.length_unit)
    area, error, perimeter = found.area * scale**2, found.area_error * scale**2, found.perimeter * scale
    size, bounds = number(area, (mechanism.size * scale) ** 2), bounds_of(mechanism, found.bounds)
    spans = (f"{axis} {_span(mechanism, ends)}{unit}" for axis, ends in bounds.items())
    return Records(
        fact("point", found.task.point),
        fact("freedoms", found.task.freedoms),
        fact("complete", found.complete),
        fact("area", area, f"{size}{unit and f'{unit}^2'} (estimated error {error:.0e})", head="area"),
        fact("area_error", error),
        fact("perimeter", perimeter, f"{length(mechanism, perimeter)}{unit}", head="length of the boundary"),
        fact("bounds", bounds, ", ".join(spans), head="extent"),
        fact("regions", sum(loop.area > 0.0 for loop in found.loops), head="regions"),
        fact("holes", sum(loop.area < 0.0 for loop in found.loops), head="holes"),
        fact("barriers", len(found.inner), head="inner curves"),
        fact("curves", region_curves(found).report()),
    )


def path_rows(found: Reach) -> Records:
    """Return the paths, one row each."""
    mechanism, runs, unit = found.task.mechanism, found.runs, found.task.mechanism.length_unit
    bounds = [bounds_of(mechanism, run.bounds) for run in runs]

    def ranges(inputs: dict[str, Any]) -> str:
        return ", ".join(
            f"{name}: {'full turn' if one['full_turn'] else interval(mechanism, name, one['from'], one['to'])}"
            for name, one in inputs.items()
        )

    return Records(
        RowField("path", [f"{k}{' *' * run.drawn}" for k, run in enumerate(runs)], head="path", key=False),
        RowField("drawn", [run.drawn for run in runs]),
        RowField("closed", [run.closed for run in runs]),
        RowField("length", [run.length * mechanism.scale for run in runs], float, unit, head="length",
                 size=mechanism.size * mechanism.scale),
        RowField("bounds", bounds),
        *(
            RowField(axis, [_span(mechanism, one[axis]) for one in bounds], head=labelled(axis, unit), key=False)
            for axis in "xy"
        ),
        RowField("inputs", [ranges_of(mechanism, run) for run in runs], head="inputs", text=ranges),
    )  # fmt: skip


def path_facts(found: Reach) -> Records:
    """Return the paths, and the assemblies that are on none of them, as a single row."""
    return Records(
        fact("point", found.task.point),
        fact("freedoms", 1),
        fact("complete", found.complete),
        fact("all", found.start is None),
        fact("assemblies", None if found.start is None else assemblies(found.task.mechanism, found.start)),
        fact("paths", path_rows(found).report()),
    )


def _span(mechanism: Mechanism, ends: list[float]) -> str:
    return " to ".join(length(mechanism, value) for value in ends)


def _geometry_of(found: Workspace | Reach) -> output.geometry.Geometry:
    """Return the boundary or the paths in true size."""
    mechanism, geometry = found.task.mechanism, output.geometry.Geometry(found.task.mechanism.length_unit)
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
    refuse((given not in names, f"point: no node or point '{given}'; {guess(given, names, 'nodes and points')}"))
    return given


def _machine_of(mechanism: Mechanism, point: str) -> Mechanism:
    """Return the machine that moves a point; the mechanism itself if it is one machine, or if nothing moves the point.

    Raise UsageError for a point of a part without inputs.
    """
    for one in mechanism.machines:
        own = one.mechanism
        moving = [n for n, name in enumerate(own.nodes) if name == point and n not in own.members[FRAME].nodes]
        if moving or any(p.name == point and p.member != FRAME for p in own.points):
            refuse(
                (
                    not one.actuators and mechanism.actuators,
                    f"point: no input moves {point}; give a point of {_listed(mechanism)}",
                )
            )
            return own
    return mechanism


def _listed(mechanism: Mechanism) -> str:
    """Return the machines with inputs, in words."""
    names = [one.name for one in mechanism.machines if one.actuators]
    return f"machine{'s' * (len(names) > 1)} {', '.join(names)}"


def _held(mechanism: Mechanism, given: Mapping[str, float]) -> dict[str, float]:
    """Return the members with a fixed direction, and the directions [rad]."""
    finite = (
        (not math.isfinite(one), f"orientation {n}: expected a finite angle, got {one}") for n, one in given.items()
    )
    refuse(*finite)
    return {name: math.radians(angle) if mechanism.angle_unit == "deg" else angle for name, angle in given.items()}


def _pose(task: Any) -> tuple[ComplexArray | None, complex | None]:
    """Return an assembled position near the drawn one, and the point in it; None if directions are fixed."""
    mechanism = task.mechanism
    z = None if task.orientation else assembled(mechanism)
    if z is None:
        return None, None
    return mechanism.to_file(z), complex(mechanism.to_file(carried_point(mechanism, task.point, z[:, None]))[0])
