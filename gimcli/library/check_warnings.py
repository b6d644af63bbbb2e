"""The warnings of a check: each with the place in the file, what is doubtful, and the remedy."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from gimcli.mechanism import Mechanism
from gimcli.rounding import at_inputs, interval, length_with_unit, number
from gimcli.status import Status

Where = tuple[str | int, ...]


def motion_warnings(mechanism: Mechanism, report: dict[str, Any], error: str) -> list[dict[str, str]]:
    """Return the warnings about a machine; `error` is why it has no motion, if it has none."""
    found: list[tuple[Where, str]] = [((), error)] if error else []
    return _placed(mechanism, [*found, *_rigid(mechanism), *_drawing(mechanism, report),
                               *_limits(mechanism, report, not error), *_loops(report)])  # fmt: skip


def file_warnings(mechanism: Mechanism, error: str) -> list[dict[str, str]]:
    """Return the warnings about a file as a whole."""
    return _placed(mechanism, [*short_table_warnings(mechanism), *_remarks(mechanism, moves=not error)])


def _placed(mechanism: Mechanism, found: list[tuple[Where, str]]) -> list[dict[str, str]]:
    """Return warnings with their places in the file."""
    written = mechanism.written
    return [{"where": written.place(at) if written is not None and at else "", "text": text} for at, text in found]


def short_table_warnings(mechanism: Mechanism) -> Iterator[tuple[Where, str]]:
    """Yield a warning for each table of a load that does not cover the law of its actuator."""
    if not any(load.curve is not None for load in mechanism.dynamics.loads):
        return
    from gimcli.dynamics.load_arrays import short_tables

    for load, actuator, own, law in short_tables(mechanism):
        covers, runs = (interval(mechanism, actuator, low, high, 0.0) for low, high in (own, law))
        text = f"the table of load {load} covers {actuator} = {covers}, its law runs over {runs}"
        yield ("loads", load), f"{text}: outside the load keeps the factor of the nearest row; add rows"


def _member(mechanism: Mechanism, name: str) -> Where:
    return mechanism.written.member(name) if mechanism.written is not None else ()


def _remarks(mechanism: Mechanism, moves: bool) -> list[tuple[Where, str]]:
    if mechanism.written is None:
        return []
    from gimcli.model.remarks import missing_duration, remarks

    model = mechanism.written.model
    return [*remarks(model), *(missing_duration(model) if moves else [])]


def _rigid(mechanism: Mechanism) -> Iterator[tuple[Where, str]]:
    from gimcli.structure.rigid_triangles import rigid_parts

    for members, hint in rigid_parts(mechanism):
        yield _member(mechanism, members[-1]), hint


def _drawing(mechanism: Mechanism, report: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    drawing = report["drawing"]
    if drawing is None:
        return
    for name in drawing["far"][:1]:
        others = f" ({', '.join(drawing['far'][1:])} too)" if len(drawing["far"]) > 1 else ""
        yield (
            ("nodes", name),
            f"node {name} is assembled {length_with_unit(mechanism, drawing['distance'])} from its initial coordinates,"
            f" {100.0 * drawing['relative']:.0f} % of the size{others}: correct the coordinates or the lengths",
        )
    for name in drawing["mirrored_members"]:
        yield (
            _member(mechanism, name),
            f"the initial coordinates of {name} are a mirror image of its shape, which cannot be turned over: "
            "correct the coordinates or the shape",
        )
    for node, first, second in drawing["mirrored_joints"]:
        yield (
            ("nodes", node),
            f"{first} and {second} meet at {node} on the other side than in the initial coordinates: "
            f"move {node} to the side that is meant, and correct the nodes next to it",
        )


def _limits(mechanism: Mechanism, report: dict[str, Any], moves: bool) -> Iterator[tuple[Where, str]]:
    if report["start"] not in (None, "regular", Status.TANGENT.word):
        yield (
            (),
            f"the inputs do not determine the initial configuration ({report['start']}): use other initial coordinates",
        )
    start = {one["name"]: one["law"][0] for one in report["inputs"]}
    if moves and not report["solved"] and any(one["moves"] for one in report["inputs"]):
        yield (
            ("actuators", next(iter(start))),
            f"there is no position at the start of the law, {at_inputs(mechanism, start)}: use a law within the"
            " range on the circuit, or other lengths",
        )
    limit = {one["name"]: one["limit"] for one in report["inputs"] if one["limit"] is not None and one["moves"]}
    if limit:
        yield (
            ("actuators", next(iter(limit))),
            f"the law exceeds a limit at {at_inputs(mechanism, limit)}: shorten it; the report describes the motion"
            " up to the limit",
        )


def _loops(report: dict[str, Any]) -> Iterator[tuple[Where, str]]:
    for loop in report["loops"]:
        if loop["near_change_point"]:
            total = sum(loop["dimensions"].values())
            yield (
                (),
                f"{', '.join(loop['dimensions'])}: p + q - s - l is only {number(100.0 * loop['margin'] / total)} % of"
                " the sum of the lengths, so that rounded lengths may change the type: give `length` with more digits",
            )
