"""Laws that reach a limit or a change point: the rows of every case against closed forms."""

from __future__ import annotations

import contextlib
import json
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from closed_linkages import LAW, LINKAGES, Linkage
from typer.testing import CliRunner

import gimcli
from gimcli import UsageError, load
from gimcli.cli import app
from gimcli.motion.motion import Motion, trace
from gimcli.status import Status

STEPS = 40
ACCURATE = 1e-10
"""Greatest error of rows with status ok, as stated in the manual, relative to the size (here a few units)."""


@dataclass(frozen=True)
class Course:
    """A law that reaches the critical input less `short` (negative: beyond it), and its behaviour there."""

    name: str
    short: float
    law: str  # of start s, turning value p and the mirrored start e
    table: str = ""

    def fill(self, case: Linkage, folder: Path) -> Path:
        """Write the model with this law and return its path."""
        s, c = case.start, case.critical
        p = c - self.short * math.copysign(1.0, c - s)
        names = {"s": s, "p": p, "d": p - s, "e": 2.0 * c - s}
        if self.table:
            (folder / "law.csv").write_text("".join(f"{k},{names[name]!r}\n" for k, name in enumerate(self.table)))
        numbers = {name: repr(value) for name, value in names.items()} | {"d4": repr(4.0 * names["d"])}
        text = self.law.format(**numbers, minus=repr(-4.0 * names["d"]))
        path = folder / "model.yaml"
        path.write_text(case.text(case.start).replace(LAW, text))
        return path


THERE_AND_BACK = "{{polynomial: [{s}, {d4}, {minus}]}}"
TABLE = "{{table: law.csv}}"
TOUCHING = [
    Course("ends there", 0.0, "{{from: {s}, to: {p}}}"),
    Course("comes to rest there", 0.0, "{{from: {s}, to: {p}, profile: cycloidal}}"),
    Course("turns back there", 0.0, THERE_AND_BACK),
    Course("turns back 1e-6 before", 1e-6, THERE_AND_BACK),
    Course("turns back 1e-9 before", 1e-9, THERE_AND_BACK),
    Course("dwells there and returns", 0.0, TABLE, "spps"),
    Course("dwells there at its end", 0.0, TABLE, "spp"),
]
BEYOND = [
    Course("turns back 1e-6 beyond", -1e-6, THERE_AND_BACK),
    Course("turns back 1e-9 beyond", -1e-9, THERE_AND_BACK),
    Course("goes on", 0.0, "{{from: {s}, to: {e}}}"),
    Course("goes on at rest", 0.0, "{{from: {s}, to: {e}, profile: cycloidal}}"),
    Course("dwells there and goes on", 0.0, TABLE, "sppe"),
    Course("goes far beyond and returns", -7.0 / 8.0, THERE_AND_BACK),
]
LIMITS = [case for case in LINKAGES if case.limit]
CHANGES = [case for case in LINKAGES if not case.limit]
FORKS = [case for case in CHANGES if case.other is not None]
MODES = ("stop", "skip", "reverse")


def crossed(cases: list[Linkage], courses: list[Course]) -> list[object]:
    """Return every case with every course, named."""
    return [pytest.param(case, course, id=f"{case.name}: {course.name}") for case in cases for course in courses]


def law_input(motion: Motion) -> np.ndarray:
    """Return the input (rows,) of the law, in the file's units."""
    return motion.mechanism.value_to_file(0, motion.mechanism.actuators[0].law(motion.time))


def node(motion: Motion, case: Linkage) -> np.ndarray:
    """Return the positions of the traced node (rows,), in the file's units."""
    return motion.mechanism.to_file(motion.z)[motion.mechanism.nodes.index(case.node)]


def blur(place: Callable[[float], complex], value: float) -> float:
    """Return the displacement of the node for a few rounding errors of the input, which is great near a limit."""
    step = 4.0 * np.spacing(max(abs(value), 1.0))
    near = []
    for v in (value - step, value + step):
        with contextlib.suppress(AssertionError):  # beyond the limit
            near.append(abs(place(v) - place(value)))
    return max(near)


def events(motion: Motion, mode: str) -> list[dict[str, Any]]:
    """Return the events of a trace of the same motion."""
    return gimcli.trace(motion.mechanism, STEPS, at_limit=mode).events


def check(motion: Motion, case: Linkage, rows: np.ndarray, place: Callable[[float], complex], at: np.ndarray) -> None:
    """Compare rows that are ok with the closed form at inputs (rows,)."""
    found = node(motion, case)
    assert motion.good[rows].all(), [str(motion.status[k]) for k in np.flatnonzero(~motion.good & rows)]
    for k in np.flatnonzero(rows):
        bound = ACCURATE if at[k] == case.critical else ACCURATE + blur(place, float(at[k]))
        assert abs(found[k] - place(float(at[k]))) <= bound, (k, at[k], found[k], place(float(at[k])))


def beyond(case: Linkage, at: np.ndarray) -> np.ndarray:
    """Return (rows,) whether inputs are beyond the critical one, as seen from the start."""
    return (at - case.critical) * math.copysign(1.0, case.start - case.critical) < 0.0


@pytest.mark.few(10)
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(("case", "course"), crossed(LINKAGES, TOUCHING))
def test_a_law_that_does_not_exceed_the_critical_input_stays_on_its_arc(
    case: Linkage, course: Course, mode: str, tmp_path: Path
) -> None:
    motion = trace(load(course.fill(case, tmp_path)), STEPS, at_limit=mode)
    check(motion, case, np.ones(STEPS + 1, dtype=bool), case.arc, law_input(motion))
    assert motion.limit is None
    assert motion.turned_back == ()
    found = events(motion, mode)
    assert [event["kind"] for event in found] == ([] if course.short else ["limit" if case.limit else "change point"])
    assert [event["at"]["m"] for event in found] == pytest.approx([case.critical] * len(found), abs=1e-9)


@pytest.mark.few(6)
@pytest.mark.parametrize(("case", "course"), crossed(LIMITS, BEYOND))
def test_rows_beyond_a_limit_are_empty_and_the_others_on_the_same_arc(
    case: Linkage, course: Course, tmp_path: Path
) -> None:
    """`stop` ends the motion at the limit; `skip` continues when the law is reachable again, on the same arc."""
    mechanism = load(course.fill(case, tmp_path))
    stopped, skipped = trace(mechanism, STEPS), trace(mechanism, STEPS, at_limit="skip")
    out = beyond(case, law_input(stopped))
    low, high = case.interval
    out |= (law_input(stopped) < low) | (law_input(stopped) > high)
    first = int(np.argmax(out))
    before = np.arange(STEPS + 1) < first
    check(stopped, case, before, case.arc, law_input(stopped))
    assert set(stopped.status[first:]) == {Status.LIMIT}
    again = ~out if "return" in course.name or "back" in course.name else before
    check(skipped, case, again, case.arc, law_input(skipped))
    assert {skipped.status[k] for k in np.flatnonzero(out)} == {Status.LIMIT}
    for motion, mode in ((stopped, "stop"), (skipped, "skip")):
        (limit,) = events(motion, mode)
        assert limit["kind"] == "limit"
        assert limit["at"]["m"] == pytest.approx(case.critical, abs=1e-9)


@pytest.mark.few(12)
@pytest.mark.parametrize(("case", "course"), crossed(LIMITS, BEYOND))
def test_the_input_is_mirrored_at_a_limit_and_the_other_arc_follows(
    case: Linkage, course: Course, tmp_path: Path
) -> None:
    motion = trace(load(course.fill(case, tmp_path)), STEPS, at_limit="reverse")
    out = beyond(case, law_input(motion))
    assert case.other is not None
    given = motion.mechanism.value_to_file(0, motion.inputs[0])
    mirrored = np.where(out, 2.0 * case.critical - law_input(motion), law_input(motion))
    low, high = case.interval
    within = (mirrored >= low) & (mirrored <= high)
    within &= np.cumsum(~within) == 0  # the other limit of the arc is tested elsewhere
    assert given[within] == pytest.approx(mirrored[within], abs=1e-9)
    check(motion, case, within & ~out, case.arc, mirrored)
    check(motion, case, within & out, case.other, mirrored)
    assert motion.good.all()


@pytest.mark.few(12)
@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(("case", "course"), crossed(CHANGES, BEYOND))
def test_a_change_point_is_passed_smoothly(case: Linkage, course: Course, mode: str, tmp_path: Path) -> None:
    motion = trace(load(course.fill(case, tmp_path)), STEPS, at_limit=mode)
    check(motion, case, np.ones(STEPS + 1, dtype=bool), case.arc, law_input(motion))
    found = [event for event in events(motion, mode) if event["kind"] == "change point"]
    assert len(found) == (2 if "return" in course.name or "back" in course.name else 1)
    assert [event["at"]["m"] for event in found] == pytest.approx([case.critical] * len(found), abs=1e-9)


@pytest.mark.parametrize(("case", "course"), crossed(FORKS, BEYOND[2:]))
def test_the_chosen_branch_is_taken_once(case: Linkage, course: Course, tmp_path: Path) -> None:
    """Behind the first change point the motion is smooth, also when it returns through it."""
    assert case.other is not None
    motion = trace(load(course.fill(case, tmp_path)), STEPS, branch=2)
    left = np.cumsum(beyond(case, law_input(motion))) > 0  # behind the first change point
    critical = law_input(motion) == case.critical  # both branches are there
    check(motion, case, ~left & ~critical, case.arc, law_input(motion))
    check(motion, case, left | critical, case.other, law_input(motion))


@pytest.mark.parametrize("case", [pytest.param(case, id=case.name) for case in CHANGES if case.other is None])
def test_a_branch_on_which_the_input_is_stationary_is_an_error(case: Linkage, tmp_path: Path) -> None:
    path = BEYOND[2].fill(case, tmp_path)
    with pytest.raises(UsageError):
        trace(load(path), STEPS, branch=2)


@pytest.mark.few(2)
@pytest.mark.parametrize("case", [pytest.param(case, id=case.name) for case in LINKAGES])
def test_singularities_circuits_and_trace_describe_it_alike(case: Linkage, tmp_path: Path) -> None:
    """The critical input, its kind and the interval of the input, by all three commands and by the closed form."""
    path = BEYOND[2].fill(case, tmp_path)
    kind = "limit" if case.limit else "change point"
    surveyed = report("singularities", path)
    there = [at for at in surveyed["singularities"] if away(at["at"]["m"], case) <= 1e-9]
    stationary = set() if case.limit or case.other else {"dead point"}  # on the other branch
    assert {at["kind"] for at in there} - {"stationary"} - stationary == {kind}
    traced = report("trace", path, "--out", tmp_path / "out.csv", "--no-png", code=5 if case.limit else 0)["events"]
    assert [(at["kind"], at["at"]["m"]) for at in traced] == [(kind, pytest.approx(case.critical, abs=1e-9))]
    for found in (surveyed["circuits"], report("circuits", path)["curves"]):
        ends = [one["interval"]["m"] for one in found]
        if math.isfinite(case.interval[0]):
            assert any(one == pytest.approx(case.interval, abs=1e-9) for one in ends)
        else:
            assert any(high - low == pytest.approx(360.0 * turns(case), abs=1e-9) for low, high in ends)


def turns(case: Linkage) -> int:
    """Return the turns of the crank after which the linkage returns: the kite's bisector rotates half as fast."""
    return 2 if case.name == "kite" else 1


def away(value: float, case: Linkage) -> float:
    """Return the distance of an input from the critical one, modulo whole turns."""
    apart = abs(value - case.critical)
    return min(apart % 360.0, -apart % 360.0) if math.isinf(case.interval[0]) else apart


def report(*arguments: object, code: int = 0) -> Any:
    """Run a command and return its JSON."""
    done = CliRunner().invoke(app, [*map(str, arguments), "--json"])
    assert done.exit_code == code, done.output
    return json.loads(done.stdout)
