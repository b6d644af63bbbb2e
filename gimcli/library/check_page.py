"""The page of a check: the report with the motion along the laws, or with the initial configuration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gimcli.library.check_sections import CheckSection
from gimcli.library.extras import Extras
from gimcli.library.trace_animation import law_animation
from gimcli.mechanism import ComplexArray, Mechanism
from gimcli.motion.motion import Motion
from gimcli.output.animation import Animation, Clip, Section
from gimcli.rates.member_angles import in_rows
from gimcli.table import Column, Table


def check_page(
    mechanism: Mechanism, motion: Motion | None, z: ComplexArray | None, sections: Sequence[CheckSection],
    warnings: Sequence[dict[str, Any]], note: str = "",
) -> Animation:  # fmt: skip
    """Return a page with the report and the motion, or else with a position z (nodes,) and a note on it."""
    shown = None
    if motion is not None:
        shown = law_animation(motion, Extras(mechanism), len(motion.time) - 1, in_rows)
    if shown is None:
        shown = Animation(mechanism.name, mechanism, (_position(mechanism, z, note),))
    return replace(shown, report=(*map(_section, sections), *_warnings(warnings)))


def _position(mechanism: Mechanism, z: ComplexArray | None, note: str) -> Clip:
    """Return a clip of one row; without a position it is empty, and the page shows the initial coordinates."""
    status = "not-assembled" if z is None else "ok"
    place = np.full(len(mechanism.nodes), complex(np.nan, np.nan)) if z is None else mechanism.to_file(z)
    table = Table((Column("time", np.zeros(1), "s"), Column("status", np.array([status]))))
    name = note or "initial configuration"
    return Clip(name, place[None, :], np.zeros(1), (status,), table, note=note)


def _section(own: CheckSection) -> Section:
    columns = (Column(name, np.array(cells)) for name, cells in zip(own.head, zip(*own.rows, strict=True), strict=True))
    more = (f"and {own.left_out} more: the file .json or .csv lists all",) if own.left_out else ()
    return Section(own.heading, more, Table(tuple(columns)))


def _warnings(warnings: Sequence[dict[str, Any]]) -> list[Section]:
    lines = tuple(": ".join(filter(None, (one["where"], one["text"]))) for one in warnings)
    return [Section("Warnings", lines, warning=True)] if lines else []
