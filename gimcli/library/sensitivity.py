"""Find how positions depend on the dimensions, and their spread within tolerances."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any

import numpy as np

from gimcli.canonical import principal
from gimcli.errors import UsageError, refuse
from gimcli.families.design_columns import DesignColumns
from gimcli.families.design_sensitivity import DesignSensitivity, QuantitySlopes, moves_nodes
from gimcli.families.design_state import DesignState, position_items
from gimcli.families.designs import Designs
from gimcli.families.family import Family
from gimcli.families.motion_sensitivity import MotionNumber, motion_number
from gimcli.families.quantity_text import ColumnNames
from gimcli.families.tolerances import DEVIATIONS, SampledSpread, drawn, sampled_spread
from gimcli.library.inputs import MOST_STEPS, Jit, OneOf, Range, Seed, Steps, inputs_of
from gimcli.library.machines import accepted, driven_machines, for_each_machine, names_of
from gimcli.library.sensitivity_result import SensitivityResult
from gimcli.mechanism import FloatArray, Machine, Mechanism
from gimcli.model.dimensions import Dimension, tolerances, written
from gimcli.motion.motion import Motion, trace
from gimcli.motion.solve import solve
from gimcli.positions.dispatch import choose
from gimcli.positions.newton import Run
from gimcli.positions.options import Options
from gimcli.progress import Notify, Phases, no_phases
from gimcli.quantities.catalogue import catalogue
from gimcli.quantities.quantity import Item
from gimcli.rates.derivatives import ORDERS, law_rates, law_state
from gimcli.rates.member_angles import full_turn
from gimcli.structure.drive_check import require_consistent
from gimcli.structure.plan import make_plan

SAMPLES = 10_000
"""Random designs, if the model has tolerances."""

MOST_NUMBERS = 200_000_000
"""Derivatives in a result: 1.6 GB."""

BLOCK_SECONDS = 3e-4
"""Approximate time of one step of a plan, one dimension and 256 rows without compilation [s]."""


def _machines(mechanism: Mechanism, given: dict[str, Any]) -> Sequence[Machine]:
    """Return the machines whose quantities are found, and the whole mechanism for quantities of several machines."""
    driven_machines(mechanism)  # refuses other parts that can move
    _dimensions(mechanism, names_of(given.get("by", ())))  # refuses names that no machine has
    whole = mechanism.as_machine._replace(name="+".join(one.name for one in mechanism.machines))
    of, by, every = given.get("of"), given.get("by"), (*mechanism.machines, whole)
    parts = {one: _own(one.mechanism, given) for one in every}
    found = [one for one, own in parts.items() if (own["of"] or not of) and (own["by"] or not by)]
    zero = [text for own in parts.values() if by and not own["by"] for text in own["of"]]
    if zero:
        text = f"of {', '.join(zero)}: all derivatives are 0, the dimensions belong to other machines"
        refuse((not found, text))
        (given.get("notify") or no_phases)(text)
    return found if of else found[:-1] or every[-1:]


def _own(mechanism: Mechanism, given: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments for a machine: its own quantities and dimensions; of the whole those of no machine alone."""
    of, by = _texts(given.get("of", ())), names_of(given.get("by", ()))
    own = [text for text in of if accepted(_quantities, mechanism, [text], True)]
    if len(mechanism.machines) > 1:
        alone = [text for one in mechanism.machines for text in _own(one.mechanism, given)["of"]]
        own = [text for text in of if text not in alone]
    return {**given, "of": own, "by": [text for text in by if accepted(_dimensions, mechanism, [text])]}


def _texts(given: str | Sequence[str]) -> list[str]:
    return [given] if isinstance(given, str) else list(given)


@for_each_machine(_machines, _own)
def sensitivity(
    mechanism: Mechanism, at: Mapping[str, float | str] | None = None, of: str | Sequence[str] = (), *,
    by: str | Sequence[str] = (), steps: Steps = 72,
    samples: Annotated[int | None, Range(0, MOST_STEPS)] = None, seed: Seed = 0,
    distribution: Annotated[str, OneOf(DEVIATIONS)] = "normal", jit: Jit = "auto", notify: Notify | None = None,
    progress: Phases = no_phases, **inputs: float,
) -> SensitivityResult:  # fmt: skip
    """Find the derivatives of positions and rates by the dimensions, for example `sensitivity(m, of="P", motor=30)`.

    The derivatives are exact (implicit function theorem) and at constant inputs: a dimension that also changes the
    start of a law does not move the input, nor change its speed. Without inputs they are found along the motion of the
    laws. If the model has `tolerances`, the spread of each quantity is found too: worst case and root of the sum of
    squares (RSS) to first order, mean and standard deviation of random designs.

    Args:
        mechanism: from `load` or `loads`.
        at: dict of inputs by name, for names that are not Python names or are names of arguments.
        of: quantities, a text or a list: nodes or points ("P", "P.x"), members (their direction), "transmission",
            "transmission:B", "angle:A/B", velocities, accelerations and jerks ("P.vx", "rocker.alpha"); of a motion
            also numbers that `sweep` can keep, such as "range(P.y)" or "max(hypot(P.vx, P.vy))". By default the traced
            points.
        by: dimensions, such as "crank" or "B.x", or actuators for their inputs. By default all numbers of the file that
            move a node and are not given by a formula, and all inputs.
        steps: number of steps of the motion, if no input is given.
        samples: number of random designs for the tolerances; by default 10 000, or none where the linkage turns gears.
            0: none.
        seed: seed of the random designs.
        distribution: of each dimension within its tolerance, independent of the others: "normal" (the tolerance is
            three standard deviations) or "uniform" (the tolerance is half the width).
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        inputs: inputs by name, in the file's units. Inputs that are not given have the value at the start of their law.

    Returns:
        A SensitivityResult; derivatives are NaN in rows without a position and at dead points, which have a status.

    Raises:
        UsageError: an unknown name or an invalid argument.
        StructureError: the mechanism is not fully driven, over-driven or contradictory.
    """
    whole = bool(mechanism.drivers) and not at and not inputs
    make_plan(mechanism)
    reduced, quantities = _quantities(mechanism, _texts(of), whole)
    chosen = _dimensions(mechanism, names_of(by))
    if whole:
        much = len(quantities) * (len(chosen) + 1) * (steps + 1)
        refuse(
            (
                much > MOST_NUMBERS,
                f"steps: the result has {much:.2g} derivatives, at most {MOST_NUMBERS:.0e} are possible: use fewer"
                " steps, or name quantities (of) and dimensions (by)",
            )
        )
        motion = trace(mechanism, steps, Options(jit=jit), notify=notify)
    else:
        motion = _position(mechanism, inputs_of(mechanism, at, inputs))
    require_consistent(mechanism, motion.start, motion.inputs[:, 0], motion.first_status, 1e-10)
    work = BLOCK_SECONDS * (1 + len(chosen)) * len(make_plan(mechanism).steps) * (1 + len(motion.time) // 256)
    run = choose(jit, work, notify, ("play_designs",))
    chosen, fixed, rows = _derivatives(motion, quantities, chosen, bool(by), run)
    known = tolerances(mechanism)
    allowed = np.array([known.get(one.name, 0.0) for one in chosen])
    given = np.flatnonzero(allowed > 0.0)
    many = SAMPLES if len(given) and mechanism.complete is None else 0
    count = many if samples is None else samples
    why = f"those with a tolerance ({', '.join(known)}) move no node, or are not chosen" if known else ""
    text = f"samples: {why or 'none has a tolerance'}; add `tolerances: {{NAME: VALUE}}` of others to the model, or"
    refuse((count and not len(given), f"{text} remove samples"))
    left_out = tuple(name for name in known if name not in {one.name for one in chosen})
    result = SensitivityResult(
        mechanism, motion, whole, quantities, reduced, chosen, rows, allowed, distribution, fixed, left_out
    )
    if count and result.good.any():
        changes = drawn(seed, count, allowed[given], distribution)
        names = [chosen[k].name for k in given]
        result.sampled = _sampled(motion, names, quantities, reduced, rows, changes, notify, progress)
        result.seed = seed
    return result


def _derivatives(
    motion: Motion, quantities: Sequence[Item], chosen: Sequence[Dimension], named: bool, run: Run
) -> tuple[list[Dimension], tuple[str, ...], QuantitySlopes]:
    """Return the dimensions, those that redundant constraints fix, and the derivatives by the others.

    Unless the dimensions were `named`, those that move no node are left out too.
    """
    mechanism, free = motion.mechanism, list(chosen)
    found = DesignSensitivity(mechanism, [one.name for one in free], quantities, run)
    fixed = found.fixed(motion.z, motion.inputs)
    if named and fixed:
        raise UsageError(
            f"by '{fixed[0]}': redundant constraints fix this dimension: a change of it alone contradicts the others"
            " (`gim mobility` names them)"
        )
    if not named:
        free = [one for one in _moving(found, chosen) if one.name not in fixed]
        found = DesignSensitivity(mechanism, [one.name for one in free], quantities, run)
    time, given = _law_states(motion)
    return free, fixed, found(motion.z, motion.inputs, given[1:], time)


def _law_states(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """Return the time [s] (rows,), and the inputs with three derivatives (4, actuators, rows), as in `solve`."""
    mechanism = motion.mechanism
    if len(motion.time) > 1:
        return motion.time * mechanism.duration, law_rates(mechanism, motion.time, len(ORDERS), motion.inputs)
    time, given = law_state(mechanism, motion.inputs[:, 0], motion.z[:, 0])
    return np.nan_to_num(np.append(time, 0.0)[:1]) * mechanism.duration, given[..., None]


def _position(mechanism: Mechanism, values: FloatArray) -> Motion:
    """Return one position as a motion of one row."""
    position = solve(mechanism, values, Options())
    z = position.z if not position.status.value else np.full(len(position.z), complex(math.nan, math.nan))
    return Motion(
        mechanism, np.zeros(1), position.inputs[:, None], z[:, None], np.array([int(position.status)]),
        position.residual.total, np.array([position.sweeps], dtype=float), position.z,
    )  # fmt: skip


def _quantities(mechanism: Mechanism, texts: Sequence[str], whole: bool) -> tuple[list[MotionNumber], list[Item]]:
    """Return the numbers of the motion, if such were requested, and the quantities of the positions."""
    known = catalogue(mechanism)
    wanted = list(texts) or list(mechanism.traced)
    numbers = [text for text in wanted if known.is_number(text)]
    if not numbers:
        return [], [one for text in wanted for one in position_items(mechanism, text, len(ORDERS))]
    refuse(
        *(
            (
                text not in numbers,
                f"of '{text}': the others are numbers of the whole motion: ask for them in a second call",
            )
            for text in wanted
        ),
        (not whole, f"of '{numbers[0]}': a number of the whole motion; remove the values of the inputs"),
    )
    quantities: list[Item] = []
    return [motion_number(mechanism, text, quantities) for text in numbers], quantities


def _dimensions(mechanism: Mechanism, names: Sequence[str]) -> list[Dimension]:
    """Return the named dimensions and inputs; by default those that the file gives as numbers, and all inputs."""
    inputs = {mechanism.actuators[k].name: _input(mechanism, k) for k in mechanism.drivers}
    if names:
        found = [inputs[name] if name in inputs else written(mechanism).dimension(name) for name in names]
    else:
        tolerated = tolerances(mechanism)
        own = [d for d in written(mechanism).dimensions.values() if (d.given and not d.formula) or d.name in tolerated]
        found = [*own, *inputs.values()]
    return list({one.name: one for one in found}.values())


def _input(mechanism: Mechanism, k: int) -> Dimension:
    actuator = mechanism.actuators[k]
    return Dimension(actuator.name, math.nan, "angle" if actuator.rotary else "length", (), True, "")


def _moving(found: DesignSensitivity, chosen: Sequence[Dimension]) -> list[Dimension]:
    """Return the dimensions that move a node or change the forces, if any are asked for, and all inputs."""
    own = found.family.names
    moves = dict(zip(own, moves_nodes(found.tables).tolist(), strict=False))
    moves |= dict.fromkeys(() if found.forces is None else found.forces.used, True)
    return [one for one in chosen if moves.get(one.name, True)]


def _linked_states(found: Designs, time: FloatArray) -> FloatArray:
    """Return the inputs of designs with three derivatives (designs, 4, actuators, rows) where the linkage turns gears.

    NaN for designs without a position.
    """
    every = np.full((len(found.designs), 1 + len(ORDERS), *found.inputs.shape[1:]), np.nan)
    for k in np.flatnonzero(found.good.any(axis=1)).tolist():
        one = found.motion(k)
        assert one is not None
        scale = one.mechanism.scale / found.family.mechanism.scale
        units = np.where([a.rotary for a in one.mechanism.actuators], 1.0, scale)
        every[k] = units[:, None] * _law_states(replace(one, time=time))[1]
    return every


def _sampled(
    motion: Motion, names: Sequence[str], quantities: Sequence[Item], reduced: Sequence[MotionNumber],
    nominal: QuantitySlopes, changes: FloatArray, notify: Notify | None, progress: Phases,
) -> SampledSpread:  # fmt: skip
    """Return the spread of random designs at the solved rows of a motion."""
    good, family = motion.good, Family(motion.mechanism, names)
    time, given = (own[..., good] for own in _law_states(motion))
    solved = QuantitySlopes(nominal.values[:, good], nominal.slopes[..., good], nominal.good[good])
    nominals = [one.with_slopes(quantities, solved)[0] for one in reduced]

    def numbers(found: Designs) -> FloatArray:
        columns = DesignColumns(found, ColumnNames(motion.mechanism, family.names))
        rows = [np.where(found.good.all(axis=1), columns.of(one.kept), np.nan) for one in reduced]
        return np.stack([(row - own)[:, None] for row, own in zip(rows, nominals, strict=True)])

    def positions(found: Designs) -> FloatArray:
        laws = _linked_states(found, motion.time[good]) if family.linked else given[None]
        at = DesignState(family, found.designs, found.z, found.tables, laws, time[None], quantities)
        away = at.values(quantities) - nominal.values[:, None, good]
        turns = [k for k, one in enumerate(quantities) if one.quantity.circular]
        away[turns] = principal(away[turns], full_turn(motion.mechanism))
        return away

    measure = numbers if reduced else positions
    found = sampled_spread(family, motion.inputs[:, good], changes, measure, notify, progress("random designs"))
    if reduced or good.all():
        return found
    place = np.flatnonzero(good)
    wide: list[Any] = []
    for value in found[1:]:
        full = np.full((*np.shape(value)[:-1], len(good)), 0.0 if value is found.solved else np.nan)
        full[..., place] = value
        wide.append(full)
    return SampledSpread(found.samples, *wide)
