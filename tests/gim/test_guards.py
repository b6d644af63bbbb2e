"""Every kind of failure of the sweeps, provoked: each stops early, with its status."""

import json

import numpy as np
import pytest
from bundled import MODELS, run_model
from extreme_cases import near_change_point, stretched, tried
from random_mechanisms import Growth
from table1_operations import CASES
from typer.testing import CliRunner

from gimcli import StructureError, load
from gimcli.cli import app
from gimcli.gim import sweeps
from gimcli.gim.sequence_switching import SwitchingState, off_branch
from gimcli.gim.sweeper import Sweeper
from gimcli.kernels import jit, sweep as kernels
from gimcli.motion.motion import trace
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.residual import errors
from gimcli.structure.restrictions import Move, angle, distance
from gimcli.structure.rotation import ties
from gimcli.structure.steps import Value

NONE = np.zeros(0)


def settle(moves, z, run=plain, **policy):
    return sweeps.settle(
        tuple(moves), np.array(z, dtype=complex), NONE, 1.0, 1e-10, run, sweeps.SweepConstants(**policy)
    )


def dyad(a, b):
    """Return the moves that place node 2 at distances a and b from nodes 0 and 1."""
    return [Move(distance("a", 0, 2, Value(a)), 2), Move(distance("b", 1, 2, Value(b)), 2)]


# --- one position ----------------------------------------------------------------------------------------


def test_a_cycle_is_reported():
    """An angle of 90 deg from a node's arm to the same node rotates it by 90 deg in each sweep."""
    done = settle([Move(angle("turn", 0, 1, 1, 1j), 1)], [0, 1])
    assert done.status is Status.CYCLING
    assert done.sweeps <= 8  # the period of 4 is detected from the positions saved at sweep 4


def test_stagnation_is_reported_at_once():
    """Two circles of radius 3 about 0 and 4: a node on the line of centres moves to 3, then to 1, and stays there."""
    done = settle(dyad(3, 3), [0, 4, 2])
    assert done.status is Status.STALLED
    assert done.sweeps <= 2
    assert done.z[2] == 1


def test_circles_that_do_not_intersect_stall_at_their_closest_points():
    """Bars 1 and 1, pivots at a distance of 4: alternating projections end at 3, with a gap of 2."""
    done = settle(dyad(1, 1), [0, 4, 2 + 0.5j])
    assert done.status is Status.STALLED
    assert abs(done.z[2] - 3) < 1e-6
    assert done.length_error == pytest.approx(2)


def test_circles_that_touch_stall_above_the_tolerance():
    """For tangent circles the error decreases like 1 / n: the tolerance is not reached, and the sweeps stop early."""
    done = settle(dyad(1, 1), [0, 2, 1 + 0.3j])
    assert done.status is Status.STALLED
    assert done.sweeps < 20000
    assert done.length_error > 1e-10


def test_slow_convergence_is_not_stagnation():
    """A factor of 0.9979 for each sweep: cos^2 of the angle of the bars at a height of 0.0229 (extremes X03)."""
    h = 0.0229
    done = settle(dyad(1, 1), [0, 2 * np.sqrt(1 - h * h), 1 + 0.03j])
    assert done.status is Status.OK
    assert done.z[2].imag == pytest.approx(h, abs=1e-8)


def test_too_many_sweeps_have_their_own_status():
    assert settle(dyad(1, 1), [0, 1.9, 1 + 0.1j], sweeps=3).status is Status.NOT_CONVERGED


@pytest.mark.parametrize("bad", [np.nan, np.inf, complex(0, np.nan)])
def test_nonfinite_coordinates_end_at_once(bad):
    done = settle(dyad(3, 3), [0, 4, bad])
    assert done.status is Status.DIVERGED
    assert done.sweeps == 1


@pytest.mark.parametrize("far", [1e150, 1e200, 1e300])
def test_overflow_is_never_ok(far):
    done = settle(dyad(3, 3), [0, 4, far * (1 + 1j)])
    assert done.status is not Status.OK or abs(done.z[2] - (2 + np.sqrt(5) * 1j)) < 1e-8


@pytest.mark.parametrize("run", [plain, jit.compiled])
def test_an_arm_of_length_zero_causes_no_division_by_zero(run):
    done = settle([Move(angle("bent", 0, 1, 2, 1j), 2), Move(distance("a", 0, 2, Value(1.0)), 2)], [0, 0, 1], run)
    assert done.status is Status.STALLED
    assert np.all(np.isfinite(done.z))


def test_each_status_text_has_a_correction():
    for status in (Status.STALLED, Status.CYCLING, Status.DIVERGED):
        assert "the method auto" in status.text


@pytest.mark.parametrize("gap", [-1e-3, 0.0, 1e-12])
def test_unreachable_and_flat_positions_name_a_bar(gap, tmp_path):
    position, _ = tried(stretched(gap), tmp_path, method="gim")
    if position.status is not Status.OK:
        assert position.status in (Status.STALLED, Status.NOT_CONVERGED)
        assert position.worst in ("left", "right")


# --- a motion: the branch --------------------------------------------------------------------------------


def mechanism_of(spec, folder):
    path = folder / "model.yaml"
    path.write_text(json.dumps(spec))
    return load(path)


@pytest.mark.parametrize("delta", [1e-1, 1e-3, 1e-5, 1e-6])
def test_the_mirror_branch_is_detected_at_any_distance(delta, tmp_path):
    """Solutions +-h with h = sqrt(2.4 delta): halfway between them both bars have errors of at least h^2 / 2."""
    law = (179.9, 180.1)
    here, there = (mechanism_of(near_change_point(delta, side, *law)[0], tmp_path) for side in (1, -1))
    one, other = trace(here, 4), trace(there, 4)
    assert np.all(one.good & other.good)
    assert np.all(off_branch(here, one.z, other.z, one.inputs, 1e-10))
    assert not np.any(off_branch(here, one.z, one.z * (1 + 1e-11), one.inputs, 1e-10))
    if delta >= 1e-3:  # the sweeps start on their own branch: all rows are on another one
        swept = SwitchingState(Sweeper(here, Options(method="gim"), jit.compiled), one.inputs, other.z).run()
        assert set(swept.codes) == {int(Status.JUMPED)}


def test_a_step_over_half_a_turn_is_not_ok_on_another_branch():
    """Peaucellier-Lipkin in one step of 200 deg: positions off the continuous motion are not ok."""
    m = run_model("peaucellier", 1, method="gim", jit="on")
    exact = run_model("peaucellier", 1)
    for name in ("A", "B", "Q"):
        rows = [k for k, status in enumerate(m.status) if status == "ok"]
        assert np.max(abs(m.xy(name) - exact.xy(name))[rows], initial=0.0) < 1e-6


# --- a motion: the sequence ------------------------------------------------------------------------------


def test_a_sequence_whose_radius_exceeds_1_is_exchanged(monkeypatch):
    name, options = "gim_fig13c", {"method": "gim", "jit": "on"}
    m, exact = run_model(name, 72, **options), run_model(name, 72)
    assert set(m.status) == {"ok"}
    assert m.motion.exchanged
    assert set(m.motion.exchanged) <= set(m.motion.time)
    size = m.mechanism.size
    assert np.max(abs(m.motion.z - exact.motion.z)) < 1e-6 * size
    monkeypatch.setattr(Sweeper, "exchange", lambda *_: False)
    kept = run_model(name, 72, **options)
    assert kept.motion.exchanged == ()
    assert "stalled" in kept.status


def test_a_sequence_that_becomes_slow_is_exchanged(monkeypatch):
    fast = run_model("elliptic_trammel", 72, method="gim", jit="on")
    assert fast.motion.exchanged
    monkeypatch.setattr(Sweeper, "exchange", lambda *_: False)
    slow = run_model("elliptic_trammel", 72, method="gim", jit="on")
    assert slow.motion.work.sum() > 4 * fast.motion.work.sum()
    assert np.nanmax(abs(slow.motion.z - fast.motion.z)) < 1e-7


TEN_BAR = next(case.sequence for case in CASES if case.model == "ten_bar")


def test_a_given_sequence_is_not_exchanged():
    mechanism = load(MODELS / "ten_bar.yaml")
    sweeper = Sweeper(mechanism, Options(method="gim", moves=TEN_BAR), plain)
    moves = sweeper.moves
    assert not sweeper.exchange(mechanism.drawn, 0.0)
    assert sweeper.moves == moves
    m = run_model("ten_bar", 72, method="gim", moves=TEN_BAR, jit="on")
    assert m.motion.exchanged == ()


def test_exchanges_are_reported_in_text_and_json(tmp_path):
    command = ["trace", str(MODELS / "elliptic_trammel.yaml"), "--steps", "72", "--method", "gim", "--no-png", "-o"]
    printed = CliRunner().invoke(app, [*command, str(tmp_path)])
    assert printed.exit_code == 0
    found = json.loads(CliRunner().invoke(app, [*command, str(tmp_path), "--json"]).stdout)["events"]
    exchanged = [e for e in found if e["kind"] == "sequence exchanged"]
    assert len(exchanged) >= 2
    assert all(set(e["at"]) == {"motor"} for e in exchanged)


def test_a_search_without_a_result_raises_an_error(tmp_path):
    """A slider's travel can only move this slider: the group has too few restrictions for two moves of each node."""
    spec = Growth(4259149354, ["true_pair", "rpr", "triad", "triad"], "travel").model()
    mechanism = mechanism_of(spec, tmp_path)
    with pytest.raises(StructureError, match="no sequence moves nodes"):
        Sweeper(mechanism, Options(method="gim"), plain)


@pytest.mark.parametrize(("name", "most"), [("excavator", 20_000), ("peaucellier", 20_000), ("klann", 5_000)])
def test_sweeps_reach_the_start_and_all_rows(name, most):
    """A member in several groups is placed by distance and angle; the start is reached from the drawn position."""
    m = run_model(name, 72, method="gim", jit="on")
    assert set(m.status) == {"ok"}
    assert m.motion.work.sum() < most


def test_every_result_of_the_kernel_has_a_status():
    ends = (kernels.SETTLED, kernels.EXHAUSTED, kernels.STALLED, kernels.CYCLING, kernels.DIVERGED)
    assert set(sweeps.ENDS) == set(ends)


# --- a motion past infinity ------------------------------------------------------------------------------


@pytest.mark.few(1)
@pytest.mark.parametrize("jit", ["off", "on"])
def test_a_pin_in_a_rotating_slot_does_not_pass_infinity(jit, tmp_path):
    """Whitworth's rocker is parallel to the rail when the crank pin is level with the rocker's pivot: sin = 1/3."""
    spec = {
        "nodes": {"O1": [0, -1], "O2": [0, 0], "H": [-4, 1], "K": [4, 1], "C": [0, 2], "T": [0, 3], "B": [0, 1]},
        "ground": ["O1", "O2", "H", "K"],
        "links": {"crank": ["O1", "C"], "rocker": ["O2", "T"]},
        "prismatic": {
            "block": {"node": "C", "guide": ["O2", "T"]}, "slot": {"node": "B", "guide": ["O2", "T"]},
            "rail": {"node": "B", "guide": ["H", "K"]},
        },
        "actuators": {"motor": {"type": "rotary", "pivot": "O1", "arm": "C", "law": {"from": 90, "to": 450}}},
    }  # fmt: skip
    (tmp_path / "model.yaml").write_text(json.dumps(spec))
    mechanism = load(tmp_path / "model.yaml")
    parallel = 0.25 - np.arcsin(1 / 3) / (2 * np.pi)
    for steps in (40, 44, 60, 128, 180, 284, 301, 388):
        motion = trace(mechanism, steps, Options(jit=jit))
        assert motion.limit == pytest.approx(parallel, abs=1e-6)
        assert not motion.good[motion.time > parallel].any()
        assert motion.good[motion.time < parallel - 1e-3].all()


def test_a_prismatic_pair_rotated_by_180_deg_is_detected():
    """A yoke rotated by 180 deg on its guide has the same heights; only the check of its angle detects it."""
    mechanism = load(MODELS / "scotch_yoke.yaml")
    motion = trace(mechanism, 8)
    tie = next(iter(ties(mechanism)))
    nodes = list(mechanism.members[tie.body].nodes)
    pivot = motion.z[tie.row.node, :1]
    turned = motion.z[:, :1].copy()
    turned[nodes] = 2.0 * pivot - turned[nodes]
    names = {name for name, _, error in errors(mechanism, turned, motion.inputs[:, :1]) if error[0] > 3.0}
    assert tie.pair in names
    assert all(error[0] < 1e-12 for _, _, error in errors(mechanism, motion.z[:, :1], motion.inputs[:, :1]))
