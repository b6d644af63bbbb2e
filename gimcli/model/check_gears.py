"""Checks of gears: members and pivots that fit each other, one of ratio, teeth and radii, radii that fit the pivots."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from gimcli.coupling_data import BELT, CROSSED, EXTERNAL, INTERNAL, RACK
from gimcli.model.check_inputs import GREATEST
from gimcli.model.compile_gears import carrier_of, rack_height, rack_pair
from gimcli.model.references import CLOSEST, PartFault, References
from gimcli.model.schema import Gear
from gimcli.model.source import Where
from gimcli.model.units import TURN

FITS = 1e-2
"""Greatest difference of the radii's sum from the distance of the pivots, relative to it: drawings are rounded."""


def check_gears(refs: References) -> None:
    """Record the errors in the gears."""
    for name, gear in refs.model.gears.items():
        where: Where = ("gears", name)
        known = [refs.member((*where, "members", k), member) for k, member in enumerate(gear.members)]
        known += [refs.member((*where, "carrier"), gear.carrier)] if gear.carrier is not None else []
        known.append(refs.nodes((*where, "pivots"), gear.pivots))
        sound = all(known) and refs.sure and refs.sound(where, _errors(refs, gear))
        for error in _of_distance(refs, gear) if sound and refs.placed and gear.type != RACK else ():
            refs.fault((*where, *error.at), error.text)


def _errors(refs: References, gear: Gear) -> Iterator[PartFault]:
    """Yield the errors of members, pivots and sizes; those behind the first one may follow from it."""
    yield from _of_members(refs, gear)
    yield from _of_rack(refs, gear) if gear.type == RACK else _of_wheels(gear)
    angle, right = gear.pressure_angle, TURN[refs.model.units.angle] / 4.0
    if angle is not None and gear.type in (BELT, CROSSED):
        yield PartFault(("pressure_angle",), "a belt has no pressure angle; remove it", key=True)
    if angle is not None and not 0.0 <= angle < right:
        yield PartFault(("pressure_angle",), f"expected an angle from 0 to below {right:g}, got {angle:g}")


def _of_members(refs: References, gear: Gear) -> Iterator[PartFault]:
    """Yield the errors where pivots are no nodes of members and carrier, or where a member has no direction."""
    carrier, wheels = carrier_of(refs.model, gear), gear.members[: 1 if gear.type == RACK else 2]
    if len(gear.pivots) != len(wheels):
        count = f"{len(wheels)} pivot{'s' * (len(wheels) > 1)}"
        yield PartFault(("pivots",), f"expected {count}, got {len(gear.pivots)}")
    yield from _pivots(refs, zip(wheels, gear.pivots, strict=True))
    if not carrier:
        both = " and ".join(gear.pivots)
        yield PartFault((), f"no member has both pivots {both}; add the `carrier` on which the wheels turn")
    if len({*gear.members, carrier}) < 3:
        text = f"expected two members that turn on a third one, got {', '.join(gear.members)} on '{carrier}'"
        yield PartFault(("members",), text)
    yield from _pivots(refs, ((carrier, pivot) for pivot in gear.pivots))
    for name in (name for name in (*gear.members, carrier) if name not in ("ground", refs.held)):
        nodes = refs.members[name]
        if not set(nodes) <= refs.model.nodes.keys():
            yield PartFault((), "")
        if not any(refs.apart(nodes[0], node) for node in nodes[1:]):
            yield PartFault((), f"the nodes of '{name}' coincide, so that its direction is not known; move one of them")


def _pivots(refs: References, pairs: Iterable[tuple[str, str]]) -> Iterator[PartFault]:
    """Yield the errors of members that do not have their pivot."""
    for name, pivot in pairs:
        if pivot not in refs.having(name):
            yield PartFault(("pivots",), f"the pivot {pivot} is no node of '{name}'; add it to its nodes")


def _of_wheels(gear: Gear) -> Iterator[PartFault]:
    """Yield the errors of the keys that give the ratio."""
    sizes = ("ratio", "teeth", "radii")
    given = [key for key in sizes if getattr(gear, key) is not None]
    if len(given) != 1:
        got = " and ".join(f"`{key}`" for key in given) or "none"
        yield PartFault((), f"expected one of `ratio`, `teeth` and `radii`, got {got}", lacking=sizes)
    if gear.radii is not None and len(gear.radii) != 2:
        yield PartFault(("radii",), "expected two radii, one of each wheel")
    pair = gear.teeth or gear.radii
    if not all(1.0 / GREATEST <= part <= GREATEST for part in (gear.ratio or 1.0, pair[0] / pair[1] if pair else 1.0)):
        yield PartFault((), f"expected a ratio of {1.0 / GREATEST:g} to {GREATEST:g}; correct `{given[0]}`")
    if gear.teeth is not None and not all(float(count).is_integer() for count in gear.teeth):
        yield PartFault(("teeth",), "expected whole numbers of teeth")
    if gear.pitch is not None and (gear.type not in (BELT, CROSSED) or gear.teeth is None):
        text = "`pitch` gives the radii of a chain or toothed belt with `teeth`; remove it"
        yield PartFault(("pitch",), text, key=True)


def _of_rack(refs: References, gear: Gear) -> Iterator[PartFault]:
    """Yield the errors of the keys of a rack and pinion, and of their initial position."""
    for key in (key for key in ("ratio", "teeth", "pitch") if getattr(gear, key) is not None):
        yield PartFault((key,), f"a rack has no `{key}`; give the pinion's radius: `radii: [R]`", key=True)
    radii, model = gear.radii or [], refs.model
    if len(radii) != 1:
        text = "a rack and pinion needs the pitch radius of the pinion: `radii: [R]`"
        yield PartFault((), text, lacking=("radii",))
    if refs.placed and not refs.size / GREATEST <= radii[0] <= refs.size * GREATEST:
        text = f"expected a radius of {1.0 / GREATEST:g} to {GREATEST:g} of the mechanism's size {refs.size:g}"
        yield PartFault(("radii",), f"{text}, got {radii[0]:g}")
    if (pair := rack_pair(model, gear)) is None:
        text = f"the rack '{gear.members[1]}' does not slide on '{carrier_of(model, gear)}' without turning"
        yield PartFault(("members",), f"{text}; add a prismatic pair with two `nodes`")
        return
    slide = model.prismatic[pair]
    if not {*(slide.nodes or []), *slide.guide} <= model.nodes.keys() or not refs.apart(*slide.guide):
        yield PartFault((), "")
    if refs.placed and abs(rack_height(model, gear, slide)) <= CLOSEST * refs.size:
        text = f"the line of the rack passes through the pivot {gear.pivots[0]}, so that its side is not known"
        yield PartFault((), f"{text}; place the rack's nodes at its pitch line")


def _of_distance(refs: References, gear: Gear) -> Iterator[PartFault]:
    """Yield the errors of wheels that do not fit the distance of their pivots."""
    apart = math.dist(*(refs.model.nodes[n] for n in gear.pivots))
    if apart <= CLOSEST * refs.size:
        text = f"the pivots {' and '.join(gear.pivots)} coincide; write `follows` at an actuator instead"
        yield PartFault(("pivots",), text)
        return
    one, other = gear.teeth or gear.radii or [gear.ratio or 1.0, 1.0]
    if gear.type == INTERNAL and one == other:
        yield PartFault((), "wheels of equal size do not mesh inside each other; correct the ratio, teeth or radii")
    if gear.radii is None:
        return
    needed = {EXTERNAL: one + other, INTERNAL: abs(one - other)}.get(gear.type)
    if needed is not None and abs(needed - apart) > FITS * apart:
        word = "sum" if gear.type == EXTERNAL else "difference"
        text = f"the {word} of the radii is {needed:g}, the distance of the pivots {apart:g}; make them equal"
        yield PartFault(("radii",), text)
    least = {BELT: abs(one - other), CROSSED: one + other}.get(gear.type, 0.0)
    if least >= apart:
        text = f"the wheels overlap: the pivots are {apart:g} apart, the belt needs more than {least:g}"
        yield PartFault(("radii",), text)
