"""`gim sweep`: counts that are known exactly, filters and best designs, resumption, processes and clusters."""

import csv
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import suppress
from multiprocessing import active_children
from types import SimpleNamespace

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim, ran, refused

import gimcli
from gimcli import UsageError
from gimcli.families import sweep_job, sweep_run
from gimcli.families.four_bar_type import four_bar_types
from gimcli.families.sweep_job import SweepJob
from gimcli.library import sweep as library

FOUR_BAR = """\
name: Four-bar
nodes: {O: [0, 0], G: [4, 0], A: [0, 2], B: [4, 3]}
ground: [O, G]
links:
  crank: {nodes: [O, A], length: 2}
  coupler: {nodes: [A, B], length: 4}
  rocker: {nodes: [G, B], length: 3}
actuators:
  motor: {type: rotary, pivot: O, arm: A, law: {from: 0, to: 360}}
"""
CRANK_ROCKER = MODELS / "crank_rocker.yaml"
VARY = ("--vary", "crank.length=30:50:7", "--vary", "O4.x=95,100,105", "--steps", 12)


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "fb.yaml"
    path.write_text(FOUR_BAR)
    return path


@pytest.fixture
def small_chunks(monkeypatch):
    monkeypatch.setattr(library, "chunk_size", lambda mechanism, steps: 4)


def rows_of(path):
    with open(path, newline="", encoding="utf-8") as handle:
        return list(csv.DictReader(handle))


@pytest.mark.soak
def test_grashof_types_of_integer_lengths(model, tmp_path):
    """Lengths 1 to 6 each: 120 designs with each link shortest, 336 change points, 420 triple-rockers, 60 open.

    Of the Grashof linkages exactly those with the shortest input or frame turn fully.
    """
    lengths = [f"--vary={name}=1:6:6" for name in ("G.x", "crank", "coupler", "rocker")]
    assert gim("sweep", model, *lengths, "--keep", "type", "-o", tmp_path / "a.csv").code == 0
    rows = rows_of(tmp_path / "a.csv")
    types = Counter(row["type"] for row in rows)
    change = sum(types.pop(name, 0) for name in (
        "linkage with change points", "kite", "parallelogram", "antiparallelogram", "rhombus"
    ))  # fmt: skip
    assert change == 336
    assert types == {
        "double-crank": 120, "crank-rocker": 120, "double-rocker": 120, "crank-rocker driven at the rocker": 120,
        "triple-rocker": 420, "cannot be assembled": 60,
    }  # fmt: skip
    for row in rows:
        if row["type"] in types:
            assert (row["status"] == "ok") == (row["type"] in ("double-crank", "crank-rocker"))


def test_types_of_random_lengths(model, tmp_path):
    """Of lengths that are uniform on [0, 6]: each link the shortest of a Grashof linkage in 1/8, open in 1/6.

    The input turns fully in 1/4 of all. The tolerance is four standard deviations of the shares.
    """
    count, lengths = 4_000, [f"--vary={name}=uniform(0,6)" for name in ("G.x", "crank", "coupler", "rocker")]
    options = ("--samples", count, "--steps", 24, "--keep", "type", "-o", tmp_path / "a.csv", "--json")
    done = gim("sweep", model, *lengths, *options).json
    types = Counter(row["type"] for row in rows_of(tmp_path / "a.csv"))
    shares = {"double-crank": 1 / 8, "crank-rocker": 1 / 8, "double-rocker": 1 / 8, "triple-rocker": 1 / 3,
              "crank-rocker driven at the rocker": 1 / 8, "cannot be assembled": 1 / 6}  # fmt: skip
    assert set(types) == set(shares)
    for name, share in shares.items():
        assert abs(types[name] / count - share) < 4.0 * (share * (1.0 - share) / count) ** 0.5
    assert done["solved"] == types["double-crank"] + types["crank-rocker"]
    assert done["solved_one_by_one"] < 0.01 * count


@pytest.mark.parametrize("height", [3e-15, -3e-15])
def test_the_initial_coordinates_decide_where_all_links_are_in_line(height):
    """Rounding puts the coupler of a folded parallelogram above or below the frame."""
    mechanism = gimcli.loads(FOUR_BAR).with_({"crank.length": 3.0})
    corners = {"O": 0.0, "G": 4.0, "A": 3.0 + 1j * height, "B": 7.0 - 5j * height}
    z = np.array([[corners[name] for name in mechanism.nodes]])
    shapes = np.concatenate([member.shape for member in mechanism.members])
    tables = SimpleNamespace(shapes=np.stack((shapes.real, shapes.imag), axis=1)[None])
    assert four_bar_types(mechanism, tables, (z - mechanism.origin) / mechanism.scale).tolist() == ["parallelogram"]


def test_types_are_those_of_check(model):
    m = gimcli.load(model)
    found = gimcli.sweep(m, {"crank.length": [1.0, 2.0, 3.0], "G.x": [2.0, 4.0]}, steps=2, keep="type").table()
    for k, name in enumerate(found["type"]):
        own = m.with_({"crank.length": found["crank.length"][k], "G.x": found["G.x"][k]})
        assert gimcli.check(own).report()["loops"][0]["kind"].partition(" (")[0] == name


def test_where_and_best_choose_rows_of_the_whole_table(tmp_path, small_chunks):
    keep = ("--keep", "range(P.y)", "--keep", "min(transmission)")
    whole, some, best = (tmp_path / f"{name}.csv" for name in ("whole", "some", "best"))
    where = ("--where", "min(transmission) > 25 and crank.length != 30")
    assert gim("sweep", CRANK_ROCKER, *VARY, *keep, "-o", whole).code == 0
    done = gim("sweep", CRANK_ROCKER, *VARY, *keep, *where, "-o", some, "--json").json
    assert gim("sweep", CRANK_ROCKER, *VARY, *keep, *where, "--goal=-range(P.y)", "--best=3", "-o", best).code == 0
    rows = rows_of(whole)
    good = [row for row in rows if float(row["min(transmission)"]) > 25 and float(row["crank.length"]) != 30]
    assert 3 < len(good) < len(rows)
    assert rows_of(some) == good
    assert (done["designs"], done["kept"]) == (21, len(good))
    order = sorted(good, key=lambda row: -float(row["range(P.y)"]))[:3]
    assert [row["design"] for row in rows_of(best)] == [row["design"] for row in order]
    assert [float(row["goal"]) for row in rows_of(best)] == [-float(row["range(P.y)"]) for row in order]


def test_a_design_that_fails_is_a_row(model):
    found = gimcli.sweep(gimcli.load(model), {"crank.length": [-1.0, 2.0, 30.0]}, steps=4, keep="max(B.y)")
    assert [status == "ok" for status in found.status] == [False, True, False]
    assert np.isfinite(found["max(B.y)"]).tolist() == [False, True, False]
    assert found.answered
    assert found.headline() == "Four-bar: 1 of 3 designs solved"


def test_no_design_is_solved(model, tmp_path):
    done = ran("sweep", model, "--vary", "crank.length=20,30", "--steps", 4, "-o", tmp_path / "a.csv")
    assert done.code == 5
    assert "0 of 2 designs solved" in done.text
    assert "not-assembled" in done.text
    assert len(rows_of(tmp_path / "a.csv")) == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--vary", "crank.length"], "expected NAME=VALUES"),
        (["--vary", "crank=1,2", "--vary", "crank=2"], "give it once"),
        (["--vary", "crank=1,2", "--vary", "crank.length=2"], "'crank.length' is given twice"),
        (["--vary", "handle=1,2"], "'handle' is not a dimension"),
        (["--vary", "crank=1,2", "--best", "2"], "need a goal"),
        (["--vary", "crank=1,2", "--where", "max(B.x)"], "expected a comparison"),
        (["--vary", "crank=1,2", "--goal", "type"], "expected a number"),
        (["--vary", "crank=1,2", "--keep", "crank.length"], "two columns would be named 'crank.length'; rename"),
        (["--vary", "crank=1,2", "--scheduler", "tcp://x:1", "--workers", "2"], "remove one of them"),
        (["--vary", "crank=1,2", "--resume", "-o", "-"], "resume continues a sweep from its folder"),
    ],
)
def test_invalid_options_are_refused(options, message, model):
    assert message in refused("sweep", model, *options)


def test_dimensions_without_effect_are_named():
    notes, m = [], gimcli.load(CRANK_ROCKER)  # its lengths are given: B.y is an initial coordinate
    vary = {"B.y": [60, 70], "crank": [30, 40], "O4.x": 100, "P.x": [50, 60], "motor.to": [90, 180], "duration": [1, 2]}
    gimcli.sweep(m, vary, steps=2, notify=notes.append)
    assert [note.partition(":")[0] for note in notes] == ["vary B.y"]


# -- interrupts -----------------------------------------------------------------------------------------


class Computed:
    """Records the chunks that are computed; interrupts after some."""

    def __init__(self, monkeypatch, most=None):
        self.numbers, run = [], SweepJob.run

        def counted(job, number):
            if most is not None and len(self.numbers) == most:
                raise KeyboardInterrupt
            self.numbers.append(number)
            return run(job, number)

        monkeypatch.setattr(SweepJob, "run", counted)


def test_an_interrupted_sweep_is_resumed(tmp_path, small_chunks):
    out, whole = tmp_path / "a.csv", tmp_path / "whole.csv"
    assert gim("sweep", CRANK_ROCKER, *VARY, "-o", whole).code == 0
    with pytest.MonkeyPatch.context() as patch:
        first = Computed(patch, 2)
        done = ran("sweep", CRANK_ROCKER, *VARY, "-o", out)
    assert done.code == 130
    assert "interrupted: 2 of 6 chunks are done" in done.error
    assert (first.numbers, out.exists()) == ([0, 1], False)
    assert "belongs to another run (differs in steps)" in refused(
        "sweep", CRANK_ROCKER, *VARY[:-1], 13, "-o", out, "--resume"
    )
    with pytest.MonkeyPatch.context() as patch:
        second = Computed(patch)
        assert gim("sweep", CRANK_ROCKER, *VARY, "-o", out, "--resume").code == 0
    assert second.numbers == [2, 3, 4, 5]
    assert out.read_bytes() == whole.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "whole.csv"]


def test_a_damaged_part_is_computed_again(tmp_path, small_chunks):
    out, whole = tmp_path / "a.csv", tmp_path / "whole.csv"
    assert gim("sweep", CRANK_ROCKER, *VARY, "-o", whole).code == 0
    with pytest.MonkeyPatch.context() as patch:
        Computed(patch, 3)
        assert ran("sweep", CRANK_ROCKER, *VARY, "-o", out).code == 130
    [part] = (tmp_path / "a.parts").glob("part-000001-*.npy")
    part.write_bytes(part.read_bytes()[:-40])
    assert gim("sweep", CRANK_ROCKER, *VARY, "-o", out, "--resume").code == 0
    assert out.read_bytes() == whole.read_bytes()


def test_parts_of_another_run_in_the_folder_are_not_used(tmp_path, small_chunks):
    """A folder that is a link is not removed, and another run may write into it at the same time."""
    (tmp_path / "kept").mkdir()
    (tmp_path / "a.parts").symlink_to(tmp_path / "kept")
    for values in ("30,40", "35,45"):
        assert gim("sweep", CRANK_ROCKER, "--vary", f"crank={values}", "--steps", 4, "-o", tmp_path / "a.csv").code == 0
        assert ",".join(f"{float(row['crank.length']):g}" for row in rows_of(tmp_path / "a.csv")) == values


def test_folders_that_cannot_hold_parts(tmp_path):
    vary, folder = ("--vary", "crank=30,40", "--steps", 4), tmp_path / "a.parts"
    folder.write_text("")
    for resume in ((), ("--resume",)):
        message = refused("sweep", CRANK_ROCKER, *vary, "-o", tmp_path / "a.csv", *resume, code=6)
        assert f"{folder}: is a file, not a folder" in message
    folder.unlink()
    folder.mkdir()
    (folder / "header.json").write_text("[1]")
    (folder / "part-x.npy").write_text("")
    assert gim("sweep", CRANK_ROCKER, *vary, "-o", tmp_path / "a.csv", "--resume").code == 0


def test_a_killed_sweep_is_resumed(tmp_path):
    """The process gets SIGKILL when some parts are there."""
    options = ["sweep", CRANK_ROCKER, "--vary=crank.length=30:50:150", "--vary=O4.x=90:110:150", "--keep=range(P.y)"]
    command = [sys.executable, "-m", "gimcli", *map(str, options)]
    out, whole = tmp_path / "a.csv", tmp_path / "whole.csv"
    process = subprocess.Popen([*command, "-o", str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    folder, end = tmp_path / "a.parts", time.monotonic() + 60.0
    while len(list(folder.glob("part-*.npy"))) < 2 and time.monotonic() < end:
        time.sleep(0.005)
    process.kill()
    process.wait()
    kept = len(list(folder.glob("part-*.npy")))
    assert 2 <= kept < 6
    done = gim(*options, "-o", out, "--resume", "--json")
    assert done.json["resumed_chunks"] == kept
    assert gim(*options, "-o", whole).code == 0
    assert out.read_bytes() == whole.read_bytes()


# -- processes and clusters -----------------------------------------------------------------------------

MANY = {"crank.length": "30:50:9", "O4.x": "95,100,105"}
KEEP = ("range(P.y)", "min(transmission)", "type")


def alike(first, second):
    one, two = first.table(), second.table()
    assert one.names == two.names
    for name in one.names:
        a, b = one[name], two[name]
        assert a.tobytes() == b.tobytes() if a.dtype.kind == "f" else np.array_equal(a, b)


def sweep(**options):
    return gimcli.sweep(gimcli.load(CRANK_ROCKER), MANY, steps=12, keep=KEEP, **options)


def test_processes_give_the_same_numbers(small_chunks):
    alike(sweep(), sweep(workers=2))


def test_a_process_that_is_killed_loses_nothing(small_chunks):
    killed = []

    def progress(phase):
        def report(done, of):
            if done and not killed:
                killed.append(active_children()[0].pid)
                os.kill(killed[0], signal.SIGKILL)

        return report

    alike(sweep(), sweep(workers=2, progress=progress))
    assert killed


def lives(group):
    """Return whether a process of a group has not ended."""
    with suppress(ProcessLookupError):
        os.killpg(group, 0)
        return True
    return False


@pytest.mark.soak
def test_workers_end_with_a_main_process_that_is_killed(tmp_path):
    options = ["--vary=crank.length=30:50:300", "--vary=O4.x=90:110:300", "--workers=2", "-o", str(tmp_path / "a.csv")]
    command = [sys.executable, "-m", "gimcli", "sweep", str(CRANK_ROCKER), *options]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    end = time.monotonic() + 60.0
    while not list(tmp_path.glob("a.parts/part-*.npy")) and time.monotonic() < end:
        time.sleep(0.005)
    process.kill()
    process.wait()
    while lives(process.pid) and time.monotonic() < end:
        time.sleep(0.05)
    assert not lives(process.pid)


@pytest.mark.soak
def test_workers_of_a_script_that_starts_them_on_import(tmp_path):
    """Each worker imports the script, which begins the sweep again: it is refused, also with a large table."""
    script = tmp_path / "script.py"
    script.write_text(
        f"import gimcli\nm = gimcli.load({str(CRANK_ROCKER)!r})\n"
        "gimcli.sweep(m, {'crank.length': '30:50:9000'}, keep='max(P.y)', workers=2)\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert 'needs the line: if __name__ == "__main__":' in done.stderr


def test_a_cluster_loses_nothing_with_one_of_its_two_workers(small_chunks):
    distributed, dask = pytest.importorskip("distributed"), pytest.importorskip("dask")
    killed, once = [], {"distributed.worker.multiprocessing-method": "forkserver"}  # imports once for all workers
    with (
        dask.config.set(once),
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as cluster,
    ):

        def progress(phase):
            def report(done, of):
                if done and not killed:
                    killed.append(next(iter(cluster.workers.values())).pid)
                    os.kill(killed[0], signal.SIGKILL)

            return report

        found = sweep(scheduler=cluster.scheduler_address, progress=progress)
    alike(sweep(), found)
    assert killed


def test_a_scheduler_that_does_not_answer(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(sweep_run, "ANSWER", "1s")
    with pytest.raises(UsageError, match="no Dask scheduler answers"):
        sweep(scheduler="tcp://127.0.0.1:9")


def test_chunks_do_not_depend_on_processes():
    m = gimcli.load(CRANK_ROCKER)
    assert sweep_job.chunk_size(m, 72) == 4096
    assert 1 <= sweep_job.chunk_size(m, 1_000_000) < 4096
