"""The sides of nodes without coordinates: an error that lists them where they are open, and the choice of one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from gimcli.errors import GimError, ModelError
from gimcli.library.rounding import length
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.model.compile import compile_model
from gimcli.model.placing import Placement, place, placed_again, sides_at, with_sides

LISTED = 16
"""Number of choices that a message lists."""

SAME = 1e-9
"""Distance of two positions, relative to the size, up to which they are the same."""


def refused_sides(mechanism: Mechanism) -> ModelError:
    """Return the error that lists the choices for nodes whose side is open."""
    own = mechanism.written
    undecided = own.model.open.undecided
    source = replace(own.source, faults=[])
    for name in undecided:
        text = f"node {name} has two possible positions: give `side: left` or `side: right`, or use --assembly"
        source.fault(("nodes", name), text, key=True)
    found = place(own.model, own.source.folder, {}).found
    numbers = _numbers(mechanism, found)
    order = sorted(range(len(found)), key=lambda k: numbers.get(k, len(found)))[:LISTED]
    shown = [_choice(mechanism, undecided, found[k], numbers.get(k)) for k in order]
    more = [f"and {len(found) - LISTED} more: `gim solve --all` lists all"] if len(found) > LISTED else []
    return ModelError([*source.error().faults, *(f"{own.source.path}: {text}" for text in (*shown, *more))])


def with_sides_of(mechanism: Mechanism, plain: Mechanism, z: ComplexArray) -> Mechanism:
    """Return a mechanism whose initial position is z (nodes,), with the sides that its open nodes have there.

    `plain` is the mechanism before it was assembled.
    """
    own = mechanism.written
    if own is None or not own.model.open.parts:
        return mechanism
    sides = sides_at(own.model, own.source.folder, _by_name(mechanism, z))
    model = placed_again(with_sides(own.model, sides), own.source.folder)
    written = replace(own, model=model)
    compiled = compile_model(model, own.source.folder)
    same = np.max(np.abs(compiled.to_file(compiled.drawn) - mechanism.to_file(z))) <= SAME * plain.size * plain.scale
    if same and np.array_equal(mechanism.drawn_inputs, plain.start_inputs):
        return replace(
            compiled, files=mechanism.files, path=mechanism.path, left_out=mechanism.left_out, written=written
        )
    return replace(mechanism, written=written)


def _by_name(mechanism: Mechanism, z: ComplexArray) -> dict[str, complex]:
    """Return the positions of nodes by name, file's unit."""
    return dict(zip(mechanism.nodes, mechanism.to_file(z).tolist(), strict=True))


def _choice(mechanism: Mechanism, undecided: tuple[str, ...], found: Placement, number: int | None) -> str:
    """Return the text of one choice."""
    parts = []
    for name in (one for one in undecided if one in found.sides):
        x, y = (length(mechanism, part) for part in (found.at[name].real, found.at[name].imag))
        parts.append(f"{name} {found.sides[name]} [{x}, {y}]")
    return f"{'' if number is None else f'assembly {number}: '}{', '.join(parts)}"


def _numbers(mechanism: Mechanism, found: tuple[Placement, ...]) -> Mapping[int, int]:
    """Return the numbers of `gim solve --all` for some choices; none if the configurations cannot be listed."""
    from gimcli.assemblies import all_configurations

    try:
        listed = all_configurations(mechanism, mechanism.start_inputs, 1e-10)
    except GimError:
        return {}
    own = mechanism.to_file(listed.z)
    near = SAME * mechanism.size * mechanism.scale
    numbers: dict[int, int] = {}
    for k, one in enumerate(found):
        z = np.array([one.at[name] for name in mechanism.nodes])
        same = [j for j, other in enumerate(own) if np.max(np.abs(other - z)) <= near]
        if same:
            numbers[k] = same[0] + 1
    return numbers
