"""Checks of the parameters' names, and of the dimensions that tolerances name."""

from __future__ import annotations

from gimcli.errors import UsageError
from gimcli.model.arithmetic import is_name
from gimcli.model.dimensions import WHOLE, dimensions_of, found
from gimcli.model.references import References


def check_parameters(refs: References) -> None:
    """Record the errors in the sections `parameters` and `tolerances`."""
    for name in refs.model.parameters:
        if not is_name(name) or name in WHOLE:
            why = "it is reserved" if name.isidentifier() else "expected letters, digits and _, a letter first"
            refs.fault(("parameters", name), f"'{name}' cannot be the name of a parameter: {why}; rename it", key=True)
    if refs.model.tolerances and not refs.doubtful and not refs.source.faults:
        _check_tolerances(refs)


def _check_tolerances(refs: References) -> None:
    named = dimensions_of(refs.model)
    seen: dict[str, str] = {}
    for name in refs.model.tolerances:
        try:
            full = found(named, name).name
        except UsageError as error:
            refs.fault(("tolerances", name), str(error), key=True)
            continue
        if full in seen:
            refs.fault(("tolerances", name), f"'{name}' and '{seen[full]}' are the same; remove one", key=True)
        seen[full] = name
