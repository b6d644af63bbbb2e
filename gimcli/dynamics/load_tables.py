"""Tables of loads that end inside the motion: the load then keeps its last factor, which is seldom meant."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gimcli.dynamic_data import TIME
from gimcli.mechanism import Mechanism

SAMPLES = 513
"""Times at which a law is evaluated for its range."""

OUTSIDE = 1e-9
"""Part of the range of a law that may be outside of a table."""


def short_tables(mechanism: Mechanism) -> Iterator[tuple[str, str, list[float], list[float]]]:
    """Yield load, actuator, range of the table and range of the law, where the table does not cover the law.

    The ranges are in the file's units. Tables over the time are left out: a load may well end before the motion does.
    """
    for load in mechanism.dynamics.loads:
        if load.curve is None or load.over == TIME:
            continue
        values = mechanism.actuators[load.over].law(np.linspace(0.0, 1.0, SAMPLES))
        law, table = (np.array([np.min(v), np.max(v)]) for v in (values, load.curve.at))
        slack = OUTSIDE * max(float(law[1] - law[0]), 1e-12)
        if law[0] < table[0] - slack or law[1] > table[1] + slack:
            own, whole = (mechanism.value_to_file(load.over, span).tolist() for span in (table, law))
            yield load.name, mechanism.actuators[load.over].name, own, whole
