"""Integrators of the equations of motion: one line here for each.

Those of scipy (Dormand & Prince 8(5,3) and 5(4), Radau IIA, LSODA) choose their steps; Runge & Kutta's classic one
takes equal steps. Importing this file is cheap: the command line shows the names.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gimcli.mechanism import FloatArray

Slopes = Callable[[float, "FloatArray"], "FloatArray"]
"""Returns the derivatives of a state at a time."""


@dataclass(frozen=True)
class StepControl:
    """What an integrator may choose its steps by."""

    rtol: float
    atol: FloatArray  # (state,)
    step: float  # s, of methods with equal steps
    least: float  # s, the shortest first step of the others


Begin = Callable[[Slopes, float, "FloatArray", float, StepControl], Any]
"""Makes a solver of scipy's interface from derivatives, a time, a state there, and the end."""


@dataclass(frozen=True)
class Integrator:
    """A method of integration."""

    begin: Begin
    lands: bool = True  # a step that is cut to end at an event is as exact as any other
    corrected: bool = False  # its state may be corrected between steps
    compiled: bool = False  # it has compiled steps too
    over_input: bool = False  # its steps are of the input, not of the time: `begin` is not asked


def of_scipy(name: str) -> Begin:
    """Return what begins a solver of scipy's."""

    def begin(slopes: Slopes, start: float, y: FloatArray, end: float, control: StepControl) -> Any:
        from scipy import integrate

        solver = getattr(integrate, name)(slopes, start, y, end, rtol=control.rtol, atol=control.atol)
        if hasattr(solver, "h_abs"):  # LSODA keeps its own
            solver.h_abs = min(max(solver.h_abs, control.least), end - start)
        return solver

    return begin


def in_equal_steps(slopes: Slopes, start: float, y: FloatArray, end: float, control: StepControl) -> Any:
    """Begin Runge & Kutta's classic method."""
    from gimcli.dynamics.classic_runge_kutta import ClassicRungeKutta

    return ClassicRungeKutta(slopes, start, y, end, control.step)


INTEGRATORS: dict[str, Integrator] = {
    "dop853": Integrator(of_scipy("DOP853"), corrected=True, compiled=True),
    "rk45": Integrator(of_scipy("RK45"), corrected=True),
    "radau": Integrator(of_scipy("Radau")),
    "lsoda": Integrator(of_scipy("LSODA")),
    "rk4": Integrator(in_equal_steps, lands=False),
    "euler": Integrator(in_equal_steps, over_input=True),
}
