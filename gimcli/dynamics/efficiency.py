"""Efficiency of a motion with friction, the energy lost in each pair, and where the mechanism is self-locking.

The work of each drive, of the loads, of the weight, of the springs and of the inertia is an input where it is positive,
and an output where it is negative. The efficiency is the ratio of outputs to inputs: 1 - lost / inputs. Over a motion
the works are net works, so that the weight and the springs count only as far as the motion does not return.

The columns of the table of forces of a motion with dry friction, and the words of its rows, are here too.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from typing import Any

import numpy as np

from gimcli.dynamics.coulomb import DryFriction
from gimcli.dynamics.coulomb_solver import SELF_LOCKING, FrictionStatus
from gimcli.dynamics.force_columns import ForceColumn, columns_of, effort_unit
from gimcli.dynamics.forces import Forces
from gimcli.dynamics.load_arrays import friction_pairs
from gimcli.dynamics.statics import Statics
from gimcli.mechanism import BoolArray, FloatArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.table import Column

NOTHING = 1e-12
"""Power or work that counts as zero, relative to the greatest."""
SOURCES = {"load": "loads", "gravity": "weight", "spring": "springs"}
"""Names of the works of applied forces, by the kind of force."""
VISCOUS = "viscous"
"""Name of the energy lost in dampers and viscous friction."""


def source_powers(forces: Forces) -> dict[str, FloatArray]:
    """Return the power [W] of each input, of the loads, of the weight, of the springs and of the inertia (rows,)."""
    found = {forces.mechanism.actuators[k].name: forces.power(k) for k in forces.mechanism.drivers}
    applied = {name: forces.loads.power[kind] for kind, name in SOURCES.items()}
    return {**found, **applied, "inertia": -forces.loads.kinetic_rate}


def lost_powers(forces: Forces) -> dict[str, FloatArray]:
    """Return the power [W] lost in each pair with dry friction, and in dampers and viscous friction (rows,)."""
    dry: Any = forces.dry
    return {**dict(zip(dry.names, -dry.powers, strict=True)), VISCOUS: -forces.loads.power["damping"]}


def efficiency(sources: list[Any], lost: Any) -> FloatArray:
    """Return outputs / inputs of powers or works; NaN without an input."""
    given = np.sum(np.maximum(sources, 0.0), axis=0)
    size = np.max(np.abs(sources), initial=0.0, where=np.isfinite(sources))
    with np.errstate(all="ignore"):
        return np.where(given > NOTHING * size, np.maximum(1.0 - lost / given, 0.0), np.nan)


def row_efficiency(forces: Forces) -> FloatArray:
    """Return the efficiency in every row (rows,) of a motion with dry friction."""
    return efficiency(list(source_powers(forces).values()), sum(lost_powers(forces).values()))


def self_locking(dry: DryFriction) -> BoolArray:
    """Return for every row whether friction holds the mechanism at rest without an effort against its loads."""
    return _held(dry.margin) & _driven(dry.margin, dry.smooth)


def _held(margin: FloatArray) -> BoolArray:
    """Return whether the drive must give power to move the mechanism from rest either way (rows,)."""
    return np.asarray(margin > NOTHING * np.max(np.abs(margin), initial=0.0, where=np.isfinite(margin)))


def _driven(margin: FloatArray, smooth: FloatArray) -> BoolArray:
    """Return whether the loads would move the mechanism without friction (rows,)."""
    return np.asarray(np.abs(smooth) > NOTHING * np.where(np.isfinite(margin), np.abs(margin), 0.0))


class FrictionSummary:
    """Works, lost energies, self-locking intervals and counts of a motion in pieces."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._powers: list[tuple[FloatArray, dict[str, FloatArray], dict[str, FloatArray]]] = []  # of rows with forces
        self.counts = dict.fromkeys(FrictionStatus, 0)
        self.residual = 0.0
        self.complete = True  # whether all rows have forces, or stand still
        self._held: list[tuple[FloatArray, FloatArray, BoolArray]] = []  # places, margins, whether loads drive

    def add(self, motion: Motion, forces: Forces, dry: DryFriction) -> None:
        """Add the next piece of the motion."""
        for code in FrictionStatus:
            self.counts[code] += int(np.sum(dry.codes == code))
        self.complete &= bool(np.all(forces.good | (dry.codes == FrictionStatus.STANDSTILL)))
        self.residual = max(self.residual, float(np.max(dry.residual, initial=0.0)))
        drivers = self.mechanism.drivers
        over = motion.inputs[drivers[0]] if len(drivers) == 1 else forces.course.time
        self._held.append((np.asarray(over), dry.margin, _driven(dry.margin, dry.smooth)))
        powers = source_powers(forces), lost_powers(forces)
        if forces.good.any():
            sources, lost = ({name: power[forces.good] for name, power in kind.items()} for kind in powers)
            self._powers.append((forces.course.time[forces.good], sources, lost))

    @property
    def works(self) -> dict[str, float]:
        """The works of the sources [J]."""
        return self._integrals([sources for _, sources, _ in self._powers])

    @property
    def lost(self) -> dict[str, float]:
        """The energies lost in each pair, and in dampers and viscous friction [J]."""
        return self._integrals([lost for _, _, lost in self._powers])

    def _integrals(self, powers: list[dict[str, FloatArray]]) -> dict[str, float]:
        """Return the integrals of powers over the time between the rows with forces, by the trapezoidal rule."""
        steps = np.diff(np.concatenate([time for time, *_ in self._powers])) if powers else np.zeros(0)
        rows = {name: np.concatenate([piece[name] for piece in powers]) for name in (powers[0] if powers else ())}
        return {name: float(0.5 * (power[1:] + power[:-1]) @ steps) for name, power in rows.items()}

    @property
    def failure(self) -> FrictionStatus | None:
        """What prevails in the rows without forces; None if dry friction is not the cause."""
        return max((code for code, count in self.counts.items() if count and code.status), default=None)

    @property
    def efficiency(self) -> float | None:
        """The efficiency of the whole motion; None if a row has no forces, or no work is put in."""
        if not self.complete or not self.works:
            return None
        found = float(efficiency(list(self.works.values()), sum(self.lost.values())))
        return None if np.isnan(found) else found

    @property
    def locked(self) -> list[tuple[float, float]]:
        """Intervals in which the mechanism is self-locking: of the input (file's unit) if there is one, else of time.

        An end between two rows is interpolated linearly from the effort that would move the mechanism.
        """
        if not self._held:
            return []
        place, margin, driven = (np.concatenate(pieces) for pieces in zip(*self._held, strict=True))
        inside, found = _held(margin), []
        edges = np.flatnonzero(np.diff(np.concatenate(([False], inside, [False])).astype(int)))
        for first, end in edges.reshape(-1, 2):
            if not driven[first:end].any():  # such as a block on a level guide
                continue
            ends = [
                _crossing(place, margin, int(first), int(first) - 1),
                _crossing(place, margin, int(end) - 1, int(end)),
            ]
            found.append((self._shown(ends[0]), self._shown(ends[1])))
        return found

    def _shown(self, place: float) -> float:
        drivers = self.mechanism.drivers
        if len(drivers) != 1:
            return place
        return float(self.mechanism.value_to_file(drivers[0], np.array([place]))[0])

    @property
    def over(self) -> str:
        """Name of what the intervals are given over: the only input, or the time."""
        drivers = self.mechanism.drivers
        return self.mechanism.actuators[drivers[0]].name if len(drivers) == 1 else "time"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        return {
            "efficiency": self.efficiency, "works": self.works, "lost": self.lost, "over": self.over,
            "self_locking": [list(ends) for ends in self.locked],
            "rows": {code.word: count for code, count in self.counts.items() if count}, "residual": self.residual,
        }  # fmt: skip


def _crossing(place: FloatArray, margin: FloatArray, inside: int, outside: int) -> float:
    """Return where the margin is zero between a row inside an interval and its neighbour outside."""
    if not 0 <= outside < len(place) or not np.isfinite(margin[[inside, outside]]).all():
        return float(place[inside])
    share = margin[inside] / (margin[inside] - margin[outside])
    return float(place[inside] + share * (place[outside] - place[inside]))


WORDS = np.array([status.word for status in FrictionStatus])
LIMITS = ("least", "greatest")
STATE = "friction.state"
"""Name of the column with the words of the rows."""


def friction_formulas(statics: Statics) -> Iterator[ForceColumn]:
    """Yield the power lost in each pair, limits of the efforts, and the efficiency; none without dry friction."""
    mechanism = statics.mechanism
    rubbing = dict.fromkeys(pair.friction.name for pair in friction_pairs(mechanism) if pair.friction.mu)
    for name in rubbing:
        yield ForceColumn(f"friction.power.{name}", "W", partial(_power, name=name), dry=True)
    for k, actuator in enumerate(mechanism.actuators if rubbing else ()):
        if k in mechanism.geared:
            continue
        for word, (i, end) in product(("effort", "hold"), enumerate(LIMITS)):
            find = partial(_limit, word=word, end=i, actuator=k)
            yield ForceColumn(f"{actuator.name}.{word}.{end}", effort_unit(mechanism, k), find, dry=True)
    if rubbing:
        yield ForceColumn("friction.efficiency", "", row_efficiency, dry=True)


def _power(forces: Forces, name: str) -> FloatArray:
    dry: Any = forces.dry
    return np.where(forces.good, dry.powers[dry.names.index(name)], np.nan)


def _limit(forces: Forces, word: str, end: int, actuator: int) -> FloatArray:
    return np.asarray(getattr(forces.dry, word)[end, actuator])


def friction_columns(forces: Forces, dry: DryFriction) -> list[Column]:
    """Return the power lost in each pair, limits of the efforts, efficiency, and the words of the rows."""
    locked = np.where(self_locking(dry) & (dry.codes == FrictionStatus.SLIDING), SELF_LOCKING, WORDS[dry.codes])
    return [*columns_of(forces, friction_formulas(forces.statics)), Column(STATE, locked)]


def with_friction_words(status: Column, dry: DryFriction) -> Column:
    """Return the status column with the words of rows whose forces dry friction does not determine."""
    return Column(status.name, np.where(dry.codes == FrictionStatus.SLIDING, status.values, WORDS[dry.codes]))
