"""All methods on extreme mechanisms: each row is accurate, or has a status that states the reason.

A row with the status ok agrees with the closed form, up to the analytic limit of the accuracy (see extreme_cases).
"""

import json
import time

import numpy as np
import pytest
from extreme_cases import (
    METHODS,
    ROUNDINGS,
    SWEPT,
    TOLERANCE,
    Case,
    U,
    chain_of_scissors,
    chain_of_windows,
    change_point,
    dead_centre,
    drawn,
    far_off,
    guides,
    kite,
    long_rod,
    meet,
    one_file,
    parallelogram,
    redundant,
    rotary,
    scaled,
    short_links,
    sliver,
    steep_rod,
    stretched,
    third_crank,
    tried,
    walker,
)
from specifications import four_bar, run, size

from gimcli import GimError, ModelError, load
from gimcli.status import Status

REASONS = {status.word: status.text for status in Status}

CASES: dict[str, list[Case]] = {
    "change points": [
        *(change_point(d, side) for d in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15) for side in (1, -1)),
        *(change_point(d, 1, ends, steps) for d in (1e-3, 1e-8) for ends, steps in (((270, 90), 7), ((179, 181), 20))),
    ],
    "flat positions": [
        parallelogram(50, 129, 7), parallelogram(50, 310, 52), parallelogram(50, -410, 92),
        kite(60, 330, 27), kite(60, 780, 72), kite(60, 777, 7),
    ],
    "dead centres": [
        dead_centre({"from": 3.5, "to": 4.0}, 20), dead_centre({"from": 3.5, "to": 3.9999}, 20),
        dead_centre({"profile": {"polynomial": [3.9, 0.4, -0.4]}}, 39),
    ],
    "lengths": [
        *(long_rod(ratio) for ratio in (1e3, 1e6, 1e9)), *(short_links(ratio) for ratio in (1e2, 1e4, 1e6)),
        *(scaled(factor) for factor in (1e-9, 1.0, 1e9)), one_file(1e-4, 1e4), far_off(1e8 - 1e8j),
    ],
    "slivers": [sliver(height) for height in (1e-1, 1e-3, 1e-6, 1e-9, 0.0)],
    "guides": [*(steep_rod(d) for d in (1e-3, 1e-6, 1e-9, 1e-12)), *(guides(a) for a in (1.0, 1e-1, 1e-2, 1e-3))],
    "chains": [make(n) for make in (chain_of_windows, chain_of_scissors) for n in (10, 20)],
    "redundant": [redundant(e) for e in (0.0, 1e-16, 1e-15, 1e-14, 1e-13, 1e-12)],
}  # fmt: skip


def table(subjects=tuple(CASES)):
    """Return all cases with all methods."""
    rows = []
    for subject in subjects:
        for number, case in enumerate(CASES[subject]):
            for method in METHODS:
                rows.append(pytest.param(case, method, id=f"{subject} {number}: {case.name}, {method}"))
    return rows


@pytest.mark.few(12)
@pytest.mark.parametrize(("case", "method"), table())
def test_rows_are_accurate_or_have_a_reason(case, method):
    check(case, method)


def check(case, method):
    m = case.run(method)
    for row in case.compared(m):
        assert case.error(m, row) <= case.limit(method, case.value(m, row)), (row, case.value(m, row))
    for row, word in enumerate(m.status):
        if word == "ok":
            continue
        assert REASONS[word]
        assert all(np.isnan(z[row]) for z in m.z.values())
        if method == "auto":  # closed forms fail only where rounding of the lengths alone reaches the tolerance
            assert case.rounding(case.value(m, row)) > 0.1 * TOLERANCE * size(case.spec)
    if method == "gim":
        assert m.status.count("ok") >= case.swept * len(m.status)


LONG = [make(n) for make in (chain_of_windows, chain_of_scissors) for n in (100, 1000)]


@pytest.mark.soak
@pytest.mark.parametrize("method", ["newton", "gim"])
@pytest.mark.parametrize("case", LONG, ids=[case.name for case in LONG])
def test_long_chains_without_closed_forms(case, method):
    check(case, method)


@pytest.mark.few(2)
@pytest.mark.parametrize("case", LONG, ids=[case.name for case in LONG])
def test_long_chains(case):
    check(case, "auto")


@pytest.mark.few(1)
@pytest.mark.parametrize("case", LONG[::2], ids=[case.name for case in LONG[::2]])
def test_chains_of_a_hundred_without_closed_forms(case):
    check(case, "newton")


def test_lengths_that_are_negligible_beside_others_are_refused():
    with pytest.raises(ModelError, match="is too small for"):
        one_file(1e-9, 1e9).run("auto")


@pytest.mark.few(4)
@pytest.mark.parametrize(
    ("make", "error"), [*((third_crank, e) for e in (1e-3, -1e-3, 1e-6, 1e-8, 1e-9)), (walker, 1e-3), (walker, 1e-8)]
)
def test_sweeps_report_a_contradiction(make, error):
    try:
        m = run(make(error), 4, method="gim", sweeps=2000)
    except GimError:
        return
    assert set(m.status) <= {"contradictory", "not-assembled"}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("steps", [10, 11])
def test_a_motion_ends_where_two_guides_become_parallel(method, steps):
    """Slot and rail are parallel at 180 deg: the pin moves to infinity, so the motion cannot continue."""
    spec = guides(1.0).spec | {"actuators": rotary(200, 160)}
    m = run(spec, steps, method=method)
    assert m.motion.limit == pytest.approx(0.5, abs=1e-3)
    assert all(word != "ok" for word, value in zip(m.status, m.value["motor"], strict=True) if value <= 180)


# --- starts ----------------------------------------------------------------------------------------------

STARTS = {
    "far": {"A": 3e3 - 2e3j, "B": -4e3 + 1e3j},
    "very far": {"A": 1e9, "B": -1e9j},
    "coincident": {"A": 0.5, "B": 0.5},
    "on the pivots": {"A": 0, "B": 4},
    "in line": {"A": 1, "B": 4.5},
    "mirrored": {"A": -1j, "B": 2 - 2.5j},
    "crossed": {"A": 1j, "B": 5 - 3j},
}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("start", STARTS)
def test_any_start_gives_a_position_or_a_reason(start, method, tmp_path):
    """Four-bar 1, 3, 3.5, 4 at 70 deg: one of its two positions, each time the same."""
    spec = drawn(four_bar(1, 3, 3.5, 4), **STARTS[start]) | {"actuators": rotary(70, 71)}
    begin = time.monotonic()
    first, z = tried(spec, tmp_path, method=method, sweeps=2000)
    again, _ = tried(spec, tmp_path, method=method, sweeps=2000)
    assert time.monotonic() - begin < 20
    assert np.array_equal(first.z, again.z, equal_nan=True)
    if first.status is not Status.OK:
        assert first.status.text
        return
    pin = complex(np.exp(1j * np.radians(70)))
    far = min(abs(z["B"] - complex(meet(pin, 3, 4, 3.5, side)[0])) for side in (1, -1))
    big = load(tmp_path / "model.yaml")
    assert abs(z["A"] - pin) <= 1e-9 * big.size * big.scale
    assert far <= SWEPT * TOLERANCE * big.size * big.scale


@pytest.mark.few(12)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 0.0])
def test_nearly_stretched(gap, method, tmp_path):
    position, z = tried(stretched(gap), tmp_path, method=method)
    if position.status is not Status.OK:
        assert method == "gim" or ROUNDINGS * U / max(gap, U) ** 0.5 > 0.1 * TOLERANCE
        return
    apex, h = meet(0, 1, 2 - gap, 1)
    swept = SWEPT * min(TOLERANCE / float(h or U), TOLERANCE**0.5)
    limit = max(2 * TOLERANCE, swept if method == "gim" else ROUNDINGS * U / float(h or U))
    assert abs(z["C"] - complex(apex)) <= limit


def test_the_shape_of_a_very_flat_member_is_read_exactly(tmp_path):
    """A member of height 1e-12 keeps its shape to the last digit."""
    path = tmp_path / "model.yaml"
    path.write_text(json.dumps(sliver(1e-12).spec))
    mechanism = load(path)
    member = next(m for m in mechanism.members if m.name == "coupler")
    assert float(member.shape[2].imag) * mechanism.scale == 1e-12
