"""Targets of a fit: columns of a CSV file or of a dict, and what of the motion is compared with them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gimcli.errors import UsageError, refuse
from gimcli.families.design_state import position_items
from gimcli.fitting.targets import FREE, GIVEN, STEP, TURN, FitRange, Targets
from gimcli.library.number_columns import number_columns
from gimcli.mechanism import FRAME, FloatArray, Mechanism
from gimcli.nearest import guess
from gimcli.quantities.quantity import Item

COLUMNS = "x,y (a path), x,y,x2,y2 (pairs of points), x,y,angle (poses) or input,output (a function)"
"""The columns that a file of targets can have."""


@dataclass(frozen=True)
class FittedTask:
    """The targets of a fit and the components of the motion that are compared with them."""

    targets: Targets
    components: tuple[Item, ...]
    kind: str  # "path", "poses" or "function"
    points: FloatArray  # (targets, points, 2) the places of all points of each target; empty for a function

    @property
    def point(self) -> str:
        """The name of the node or point; of a function the name of its output."""
        return self.components[0].head.name.rpartition(".")[0]


def columns_of(
    through: Path | str | Mapping[str, Sequence[float]] | Sequence[Sequence[float]] | None,
) -> dict[str, FloatArray]:
    """Return the columns (targets,) of targets by name: of a file, of a dict, or of pairs of x and y."""
    if through is None:
        raise UsageError("through: name a CSV file of targets, or a goal")
    if isinstance(through, Path | str):
        return number_columns(Path(through), "targets", f"; the columns can be {COLUMNS}")
    if not isinstance(through, Mapping):
        pairs = _array(through)
        refuse(
            (pairs.ndim != 2 or pairs.shape[1] != 2, "through: expected a file, a dict of columns, or rows of x and y")
        )
        through = {"x": pairs[:, 0].tolist(), "y": pairs[:, 1].tolist()}
    found = {str(name): _array(values) for name, values in through.items()}
    alike = len({values.shape for values in found.values()}) <= 1 and all(values.ndim == 1 for values in found.values())
    finite = all(np.isfinite(values).all() for values in found.values())
    refuse((not alike or not finite, "through: expected columns of finite numbers with the same number of rows"))
    return found


def _array(values: object) -> FloatArray:
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise UsageError("through: expected rows or columns of finite numbers, all of the same length") from None


def task_of(
    mechanism: Mechanism,
    columns: Mapping[str, FloatArray],
    timing: str,
    point: str,
    output: str,
    any_order: bool = False,
) -> FittedTask:
    """Return the task that columns of targets describe; raise UsageError where they do not fit the mechanism."""
    own = dict(columns)
    actuator = _actuator(mechanism)
    refuse(("input" in own and actuator in own, f"through: the columns input and {actuator} are the same; remove one"))
    given = own.pop("input", own.pop(actuator, None))
    timing = timing or (FREE if given is None else GIVEN)
    head = f"timing {timing}: the targets have"
    refuse(
        (timing == FREE and given is not None, f"{head} a column of inputs; remove it, or use timing given or step"),
        (timing != FREE and given is None, f"{head} no column `input`; add it, or use timing free"),
    )
    limits = input_range(mechanism)
    driver, places = mechanism.drivers[0], np.zeros(len(next(iter(own.values()), ()))) if given is None else given
    inputs = np.array([mechanism.value_from_file(driver, float(u)) for u in places])
    _refuse_beyond(mechanism, inputs, timing, limits)
    values, weights, components, kind, points = _compared(mechanism, own, point, output)
    refuse((len(values) < 2, f"through: expected at least 2 targets, got {len(values)}"))
    circular = np.array([float(one.quantity.circular) for one in components])
    share = max(1, points.shape[1])
    constant = float(np.sum((points - points.mean(axis=1, keepdims=True)) ** 2)) if points.size else 0.0
    scaled = weights * np.where(circular > 0.0, 1.0, math.sqrt(share))
    targets = Targets(values, scaled, circular, inputs, timing, limits, constant, not any_order)
    return FittedTask(targets, components, kind, points)


def input_range(mechanism: Mechanism, turning: bool = True) -> FitRange:
    """Return the range of the law of the only driver; `turning`: a law of a turn or more is a turn without ends.

    With inputs that follow it is a range, since these may be others after a turn.
    """
    actuator = mechanism.actuators[mechanism.drivers[0]]
    law = actuator.law
    start, values = float(law(np.zeros(1))[0]), law(np.linspace(0.0, 1.0, 361))
    low, high = float(values.min()), float(values.max())
    if turning and actuator.rotary and not mechanism.couplings and high - low >= TURN * (1.0 - 1e-9):
        low = start - TURN if float(law(np.ones(1))[0]) < start else start
        return FitRange(low, low + TURN, True)
    refuse((not high > low, f"the law of {actuator.name} does not move; give it `from` and `to`"))
    return FitRange(low, high, False)


def _actuator(mechanism: Mechanism) -> str:
    names = [mechanism.actuators[k].name for k in mechanism.drivers]
    refuse(
        (
            len(names) != 1,
            f"a fit needs a mechanism with one actuator; {mechanism.name} has {len(names) or 'none'}"
            f"{': ' if names else ''}{', '.join(names)}",
        )
    )
    return names[0]


def _refuse_beyond(mechanism: Mechanism, inputs: FloatArray, timing: str, limits: FitRange) -> None:
    """Raise UsageError for given inputs that the law does not reach."""
    if limits.turning or timing == FREE:
        return
    room, driver = 1e-9 * (limits.high - limits.low), mechanism.drivers[0]
    beyond = np.any((inputs < limits.low - room) | (inputs > limits.high + room))
    if timing == STEP:
        beyond = np.ptp(inputs) > limits.high - limits.low + room
    low, high = mechanism.value_to_file(driver, np.array([limits.low, limits.high])).tolist()
    law, unit = f"the law of {mechanism.actuators[driver].name}", mechanism.unit_of(mechanism.actuators[driver])
    refuse((beyond, f"through: the inputs are beyond {law}, {low:g} to {high:g} {unit}; change one"))


def _compared(
    mechanism: Mechanism, own: dict[str, FloatArray], point: str, output: str
) -> tuple[FloatArray, FloatArray, tuple[Item, ...], str, FloatArray]:
    """Return values, weights, components, kind and places of targets."""
    if "output" in own or output:
        return _function(mechanism, own, output)
    angle = own.pop("angle", None)
    count = len(own) // 2
    wanted = [f"{axis}{k or ''}" for k in (0, *range(2, count + 1)) for axis in "xy"]
    known = ", ".join(own) or "none"
    refuse((not count or sorted(own) != sorted(wanted), f"through: expected the columns {COLUMNS}; got {known}"))
    points = np.stack([np.stack([own[f"{a}{k or ''}"] for a in "xy"], -1) for k in (0, *range(2, count + 1))], axis=1)
    name = point or mechanism.traced[0]
    places = position_items(mechanism, _known_point(mechanism, name))
    values = points.mean(axis=1)
    if angle is None:
        return values, np.ones(2), places, "path", points
    turned = np.radians(angle) if mechanism.angle_unit == "deg" else angle
    member = position_items(mechanism, _member_of(mechanism, name))
    length = mechanism.size * mechanism.scale  # an error of 1 rad counts as much as this length
    return np.column_stack((values, turned)), np.array([1.0, 1.0, length]), (*places, *member), "poses", points


def _function(
    mechanism: Mechanism, own: dict[str, FloatArray], output: str
) -> tuple[FloatArray, FloatArray, tuple[Item, ...], str, FloatArray]:
    refuse(
        (not output, "output: name the output of a function, such as rocker.angle"),
        (list(own) != ["output"], "through: the output of a function: the file needs the columns input,output"),
    )
    with suppress(UsageError):
        items = position_items(mechanism, output)
        if len(items) == 1:
            angle = items[0].quantity.circular and mechanism.angle_unit == "deg"
            values = np.radians(own["output"]) if angle else own["output"]
            return values[:, None], np.ones(1), items, "function", np.empty((len(values), 0, 2))
    members = [m.name for m in mechanism.members[FRAME + 1 :]]
    known = [*(f"{m}.angle" for m in members), *(f"{p}.{a}" for p in mechanism.traced for a in "xy")]
    raise UsageError(
        f"output '{output}': expected an angle, a coordinate or another number of a position"
        f"; {guess(output, known, 'such as')}"
    )


def _known_point(mechanism: Mechanism, name: str) -> str:
    """Return the name of a node or of a point of a moving member; raise UsageError for others."""
    frame = mechanism.members[FRAME]
    moving = [n for k, n in enumerate(mechanism.nodes) if k not in frame.nodes]
    moving += [p.name for p in mechanism.points if p.member != FRAME]
    refuse((name not in moving, f"point: '{name}' is no node or point that moves; {guess(name, moving)}"))
    return name


def _member_of(mechanism: Mechanism, name: str) -> str:
    """Return the member of a point, or the only moving member of a node."""
    own = [p.member for p in mechanism.points if p.name == name]
    if not own:
        node = mechanism.nodes.index(name)
        own = [k for k, member in enumerate(mechanism.members) if k != FRAME and node in member.nodes]
    refuse((len(own) != 1, f"poses: {name} belongs to several members; give a point of the member under `points`"))
    return mechanism.members[own[0]].name
