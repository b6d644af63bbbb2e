"""Analyse planar mechanisms described in text model files, by the Geometrical-Iterative Method.

    import gimcli

    m = gimcli.load("crank_rocker")  # a path, a shipped model or a dict
    p = gimcli.solve(m, motor=45)
    p.xy["B"], p.angle["rocker"], p.status
    t = gimcli.trace(m, steps=360, derivatives=2)
    t.save("crank_rocker.csv", "crank_rocker.png")

In the place of a mechanism, functions also take what `load` takes: `gimcli.trace("crank_rocker", 360)`.
Arguments and results use the units and the names of the model file. Importing the package is fast: each function
imports its own modules when it is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gimcli.version import __version__ as __version__

if TYPE_CHECKING:
    from gimcli.errors import GimError, ModelError, OutputError, StructureError, UnassembledError, UsageError
    from gimcli.library.assembled import assembled
    from gimcli.library.check import check
    from gimcli.library.circuits import circuits
    from gimcli.library.configurations import configurations
    from gimcli.library.convert import convert
    from gimcli.library.equilibrium import equilibrium
    from gimcli.library.evaluator import evaluator
    from gimcli.library.fit import fit
    from gimcli.library.forces import forces
    from gimcli.library.groups import groups
    from gimcli.library.holding_forces import holding_forces
    from gimcli.library.load import load, loads
    from gimcli.library.mobility import mobility
    from gimcli.library.modes import modes
    from gimcli.library.reduce import reduce
    from gimcli.library.sensitivity import sensitivity
    from gimcli.library.sequence import sequence
    from gimcli.library.shipped_models import shipped_models
    from gimcli.library.simulate import simulate
    from gimcli.library.singularities import singularities
    from gimcli.library.solve import solve
    from gimcli.library.sweep import sweep
    from gimcli.library.trace import trace
    from gimcli.library.tradeoff import tradeoff
    from gimcli.library.workspace import workspace
    from gimcli.mechanism import Mechanism

__all__ = [
    "GimError", "Mechanism", "ModelError", "OutputError", "StructureError", "UnassembledError", "UsageError",
    "assembled", "check", "circuits", "configurations", "convert", "equilibrium", "evaluator", "fit", "forces",
    "groups", "holding_forces", "load", "loads", "mobility", "modes", "reduce", "sensitivity", "sequence",
    "shipped_models", "simulate", "singularities", "solve", "sweep", "trace", "tradeoff", "workspace",
]  # fmt: skip

RENAMED = {
    "circuits": {"samples": "values"}, "reduce": {"input": "actuator"},
    "simulate": {"time": "duration", "method": "integrator"}, "workspace": {"keep": "folder", "all": "every"},
}  # fmt: skip
"""Old and new names of arguments by functions; the old ones work in this version."""

BEFORE_AT = {"assembled": "assembly", "equilibrium": "free", "modes": "free", "sensitivity": "of"}
"""Functions whose second argument was another one, before `at`; this order works in this version."""

_NO_VERBS = ("load", "loads", "shipped_models")
_ERRORS = ("GimError", "ModelError", "OutputError", "StructureError", "UnassembledError", "UsageError")
_MODULES = {name: f"gimcli.library.{name}" for name in __all__ if name.islower()} | {
    "loads": "gimcli.library.load", "Mechanism": "gimcli.mechanism", **dict.fromkeys(_ERRORS, "gimcli.errors"),
}  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in _MODULES:
        raise AttributeError(f"module 'gimcli' has no attribute '{name}'")
    found = getattr(import_module(_MODULES[name]), name)
    globals()[name] = _of_any_model(found) if name.islower() and name not in _NO_VERBS else found
    return globals()[name]


def _of_any_model(verb: Any) -> Any:
    """Return a verb that also takes what `load` takes, such as a path, in the place of the mechanism, and old names."""
    from collections.abc import Mapping
    from functools import wraps
    from warnings import warn

    from gimcli.library.load import load
    from gimcli.mechanism import Mechanism

    @wraps(verb)
    def decorated(mechanism: Any, *args: Any, **kwargs: Any) -> Any:
        first = BEFORE_AT.get(verb.__name__)
        if first and args and args[0] is not None and not isinstance(args[0], Mapping):
            text = f"{verb.__name__}: the second argument is `at`, as in all functions; give `{first}` by its name"
            warn(text, DeprecationWarning, stacklevel=2)
            kwargs[first], args = args[0], args[1:]
        known = RENAMED.get(verb.__name__, {})
        given = known.keys() & kwargs.keys()
        for old in given:
            text = f"{verb.__name__}: the argument `{old}` is now named `{known[old]}`"
            warn(text, DeprecationWarning, stacklevel=2)
        renamed = {known[old]: kwargs.pop(old) for old in given}
        return verb(mechanism if isinstance(mechanism, Mechanism) else load(mechanism), *args, **kwargs, **renamed)

    decorated.__module__ = __name__  # where pickle finds it
    return decorated


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
