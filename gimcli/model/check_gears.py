"""Checks of gears: members and pivots that fit each other, one of ratio, teeth and radii, radii that fit the pivots."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from gimcli.coupling_data import BELT, CROSSED, EXTERNAL, INTERNAL, RACK
from gimcli.model.check_inputs import GREATEST
from gimcli.model.compile_gears import carrier_of, rack_height, rack_pair
from gimcli.model.references import CLOSEST, PartFault, References, those
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
    angle, right = gear.pressure_angle or 0.0, TURN[refs.model.units.angle] / 4.0
    yield from those(
        gear.type in (BELT, CROSSED) and gear.pressure_angle is not None and PartFault(
            ("pressure_angle",), "a belt has no pressure angle; remove it", key=True
        ),
        not 0.0 <= angle < right and PartFault(
            ("pressure_angle",), f"expected an angle from 0 to below {right:g}, got {angle:g}"
        ),
    )  # fmt: skip


def _of_members(refs: References, gear: Gear) -> Iterator[PartFault]:
    """Yield the errors where pivots are no nodes of members and carrier, or where a member has no direction."""
    carrier, wheels = carrier_of(refs.model, gear), gear.members[: 1 if gear.type == RACK else 2]
    yield from those(len(gear.pivots) != len(wheels) and PartFault(
        ("pivots",), f"expected {len(wheels)} pivot{'s' * (len(wheels) > 1)}, got {len(gear.pivots)}"
    ))  # fmt: skip
    yield from _pivots(refs, zip(wheels, gear.pivots, strict=True))
    both, named = " and ".join(gear.pivots), ", ".join(gear.members)
    yield from those(
        not carrier and PartFault(
            (), f"no member has both pivots {both}; add the `carrier` on which the wheels turn"
        ),
        len({*gear.members, carrier}) < 3 and PartFault(
            ("members",), f"expected two members that turn on a third one, got {named} on '{carrier}'"
        ),
    )  # fmt: skip
    yield from _pivots(refs, ((carrier, pivot) for pivot in gear.pivots))
    for name in (name for name in (*gear.members, carrier) if name not in ("ground", refs.held)):
        nodes = refs.members[name]
        known = set(nodes) <= refs.model.nodes.keys()
        yield from those(
            not known and PartFault((), ""),
            known and not any(refs.apart(nodes[0], node) for node in nodes[1:]) and PartFault(
                (), f"the nodes of '{name}' coincide, so that its direction is not known; move one of them"
            ),
        )  # fmt: skip


def _pivots(refs: References, pairs: Iterable[tuple[str, str]]) -> Iterator[PartFault]:
    """Return the errors of members that do not have their pivot."""
    return those(*(pivot not in refs.having(name) and PartFault(
        ("pivots",), f"the pivot {pivot} is no node of '{name}'; add it to its nodes"
    ) for name, pivot in pairs))  # fmt: skip


def _of_wheels(gear: Gear) -> Iterator[PartFault]:
    """Return the errors of the keys that give the ratio."""
    sizes, pair = ("ratio", "teeth", "radii"), gear.teeth or gear.radii or [1.0]
    given = [key for key in sizes if getattr(gear, key) is not None]
    got = " and ".join(f"`{key}`" for key in given) or "none"
    ratios = (gear.ratio or 1.0, pair[0] / pair[-1])
    chain = gear.type in (BELT, CROSSED) and gear.teeth is not None
    return those(
        len(given) != 1 and PartFault((), f"expected one of `ratio`, `teeth` and `radii`, got {got}", lacking=sizes),
        len(gear.radii or (1.0, 1.0)) != 2 and PartFault(("radii",), "expected two radii, one of each wheel"),
        not all(1.0 / GREATEST <= part <= GREATEST for part in ratios) and PartFault(
            (), f"expected a ratio of {1.0 / GREATEST:g} to {GREATEST:g}; correct `{''.join(given[:1])}`"
        ),
        not all(float(count).is_integer() for count in gear.teeth or ()) and PartFault(
            ("teeth",), "expected whole numbers of teeth"
        ),
        gear.pitch is not None and not chain and PartFault(
            ("pitch",), "`pitch` gives the radii of a chain or toothed belt with `teeth`; remove it", key=True
        ),
    )  # fmt: skip


def _of_rack(refs: References, gear: Gear) -> Iterator[PartFault]:
    """Yield the errors of the keys of a rack and pinion, and of their initial position."""
    radii, model, (limit, size) = gear.radii or [], refs.model, (GREATEST, refs.size)
    radius, pair = (radii or [0.0])[0], rack_pair(model, gear)
    yield from those(
        *(getattr(gear, key) is not None and PartFault(
            (key,), f"a rack has no `{key}`; give the pinion's radius: `radii: [R]`", key=True
        ) for key in ("ratio", "teeth", "pitch")),
        len(radii) != 1 and PartFault(
            (), "a rack and pinion needs the pitch radius of the pinion: `radii: [R]`", lacking=("radii",)
        ),
        refs.placed and not size / limit <= radius <= size * limit and PartFault(
            ("radii",),
            f"expected a radius of {1.0 / limit:g} to {limit:g} of the mechanism's size {size:g}, got {radius:g}",
        ),
        pair is None and PartFault(
            ("members",),
            f"the rack '{gear.members[1]}' does not slide on '{carrier_of(model, gear)}' without turning; add a"
            " prismatic pair with two `nodes`",
        ),
    )  # fmt: skip
    if pair is None:
        return
    slide = model.prismatic[pair]
    known = {*(slide.nodes or []), *slide.guide} <= model.nodes.keys() and refs.apart(*slide.guide)
    yield from those(
        not known and PartFault((), ""),
        known and refs.placed and abs(rack_height(model, gear, slide)) <= CLOSEST * refs.size and PartFault(
            (),
            f"the line of the rack passes through the pivot {gear.pivots[0]}, so that its side is not known; place the"
            " rack's nodes at its pitch line",
        ),
    )  # fmt: skip


def _of_distance(refs: References, gear: Gear) -> Iterator[PartFault]:
    """Return the errors of wheels that do not fit the distance of their pivots."""
    apart = math.dist(*(refs.model.nodes[n] for n in gear.pivots))
    one, other = gear.teeth or gear.radii or [gear.ratio or 1.0, 1.0]
    near, word = apart <= CLOSEST * refs.size, "sum" if gear.type == EXTERNAL else "difference"
    needed = {EXTERNAL: one + other, INTERNAL: abs(one - other)}.get(gear.type, apart)
    least = {BELT: abs(one - other), CROSSED: one + other}.get(gear.type, 0.0)
    sized = gear.radii is not None and not near
    return those(
        near and PartFault(
            ("pivots",), f"the pivots {' and '.join(gear.pivots)} coincide; write `follows` at an actuator instead"
        ),
        gear.type == INTERNAL and one == other and not near and PartFault(
            (), "wheels of equal size do not mesh inside each other; correct the ratio, teeth or radii"
        ),
        sized and abs(needed - apart) > FITS * apart and PartFault(
            ("radii",), f"the {word} of the radii is {needed:g}, the distance of the pivots {apart:g}; make them equal"
        ),
        sized and least >= apart and PartFault(
            ("radii",), f"the wheels overlap: the pivots are {apart:g} apart, the belt needs more than {least:g}"
        ),
    )  # fmt: skip
