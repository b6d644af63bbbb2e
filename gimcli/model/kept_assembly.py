"""The initial configuration of a mechanism whose dimensions change: another assembly is kept."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from gimcli.mechanism import FRAME, Input, Mechanism
from gimcli.model.schema import Model


def in_assembly_of(mechanism: Mechanism, old: Mechanism, model: Model) -> Mechanism:
    """Return a mechanism in the initial configuration of `old`, the same mechanism with other dimensions.

    `model` is the model of `old`. Where the initial configuration is not that of its coordinates, each node is
    displaced from its own coordinates as it is in `old`; nodes of the frame are not.
    """
    written = np.array([complex(*model.nodes[name]) for name in old.nodes])
    if np.array_equal((written - old.origin) / old.scale, old.drawn):
        return mechanism
    drawn = mechanism.drawn + (old.to_file(old.drawn) - written) / mechanism.scale
    frame = mechanism.members[FRAME]
    drawn[list(frame.nodes)] = frame.shape
    ratio = old.scale / mechanism.scale
    actuators = _drawn_as(mechanism.actuators, old.actuators, ratio)
    return replace(mechanism, drawn=drawn, actuators=actuators, gauges=_drawn_as(mechanism.gauges, old.gauges, ratio))


def _drawn_as(inputs: Iterable[Input], old: Iterable[Input], ratio: float) -> tuple[Input, ...]:
    """Return inputs with the initial values of others; lengths are multiplied by a ratio."""
    pairs = zip(inputs, old, strict=True)
    return tuple(replace(one, drawn=other.drawn * (1.0 if one.rotary else ratio)) for one, other in pairs)
