"""Compare methods and tolerances on a motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from gimcli import output
from gimcli.comparison.timing import TIMING, Clock
from gimcli.comparison.tradeoff import STEPS, TOLERANCES, Tradeoff, advise, tradeoff as compare
from gimcli.connected import grouped
from gimcli.errors import refuse
from gimcli.library.inputs import Jit, Number, Steps, refuse_unmoved
from gimcli.library.machines import driven_machines, for_each_machine
from gimcli.library.record import Records, RowField
from gimcli.library.result import Result
from gimcli.mechanism import Mechanism
from gimcli.progress import Notify, Phases, no_phases

FINEST, COARSEST = 1e-14, 1.0

Seconds = Annotated[float, Number("a number of at least 1", lambda value: value >= 1.0)]


@for_each_machine(driven_machines)
def tradeoff(
    mechanism: Mechanism, steps: Steps = STEPS, *, tolerances: Sequence[float] = (), seconds: Seconds = 10.0,
    jit: Jit = "auto", notify: Notify | None = None, progress: Phases = no_phases, clock: Clock = TIMING.clock,
) -> TradeoffResult:  # fmt: skip
    """Compare time and true error of all methods at several tolerances, on the motion along the actuators' laws.

    Args:
        mechanism: from `load` or `loads`.
        steps: number of steps of the motion, 1 to 10 000 000.
        tolerances: from 1e-14 to below 1; by default several from 1e-2 to 1e-14.
        seconds: intended processor time [s], at least 1; the slowest combinations are then left out.
        jit: "auto" compiles the kernels where this saves time; "on", "off". The numbers are the same.
        notify: function of a text; called with notices, such as the start of a compilation.
        progress: function of the name of a phase; returns a function of (done, all), for a progress bar.
        clock: function that returns a time [s]; by default the processor time of the process.

    Returns:
        A TradeoffResult: one row for each method and tolerance; `report()` also has advice.

    Raises:
        UsageError: an invalid argument.
        StructureError: the mechanism has no actuator, or is not fully driven or over-driven.
    """
    text = "tolerances: expected numbers from 1e-14 to below 1, got"
    refuse(*((not FINEST <= value < COARSEST, f"{text} {value:g}") for value in tolerances))
    chosen = tuple(dict.fromkeys(tolerances)) or TOLERANCES
    refuse_unmoved(mechanism, "add an actuator")
    timing = replace(TIMING, clock=clock)
    found = compare(mechanism, steps, chosen, jit, notify, progress("comparing"), timing, seconds)
    return TradeoffResult(found, steps)


class TradeoffResult(Result):
    """Time, operations and true error of each method at each tolerance, one row each."""

    KIND = "tradeoff"

    def __init__(self, found: Tradeoff, steps: int) -> None:
        self.mechanism, self._found, self.steps = found.mechanism, found, steps
        self.status = found.motion.overall.word

    @property
    def complete(self) -> bool:
        """Whether the motion was solved."""
        return bool(self._found.reached)

    def headline(self) -> str:
        """Return the result in one line."""
        how = "compiled kernels" if self._found.compiled else "kernels not compiled"
        return f"{self.mechanism.name}: values per position of a motion in {self.steps} steps, {how}"

    def report(self) -> dict[str, Any]:
        """Return the report that --json prints."""
        found = self._found
        advice = [
            {
                "digits": a.digits, "text": a.text, "options": a.best.method.options if a.best else None,
                "tolerance": a.best.tolerance if a.best else None, "call": a.best.call if a.best else None,
                "price": a.price,
            }
            for a in advise(found)
        ]  # fmt: skip
        return {
            "steps": self.steps, "solved": found.motion.solved, "status": self.status,
            "compiled": found.compiled, "untold": found.unrefined,
            "entries": self._records.report(), "advice": advice,
        }  # fmt: skip

    @cached_property
    def _records(self) -> Records:
        """The methods and tolerances, one row each."""
        found = self._found.entries
        names = [e.method.name for e in found]
        labels = [e.method.label * (name != last) for e, name, last in zip(found, names, ["", *names], strict=False)]
        return Records(
            RowField("method", names, str, head="method", text=labels),
            RowField("tolerance", [e.tolerance for e in found], float, head="tolerance"),
            RowField("unknowns", [list(e.unknowns) for e in found], head="unknowns",
                     text=[" + ".join(map(str, e.unknowns)) for e in found]),
            RowField("unknowns", [_sum(e.unknowns) for e in found], str, key=False),
            RowField("iteration_operations", [list(e.iterations) for e in found]),
            RowField("iteration_operations", [_sum(e.iterations) for e in found], str, key=False),
            RowField("iterations", [e.work for e in found], float, head="iterations", text=_formatted(".2f")),
            RowField("most_iterations", [e.most for e in found], float),
            RowField("paper_operations", [e.paper for e in found], float),
            RowField("operations", [e.operations for e in found], float, head="operations", text=_formatted(".0f")),
            RowField("seconds", [e.time.seconds for e in found], float, "s", head="position [µs]", text=_micro),
            RowField("error", [e.error for e in found], float, head="true error", text=_formatted(".1e")),
            RowField("solved", [e.solved for e in found], int, head="solved",
                     text=[f"{e.solved}/{e.rows}" for e in found]),
            RowField("positions", [e.rows for e in found], int),
            RowField("efficient", [e.efficient for e in found], int),
            RowField("reason", [e.reason for e in found], str, head="",
                     text=[e.reason + "*" * (e.efficient and e.solved > 0) for e in found]),
            RowField("spread", [e.time.spread for e in found], float, "s", head="spread",
                     text=[f"{e.time.spread / e.time.seconds:.0%}" if e.solved else "-" for e in found]),
            RowField("fixed", [e.fixed.seconds for e in found], float, "s", head="call [µs]", text=_micro),
            RowField("call", [e.call for e in found], float, "s"),
        )  # fmt: skip

    def picture(self) -> output.picture.Content | None:
        """Return the graph of the error over the time; None if there is nothing to draw."""
        found = self._found
        if not any(e.drawable for e in found.entries):
            return None
        drawable = (e for e in found.entries if e.drawable)
        curves = grouped((e.method.label, (e.time.seconds, e.call, e.error, float(e.complete))) for e in drawable)
        front = np.array([(e.time.seconds, e.call, e.error) for e in found.entries if e.efficient]).reshape(-1, 3)
        how = "compiled kernels" if found.compiled else "kernels not compiled"
        title = f"{found.mechanism.name}: error and time, {how}"
        arrays = {name: np.array(points) for name, points in curves.items()}
        return output.tradeoff.tradeoff_sheet(arrays, front, title, self.steps)


def _sum(parts: Sequence[float]) -> str:
    return "+".join(f"{part:.0f}" for part in parts)


def _formatted(form: str) -> Callable[[float], str]:
    """Return a function that formats a number; "-" if it was not measured."""
    return lambda value: format(value, form) if math.isfinite(value) else "-"


def _micro(seconds: float) -> str:
    """Return a time in µs to three digits; "-" if it was not measured."""
    return f"{1e6 * seconds:#.3g}".rstrip(".") if math.isfinite(seconds) else "-"
