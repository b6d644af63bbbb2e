"""Forward dynamics: the motion that loads, weight and drives give a mechanism whose inputs are let go.

The state is the independent variables s, their speeds, and the energies dissipated and supplied since the start:

    M(s) s'' = Q(s, s', t) - h(s, s')

Usually s are the inputs. Near a dead point of them, where M grows beyond all numbers, another variable takes their
place until it has been passed. Source: Durango, Giraldo, Calle & Mesa 2014, eq. 1, for any freedom; Wehage & Haug 1982
for the change of independent variables.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from gimcli.analysis.course import Course
from gimcli.errors import UsageError
from gimcli.kernels.reduction import DISSIPATED, KINETIC, POTENTIAL, SUPPLIED
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.effort import plain
from gimcli.motion.options import Options
from gimcli.motion.position import law_start, solve
from gimcli.motion.reducer import Reducer, State, free_inputs, metre_of, release_of
from gimcli.motion.striding import Strider
from gimcli.solvers.newton import Run
from gimcli.solvers.ode import METHODS, make_solver
from gimcli.status import Status
from gimcli.structure.chart import free_choice, input_choice

STANDSTILL, DEAD_POINT, LIMIT, SINGULAR = "standstill", "dead point", "limit", "singular position"


@dataclass(frozen=True)
class Settings:
    """What the user decides about an integration."""

    method: str = "dop853"
    rtol: float = 1e-9  # of variables and speeds
    step: float = 1e-3  # s, of rk4
    standstills: int = 0  # end at this one; 0: do not

    def __post_init__(self) -> None:
        if self.method not in (*METHODS, "euler"):
            raise UsageError(f"method '{self.method}': choose {', '.join((*METHODS, 'euler'))}")


@dataclass(frozen=True)
class Policy:
    """Constants of the method, each with its reason."""

    steep: float = 12.0  # influence coefficient above which other variables are better: M grows with its square
    gentle: float = 6.0  # below which the inputs serve again: half of it, so that they do not change to and fro
    absolute: float = 0.1  # absolute tolerance (rad, lengths about 1) beside the relative one: where a variable is 0
    energies: float = 1e30  # tolerance of the energies: they follow the motion, the steps do not follow them
    shortest: float = 1e-12  # step beside the whole time: shorter ones lead nowhere, as before a singular position
    bisections: int = 60  # of a bracket: to the last digit
    lively: float = 1e-2  # part of the greatest energies above which the kinetic one tells speeds to enough digits


@dataclass(frozen=True)
class Event:
    """Something that happened on the way."""

    kind: str
    time: float  # s
    inputs: FloatArray  # (actuators,)
    speeds: FloatArray  # (actuators,) by s
    actuator: int = -1  # the input that it is about


@dataclass(frozen=True)
class Simulation:
    """A motion as it came about; rows after its end are missing."""

    mechanism: Mechanism = field(repr=False)
    time: FloatArray  # (rows,) s
    inputs: FloatArray = field(repr=False)  # (3, actuators, rows) values, speeds, accelerations by s
    nodes: ComplexArray = field(repr=False)  # (3, nodes, rows) normal frame
    efforts: FloatArray = field(repr=False)  # (actuators, rows) N m or N x length: of the inputs that follow laws
    energy: FloatArray = field(repr=False)  # (4, rows) J: kinetic, potential; dissipated and supplied since the start
    events: tuple[Event, ...]
    status: Status  # how it ended
    end: float  # s
    evaluations: int
    steps: int
    corrected: float  # J: what the steps alone would have let the energy drift by, added up without signs
    contradiction: float  # greatest residual of all equations, those not used among them

    @property
    def total(self) -> FloatArray:
        """Kinetic and potential energy and what has been dissipated, less what has been supplied [J] (rows,)."""
        kinetic, potential, dissipated, supplied = self.energy
        return np.asarray(kinetic + potential + dissipated - supplied)

    @property
    def drift(self) -> FloatArray:
        """Change of the total since the start [J] (rows,)."""
        return np.asarray(self.total - self.total[0]) if len(self.time) else self.total

    @property
    def worst_drift(self) -> float:
        """Greatest drift relative to the greatest of the energies."""
        if not len(self.time):
            return float("nan")
        scale = max(float(np.max(np.abs(self.energy))), float(np.ptp(self.energy[POTENTIAL])))
        return float(np.max(np.abs(self.drift))) / scale if scale > 0.0 else 0.0

    def course(self) -> Course:
        """Return the motion as what reactions are asked for."""
        return Course(self.time, self.inputs[0], self.nodes)


def simulate(
    mechanism: Mechanism, times: FloatArray, settings: Settings | None = None, run: Run = plain, progress: Any = None
) -> Simulation:
    """Let a mechanism move from its start; return it at `times` (rows,) [s], ascending from the start's."""
    settings = settings or Settings()
    if settings.method == "euler":
        from gimcli.analysis.euler import simulate_by_euler

        return simulate_by_euler(mechanism, times, settings, run, progress)
    return Integration(mechanism, np.asarray(times, dtype=float), settings, run, progress).simulation()


class Integration:
    """One simulation."""

    def __init__(self, mechanism: Mechanism, times: FloatArray, settings: Settings, run: Run, progress: Any) -> None:
        self.mechanism, self.times, self.settings, self.progress = mechanism, times, settings, progress
        metre_of(mechanism)
        self.free = free_inputs(mechanism)
        self.reducer = Reducer(mechanism, self.free, run)
        self.policy = Policy()
        self.rows: list[State] = []
        self.told: list[tuple[float, float]] = []  # dissipated and supplied at the rows
        self.events: list[Event] = []
        self.evaluations = self.steps = 0
        self.status, self.contradiction, self.corrected = Status.OK, 0.0, 0.0
        self.liveliest = 0.0  # J

    # -- from beginning to end ----------------------------------------------------------------------

    def simulation(self) -> Simulation:
        """Run; everything up to the end is kept, whatever ends it."""
        time = float(self.times[0])
        y = self._start(time)
        if y is not None:
            time = self._integrate(time, y)
        return self._result(time)

    def _start(self, time: float) -> FloatArray | None:
        mechanism, reducer = self.mechanism, self.reducer
        inputs = law_start(mechanism)
        speeds = []
        for k in self.free:
            release = release_of(mechanism, k)
            inputs[k] = inputs[k] if release.start is None else release.start
            speeds.append(release.speed)
        for row, k in enumerate(reducer.given):
            inputs[k] = self._given(time, 0)[row]
        position = solve(mechanism, inputs, Options())
        if position.status is not Status.OK and not reducer.start_singular(inputs):
            self.status = position.status
            return None
        if position.status is Status.OK:
            reducer.start(position.z, inputs)
        if not reducer.on_inputs:
            if any(speeds):
                raise UsageError(
                    f"{mechanism.name} starts at a dead point of its free inputs, where they cannot have a speed: give"
                    " another `start:`"
                )
            self._event(DEAD_POINT, time, reducer.base.v, np.zeros(reducer.terms.variables))
        own = len(self.free)
        return np.concatenate([reducer.base.v[reducer.own[:own]], speeds, [0.0, 0.0]])

    def _integrate(self, time: float, y: FloatArray) -> float:
        """Integrate piece by piece, each with its own independent variables; return where it ended."""
        self._tell(time, y)
        end = float(self.times[-1])
        while time < end:
            if not self._accept(time, y):  # the signs of a new piece
                self.status = self._reason()
                break
            solver = self._strider(time, y, end) or self._solver(time, y, end)
            changed = False
            while solver.status == "running" and not changed:
                if isinstance(solver, Strider):
                    solver.due(self._due)
                failed = solver.step() is not None or not np.all(np.isfinite(solver.y))
                if isinstance(solver, Strider):
                    self._last_y = solver.before.copy()
                    self.liveliest = max(self.liveliest, solver.liveliest)
                    self._standing = list(self._last_y[len(self.free) : 2 * len(self.free)])
                if failed or self._is_stuck(solver):
                    break
                self.steps += 0 if isinstance(solver, Strider) else 1
                if self._pass(solver):
                    return self.events[-1].time
                if not self._accept(solver.t, solver.y):
                    break
                self._keep_energy(solver)
                changed = self._is_steep() or self._is_gentle()
                if self.progress is not None:
                    self.progress(int(1000 * solver.t / end), 1000)
            self._count(solver)
            time, y = solver.t, np.array(solver.y)
            if solver.status == "finished":
                break
            moved = self._change(changed)
            if moved is None:
                self.status = self._reason()
                kind = LIMIT if self.status is Status.LIMIT else SINGULAR
                self._event(kind, time, self.reducer.base.v, self._velocity(time, y))
                break
            y = np.concatenate([moved, y[-2:]])
        return time

    def _solver(self, time: float, y: FloatArray, end: float) -> Any:
        settings, own = self.settings, 2 * len(self.free)
        atol = np.array([self.policy.absolute * settings.rtol] * own + [self.policy.energies] * 2)
        return make_solver(settings.method, self._slopes, time, y, end, settings.rtol, atol, settings.step)

    def _strider(self, time: float, y: FloatArray, end: float) -> Strider | None:
        """Return the solver that takes many steps in one compiled call, where nothing has to be asked between."""
        reducer, settings, policy = self.reducer, self.settings, self.policy
        compiled = reducer.run is not plain and settings.method == "dop853"
        if not compiled or reducer.given or not reducer.constant or not reducer.on_inputs or not self.rows:
            return None
        start = float(self.rows[0].energy[KINETIC] + self.rows[0].energy[POTENTIAL])
        return Strider(
            reducer, self._slopes, time, y, end, settings.rtol, policy.absolute * settings.rtol, policy.steep,
            policy.lively, (start, self.liveliest), policy.shortest * float(self.times[-1] - self.times[0]),
        )  # fmt: skip

    @property
    def _due(self) -> float:
        """Time of the next row."""
        return float(self.times[len(self.rows)]) if len(self.rows) < len(self.times) else math.inf

    def _slopes(self, time: float, y: FloatArray) -> FloatArray:
        """Return y' (2 f + 2,); NaN where there is no position."""
        own = len(self.free)
        if not self._move(time, y):
            return np.full(len(y), np.nan)
        energy = self.reducer.out.energy
        return np.concatenate([y[own : 2 * own], self.reducer.gain[:own], energy[[DISSIPATED, SUPPLIED]]])

    def _move(self, time: float, y: FloatArray) -> bool:
        own, reducer = len(self.free), self.reducer
        if not reducer.given:
            return reducer.move(y[:own], y[own : 2 * own], NOTHING, time)
        laws = [self._given(time, order) for order in range(3)]
        target = np.concatenate([y[:own], laws[0]])
        speeds = np.concatenate([y[own : 2 * own], laws[1]])
        return reducer.move(target, speeds, np.concatenate([np.zeros(own), laws[2]]), time)

    def _given(self, time: float, order: int) -> FloatArray:
        """Return the inputs that follow laws; beyond the ends these go on straight."""
        duration = self.mechanism.duration
        at = np.array([time / duration])
        inside, result = np.clip(at, 0.0, 1.0), []
        for k in self.reducer.given:
            law = self.mechanism.actuators[k].law
            beyond = float((at - inside)[0])
            value = float(law(inside, order)[0])
            if beyond and order == 0:
                value += beyond * float(law(inside, 1)[0])
            elif beyond and order == 2:
                value = 0.0
            result.append(value / duration**order)
        return np.array(result)

    # -- rows and events ----------------------------------------------------------------------------

    def _pass(self, solver: Any) -> bool:
        """Tell rows and events of the last step; return whether the motion is to end there."""
        before, after = self._signals(solver.t_old, None), self._signals(solver.t, solver.y)
        crossed = [k for k, (a, b) in enumerate(zip(before, after, strict=True)) if a * b < 0.0]
        if self._due > solver.t and not crossed:
            return False
        path, ending = solver.dense_output(), False
        found = sorted((self._refined(solver, path, k) for k in crossed), key=lambda event: event.time)
        stop = np.inf
        for event in found:
            self.events.append(event)
            done = sum(e.kind == STANDSTILL for e in self.events)
            if event.kind == STANDSTILL and done == self.settings.standstills:
                ending, stop = True, event.time
                break
        while len(self.rows) < len(self.times) and self.times[len(self.rows)] <= min(solver.t, stop):
            at = float(self.times[len(self.rows)])
            if not self._tell(at, solver.y if at == solver.t else path(at)):
                break
        if ending:
            self._count(solver)
        return ending

    def _is_stuck(self, solver: Any) -> bool:
        span = float(self.times[-1] - self.times[0])
        return bool(0.0 < solver.t - solver.t_old < self.policy.shortest * span and solver.status == "running")

    def _count(self, solver: Any) -> None:
        self.evaluations += solver.nfev
        if isinstance(solver, Strider):
            self.steps += solver.steps
            self.corrected += solver.corrected

    def _signals(self, time: float, y: FloatArray | None) -> list[float]:
        """Return what changes its sign at the events: speeds of the free inputs, and at their dead point a determinant.

        y: None where the reducer stands.
        """
        if y is None:
            return self._standing
        if self.reducer.on_inputs:
            return [float(v) for v in y[len(self.free) : 2 * len(self.free)]]
        if not self._move(time, y):
            return [0.0] * len(self._standing)
        return self._here(y)

    def _here(self, y: FloatArray) -> list[float]:
        reducer, own = self.reducer, len(self.free)
        if reducer.on_inputs:
            return [float(v) for v in y[own : 2 * own]]
        b = reducer.at.b[:own][:, [reducer.terms.first_reading + k for k in self.free]]
        if own == 1:
            return [float(y[1]), float(b[0, 0])]
        speeds = reducer.room.velocity[[reducer.terms.first_reading + k for k in self.free]]
        return [*(float(v) for v in speeds), float(np.linalg.det(b))]

    def _refined(self, solver: Any, path: Any, signal: int) -> Event:
        """Find an event by bisection of the states between, then by one step that ends there."""
        low, high = solver.t_old, solver.t
        sign = self._signals(low, None)[signal]
        for _ in range(self.policy.bisections):
            middle = 0.5 * (low + high)
            if not low < middle < high:
                break
            if self._signals(middle, path(middle))[signal] * sign > 0.0:
                low = middle
            else:
                high = middle
        time, y = high, path(high)
        own = len(self.free)
        kind, actuator = (STANDSTILL, self.free[signal]) if signal < own else (DEAD_POINT, self.free[0])
        if self.settings.method != "rk4" and kind == STANDSTILL and time > solver.t_old:
            time, y = self._landed(solver, time, signal)
        self._move(time, y)
        state = self.reducer.state()
        return Event(kind, time, self.reducer.inputs(state.v), self.reducer.inputs(state.velocity), actuator)

    def _landed(self, solver: Any, time: float, signal: int) -> tuple[float, FloatArray]:
        """Integrate from the last step to an event, and go the rest by a tangent: not what lies between steps."""
        start, y = solver.t_old, self._last_y
        for _ in range(2):
            fine = self._solver(start, y, time)
            while fine.status == "running":
                if fine.step() is not None:
                    return time, solver.dense_output()(time)
            self.evaluations += fine.nfev
            slopes = self._slopes(time, fine.y)
            speed = self._here(fine.y)[signal]
            gain = self.reducer.state().acceleration[self.reducer.terms.first_reading + self.free[signal]]
            if not self.reducer.on_inputs and len(self.free) == 1:
                gain = slopes[1]
            rest = -speed / gain if gain else 0.0
            if not abs(rest) < abs(time - start):
                return time, fine.y
            time += rest
        return time, fine.y + rest * slopes

    def _tell(self, time: float, y: FloatArray) -> bool:
        """Keep a row."""
        if not self._move(time, y):
            return False
        y, excess = self._corrected(y)
        if excess and not self._move(time, y):
            return False
        state = self.reducer.state()
        self.rows.append(state)
        self.told.append((float(y[-2]), float(y[-1])))
        self.contradiction = max(self.contradiction, self.reducer.error(state.v))
        return True

    def _accept(self, time: float, y: FloatArray) -> bool:
        """Stand at a state; everything is followed from there."""
        if not self._move(time, y):
            return False
        self.reducer.accept()
        self._last_y = np.array(y)
        self._standing = self._here(y)
        return True

    def _keep_energy(self, solver: Any) -> None:
        """Correct the state of a solver where nothing is dissipated or supplied."""
        y, excess = self._corrected(solver.y)
        if excess and self._move(solver.t, y):
            self.corrected += abs(excess)
            self.reducer.accept()
            solver.y, solver.f = y, self._slopes(solver.t, y)
            self._last_y, self._standing = y.copy(), self._here(y)

    def _corrected(self, y: FloatArray) -> tuple[FloatArray, float]:
        """Return the state just met with speeds for the energy of the start, and the excess of energy before [J].

        Source: Hairer, Lubich & Wanner, Geometric Numerical Integration, 2006, algorithm IV.4.2, along the speeds.
        """
        if self.settings.method not in PROJECTED or not self.reducer.conservative or not self.rows:
            return y, 0.0
        kinetic, potential = (float(e) for e in self.reducer.out.energy[[KINETIC, POTENTIAL]])
        start = self.rows[0].energy
        self.liveliest = max(self.liveliest, kinetic)
        if not kinetic > self.policy.lively * max(self.liveliest, abs(potential)):
            return y, 0.0
        excess, own = kinetic + potential - float(start[KINETIC] + start[POTENTIAL]), len(self.free)
        y = y.copy()
        y[own : 2 * own] *= 1.0 - 0.5 * excess / kinetic
        return y, excess

    def _event(self, kind: str, time: float, v: FloatArray, velocity: FloatArray) -> None:
        inputs, speeds = self.reducer.inputs(v).copy(), self.reducer.inputs(velocity).copy()
        self.events.append(Event(kind, time, inputs, speeds, self.free[0] if len(self.free) == 1 else -1))

    def _velocity(self, time: float, y: FloatArray) -> FloatArray:
        moved = self._move(time, y)
        return self.reducer.room.velocity.copy() if moved else np.zeros(self.reducer.terms.variables)

    # -- the change of independent variables --------------------------------------------------------

    def _is_steep(self) -> bool:
        return bool(np.max(np.abs(self.reducer.base.b[: len(self.free)])) > self.policy.steep)

    def _is_gentle(self) -> bool:
        """Tell whether the inputs would serve again as independent variables."""
        reducer, own = self.reducer, len(self.free)
        if reducer.on_inputs:
            return False
        b = reducer.base.b[:own]
        inner = b[:, [reducer.terms.first_reading + k for k in self.free]]
        if not abs(np.linalg.det(inner)) > 1.0 / self.policy.steep**own:
            return False
        return bool(np.max(np.abs(np.linalg.solve(inner, b))) < self.policy.gentle)

    def _change(self, asked: bool) -> FloatArray | None:
        """Stand on other independent variables; return them and their speeds, None where there are none."""
        reducer, own = self.reducer, len(self.free)
        v, y = reducer.base.v.copy(), self._last_y
        speeds = y[own : 2 * own] @ reducer.base.b[:own]
        if reducer.given:
            speeds = speeds + self._given_speeds @ reducer.base.b[own:]
        if asked and not reducer.on_inputs and self._is_gentle():
            choice = input_choice(reducer.terms, v, self.free, reducer.given)
        else:
            choice = free_choice(reducer.terms, v, reducer.given, own)
        if choice is None or (not asked and reducer.choice is not None and choice == reducer.choice):
            return None
        if not reducer.stand(v, choice):
            return None
        return np.concatenate([v[reducer.own[:own]], speeds[reducer.own[:own]]])

    @property
    def _given_speeds(self) -> FloatArray:
        first = self.reducer.terms.first_reading
        return np.array([self.reducer.room.velocity[first + k] for k in self.reducer.given])

    def _reason(self) -> Status:
        """Return why there is no way on: the law of an input asks too much, or the position is singular."""
        reducer = self.reducer
        regular = free_choice(reducer.terms, reducer.base.v, (), len(self.free) + len(reducer.given))
        return Status.LIMIT if reducer.given and regular is not None else Status.SINGULAR

    # -- what comes out -----------------------------------------------------------------------------

    def _result(self, end: float) -> Simulation:
        mechanism, reducer, rows = self.mechanism, self.reducer, self.rows
        count, actuators = len(rows), len(mechanism.actuators)
        jets = np.zeros((3, count, reducer.terms.variables))
        efforts, energy = np.full((actuators, count), np.nan), np.zeros((4, count))
        for k, state in enumerate(rows):
            jets[:, k] = state.v, state.velocity, state.acceleration
            energy[:2, k] = state.energy[[KINETIC, POTENTIAL]]
            energy[2:, k] = self.told[k]
            efforts[list(reducer.given), k] = state.q[len(self.free) :]
        nodes = np.ascontiguousarray(np.swapaxes(reducer.nodes(jets), 1, 2))
        inputs = np.ascontiguousarray(np.swapaxes(reducer.inputs(jets), 1, 2))
        return Simulation(
            mechanism, self.times[:count], inputs, nodes, efforts, energy, tuple(self.events), self.status, end,
            self.evaluations, self.steps, self.corrected, self.contradiction,
        )  # fmt: skip


PROJECTED = ("dop853", "rk45")
"""Methods whose state may be corrected between steps."""

NOTHING: FloatArray = np.zeros(0)
"""No accelerations given."""
