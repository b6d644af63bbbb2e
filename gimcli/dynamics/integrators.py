"""Registry of the integrators of the equations of motion, one row each in `INTEGRATORS`.

The integrators of scipy (Dormand & Prince 8(5,3) and 5(4), Radau IIA, LSODA) have adaptive steps; the classic method of
Runge and Kutta has equal steps. The command line imports this file for the names, so it imports nothing slow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gimcli.mechanism import FloatArray

Slopes = Callable[[float, "FloatArray"], "FloatArray"]
"""Function of time [s] and state that returns the derivatives of the state."""


Begin = Callable[..., Any]
"""Function of derivatives, initial time, initial state, end time and control; returns a solver like those of scipy.

The control, by name: `rtol` and `atol` (state,); `step` [s] of methods with equal steps; `least` [s], the least first
step of methods with adaptive steps; `jacobian`, a function of time and state, for implicit methods.
"""


@dataclass(frozen=True)
class Integrator:
    """A method of integration."""

    begin: Begin
    lands: bool = True  # a shortened step that ends at an event is as accurate as the others
    corrected: bool = False  # the state may be changed between steps
    compiled: bool = False  # there is also a compiled version
    explicit: bool = False  # its steps become short where the equations are stiff
    over_input: bool = False  # its steps are steps of the input instead of the time; `begin` is not used
    exact: bool = False  # of these: with the exact derivative of the inertia instead of differences
    unit: str = ""  # of its equal steps


def of_scipy(name: str) -> Begin:
    """Return the function that creates a solver of scipy."""

    def begin(
        slopes: Slopes, start: float, y: FloatArray, end: float, *, rtol: float, atol: FloatArray, least: float,
        jacobian: Any, **_: Any,
    ) -> Any:  # fmt: skip
        from scipy import integrate

        known = {"jac": jacobian} if name == "Radau" else {}
        solver = getattr(integrate, name)(slopes, start, y, end, rtol=rtol, atol=atol, **known)
        if hasattr(solver, "h_abs"):  # LSODA has its own first step
            solver.h_abs = min(max(solver.h_abs, least), end - start)
        else:
            solver._step_impl = _quiet(solver._step_impl)
        return solver

    return begin


def _quiet(step: Callable[[], Any]) -> Callable[[], Any]:
    """Return the step of LSODA without the warning of scipy: that it failed is the status of the solver."""
    import warnings

    def quiet() -> Any:
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "lsoda")
            return step()

    return quiet


def in_equal_steps(slopes: Slopes, start: float, y: FloatArray, end: float, *, step: float, **_: Any) -> Any:
    """Return a solver of the classic Runge-Kutta method."""
    from gimcli.dynamics.classic_runge_kutta import ClassicRungeKutta

    return ClassicRungeKutta(slopes, start, y, end, step)


USUAL, WITH_DRY_FRICTION, CAREFUL = "dop853", "lsoda", "radau"
"""The default; with dry friction, which is stiff; and where that one cannot continue."""

INTEGRATORS: dict[str, Integrator] = {
    "dop853": Integrator(of_scipy("DOP853"), corrected=True, compiled=True, explicit=True),
    "rk45": Integrator(of_scipy("RK45"), corrected=True, explicit=True),
    "radau": Integrator(of_scipy("Radau")),
    "lsoda": Integrator(of_scipy("LSODA")),
    "rk4": Integrator(in_equal_steps, lands=False, unit="s"),
    "euler": Integrator(in_equal_steps, over_input=True, unit="rad or length"),
    "euler-exact": Integrator(in_equal_steps, over_input=True, exact=True, unit="rad or length"),
}

STEPPED = ", ".join(f"{name} [{one.unit}]" for name, one in INTEGRATORS.items() if one.unit)
"""Those with equal steps, and the unit of these."""
