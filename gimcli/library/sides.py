"""The configuration of a mechanism with nodes without coordinates: the only one, or an error that lists the choices."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np

from gimcli.assemblies import all_configurations
from gimcli.errors import GimError, ModelError, StructureError
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.model.compile import compile_model
from gimcli.model.placing import Placement, chosen_at, place, sides_at, with_rough
from gimcli.model.schema import Model
from gimcli.rounding import length, titled
from gimcli.structure.mobility import require_driven

MOST_SIDES = 8
"""Most nodes with a side for which all configurations are listed: their number doubles with each."""

LISTED = 16
"""Number of choices that a message lists."""

STARTS = 8
"""Most rough positions of coupled nodes that are tried."""

SAME = 1e-9
"""Distance of two positions, relative to the size, up to which they are the same."""


def with_rough_start(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism with rough positions of its coupled nodes, near which its actuators drive it.

    If there are none, the mechanism is unchanged.
    """
    own = mechanism.written
    for number in range(STARTS):
        model = with_rough(own.model, own.source.folder, number) if number else own.model
        started = compiled(mechanism, model)
        try:
            require_driven(started)
        except StructureError:
            continue
        return started
    return mechanism


def settled(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose coupled nodes are at the only positions that are possible.

    Raises ModelError, with the choices, if several positions of its nodes without coordinates are possible.
    """
    opened = mechanism.written.model.open
    choices = _coupled(mechanism) if opened.coupled else _placed(mechanism)
    if not choices:
        inputs = titled(mechanism, mechanism.inputs_to_file(mechanism.start_inputs))
        raise _refused(mechanism, opened.coupled[:1], f"cannot be assembled ({inputs}); change a length or an input")
    if opened.coupled and len(choices) == 1:
        z = np.array([choices[0].at[name] for name in mechanism.nodes])
        return with_sides_of(mechanism, mechanism, (z - mechanism.origin) / mechanism.scale, chosen=False)
    text = "has two possible positions: give `side: left` or `side: right`, or choose an assembly"
    undecided = opened.undecided
    if opened.coupled:
        undecided = tuple(name for name in undecided if len({one.sides.get(name) for one in choices}) > 1)
    error = _refused(mechanism, undecided, text)
    more = "depends on other nodes without coordinates: give rough coordinates [x, y], or choose an assembly"
    coupled = _refused(mechanism, opened.coupled[:1], more).faults if opened.coupled else []
    shown = (*undecided, *opened.coupled)
    numbered = [one for one in choices if one.number is not None] or choices[:LISTED]
    listed = [_text(mechanism, shown, one) for one in numbered[:LISTED]]
    listed += ["`gim solve --all` lists more"] if len(choices) > len(listed) else []
    path = mechanism.written.source.path
    raise ModelError([*error.faults, *coupled, *(f"{path}: {text}" for text in listed)])


def with_sides_of(mechanism: Mechanism, plain: Mechanism, z: ComplexArray, chosen: bool = True) -> Mechanism:
    """Return a mechanism whose initial position is z (nodes,), with the sides that its open nodes have there.

    `plain` is the mechanism before it was assembled; `chosen`: other configurations are possible.
    """
    own = mechanism.written
    if own is None or not own.model.open.parts:
        return mechanism
    at = _by_name(mechanism, z)
    found = compiled(mechanism, chosen_at(own.model, own.source.folder, at, chosen))
    same = np.max(np.abs(found.to_file(found.drawn) - mechanism.to_file(z))) <= SAME * plain.size * plain.scale
    if same and np.array_equal(mechanism.drawn_inputs, plain.start_inputs):
        return found
    return replace(mechanism, written=found.written)


def compiled(mechanism: Mechanism, model: Model) -> Mechanism:
    """Return the mechanism of a model with other positions of its open nodes."""
    written = replace(mechanism.written, model=model)
    found = compile_model(model, written.source.folder)
    return replace(found, files=mechanism.files, path=mechanism.path, left_out=mechanism.left_out, written=written)


def _refused(mechanism: Mechanism, names: tuple[str, ...], text: str) -> ModelError:
    """Return an error at some nodes."""
    source = replace(mechanism.written.source, faults=[])
    for name in names:
        source.fault(("nodes", name), f"node {name} {text}", key=True)
    return source.error()  # type: ignore[no-any-return]  # `written` is Any


def _by_name(mechanism: Mechanism, z: ComplexArray) -> dict[str, complex]:
    """Return the positions of nodes by name, file's unit."""
    return dict(zip(mechanism.nodes, mechanism.to_file(z).tolist(), strict=True))


def _text(mechanism: Mechanism, names: tuple[str, ...], choice: Placement) -> str:
    """Return the text of one choice."""
    parts = []
    for name in names:
        x, y = (length(mechanism, part) for part in (choice.at[name].real, choice.at[name].imag))
        parts.append(f"{name}{' ' * (name in choice.sides)}{choice.sides.get(name, '')} [{x}, {y}]")
    return f"{'' if choice.number is None else f'assembly {choice.number}: '}{', '.join(parts)}"


# -- choices --------------------------------------------------------------------------------


def _coupled(mechanism: Mechanism) -> list[Placement]:
    """Return the configurations with the sides that are decided.

    Raises ModelError if they cannot be listed.
    """
    opened = mechanism.written.model.open
    if len(opened.sides) > MOST_SIDES:
        text = "depends on other nodes without coordinates, of which there are too many: give rough coordinates [x, y]"
        raise _refused(mechanism, opened.coupled[:1], text)
    try:
        found = _listed(mechanism)
    except GimError as error:
        text = (
            "has no coordinates, and lengths and inputs do not determine its position; give rough coordinates [x, y],"
        )
        text += f" or correct this: {error}"
        raise _refused(mechanism, opened.coupled[:1], text) from None
    return [
        one for one in found
        if all(one.sides.get(name, side) == side or name in opened.undecided for name, side in opened.sides.items())
    ]  # fmt: skip


def _placed(mechanism: Mechanism) -> list[Placement]:
    """Return the sets of positions, numbered as `gim solve --all` does if it can list them."""
    own = mechanism.written
    found = place(own.model, own.source.folder, {}).found
    listed: list[Placement] = []
    with suppress(GimError):
        listed = _listed(mechanism) if len(own.model.open.sides) <= MOST_SIDES else []
    same = ([other.number for other in listed if other.sides == one.sides] for one in found)
    choices = [one._replace(number=k[0] if len(k) == 1 else None) for one, k in zip(found, same, strict=True)]
    return sorted(choices, key=lambda one: len(listed) + 1 if one.number is None else one.number)


def _listed(mechanism: Mechanism) -> list[Placement]:
    """Return all configurations, with the sides of the open nodes; raise GimError if they cannot be found."""
    own = mechanism.written
    places = [_by_name(mechanism, z) for z in all_configurations(mechanism, mechanism.start_inputs).z]
    sides = (sides_at(own.model, own.source.folder, at) for at in places)
    return [Placement(at, chosen, k) for k, (at, chosen) in enumerate(zip(places, sides, strict=True), 1)]
