"""Forces of many designs: the equations of the nominal mechanism for the rows of all designs, one after another.

Masses, centres, lengths, springs and the like are numbers of each row. What decides the equations (bodies, unknowns,
blocks) is that of the nominal design.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from dataclasses import is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gimcli.calculus.dual import Dual
from gimcli.calculus.numbers import RuleNumber, nominal
from gimcli.calculus.recorded import Recorded
from gimcli.dynamics.force_motion import EACH
from gimcli.dynamics.forces import Forces, inverse_dynamics
from gimcli.dynamics.kinematic_history import Course, Turns
from gimcli.dynamics.statics import statics
from gimcli.families.design_rates import DesignRates
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.positions.dispatch import choose
from gimcli.positions.newton import Run
from gimcli.quantities.state import ApartError


class DesignForces:
    """Computes the forces of designs along their motions."""

    def __init__(self, mechanism: Mechanism, names: Sequence[str]) -> None:
        """Record the numbers of the equations; raise ApartError for mechanisms whose designs are computed singly.

        They have dry friction, gears, inputs that follow others, or redundant constraints.
        """
        recorded, self.recording = mechanism.written.recorded(mechanism, names, True)
        dry = any(_given(friction.mu) for friction in recorded.dynamics.frictions)
        if dry or recorded.gears or recorded.couplings or mechanism.complete:
            raise ApartError
        self.statics = statics(recorded)
        if self.statics.surplus:
            raise ApartError
        self.turns = DualTurns()
        self.terms = sum(map(len, self.statics.columns))
        _ = self.statics.blocks, self.statics.scales, self.statics.pole, [member.ends for member in recorded.members]
        wanted = defaultdict[int, float](float)
        self.plain: set[int] = set()  # parts without recorded numbers
        _with_numbers(self.statics, wanted, self.plain)
        self.wanted = list(wanted)
        own = defaultdict[int, float](float)
        _with_numbers(recorded.dynamics, own, set())
        used = self.recording.variables_of(list(own))
        self.used = {name for k, name in enumerate(names) if k in used}  # dimensions of masses, loads and springs

    def __call__(self, designs: FloatArray, course: Course, jit: str = "auto", notify: Any = None) -> Forces:
        """Return the forces of designs (designs, dimensions) along a course with the rows of all designs."""
        found, count = self.recording.evaluate(designs.T, self.wanted), len(designs)
        row = np.repeat(np.arange(count), len(course.time) // count)
        own = _with_numbers(
            self.statics, {place: np.broadcast_to(x, count)[row] for place, x in found.items()}, self.plain
        )
        if any(not np.all(spring.free) for spring in own.mechanism.dynamics.springs if np.ndim(spring.free)):
            raise ApartError
        refused = np.flatnonzero(np.any([x < 0.0 for x in _amounts(own.mechanism) if np.ndim(x)], axis=0))
        course.nodes[..., refused] = np.nan
        run = choose(jit, EACH * len(row) * self.terms, notify, ("balance_rows",))
        return inverse_dynamics(own, course, run, _DesignTurns(count))

    def along(
        self, rates: DesignRates, designs: FloatArray, z: ComplexArray, given: FloatArray, time: FloatArray,
        jit: str = "auto", notify: Any = None,
    ) -> Forces:  # fmt: skip
        """Return the forces of designs in positions z (designs, nodes, rows) at times [s] (designs, rows).

        given (designs, 3, actuators, rows): inputs and their derivatives; `rates` are those of order 2.
        """
        nodes, angles = rates(designs, z, given, jit, notify)
        course = Course(time.ravel(), _in_line(given[:, 0]), _in_line(nodes), _in_line(angles))
        return self(designs, course, jit, notify)

    def dual(self, design: FloatArray, course: Course, run: Run) -> Forces:
        """Return the forces of one design (dimensions,) along a course in dual numbers.

        The tangents are the dimensions, and the inputs after them.
        """
        found, more = self.recording.tangents(design[:, None], self.wanted), len(course.inputs)
        numbers = {place: Dual(x.value, np.pad(x.slopes, ((0, more), (0, 0)))) for place, x in found.items()}
        return inverse_dynamics(_with_numbers(self.statics, numbers, self.plain), course, run, self.turns)


class DualTurns(Turns):
    """Continues the angles of springs in dual numbers."""

    def followed(self, key: int, angle: Any, drawn: Any) -> Any:
        """Return an angle [rad] without jumps (rows,)."""
        return Dual(super().followed(key, nominal(angle), float(np.ravel(nominal(drawn))[0])), angle.slopes)


class _DesignTurns(Turns):
    """Continues the angles of the springs of each design from its initial position."""

    def __init__(self, designs: int) -> None:
        super().__init__()
        self.designs = designs

    def followed(self, key: int, angle: FloatArray, drawn: Any) -> FloatArray:
        """Return an angle [rad] without jumps (rows,)."""
        firsts = np.broadcast_to(drawn, angle.shape).reshape(self.designs, -1)[:, 0]
        own = zip(angle.reshape(self.designs, -1), firsts.tolist(), strict=True)
        return np.concatenate([Turns().followed(key, part, first) for part, first in own])


def _amounts(mechanism: Mechanism) -> Iterator[Any]:
    """Yield the numbers that a file may not give as negative."""
    dynamics = mechanism.dynamics
    yield from (x for inertia in dynamics.inertias for x in (inertia.mass, inertia.moment))
    yield from (spring.stiffness for spring in dynamics.springs)
    yield from (damper.damping for damper in dynamics.dampers)
    yield from (friction.damping for friction in dynamics.frictions)
    yield from (rotor.inertia for rotor in dynamics.rotors)


def _given(number: Any) -> bool:
    """Return whether a number is not 0 in some design."""
    return isinstance(number, RuleNumber) or number != 0.0


def _with_numbers(part: Any, found: Mapping[int, Any], plain: set[int]) -> Any:
    """Return a part of a mechanism or of its equations with numbers in place of the recorded ones.

    `plain` has the identities of parts without recorded numbers; those that are found are added.
    """
    if id(part) in plain:
        return part
    if isinstance(part, Recorded):
        return found[part.place]
    if isinstance(part, tuple) or (isinstance(part, np.ndarray) and part.dtype == object):
        several = [_with_numbers(one, found, plain) for one in part]
        if any(new is not old for new, old in zip(several, part, strict=True)):
            return several
    elif is_dataclass(part):
        fields = {name: _with_numbers(old, found, plain) for name, old in vars(part).items() if name != "_derived"}
        if any(new is not vars(part)[name] for name, new in fields.items()):
            own: Any = copy(part)
            own.__dict__.pop("_derived", None)
            own.__dict__.update(fields)
            return own
    plain.add(id(part))
    return part


def _in_line(values: NDArray[Any]) -> NDArray[Any]:
    """Return values (designs, ..., rows) with the rows of all designs one after another (..., designs x rows)."""
    return np.moveaxis(values, 0, -2).reshape(*values.shape[1:-1], -1)
