"""The initial configuration of a mechanism whose dimensions change: another assembly is kept."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from gimcli.mechanism import FRAME, Input, Mechanism
from gimcli.model.schema import Model


def in_assembly_of(mechanism: Mechanism, old: Mechanism, model: Model) -> Mechanism:
    """Return a mechanism in the initial configuration of `old`, the same with other dimensions or other parts, too.

    `model` is the model of `old`. Where the initial configuration is not that of its coordinates, each node is
    displaced from its own coordinates as it is in `old`; nodes of the frame are not.
    """
    places = dict(zip(old.nodes, old.drawn.tolist(), strict=True))
    written = np.array([complex(*model.nodes[name]) for name in mechanism.nodes])
    before = np.array([places[name] for name in mechanism.nodes])
    if np.array_equal((written - old.origin) / old.scale, before):
        return mechanism
    drawn = mechanism.drawn + (old.to_file(before) - written) / mechanism.scale
    frame = mechanism.members[FRAME]
    drawn[list(frame.nodes)] = frame.shape
    ratio = old.scale / mechanism.scale
    actuators = _drawn_as(mechanism.actuators, old.actuators, ratio)
    return replace(mechanism, drawn=drawn, actuators=actuators, gauges=_drawn_as(mechanism.gauges, old.gauges, ratio))


def _drawn_as(inputs: Iterable[Input], old: Iterable[Input], ratio: float) -> tuple[Input, ...]:
    """Return inputs with the initial values of those of the same names; lengths are multiplied by a ratio."""
    drawn = {one.name: one.drawn for one in old}
    return tuple(replace(one, drawn=drawn[one.name] * (1.0 if one.rotary else ratio)) for one in inputs)
