"""The motions of independent machines joined to the motion of the whole mechanism; each keeps its own status."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Machine, Mechanism
from gimcli.positions.inputs import law_inputs

if TYPE_CHECKING:
    from gimcli.motion.follow import Stop


def side_by_side(mechanism: Mechanism, parts: Sequence[Any]) -> Any:
    """Return the Motion of a mechanism from those of its machines, in their order.

    The status of a row is the worst one (the greatest code). The nodes of a machine that is not solved have no position
    there, the others have.
    """
    first, own = parts[0], list(zip(mechanism.machines, parts, strict=True))
    codes = np.max([part.codes for part in parts], axis=0)
    inputs = law_inputs(mechanism)(first.time)
    for machine, part in own:
        inputs[list(machine.actuators)] = whole_inputs(mechanism, machine, part.inputs)
    z = whole_positions(mechanism, [part.z for part in parts])
    z[:, np.all([~part.good for part in parts], axis=0)] = complex(math.nan, math.nan)
    met = [
        (time, one._replace(z=_scattered(mechanism, machine, one.z), inputs=np.array(at)))
        for machine, part in own
        for time, one in zip(part.bridged, part.meetings, strict=True)
        for at in [_stop(mechanism, machine, (time, one.inputs))[1]]
    ]
    met.sort(key=lambda one: one[0])
    return replace(
        first, mechanism=mechanism, inputs=inputs, z=z, codes=codes, parts=tuple(parts),
        residual=np.max([part.residual for part in parts], axis=0),  # NaN where a machine is not solved
        work=np.sum([part.work for part in parts], axis=0),
        start=whole_positions(mechanism, [part.start for part in parts]),
        worst=next((part.worst for part in parts if part.worst), ""),
        limit=min((part.limit for part in parts if part.limit is not None), default=None),
        touched=tuple(_stop(mechanism, one, at) for one, part in own for at in part.touched),
        turned_back=tuple(_stop(mechanism, one, at) for one, part in own for at in part.turned_back),
        bridged=tuple(time for time, _ in met), meetings=tuple(meeting for _, meeting in met),
        exchanged=tuple(sorted(time for part in parts for time in part.exchanged)),
    )  # fmt: skip


def whole_positions(
    mechanism: Mechanism, parts: Iterable[ComplexArray], machines: Sequence[Machine] = ()
) -> ComplexArray:
    """Return positions (nodes, ...) of a mechanism from those of its machines, each in its own normal frame."""
    found = list(parts)
    z = np.full((len(mechanism.nodes), *found[0].shape[1:]), complex(math.nan, math.nan))
    frame = mechanism.members[FRAME]
    z[list(frame.nodes)] = frame.shape.reshape(-1, *[1] * (z.ndim - 1))
    for machine, own in zip(machines or mechanism.machines, found, strict=True):
        moving = [k for k, node in enumerate(machine.nodes) if node not in frame.nodes]
        placed = machine.mechanism.to_file(own[moving])
        z[[machine.nodes[k] for k in moving]] = (placed - mechanism.origin) / mechanism.scale
    return z


def whole_inputs(mechanism: Mechanism, machine: Machine, values: FloatArray) -> FloatArray:
    """Return inputs (actuators of the machine, ...) in the normal frame of the whole mechanism."""
    ratio = machine.mechanism.scale / mechanism.scale
    factors = np.array([1.0 if a.rotary else ratio for a in machine.mechanism.actuators])
    return np.asarray(values * factors.reshape(-1, *[1] * (values.ndim - 1)))


def machine_inputs(mechanism: Mechanism, machine: Machine, values: FloatArray) -> FloatArray:
    """Return the inputs (actuators of the machine,) in its own normal frame, from those of the whole mechanism."""
    return np.asarray(
        values[list(machine.actuators)] / whole_inputs(mechanism, machine, np.ones(len(machine.actuators)))
    )


def _stop(mechanism: Mechanism, machine: Machine, at: tuple[float, Any]) -> Stop:
    """Return a time and the inputs of the whole mechanism there; those of the machine are given."""
    time, own = at
    values = law_inputs(mechanism)(np.array([time]))[:, 0]
    values[list(machine.actuators)] = whole_inputs(mechanism, machine, np.asarray(own))
    return time, tuple(values.tolist())


def _scattered(mechanism: Mechanism, machine: Machine, z: ComplexArray) -> ComplexArray:
    """Return positions (nodes,) of the whole mechanism of which only those of one machine are known."""
    empty = complex(math.nan, math.nan)
    parts = [z if one is machine else np.full(len(one.nodes), empty) for one in mechanism.machines]
    return whole_positions(mechanism, parts)
