"""A motion beyond the limit of its input, or on another branch: rows told by the circuit instead of step by step.

`stop`: rows after the limit are empty. `skip`: rows that the input cannot reach are empty, later ones that it can
reach again are solved on the arc between limits that the motion was on. `reverse`: the input turns back at the limit
and the motion goes on through it. A branch is chosen at the first change point on the way.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gimcli.errors import UsageError
from gimcli.mechanism import FloatArray, Mechanism
from gimcli.motion.branches import first_circuit, leaving
from gimcli.motion.circuit import Circuit, Policy
from gimcli.motion.curve import Curve
from gimcli.motion.effort import plain
from gimcli.motion.inputs import law_inputs
from gimcli.motion.motion import Motion, trace
from gimcli.motion.options import Options
from gimcli.motion.start import moved
from gimcli.motion.stations import as_motion
from gimcli.motion.track import Route, Track
from gimcli.solvers.crossing import Crossing
from gimcli.status import Status
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import allowed, residual

AT_LIMIT = ("stop", "skip", "reverse")
SINGULAR = 1e-7
"""Part of a unit tangent below which the input rests on a branch."""

Progress = Callable[[int, int], None]


def ride(
    mechanism: Mechanism, steps: int, options: Options, at_limit: str = "stop", branch: int = 1,
    progress: Progress | None = None,
) -> Motion:  # fmt: skip
    """Follow the laws in some steps, with what to do at a limit, and the branch to take at the first change point.

    Raises UsageError where there is no such branch, or the input cannot drive it.
    """
    motion = trace(mechanism, steps, options, progress=progress)
    if motion.first_status is not Status.OK or (branch == 1 and (motion.limit is None or at_limit == "stop")):
        return motion
    if branch == 1 and at_limit == "skip" and len(mechanism.actuators) > 1:
        return _skipped(motion, options)
    curve = Curve(mechanism)
    rider = _Rider(motion, curve, branch, options.tolerance)
    return rider.skip() if at_limit == "skip" else rider.rows(at_limit == "reverse")


class _Rider:
    """Solves the rows of a motion on a route."""

    def __init__(self, motion: Motion, curve: Curve, branch: int, tolerance: float) -> None:
        self.motion, self.curve, self.branch, self.tolerance = motion, curve, branch, tolerance
        self.sense = curve.forward()
        self.circuit = first_circuit(curve, motion.z[:, 0], curve.begin())
        self.route = Route(Track(self.circuit)) if branch == 1 else self._branched()

    def asked(self, time: FloatArray) -> FloatArray:
        """Return the way (rows,) that the laws ask for at times (rows,)."""
        q = law_inputs(self.curve.mechanism)(time)[0] if self.curve.single else time * self.curve.span
        return np.asarray(self.sense * (q - self.curve.begin()))

    def rows(self, beyond: bool) -> Motion:
        """Return the motion along the route, beyond its limits or up to the first."""
        asked = self.asked(self.motion.time)
        limit = self.route.limit()
        first = self._first(asked)
        reached = len(asked)
        if not beyond:
            over = np.flatnonzero(asked > limit)
            reached = int(over[0]) if len(over) else reached
        p = np.full((len(self.circuit.places[0].p), len(asked)), np.nan)
        for k in range(first, reached):
            found = self.route.place(float(asked[k]))
            if found is not None:
                p[:, k] = found
        return self._made(p, first, limit, beyond)

    def skip(self) -> Motion:
        """Return the motion with the rows that the input reaches again."""
        asked, first = self.asked(self.motion.time), self._first(self.asked(self.motion.time))
        if self.branch > 1:
            raise UsageError("--at-limit skip: the rows reached again are those of branch 1; leave out --branch")
        track = self.route.first
        q = self.curve.begin() + self.sense * asked
        p = np.full((len(self.circuit.places[0].p), len(asked)), np.nan)
        for k in range(first, len(q)):
            found = self._on_arc(track, float(q[k]))
            if found is not None:
                p[:, k] = found
        return self._made(p, first, self.route.limit())

    def _on_arc(self, track: Track, q: float) -> FloatArray | None:
        """Return the position of the arc at a parameter.

        A rotary input counts without its turns, unless the arc is longer than one: there the motion would jump from
        its limit to another position of the same angle.
        """
        turn = 2.0 * math.pi
        low, high = track.arc
        ends = float(track.places[low].p[-1]), float(track.places[high].p[-1])
        if not self.curve.rotary[0] or abs(ends[1] - ends[0]) >= turn:
            return track.on_arc(q)
        middle = 0.5 * (ends[0] + ends[1])
        rounds = round((q - middle) / turn)
        found = track.on_arc(q - rounds * turn)
        if found is not None:
            found[-1] += rounds * turn
        return found

    def _first(self, asked: FloatArray) -> int:
        """Return the first row that the motion step by step has not solved on this route."""
        bad = np.flatnonzero(~self.motion.good)
        own = int(bad[0]) if len(bad) else len(asked)
        if self.branch > 1:
            after = np.flatnonzero(asked > self.route.at)
            own = min(own, int(after[0]) if len(after) else len(asked))
        return own

    def _made(self, p: FloatArray, first: int, limit: float, turns_back: bool = False) -> Motion:
        """Return the motion with its rows from `first` on replaced by p (n + 1, rows); NaN is out of reach."""
        motion = self.motion
        reached = np.flatnonzero(np.isfinite(p[-1]))
        z, inputs = motion.z.copy(), motion.inputs.copy()
        codes, error = motion.codes.copy(), motion.residual.copy()
        z[:, first:], error[first:] = complex(np.nan, np.nan), np.nan
        codes[first:] = int(Status.LIMIT)
        if len(reached):
            own = as_motion(self.circuit, motion.time[reached], p[:, reached], self.tolerance)
            z[:, reached] = own.z
            if turns_back:
                inputs[:, reached] = own.inputs
            codes[reached], error[reached] = own.codes, own.residual
        asked = self.asked(motion.time)
        q = self.curve.begin() + self.sense * asked
        q[reached] = p[-1, reached]
        end = float(asked.max())
        bridged = [self._time(asked, w) for w in self.route.crossings(min(end, limit))]
        back = [(self._time(asked, w), self.route.place(w)) for w in self.route.turns_back(end) if turns_back]
        return replace(
            motion, z=z, inputs=inputs, codes=codes, residual=error, limit=self._time(asked, limit),
            parameter=q if turns_back else None,
            bridged=tuple(t for t in bridged if t is not None) if self.branch > 1 else motion.bridged,
            turned_back=tuple(
                (t, tuple(self.curve.inputs(float(p[-1])).tolist())) for t, p in back if t is not None and p is not None
            ),
        )  # fmt: skip

    def _time(self, asked: FloatArray, way: float) -> float | None:
        """Return the first time at which the laws ask for a way."""
        from scipy.optimize import brentq

        over = np.flatnonzero(asked >= way)
        if not len(over):
            return None
        k = int(over[0])
        if k == 0 or asked[k] == way:
            return float(self.motion.time[k])
        ends = self.motion.time[k - 1], self.motion.time[k]
        return float(brentq(lambda t: float(self.asked(np.array([t]))[0]) - way, *ends, xtol=1e-15))

    def _branched(self) -> Route:
        """Return the route that leaves the first change point ahead on the branch asked for."""
        track = Track(self.circuit)
        ahead = [
            (float(track.way[k]), k, met)
            for k, met in track.circuit.crossings.items()
            if track.way[k] > 0.0 and len(met.tangents) > 1
        ]
        end = min(Route(track).limit(), float(self.asked(self.motion.time).max()))
        if min((way for way, _, _ in ahead), default=math.inf) > end:
            raise UsageError(f"--branch {self.branch}: no change point is on the law's way; see `gim singularities`")
        way, k, met = min(ahead, key=lambda one: one[0])
        then = self._chosen(met, track.places[k].tangent, float(track.places[k].p[-1]))
        return Route(track, Track(then), way)

    def _chosen(self, met: Crossing, along: FloatArray, q: float) -> Circuit:
        """Return the circuit that goes on along the branch asked for in the sense of the law."""
        others = [t for t in met.tangents if abs(float(t @ along)) < 1.0 - SINGULAR]
        if self.branch - 2 >= len(others):
            raise UsageError(f"--branch {self.branch}: {len(others) + 1} branches meet at the first change point")
        tangent = others[self.branch - 2]
        if abs(tangent[-1]) <= SINGULAR:
            raise UsageError(
                f"--branch {self.branch}: the input rests on this branch at the change point and cannot drive it;"
                " `gim trace --circuit --branch` follows it"
            )
        ahead = tangent * (1.0 if tangent[-1] * along[-1] > 0.0 else -1.0)
        found = leaving(self.curve, replace(met, p=np.append(met.p[:-1], q)), ahead, Policy())
        if found is None:
            raise UsageError(f"--branch {self.branch}: the branch cannot be followed from the change point")
        return found


def _skipped(motion: Motion, options: Options) -> Motion:
    """Return a motion of several inputs with the rows that a straight run of them reaches from the last one solved."""
    mechanism, plan = motion.mechanism, make_plan(motion.mechanism)
    z, codes, error = motion.z.copy(), motion.codes.copy(), motion.residual.copy()
    last = int(np.flatnonzero(motion.good)[-1])
    for k in np.flatnonzero(~motion.good).tolist():
        if k < last:
            continue
        found = moved(
            mechanism, plan, z[:, last], motion.inputs[:, last], motion.inputs[:, k], plain, options.tolerance
        )
        if found is None:
            continue
        told = float(residual(mechanism, found[:, None], motion.inputs[:, k : k + 1]).total[0])
        if told <= allowed(mechanism, options.tolerance):
            z[:, k], codes[k], error[k], last = found, int(Status.OK), told, k
    return replace(motion, z=z, codes=codes, residual=error)
