"""Validation of a model file: first the types of its values, then the references between its parts.

Each error of a file is one line: file:line:column, what is wrong, how to correct it.
"""

from __future__ import annotations

import copy
from contextlib import suppress
from typing import Any

from pydantic_core import ValidationError

from gimcli.errors import UsageError
from gimcli.model import wording
from gimcli.model.check_inputs import check_inputs, check_pair
from gimcli.model.pairs import sized_nodes, used_nodes
from gimcli.model.part import long_form
from gimcli.model.references import CLOSEST, PartFault, References, those
from gimcli.model.schema import DYNAMIC, NO_FORMULAS, WHOLE, Element, Link, Model, OpenNode
from gimcli.model.source import Source, Where, part_of
from gimcli.nearest import near

SECTIONS = ("nodes", "links", "elements", "prismatic", "actuators", "gears", "points", "masses", "loads",
            "springs", "dampers", "friction", "parameters", "tolerances", "quantities")  # fmt: skip
DRIVING = {"start", "speed", "effort", "rotor"}
"""Keys of an actuator that are of the dynamics."""

CONSTRAINTS = ("links", "elements", "prismatic", "actuators", "gears")
FORMULA = ("=", "+", "-", "@")
"""First characters of a spreadsheet formula; names are used in the headers of CSV files."""
COLUMNS = ("step", "time", "residual", "sweeps", "status")
"""Columns of the tables that an actuator's name must not repeat."""
SIZES = (1e-100, 1e100)
"""Least and greatest size of a mechanism, in the file's unit of length."""


def checked(source: Source) -> Model:
    """Return the model of a source; raise ModelError with all errors of the file."""
    model, doubtful = _typed(source)
    if model is not None:
        model = _checked_with_open_nodes(source, model, doubtful)
    if model is None or source.faults:
        raise source.error()
    model.written_in(source.data)
    return model


def _typed(source: Source) -> tuple[Model | None, set[Where]]:
    """Return the model without its invalid parts, and the paths of these parts; None if the rest is no model."""
    data = long_form(source.data)
    model, faults = _validated(data)
    if model is not None:
        return model, set()
    formulas, refused = NO_FORMULAS, dict[Where, str]()
    if texts := [tuple(f["loc"]) for f in faults if f["type"] == "float_type" and isinstance(f["input"], str)]:
        from gimcli.model.arithmetic import evaluated  # imported late: few models have formulas

        data, formulas, refused = evaluated(data, texts)
        model, faults = _validated(data)
    doubtful = set[Where]()
    if model is None:
        unknown = [tuple(f["loc"]) for f in faults if f["type"] == "extra_forbidden"]
        intended = {path for path in map(wording.intended, unknown) if path is not None}
        data, doubtful = _without(data, faults)
        doubtful |= intended
        for fault in faults:
            if fault["type"] != "missing" or fault["loc"] not in intended:
                wording.record(source, fault, refused)
        model, _ = _validated(data)
    if model is not None:
        model.formulas = formulas
    return model, doubtful


def _validated(data: dict[str, Any]) -> tuple[Model | None, list[dict[str, Any]]]:
    """Return the model of plain data, or None and the validation errors."""
    try:
        return Model.model_validate(data), []
    except ValidationError as error:
        return None, [dict(e) for e in error.errors(include_url=False)]


def _without(data: dict[str, Any], faults: list[dict[str, Any]]) -> tuple[dict[str, Any], set[Where]]:
    """Return the data without unknown keys and invalid parts, and the paths of the invalid parts."""
    rest, doubtful = copy.deepcopy(data), set[Where]()
    for fault in faults:
        where: Where = tuple(fault["loc"])
        if fault["type"] != "extra_forbidden":
            where = where[:2] if where[0] in SECTIONS else where[:1]
            doubtful.add(where)
        with suppress(AttributeError, IndexError, KeyError, TypeError):  # a part around it was removed before
            part_of(rest, where[:-1]).pop(where[-1], None)
    if ("ground",) in doubtful:
        rest["ground"] = {}
    return rest, doubtful


def _checked_with_open_nodes(source: Source, model: Model, doubtful: set[Where]) -> Model:
    """Return the model with positions of its nodes without coordinates, after a check."""
    faults = list[PartFault]()
    if any(isinstance(part, OpenNode) for part in model.nodes.values()):
        from gimcli.model.placing import with_open_nodes  # imported late: few models have such nodes

        model, faults = with_open_nodes(source, model)
    check(References(source, model, sized_nodes(model), doubtful))
    for fault in [] if source.faults else faults:
        source.fault(fault.at, fault.text, key=True)
    return model


# -- references -----------------------------------------------------------------------------


def check(refs: References) -> None:
    """Record the errors in the references between parts."""
    _check_names(refs)
    _check_ground(refs)
    for section in ("links", "elements"):
        for name, part in getattr(refs.model, section).items():
            _check_member(refs, (section, name), part)
    refs.record((), those(
        not refs.every and refs.sure and used_nodes(refs.model) <= refs.ground and PartFault(
            (), "no members and no moving node; add `links:`, `elements:` or `actuators:`"
        ),
        refs.every and refs.sure and refs.placed and not SIZES[0] < refs.size < SIZES[1] and PartFault(
            ("nodes",), f"the size of the mechanism is {refs.size:g}; use another unit of length"
        ),
    ))  # fmt: skip
    for name, pair in refs.model.prismatic.items():
        check_pair(refs, ("prismatic", name), pair)
    check_inputs(refs)
    if refs.model.gears:
        from gimcli.model.check_gears import check_gears  # imported late: few models have gears

        check_gears(refs)
    _check_points(refs)
    driven = any(DRIVING & one.given for one in refs.model.actuators.values())
    if driven or any(getattr(refs.model, section) for section in DYNAMIC):
        from gimcli.model.check_dynamics import check_dynamics

        check_dynamics(refs)
    if refs.model.parameters:
        _check_parameters(refs)
    if refs.model.tolerances and not refs.doubtful and not refs.source.faults:
        _check_tolerances(refs)


def _check_names(refs: References) -> None:
    model, keys = refs.model, refs.source.keys
    first = {name: section for section in CONSTRAINTS[::-1] for name in getattr(model, section)}
    names = [(section, name) for section in SECTIONS for name in getattr(model, section)]
    own = [(section, name) for section, name in names if section in CONSTRAINTS]
    refs.record((), (
        *(PartFault(
            (section, name),
            f"the name '{name}' begins with '{name.lstrip()[0]}', which a spreadsheet reads as a formula; rename it",
            key=True,
        ) for section, name in names if name.lstrip()[:1] in FORMULA),
        *(PartFault(
            (section, name),
            f"'{name}' is given twice, first under `{first[name]}:` in line {keys[first[name], name][0]}; rename one",
            key=True,
        ) for section, name in own if first[name] != section),
        *(PartFault(
            (section, name), f"the name '{name}' is reserved; rename it", key=True
        ) for section, name in own
          if first[name] == section and name in ("ground", *(COLUMNS if section in ("actuators", "gears") else ()))),
    ))  # fmt: skip


def _check_ground(refs: References) -> None:
    ground = refs.model.ground
    sound = refs.sound(("ground",), those(
        ground.member is not None and ground.nodes and PartFault(
            (), "expected `nodes` or `member`, got both; remove one"
        ),
        ground.member == "ground" and PartFault(("member",), "expected a link or an element, got 'ground'"),
        ground.member is None and not ground.nodes and ("ground",) not in refs.doubtful and PartFault(
            (), "no node is fixed; write `ground: [NODES]` or `ground: {member: NAME}`"
        ),
    ))  # fmt: skip
    if sound and ground.member is not None and refs.member(("ground", "member"), ground.member):
        refs.drawn(("ground", "member"), refs.every[ground.member])
    refs.nodes(("ground", "nodes"), ground.nodes)


def _check_member(refs: References, where: Where, member: Link | Element) -> None:
    name, nodes, known = where[1], member.nodes, refs.nodes((*where, "nodes"), member.nodes)
    key, length = ("length", member.length) if isinstance(member, Link) else ("shape", None)
    shape = None if isinstance(member, Link) else member.shape
    drawn = refs.model.nodes if known and length is None else {}
    at, places, cure = "nodes", drawn, f"; move one, or give the `{key}`"
    if shape is not None:
        at, places, cure = "shape", shape, " in its shape; move one"
    own = {n: places[n] for n in nodes if n in places}
    refs.record(where, those(
        known and refs.held is None and set(nodes) <= refs.ground and PartFault(
            (), f"'{name}' has ground nodes only; remove it: the frame joins them already"
        ),
        length is not None and length <= CLOSEST * refs.size and PartFault(
            ("length",), f"length {length:g} is too small for a mechanism of size {refs.size:g}; make it longer"
        ),
        *(shape is not None and n not in shape and PartFault(
            ("shape",), f"the shape of '{name}' has no node {n}; add its coordinates"
        ) for n in nodes),
        *(PartFault(
            ("shape", n),
            f"'{n}' is not a node of '{name}'{near(n, nodes) or '; remove it or add it to `nodes`'}", key=True,
        ) for n in shape or () if n not in nodes),
        *(PartFault(
            (at,), f"nodes {a} and {b} of '{name}' coincide{cure}"
        ) for a, b in refs.coincident(own)),
    ))  # fmt: skip


def _check_points(refs: References) -> None:
    model, trace = refs.model, refs.model.trace
    for name, point in model.points.items():
        refs.place(("points", name), point, "point", refs.member(("points", name, "on"), point.on))
    refs.record(("points",), (
        PartFault((name,), f"point '{name}' has the name of a node; rename it", key=True)
        for name in model.points if name in model.nodes
    ))  # fmt: skip
    known, used = {**model.points, **model.nodes}, used_nodes(model)
    doubted = {where[-1] for where in refs.doubtful if where[0] in ("nodes", "points")}
    for k, name in enumerate(trace):
        refs.record(("trace", k), those(
            name not in known and not {name, "points"} & doubted and PartFault(
                (), f"'{name}' is neither a point nor a node{near(name, known)}"
            ),
            name in model.nodes and refs.sure and name not in used and PartFault(
                (), f"node '{name}' belongs to no member; add it to one, or remove it from `trace`"
            ),
            name in trace[:k] and name not in trace[k + 1 :] and PartFault(
                (), f"'{name}' is listed twice in `trace`; remove one"
            ),
        ))  # fmt: skip


def _check_parameters(refs: References) -> None:
    from gimcli.model.arithmetic import is_name  # imported late: few models have parameters

    for name in (name for name in refs.model.parameters if not is_name(name) or name in WHOLE):
        why = "it is reserved" if name.isidentifier() else "expected letters, digits and _, a letter first"
        refs.fault(("parameters", name), f"'{name}' cannot be the name of a parameter: {why}; rename it", key=True)


def _check_tolerances(refs: References) -> None:
    from gimcli.model.dimensions import dimensions_of, found  # imported late: few models have tolerances

    named = dimensions_of(refs.model)
    seen: dict[str, str] = {}
    for name in refs.model.tolerances:
        try:
            full = found(named, name).name
        except UsageError as error:
            refs.fault(("tolerances", name), str(error), key=True)
            continue
        if full in seen:
            refs.fault(("tolerances", name), f"'{name}' and '{seen[full]}' are the same; remove one", key=True)
        seen[full] = name
