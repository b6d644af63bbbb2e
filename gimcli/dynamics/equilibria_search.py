"""Equilibria of several released inputs, by Newton's method from the drawing and from random starts.

In an orthonormal basis of the directions of motion the generalised forces Q and their derivatives dQ are exact. A step
a solves dQ a = -Q; the position is then settled onto the constraints. Of four starts one descends on the potential
instead, with the eigenvalues of -dQ made positive, and one ascends: Newton's method finds saddles more often than least
and greatest potentials. Random starts are reached by a walk along the constraints, so that all equilibria are found on
the configuration of the drawing. Source: Nocedal & Wright, Numerical Optimization, 2006, sections 3.4 and 11.2.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain, islice

import numpy as np

from gimcli.canonical import ROUNDING, beside, ranks
from gimcli.continuation.arclength import corrected
from gimcli.continuation.released import SETTLING, ReleasedPositions
from gimcli.dynamics.equilibria_balance import GeneralisedForces, StaticBalance, position_jet, released_inputs_line
from gimcli.dynamics.equilibria_curve import BALANCE, STABLE, UNDECIDED, UNSTABLE, Equilibria, Equilibrium
from gimcli.dynamics.physical import input_units
from gimcli.errors import UnassembledError
from gimcli.mechanism import BoolArray, FloatArray, Mechanism
from gimcli.motion.solve import settled, start_position
from gimcli.positions.dispatch import plain
from gimcli.progress import Progress, no_progress, spend
from gimcli.status import Status
from gimcli.structure.plan import make_plan


@dataclass(frozen=True)
class NewtonStartConstants:
    """Constants of the search; lengths are those of the space of positions and inputs."""

    iterations: int = 60  # most steps from a start
    longest: float = 0.4  # greatest step
    shortest: float = 1e-9  # least trust radius
    converged: float = 1e-13  # force relative to its contributions, below which the last step is taken
    pull: float = 0.5  # greatest correction, relative to the step
    walk: int = 24  # most steps of a random walk
    stride: float = 0.25  # length of such a step
    together: int = 24  # number of walks side by side
    same: float = 1e-6  # distance of equilibria that are the same
    zero: float = 1e-9  # eigenvalue, relative to the greatest contribution, that is 0
    longer: int = 8  # most starts, relative to those that may find nothing new
    continuum: int = 6  # most equilibria of a continuum that are listed


SEARCH = NewtonStartConstants()

DESCENDS, ASCENDS = -1, 1
"""The sense in which the potential changes along the steps from a start; 0: Newton's method."""

SENSES = (0, DESCENDS, 0, ASCENDS)
"""The senses of the starts, one after the other."""

CLOSE = 1e-6
"""Force relative to its contributions below which steps reduce it instead of following the potential."""


@dataclass(frozen=True)
class BalancedPlace:
    """A position with its directions of motion and the forces along them."""

    y: FloatArray  # (n + k,)
    basis: FloatArray = field(repr=False)  # (j, n + k)
    q: FloatArray  # (j,)
    slope: FloatArray  # (j, j) dQ
    size: float  # greatest sum of contributions to a force
    stiffness: float  # norm of the sums of the magnitudes of the contributions to `slope`
    potential: float
    angles: FloatArray = field(repr=False)

    @property
    def force(self) -> float:
        """The greatest generalised force."""
        return float(np.max(np.abs(self.q), initial=0.0))


def released_search(
    mechanism: Mechanism, released: tuple[int, ...], inputs: FloatArray, balance: StaticBalance, tolerance: float
) -> EquilibriumSearch:
    """Return the search from the position at some inputs (actuators,); raise UnassembledError if there is none."""
    start = start_position(mechanism, make_plan(mechanism), inputs, plain, tolerance)
    if start.status not in (Status.OK, Status.SINGULAR):
        raise UnassembledError(f"{mechanism.name} cannot be assembled at the start: {start.status.text}")
    freedoms = ReleasedPositions(mechanism, *released_inputs_line(mechanism, released, inputs))
    y = freedoms.settled(freedoms.point(settled(mechanism, start), inputs[list(released)]))
    if y is None:
        raise UnassembledError(f"{mechanism.name} cannot be assembled at the start: {Status.SINGULAR.text}")
    return EquilibriumSearch(freedoms, balance, y, released)


class EquilibriumSearch:
    """The search from one start position y (n + k,)."""

    def __init__(
        self, freedoms: ReleasedPositions, balance: StaticBalance, start: FloatArray, released: tuple[int, ...]
    ) -> None:  # fmt: skip
        self.freedoms, self.balance, self.released = freedoms, balance, released
        (self.start,) = self.places(start[None], balance.initial_angles()[None])
        self.scale, self.stiff = self.start.size, self.start.stiffness

    def places(self, y: FloatArray, near: FloatArray) -> list[BalancedPlace]:
        """Return the forces at settled positions (rows, n + k); near: angles of positions nearby (rows, angles)."""
        freedoms, basis = self.freedoms, self.freedoms.directions(y)
        bends = np.moveaxis(freedoms.bends(y, basis), 0, 2)
        found = GeneralisedForces(self.balance, position_jet(freedoms, y, np.moveaxis(basis, 1, 0), bends), near.T)
        return [
            BalancedPlace(
                y[k], basis[k], found.q[:, k], found.slope[:, :, k], float(np.max(found.size[:, k], initial=0.0)),
                float(np.linalg.norm(found.steep[:, :, k])), float(found.potential[k]), found.angles[:, k],
            )
            for k in range(len(y))
        ]  # fmt: skip

    def run(self, starts: int, seed: int, progress: Progress = no_progress) -> Equilibria:
        """Return the equilibria found from the drawing and random starts, until `starts` of them find nothing new.

        The search ends too at its limit, or after SEARCH.longer times as many starts.
        """
        every = self._starts(seed)
        places = list(islice(every, starts))
        self.scale = max(place.size for place in places)
        self.stiff = max(place.stiffness for place in places)
        everywhere = max(place.force for place in places) <= BALANCE.nothing * self.scale
        roots, failed, tried = ([], 0, starts) if everywhere else self._roots(chain(places, every), starts, progress)
        listed = self._listed(roots)
        z, inputs = self.freedoms.nodes(self.start.y), self.freedoms.inputs(self.start.y)
        return Equilibria(
            tuple(listed), self.released, z, inputs, self._efforts(self.start), self.balance.conservative, everywhere,
            self.scale, starts=tried, failed=failed, limited=spend() or tried == SEARCH.longer * starts,
        )  # fmt: skip

    def _roots(
        self, places: Iterable[BalancedPlace], starts: int, progress: Progress
    ) -> tuple[list[BalancedPlace], int, int]:
        """Return the equilibria, the number of starts (`places`) without convergence, and that of all starts."""
        roots: list[BalancedPlace] = []
        failed, k, last = 0, 0, -1  # the last start that found something new
        for k, place in enumerate(islice(places, SEARCH.longer * starts)):
            progress(min(k - last, starts), starts)
            if k - last > starts or (k and spend()):
                return roots, failed, k
            found = self._newton(place, SENSES[k % len(SENSES)] if self.balance.conservative else 0)
            if found is None and self.balance.conservative:
                found = self._newton(place, DESCENDS)
            failed += found is None
            if found is not None and not any(self._same(found, known) for known in roots):
                roots.append(found)
                last = k
        return roots, failed, k + 1

    def residual(self, place: BalancedPlace) -> float:
        """Return the force relative to the greatest sum of its contributions."""
        return place.force / self.scale if self.scale else 0.0

    # -- starts ---------------------------------------------------------------------------------------

    def _starts(self, seed: int) -> Iterator[BalancedPlace]:
        yield self.start
        random = np.random.default_rng(seed)
        while not spend():
            yield from self._walked(random)

    def _walked(self, random: np.random.Generator) -> list[BalancedPlace]:
        """Return the ends of walks in random directions on the constraints, each turned a little in each step."""
        here, size = [self.start] * SEARCH.together, len(self.start.y)
        heading, turns = np.empty((len(here), size)), list[FloatArray]()
        for k in range(len(here)):
            heading[k] = random.normal(size=size)
            steps = int(random.integers(SEARCH.walk // 4, SEARCH.walk + 1))
            turns.append(0.2 * random.normal(size=(steps, size)) / math.sqrt(size))
        for number in range(max(map(len, turns))):
            going = np.array([k for k, own in enumerate(turns) if number < len(own)])
            ahead = heading[going] / np.linalg.norm(heading[going], axis=1, keepdims=True)
            ahead += np.array([turns[k][number] for k in going])
            basis = np.array([here[k].basis for k in going])
            along = np.einsum("rjn,rj->rn", basis, np.einsum("rjn,rn->rj", basis, ahead))
            step = SEARCH.stride * along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
            y, good = self._settled(np.array([here[k].y for k in going]), step)
            heading[going] = np.where(good[:, None], step + 0.05 * SEARCH.stride * ahead, -ahead)
            moved = going[good].tolist()
            found = self.places(y[good], np.array([here[k].angles for k in moved])) if moved else []
            for k, place in zip(moved, found, strict=True):
                here[k] = place
        return here

    def _settled(self, y: FloatArray, step: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the positions (rows, n + k) after steps, and whether they are near the ends of the steps (rows,)."""
        found, good = corrected(self.freedoms, y + step, SETTLING, freedoms=self.freedoms.count)
        away, length = (np.linalg.norm(part, axis=1) for part in (found - y - step, step))
        return found, good & (away <= SEARCH.pull * length + 1e-10)

    # -- Newton's method ------------------------------------------------------------------------------

    def _newton(self, here: BalancedPlace, sense: int) -> BalancedPlace | None:
        """Return the equilibrium that the steps from a start lead to; None without convergence."""
        radius = SEARCH.longest
        for _ in range(SEARCH.iterations):
            if self.residual(here) <= SEARCH.converged:
                return self._last(here)
            step = self._step(here, radius, sense)
            there = self._tried(here, step)
            if there is not None and self._better(here, there, sense):
                here, radius = there, min(2.0 * radius, SEARCH.longest)
            elif self.residual(here) <= BALANCE.residual:
                return here
            else:
                radius = 0.25 * min(radius, float(np.linalg.norm(step)))
                if radius < SEARCH.shortest:
                    return None
        return here if self.residual(here) <= BALANCE.residual else None

    def _step(self, here: BalancedPlace, radius: float, sense: int) -> FloatArray:
        """Return the step (j,) in the directions of motion, no longer than the radius."""
        if sense:
            values, vectors = np.linalg.eigh(0.5 * sense * (here.slope + here.slope.T))
            bound = SEARCH.zero * max(here.stiffness, self.stiff)
            step = -sense * (vectors @ ((vectors.T @ here.q) / np.maximum(np.abs(values), bound)))
        else:
            step = np.linalg.lstsq(here.slope, -here.q, rcond=SEARCH.zero)[0]
            if np.linalg.norm(step) > radius:
                step = self._damped(here, radius)
        length = float(np.linalg.norm(step))
        return np.asarray(step if length <= radius else step * (radius / length))

    def _damped(self, here: BalancedPlace, radius: float) -> FloatArray:
        """Return the Levenberg-Marquardt step of about the length of the radius."""
        left, values, right = np.linalg.svd(here.slope)
        force = left.T @ -here.q
        damping = SEARCH.zero * values[0] ** 2 + 1e-300
        for _ in range(60):
            step = right.T @ (values * force / (values**2 + damping))
            if np.linalg.norm(step) <= radius:
                break
            damping *= 3.0
        return np.asarray(step)

    def _tried(self, here: BalancedPlace, step: FloatArray) -> BalancedPlace | None:
        y, good = self._settled(here.y[None], (here.basis.T @ step)[None])
        return self.places(y, here.angles[None])[0] if good[0] else None

    def _better(self, here: BalancedPlace, there: BalancedPlace, sense: int) -> bool:
        smaller = float(np.linalg.norm(there.q)) < float(np.linalg.norm(here.q))
        if sense and self.residual(here) > CLOSE:
            return sense * (there.potential - here.potential) > 0.0
        return smaller

    def _last(self, here: BalancedPlace) -> BalancedPlace:
        """Return an equilibrium after one more step, if that decreases the force."""
        there = self._tried(here, self._step(here, SEARCH.same, 0)) if self.residual(here) else None
        return there if there is not None and self._better(here, there, 0) else here

    # -- results --------------------------------------------------------------------------------------

    def _same(self, one: BalancedPlace, other: BalancedPlace) -> bool:
        wound = np.abs(one.angles - other.angles)[: len(self.balance.twisted)]
        near = (
            np.max(self.freedoms.mechanism.apart(self.freedoms.nodes(one.y), self.freedoms.nodes(other.y)))
            <= SEARCH.same
        )
        return bool(near and np.max(wound, initial=0.0) <= 1.0)

    def _listed(self, roots: list[BalancedPlace]) -> list[Equilibrium]:
        """Return the equilibria in the order of their potential; only some of a continuum."""
        found = in_order([self._equilibrium(root) for root in roots])
        continued = [one for one in found if one.multiplicity == 0][SEARCH.continuum :]
        return [one for one in found if not any(one is other for other in continued)]

    def _equilibrium(self, root: BalancedPlace) -> Equilibrium:
        tensor = -root.slope
        values = np.linalg.eigvals(tensor).real if not self.balance.conservative else np.linalg.eigvalsh(tensor)
        zero = SEARCH.zero * max(root.stiffness, self.stiff)
        negative = int(np.sum(values < -zero))
        flat = bool(np.any(np.abs(values) <= zero))
        decided = UNSTABLE if negative else UNDECIDED if flat or not self.balance.conservative else STABLE
        return Equilibrium(
            self.freedoms.nodes(root.y), self._near_start(root), root.potential, decided, negative,
            0 if flat else 1, self._by_inputs(root, tensor), self.residual(root),
        )  # fmt: skip

    def _near_start(self, root: BalancedPlace) -> FloatArray:
        """Return the inputs (actuators,), rotary ones within half a turn of the start if no spring counts turns."""
        own, start = self.freedoms.inputs(root.y), self.freedoms.inputs(self.start.y)
        if len(root.angles) or not self.balance.conservative:
            return own
        return np.where([a.rotary for a in self.freedoms.mechanism.actuators], beside(own, start), own)

    def _rates(self, place: BalancedPlace) -> FloatArray | None:
        """Return the released inputs [rad or m] along the directions of motion (j, k); None at a limit of an input."""
        own = place.basis[:, self.freedoms.system.n :] * input_units(self.freedoms.mechanism)[list(self.released)]
        if own.shape[0] != own.shape[1] or not np.linalg.cond(own) < 1.0 / SEARCH.zero:
            return None
        return np.asarray(own)

    def _by_inputs(self, place: BalancedPlace, tensor: FloatArray) -> FloatArray | None:
        """Return the second derivatives of the potential by the released inputs; exact where all forces are 0."""
        rates = self._rates(place)
        if rates is None:
            return None
        inverse = np.linalg.inv(rates)
        return np.asarray(inverse @ tensor @ inverse.T)

    def _efforts(self, place: BalancedPlace) -> FloatArray:
        rates = self._rates(place)
        if rates is None:
            return np.full(self.freedoms.count, math.inf)
        return np.asarray(-np.linalg.solve(rates, place.q))


def in_order(found: list[Equilibrium]) -> list[Equilibrium]:
    """Return equilibria in the order of their potential, equal ones in that of their inputs."""
    table = np.array([[one.potential, *one.inputs] for one in found])
    keys = [ranks(column, ROUNDING * float(np.max(np.abs(column)))) for column in table.T]
    return [found[k] for k in np.lexsort(keys[::-1])] if found else []
