"""The long form of a mechanism's model file."""

from __future__ import annotations

from gimcli.mechanism import Mechanism
from gimcli.model.dimensions import written


def long_form(mechanism: Mechanism) -> str:
    """Return the model file of a mechanism in long form.

    Args:
        mechanism: from `load` or `loads`, or from its `with_`.

    Returns:
        YAML text of a model of the same mechanism. Short forms are written out; types, lengths, shapes, local
        coordinates, ends of laws and the duration are explicit. Formulas are evaluated, and are comments.

    Raises:
        UsageError: the mechanism was not read from a model.
    """
    from gimcli.model.long_text import long_text

    written(mechanism)
    return long_text(mechanism)
