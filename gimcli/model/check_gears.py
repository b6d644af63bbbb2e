"""Checks of gears: members and pivots that fit each other, one of ratio, teeth and radii, radii that fit the pivots."""

from __future__ import annotations

import math

from gimcli.coupling_data import BELT, CROSSED, EXTERNAL, INTERNAL, RACK
from gimcli.model.check_inputs import GREATEST
from gimcli.model.compile_gears import carrier_of, rack_height, rack_pair
from gimcli.model.references import CLOSEST, References
from gimcli.model.schema import Gear, Prismatic
from gimcli.model.source import Where

FITS = 1e-2
"""Greatest difference of the radii's sum from the distance of the pivots, relative to it: drawings are rounded."""


def check_gears(refs: References) -> None:
    """Record the errors in the gears."""
    for name, gear in refs.model.gears.items():
        where: Where = ("gears", name)
        known = [refs.member((*where, "members", k), member) for k, member in enumerate(gear.members)]
        if gear.carrier is not None:
            known.append(refs.member((*where, "carrier"), gear.carrier))
        known.append(refs.nodes((*where, "pivots"), gear.pivots))
        sound = all(known) and refs.sure and _check_members(refs, where, gear) and _check_drawn(refs, where, gear)
        if sound and _check_size(refs, where, gear):
            _check_distance(refs, where, gear)


def _check_members(refs: References, where: Where, gear: Gear) -> bool:
    """Return whether the pivots are nodes of the members and of the carrier; record an error if not."""
    carrier, wheels = carrier_of(refs.model, gear), list(gear.members)
    if gear.type == RACK:
        wheels = wheels[:1]
    if len(gear.pivots) != len(wheels):
        text = f"expected {len(wheels)} pivot{'s' * (len(wheels) > 1)}, got {len(gear.pivots)}"
        refs.fault((*where, "pivots"), text)
    elif apart := _pivot_of_none(refs, gear, wheels):
        refs.fault((*where, "pivots"), f"the pivot {apart[1]} is no node of '{apart[0]}'; add it to its nodes")
    elif not carrier:
        text = f"no member has both pivots {' and '.join(gear.pivots)}; add the `carrier` on which the wheels turn"
        refs.fault(where, text)
    elif len({*gear.members, carrier}) < 3:
        text = f"expected two members that turn on a third one, got {', '.join(gear.members)} on '{carrier}'"
        refs.fault((*where, "members"), text)
    else:
        lacking = [pivot for pivot in gear.pivots if pivot not in _nodes(refs, carrier)]
        if not lacking:
            return True
        refs.fault((*where, "pivots"), f"the pivot {lacking[0]} is no node of '{carrier}'; add it to its nodes")
    return False


def _check_drawn(refs: References, where: Where, gear: Gear) -> bool:
    """Return whether each member and the carrier is drawn with a direction; record an error if not."""
    for name in (*gear.members, carrier_of(refs.model, gear)):
        nodes = [] if name in ("ground", refs.held) else refs.members[name]
        if not all(node in refs.model.nodes for node in nodes):
            return False
        if nodes and not any(refs.apart(nodes[0], node) for node in nodes[1:]):
            refs.fault(where, f"the nodes of '{name}' coincide, so that its direction is not known; move one of them")
            return False
    return True


def _pivot_of_none(refs: References, gear: Gear, wheels: list[str]) -> tuple[str, str] | None:
    """Return a wheel that does not have its pivot, and the pivot."""
    pairs = zip(wheels, gear.pivots, strict=True)
    return next(((name, pivot) for name, pivot in pairs if pivot not in _nodes(refs, name)), None)


def _nodes(refs: References, name: str) -> set[str]:
    return refs.ground if name in ("ground", refs.held) else set(refs.members[name])


def _check_size(refs: References, where: Where, gear: Gear) -> bool:
    """Return whether the ratio is given once and in keys that the type has; record an error if not."""
    if gear.type == RACK:
        return _check_rack(refs, where, gear)
    given = [key for key in ("ratio", "teeth", "radii") if getattr(gear, key) is not None]
    if len(given) != 1:
        got = " and ".join(f"`{key}`" for key in given) or "none"
        refs.lack(where, ("ratio", "teeth", "radii"), f"expected one of `ratio`, `teeth` and `radii`, got {got}")
    elif gear.radii is not None and len(gear.radii) != 2:
        refs.fault((*where, "radii"), "expected two radii, one of each wheel")
    elif not all(1.0 / GREATEST <= part <= GREATEST for part in (gear.ratio or 1.0, *_shares(gear))):
        refs.fault(where, f"expected a ratio of {1.0 / GREATEST:g} to {GREATEST:g}; correct `{given[0]}`")
    elif gear.teeth is not None and not all(float(count).is_integer() for count in gear.teeth):
        refs.fault((*where, "teeth"), "expected whole numbers of teeth")
    elif gear.pitch is not None and (gear.type not in (BELT, CROSSED) or gear.teeth is None):
        text = "`pitch` gives the radii of a chain or toothed belt with `teeth`; remove it"
        refs.fault((*where, "pitch"), text, key=True)
    elif not _angle_fits(refs, where, gear):
        pass
    else:
        return True
    return False


def _shares(gear: Gear) -> list[float]:
    """Return the ratio of the numbers of teeth or radii, if they are given."""
    pair = gear.teeth or gear.radii
    return [pair[0] / pair[1]] if pair else []


def _angle_fits(refs: References, where: Where, gear: Gear) -> bool:
    angle, right = gear.pressure_angle, 90.0 if refs.model.units.angle == "deg" else math.pi / 2.0
    if angle is not None and gear.type in (BELT, CROSSED):
        refs.fault((*where, "pressure_angle"), "a belt has no pressure angle; remove it", key=True)
    elif angle is not None and not 0.0 <= angle < right:
        refs.fault((*where, "pressure_angle"), f"expected an angle from 0 to below {right:g}, got {angle:g}")
    else:
        return True
    return False


def _check_rack(refs: References, where: Where, gear: Gear) -> bool:
    for key in ("ratio", "teeth", "pitch"):
        if getattr(gear, key) is not None:
            refs.fault((*where, key), f"a rack has no `{key}`; give the pinion's radius: `radii: [R]`", key=True)
            return False
    pair = rack_pair(refs.model, gear)
    if gear.radii is None or len(gear.radii) != 1:
        refs.lack(where, ("radii",), "a rack and pinion needs the pitch radius of the pinion: `radii: [R]`")
    elif refs.placed and not refs.size / GREATEST <= gear.radii[0] <= refs.size * GREATEST:
        text = f"expected a radius of {1.0 / GREATEST:g} to {GREATEST:g} of the mechanism's size {refs.size:g}"
        refs.fault((*where, "radii"), f"{text}, got {gear.radii[0]:g}")
    elif pair is None:
        text = f"the rack '{gear.members[1]}' does not slide on '{carrier_of(refs.model, gear)}' without turning"
        refs.fault((*where, "members"), f"{text}; add a prismatic pair with two `nodes`")
    elif not _drawn_line(refs, refs.model.prismatic[pair]):
        pass
    elif refs.placed and abs(rack_height(refs.model, gear, refs.model.prismatic[pair])) <= CLOSEST * refs.size:
        text = f"the line of the rack passes through the pivot {gear.pivots[0]}, so that its side is not known"
        refs.fault(where, f"{text}; place the rack's nodes at its pitch line")
    else:
        return _angle_fits(refs, where, gear)
    return False


def _drawn_line(refs: References, slide: Prismatic) -> bool:
    """Return whether the nodes of a sliding pair are declared and its guide has a direction; its own check reports."""
    nodes = refs.model.nodes
    return all(node in nodes for node in (*(slide.nodes or []), *slide.guide)) and refs.apart(*slide.guide)


def _check_distance(refs: References, where: Where, gear: Gear) -> None:
    if gear.type == RACK or not refs.placed:
        return
    apart = math.dist(*(refs.model.nodes[n] for n in gear.pivots))
    if apart <= CLOSEST * refs.size:
        text = f"the pivots {' and '.join(gear.pivots)} coincide; write `follows` at an actuator instead"
        refs.fault((*where, "pivots"), text)
        return
    if gear.type == INTERNAL and _equal(gear):
        refs.fault(where, "wheels of equal size do not mesh inside each other; correct the ratio, teeth or radii")
    if gear.radii is None:
        return
    one, other = gear.radii
    needed = {EXTERNAL: one + other, INTERNAL: abs(one - other)}.get(gear.type)
    if needed is not None and abs(needed - apart) > FITS * apart:
        word = "sum" if gear.type == EXTERNAL else "difference"
        text = f"the {word} of the radii is {needed:g}, the distance of the pivots {apart:g}; make them equal"
        refs.fault((*where, "radii"), text)
    least = {BELT: abs(one - other), CROSSED: one + other}.get(gear.type, 0.0)
    if least >= apart:
        text = f"the wheels overlap: the pivots are {apart:g} apart, the belt needs more than {least:g}"
        refs.fault((*where, "radii"), text)


def _equal(gear: Gear) -> bool:
    pair = gear.teeth or gear.radii or [gear.ratio or 1.0, 1.0]
    return pair[0] == pair[1]
