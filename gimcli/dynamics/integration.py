"""Integration of the equations of motion in pieces, with rows and events."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np

from gimcli.dynamics.dop853 import StrideSolver
from gimcli.dynamics.equations_of_motion import Equations, EventSearch, Projection, StickEvents
from gimcli.dynamics.integrators import CAREFUL, INTEGRATORS, USUAL, WITH_DRY_FRICTION
from gimcli.dynamics.reducer import release_of
from gimcli.dynamics.simulation_types import (
    DEAD_POINT,
    JAM,
    LIMIT,
    SIMULATION,
    SINGULAR,
    STANDSTILL,
    Event,
    Settings,
    Simulation,
)
from gimcli.errors import UsageError
from gimcli.kernels.dormand_prince import DOUBLE, DUE, FREE_GROWTH
from gimcli.kernels.reduction import KINETIC, POTENTIAL
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.linked_inputs import followed
from gimcli.motion.solve import solve
from gimcli.positions.dispatch import plain
from gimcli.positions.newton import Run
from gimcli.positions.options import TOLERANCE, Options
from gimcli.progress import Progress, spend
from gimcli.status import Status
from gimcli.structure.residual import holds


class Integration:
    """One simulation; the independent variables can differ from piece to piece."""

    def __init__(
        self, mechanism: Mechanism, times: FloatArray, settings: Settings, run: Run, progress: Progress
    ) -> None:
        self.mechanism, self.times, self.settings, self.progress = mechanism, times, settings, progress
        duration = float(times[-1] - times[0])
        self.equations = Equations(mechanism, run, settings.slip or SIMULATION.slip / duration)
        self.free, self.reducer = self.equations.free, self.equations.reducer
        usual = USUAL if self.equations.friction is None else WITH_DRY_FRICTION
        self.integrator = INTEGRATORS[settings.method or usual]
        if self.equations.friction is not None and not self.integrator.lands:
            raise UsageError(
                f"integrator {settings.method}: equal steps do not resolve dry friction; choose {WITH_DRY_FRICTION} or"
                f" {CAREFUL}"
            )
        self.projection = Projection(self.reducer, self.integrator.corrected)
        self.search = EventSearch(self.equations, self._solver, self.integrator.lands)
        self.sticking = None if self.equations.friction is None else StickEvents(self.equations, duration)
        self.friction: list[FloatArray] = []  # of each row
        self.rows: list[tuple[FloatArray, FloatArray, FloatArray]] = []  # variables and rates, energies, efforts
        self.events: list[Event] = []
        self.evaluations = self.steps = 0
        self.accepted = float(times[0])  # time of the last accepted state
        self.fastest = np.zeros(len(mechanism.actuators))  # greatest speed of each input since its last standstill
        self.status, self.contradiction, self.careful = Status.OK, 0.0, math.nan

    def simulation(self) -> Simulation:
        """Integrate; the result has all rows and events up to the end, also if the integration fails."""
        time = float(self.times[0])
        y = self._start(time)
        if y is not None:
            time = self._integrate(time, y)
        return self._result(time)

    def _start(self, time: float) -> FloatArray | None:
        """Return the initial state; None if it cannot be assembled."""
        mechanism, reducer = self.mechanism, self.reducer
        inputs = mechanism.start_inputs
        speeds = []
        for k in self.free:
            release = release_of(mechanism, k)
            inputs[k] = inputs[k] if release.start is None else release.start
            speeds.append(release.speed)
        inputs[list(reducer.given)] = self.equations.given(time)[0]
        inputs = followed(mechanism, inputs)
        position = solve(mechanism, inputs, Options())
        assembled = position.status is Status.OK
        if not (reducer.start(position.z, inputs) if assembled else reducer.start_singular(inputs)):
            self.status = Status.SINGULAR if assembled else position.status
            return None
        if not reducer.on_inputs:
            if any(speeds):
                raise UsageError(
                    f"{mechanism.name} starts at a dead point of its free inputs, where their speed must be 0: change"
                    " `start:`, or remove `speed:`"
                )
            self._event(DEAD_POINT, time, np.zeros(reducer.terms.variables))
        own = len(self.free)
        return np.concatenate([reducer.base.v[reducer.own[:own]], speeds, [0.0, 0.0]])

    # -- pieces -------------------------------------------------------------------------------------

    def _integrate(self, time: float, y: FloatArray) -> float:
        """Integrate to the end; return the time of the end [s]."""
        if self._keep_row(time, y) and self.sticking is not None:
            self.sticking.begin(time)
        end = float(self.times[-1])
        while time < end:
            if not self._accept(time, y):  # sets the signals of events for the new piece
                self.status = self.equations.reason()
                if self.equations.is_jammed:
                    self._event(JAM, time, self.equations.velocity(time, y))
                break
            if self._is_stiff(time, y):
                self.integrator, self.careful = INTEGRATORS[CAREFUL], time
            solver = self._stride_solver(time, y, end) or self._solver(time, y, end)
            stop, changed = self._piece(solver, end)
            if stop is not None:
                return stop
            time, y = solver.t, np.array(solver.y)
            if solver.status == "finished" or self.status is not Status.OK:
                break
            if self._is_stiff(time, y):
                continue
            if not changed and self._takes_care():
                time, y = self.accepted, self.search.last_y.copy()
                continue
            moved = None if self.equations.is_jammed else self.equations.change(self.search.last_y, changed)
            if moved is None:
                self.status = self.equations.reason()
                kind = {Status.LIMIT: LIMIT, Status.JAMMED: JAM}.get(self.status, SINGULAR)
                self._event(kind, time, self.equations.velocity(time, y))
                break
            y = np.concatenate([moved, y[-2:]])
        if self.status is Status.OK and self._due < math.inf:  # the next row is at a singular position
            time, self.status = self._due, self.equations.reason()
        return time

    def _is_stiff(self, time: float, y: FloatArray) -> bool:
        """Return whether speeds decay so fast that an explicit method, which nobody chose, takes too many steps."""
        if self.settings.method or not self.integrator.explicit or self.reducer.conservative:
            return False
        own = len(self.free)
        table = self.equations.jacobian(time, y)[own : 2 * own, own : 2 * own]
        fastest, speed = float(np.max(np.abs(np.linalg.eigvals(table)))), float(np.max(np.abs(y[own : 2 * own])))
        rest = float(self.times[-1]) - time
        return fastest * rest > SIMULATION.stiff and fastest > SIMULATION.damped * speed

    def _ends_early(self) -> bool:
        """Return whether the integration is at its bound on work."""
        if self.reducer.tried > self.settings.work or spend():
            self.status = Status.WORK_LIMIT
        return self.status is Status.WORK_LIMIT

    def _is_creeping(self, solver: Any) -> bool:
        """Return whether the last step was short, in time and in the motion; where speeds decay at once it may be."""
        step, own = solver.t - solver.t_old, len(self.free)
        moved = step * float(np.max(np.abs(solver.y[own : 2 * own])))
        return bool(step < self._creep and moved < SIMULATION.still and math.isnan(self.careful))

    def _takes_care(self) -> bool:
        """Continue with an implicit method where dry friction stops the usual one; return whether that is new."""
        if self.equations.friction is None or self.settings.method or self.integrator is INTEGRATORS[CAREFUL]:
            return False
        self.integrator = INTEGRATORS[CAREFUL]
        return True

    def _piece(self, solver: Any, end: float) -> tuple[float | None, bool]:
        """Take steps until other independent variables are better or a step fails.

        Return the time of the requested end, None before it, and whether other variables are better.
        """
        changed, crept, examined = False, 0, self.reducer.tried + SIMULATION.at_once
        while solver.status == "running" and not changed:
            if not self._step(solver):
                break
            if self._pass(solver):
                self._count(solver)
                return self.events[-1].time, False
            if not self._accept(solver.t, solver.y):
                break
            self._keep_energy(solver)
            if self.sticking is not None:
                self.sticking.take(solver)
            crept = crept + 1 if self._is_creeping(solver) else 0
            if crept > SIMULATION.patience:
                break
            changed = not self.reducer.is_within and (self.equations.is_steep or self.equations.is_gentle)
            self.progress(int(1000 * solver.t / end), 1000)
            if self._ends_early():
                break
            if self.reducer.tried > examined:
                examined += SIMULATION.at_once
                if self._is_stiff(solver.t, np.array(solver.y)):
                    break
        self._count(solver)
        return None, changed

    def _step(self, solver: Any) -> bool:
        """Take one step, or many in one compiled call; return whether it succeeded."""
        strides = isinstance(solver, StrideSolver)
        if strides:
            solver.states.clock[DUE] = self._due
        failed = solver.step() is not None or not np.all(np.isfinite(solver.y)) or solver.t_old is None
        if strides:
            self.projection.greatest_kinetic = max(self.projection.greatest_kinetic, solver.greatest_kinetic)
            self.search.keep(solver.before)
        elif not failed and hasattr(solver, "h_abs") and len(self.free) == 1:
            solver.h_abs = min(solver.h_abs, max(DOUBLE * (solver.t - solver.t_old), FREE_GROWTH * self._creep))
        if failed or (0.0 < solver.t - solver.t_old < self._shortest and solver.status == "running"):
            return False
        self.steps += 0 if strides else 1
        return True

    def _solver(self, time: float, y: FloatArray, end: float) -> Any:
        settings, least = self.settings, SIMULATION.beginning * self._shortest
        return self.integrator.begin(
            self.equations.slopes, time, y, end, rtol=settings.rtol, atol=self.tolerances, step=settings.step,
            least=least, jacobian=self.equations.jacobian,
        )  # fmt: skip

    @property
    def tolerances(self) -> FloatArray:
        """Absolute tolerances of a state."""
        own, places = len(self.free), SIMULATION.absolute * self.settings.rtol
        friction = self.equations.friction
        speeds = places if friction is None else min(places, SIMULATION.resolved * friction.slip)
        energies = SIMULATION.energies
        if friction is not None:  # implicit methods iterate only for what has a tolerance
            acting, whole = self.reducer.acting, float(self.times[-1] - self.times[0])
            weight = float(acting.mass[:, 2].sum()) * acting.metre**2 + float(acting.mass[:, 3].sum())
            energies = SIMULATION.lost * weight / whole**2
        return np.array([places] * own + [speeds] * own + [energies] * 2)

    def _stride_solver(self, time: float, y: FloatArray, end: float) -> StrideSolver | None:
        """Return the solver that takes many steps per compiled call, if the model allows it."""
        reducer, settings = self.reducer, self.settings
        compiled = reducer.run is not plain and self.integrator.compiled
        if not compiled or reducer.given or not reducer.constant or not reducer.on_inputs:
            return None
        if self.projection.start is None or self.equations.friction is not None:
            return None
        return StrideSolver(
            reducer, self.equations.slopes, time, y, end, settings.rtol,
            (self.projection.start, self.projection.greatest_kinetic), self._shortest, self._creep,
        )  # fmt: skip

    @property
    def _due(self) -> float:
        """Time of the next row."""
        return float(self.times[len(self.rows)]) if len(self.rows) < len(self.times) else math.inf

    @property
    def _shortest(self) -> float:
        """Step below which the integration has failed [s]."""
        return SIMULATION.shortest * self._span

    @property
    def _creep(self) -> float:
        """Step below which only `patience` steps in succession are allowed [s]."""
        return SIMULATION.creep * self._span

    @property
    def _span(self) -> float:
        """Time to which short steps are compared [s]: the whole time, less where speeds reverse or decay at once."""
        whole = float(self.times[-1] - self.times[0])
        regular = self.equations.friction is None and math.isnan(self.careful)
        return whole if regular else SIMULATION.reversal * whole

    def _count(self, solver: Any) -> None:
        self.evaluations += solver.nfev
        if isinstance(solver, StrideSolver):
            self.steps += solver.steps
            self.projection.total += solver.corrected

    # -- rows and events ----------------------------------------------------------------------------

    def _pass(self, solver: Any) -> bool:
        """Store the rows and events of the last step; return whether the requested end is reached."""

        @cache
        def path() -> Any:
            """Return the interpolation of the step, made on first use."""
            found = solver.dense_output()
            return found if np.all(np.isfinite(found(0.5 * (solver.t_old + solver.t)))) else self._again(solver)

        stop = math.inf
        for event in self.search.events(solver, path):
            if self._is_creep(event):
                continue
            self.events.append(event)
            done = sum(e.kind == STANDSTILL for e in self.events)
            if event.kind == STANDSTILL and done == self.settings.standstills:
                stop = event.time
                break
        while self._due <= min(solver.t, stop):
            at = self._due
            if not self._keep_row(at, solver.y if at == solver.t else path()(at)):
                break
        return stop < math.inf

    def _is_creep(self, event: Event) -> bool:
        """Return whether an input that dry friction holds reverses its creep: that is no standstill."""
        if self.equations.friction is None or event.kind != STANDSTILL:
            return False
        greatest, self.fastest[event.actuator] = float(self.fastest[event.actuator]), 0.0
        return greatest < SIMULATION.standing * self.equations.friction.slip

    def _again(self, solver: Any) -> Any:
        """Return the states of a step by shorter steps, if the stages of its dense output have no position."""
        start, y = solver.t_old, self.search.last_y

        def state(time: float) -> FloatArray:
            fine = self._solver(start, y, time)
            while fine.status == "running" and fine.step() is None and not self._ends_early():
                pass
            self.evaluations += fine.nfev
            return np.asarray(fine.y if fine.status == "finished" else np.full_like(y, np.nan))

        return state

    def _keep_row(self, time: float, y: FloatArray) -> bool:
        """Store a row; return whether its position was reached."""
        if not self.equations.move(time, y):
            return False
        y, excess = self.projection(y)
        if excess and not self.equations.move(time, y):
            return False
        reducer, out = self.reducer, self.reducer.out
        self.projection.begin()
        jet = np.array([reducer.at.v, reducer.room.velocity, reducer.acceleration])
        self.rows.append((jet, np.append(out.energy[[KINETIC, POTENTIAL]], y[-2:]), out.q[len(self.free) :].copy()))
        if self.equations.friction is not None:
            self.friction.append(self.equations.friction.loop.f.copy())
        self.contradiction = max(self.contradiction, reducer.error(reducer.at.v))
        return True

    def _accept(self, time: float, y: FloatArray) -> bool:
        """Accept a state: the branch is followed from there."""
        if not self.equations.move(time, y):
            return False
        self.reducer.accept()
        self.search.keep(y)
        self.accepted = time
        if self.equations.friction is not None:
            np.maximum(self.fastest, np.abs(self.reducer.inputs(self.reducer.room.velocity)), out=self.fastest)
        return True

    def _keep_energy(self, solver: Any) -> None:
        """Correct the energy of the solver's state if the mechanism is conservative."""
        y, excess = self.projection(solver.y)
        if excess and self.equations.move(solver.t, y):
            self.projection.total += abs(excess)
            self.reducer.accept()
            solver.y[:], solver.f = y, self.equations.slopes(solver.t, y)
            self.search.keep(y)

    def _event(self, kind: str, time: float, velocity: FloatArray) -> None:
        inputs, speeds = self.reducer.inputs(self.reducer.base.v).copy(), self.reducer.inputs(velocity).copy()
        self.events.append(Event(kind, time, inputs, speeds, self.free[0] if len(self.free) == 1 else -1))

    # -- result -------------------------------------------------------------------------------------

    def _result(self, end: float) -> Simulation:
        """Return the simulation up to the last row before one that violates a constraint."""
        mechanism, reducer, dry, count = self.mechanism, self.reducer, self.equations.friction, len(self.rows)
        jets = np.array([jet for jet, _, _ in self.rows]).reshape(count, 3, reducer.terms.variables).swapaxes(0, 1)
        nodes = np.ascontiguousarray(np.swapaxes(reducer.nodes(jets), 1, 2))
        inputs = np.ascontiguousarray(np.swapaxes(reducer.inputs(jets), 1, 2))
        efforts = np.full((len(mechanism.actuators), count), np.nan)
        efforts[list(reducer.given)] = np.array([own for _, _, own in self.rows]).reshape(count, len(reducer.given)).T
        energy = np.array([own for _, own, _ in self.rows]).reshape(count, 4).T
        if self.sticking is not None:
            self.events = sorted([*self.events, *self.sticking.all(end)], key=lambda event: event.time)
        good = holds(mechanism, nodes[0], inputs[0], TOLERANCE)
        if not good.all():
            count = int(np.argmin(good))
            self.status, end = Status.NOT_CONVERGED, float(self.times[count])
        friction = None if dry is None else np.array(self.friction).reshape(-1, len(dry.names))[:count].T
        return Simulation(
            mechanism, self.times[:count], inputs[..., :count], nodes[..., :count], efforts[:, :count],
            energy[:, :count], tuple(self.events), self.status, end,
            self.evaluations + self.search.evaluations, self.steps, self.projection.total, self.contradiction,
            friction, 0.0 if dry is None else dry.slip, self.careful,
        )  # fmt: skip
