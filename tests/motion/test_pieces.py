"""A motion in one call, in pieces and in interpreted blocks is identical; a long trace needs no more memory."""

import subprocess
import sys

import numpy as np
import pytest
import yaml
from bundled import FILES, changed
from random_mechanisms import Growth

from gimcli import GimError, load
from gimcli.motion.follow import FollowedPath
from gimcli.motion.motion import Motion, checked, stream, trace
from gimcli.motion.summary import DRAWN, Summary
from gimcli.positions.inputs import law_inputs
from gimcli.positions.options import Options
from gimcli.structure.plan import make_plan

STEPS = 700


def assert_equal(a, b):
    assert np.array_equal(a.codes, b.codes)
    assert np.array_equal(a.z, b.z, equal_nan=True)
    assert np.array_equal(a.residual, b.residual, equal_nan=True)
    assert np.array_equal(a.work, b.work)
    assert (a.limit, a.bridged) == (b.limit, b.bridged)


@pytest.mark.few
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
@pytest.mark.parametrize("method", ["auto", "newton"])
def test_compiled_and_interpreted_rows_are_identical(path, method):
    mechanism = load(path)
    plain = trace(mechanism, STEPS, Options(jit="off", method=method))
    assert_equal(plain, trace(mechanism, STEPS, Options(jit="on", method=method)))


@pytest.mark.few(6)
@pytest.mark.parametrize("seed", range(200, 240))
def test_compiled_and_interpreted_rows_of_random_mechanisms_are_identical(seed, tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(Growth(seed, 1 + seed % 5).model()))
    mechanism = load(path)
    try:
        plain = trace(mechanism, STEPS, Options(jit="off"))
    except GimError:
        return
    assert_equal(plain, trace(mechanism, STEPS, Options(jit="on")))


@pytest.mark.few(15)
@pytest.mark.parametrize("name", ["crank_rocker", "stephenson_3_far", "parallelogram", "excavator", "gim_fig13b"])
@pytest.mark.parametrize("jit", ["on", "off"])
@pytest.mark.parametrize(("steps", "rows"), [(1024, 256), (600, 128), (24, 7)])
def test_joined_pieces_equal_the_whole_motion(name, jit, steps, rows):
    mechanism = load(FILES[0].with_name(f"{name}.yaml"))
    whole = trace(mechanism, steps, Options(jit=jit))
    joined = Motion.joined(list(stream(mechanism, steps, Options(jit=jit), rows=rows)))
    assert np.array_equal(whole.codes, joined.codes)
    assert np.array_equal(whole.time, joined.time)
    assert np.max(np.abs(whole.z - joined.z)) < 1e-12  # factors are renewed in other rows
    assert len(whole.bridged) == len(joined.bridged)
    assert whole.work[0] == joined.work[0]


def test_pieces_after_a_limit_have_empty_rows_with_its_status():
    def longer(data):
        data["links"]["crank"]["length"] = 70  # too long to pass the frame

    mechanism = changed(FILES[0].with_name("crank_rocker.yaml"), {"motor": {"from": 90, "to": 360}}, longer)
    whole = trace(mechanism, 1000)
    joined = Motion.joined(list(stream(mechanism, 1000, rows=64)))
    assert 0 < whole.solved < 1001
    assert np.array_equal(whole.codes, joined.codes)
    assert whole.limit == pytest.approx(joined.limit, abs=1e-12)


@pytest.mark.parametrize("name", ["crank_rocker", "gim_fig13b"])
def test_joined_pieces_by_sweeps_equal_the_whole_motion(name):
    mechanism = load(FILES[0].with_name(f"{name}.yaml"))
    whole = trace(mechanism, 200, Options(method="gim"))
    joined = Motion.joined(list(stream(mechanism, 200, Options(method="gim"), rows=50)))
    assert np.array_equal(whole.codes, joined.codes)
    assert np.max(np.abs(whole.z - joined.z)) < 1e-8


def test_a_row_that_was_not_solved_is_never_ok():
    mechanism = load(FILES[0].with_name("crank_rocker.yaml"))
    path = FollowedPath.empty(len(mechanism.nodes), np.arange(5) / 4, law_inputs(mechanism)(np.arange(5) / 4))
    path.z[:] = trace(mechanism, 4).z
    path.z[:, 2] = np.nan
    path.z[-1, 3] += 1e-6
    assert checked(mechanism, make_plan(mechanism), path, Options()).good.tolist() == [True, True, False, False, True]


def test_a_summary_counts_all_rows_and_keeps_some():
    mechanism = load(FILES[0].with_name("crank_rocker.yaml"))
    summary = Summary(20001)
    for piece in stream(mechanism, 20000, rows=3000):
        summary.add(piece)
    whole = trace(mechanism, 20000)
    assert summary.solved == whole.solved == 20001
    assert summary.residual == whole.residual.max()
    kept = summary.motion
    assert len(kept.time) <= DRAWN + 8
    assert (kept.time[0], kept.time[-1]) == (0.0, 1.0)
    assert np.array_equal(kept.z, whole.z[:, np.round(kept.time * 20000).astype(int)])


PEAK = """
import resource, sys
from gimcli.cli import main
sys.argv = ["gim", "trace", {model!r}, "--steps", "{steps}", "--no-png", "--out", {out!r}]
try:
    main()
except SystemExit:
    pass
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.soak
@pytest.mark.skipif(sys.platform == "win32", reason="no resource module")
def test_memory_of_a_long_trace_is_bounded(tmp_path):
    def peak(steps):
        script = PEAK.format(model=str(FILES[0].with_name("crank_rocker.yaml")), steps=steps, out=str(tmp_path))
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
        assert f"{steps + 1} of {steps + 1}" in done.stdout
        return int(done.stdout.split()[-1]) / 1024  # MB

    short, long = peak(50_000), peak(350_000)
    assert long - short < 10  # the rows themselves would take 30
