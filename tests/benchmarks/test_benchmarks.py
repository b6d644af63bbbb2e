"""The benchmarks run, with small sizes and results in a temporary folder. Their times are not checked."""

import csv
import sys

import chains
import compile_time
import design_forces
import files_entered
import first_call
import machine
import numpy as np
import page_frames
import positions
import pytest
import random_starts
import rates
import sensitivity
import view


def rows_of(name, folder):
    with machine.result_path(name, folder).open(newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.mark.soak
def test_positions(tmp_path, monkeypatch):
    for peer in ("pylinkage", "python_solvespace", "exudyn"):
        monkeypatch.setitem(sys.modules, peer, None)
    positions.main(["--steps", "50", "--repeats", "1", "--out", str(tmp_path)])
    rows = rows_of("positions", tmp_path)
    assert {r["mechanism"] for r in rows} == set(positions.COUPLED)
    assert all(float(r["difference"]) <= 1e-9 for r in rows if r["program"] == "gim")
    dyadic = [r for r in rows if r["program"] in positions.peers.PEERS and r["mechanism"] == "jansen"]
    assert [r["note"] for r in dyadic] == ["not installed"] * 3


@pytest.mark.soak
def test_rates(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pylinkage", None)
    rates.main(["--steps", "200", "--repeats", "1", "--out", str(tmp_path)])
    rows = rows_of("rates", tmp_path)
    assert {r["mechanism"] for r in rows} == set(rates.NAMES)
    assert all(float(r["difference"]) <= 1e-6 for r in rows if r["program"] == "2 derivatives")


@pytest.mark.soak
def test_sensitivity(tmp_path):
    sensitivity.main(["--steps", "200", "--repeats", "1", "--out", str(tmp_path)])
    rows = rows_of("sensitivity", tmp_path)
    assert {r["mechanism"] for r in rows} == set(sensitivity.DIMENSIONS)
    assert all(float(r["difference"]) <= 1e-6 for r in rows)


@pytest.mark.soak
def test_forces_of_designs(tmp_path):
    design_forces.main(["--steps", "1000", "--repeats", "1", "--out", str(tmp_path)])
    rows = rows_of("design_forces", tmp_path)
    assert {r["mechanism"] for r in rows} == set(design_forces.NAMES)
    assert all(float(r["difference"]) <= 1e-10 for r in rows)


def test_loops_by_hand_satisfy_the_lengths():
    """Lengths of the bars of the Stephenson mechanism and of the platform, from the positions."""
    c, e, f, b = (q[0] + 1j * q[1] for q in positions.by_hand.trace("stephenson_3_far", 50, True))
    for one, other, square in (
        (c, e, 149),
        (e, b, 530),
        (b, c, 481),
        (c, 23 + 10j, 229),
        (e, f, 634),
        (b, 7 + 4j, 148),
    ):
        assert np.allclose(np.abs(one - other) ** 2, square, rtol=1e-10)
    elbows = positions.by_hand.trace("platform_3rrr", 50, True)[4:]
    corners = positions.by_hand.trace("platform_3rrr", 50, True)[1:4]
    legs = np.abs((elbows[:, 0] + 1j * elbows[:, 1]) - (corners[:, 0] + 1j * corners[:, 1]))
    assert np.allclose(legs, 6.0, rtol=1e-10)


def test_chains(tmp_path):
    chains.main(["--steps", "20", "--largest", "3", "--repeats", "1", "--out", str(tmp_path)])
    assert [(r["chain"], r["n"]) for r in rows_of("chains", tmp_path)] == [
        (name, n) for name in ("scissor", "windows") for n in ("1", "3")
    ]


def test_exponent_of_a_power_law():
    rows = [{"n": n, "t": 3.0 * n**1.7} for n in (1, 10, 100, 1000)]
    assert chains.exponent(rows, "t") == pytest.approx(1.7, abs=1e-9)


@pytest.mark.soak
def test_first_call(tmp_path):
    first_call.main(["--runs", "1", "--steps", "0", "--out", str(tmp_path)])
    assert len(rows_of("first_call", tmp_path)) == 2


@pytest.mark.soak
def test_compile_time(tmp_path):
    compile_time.main(["--repeats", "1", "--out", str(tmp_path)])
    rows = rows_of("compile_time", tmp_path)
    assert len(rows) == len(compile_time.COMMANDS)
    assert all(float(row["second s"]) < float(row["first s"]) for row in rows)


def test_random_starts(tmp_path):
    arguments = ["--starts", "12", "--models", "crank_rocker", "--processes", "1", "--out", str(tmp_path)]
    random_starts.main(arguments)
    rows = rows_of("random_starts", tmp_path)
    assert [r["method"] for r in rows] == list(random_starts.METHODS)
    assert [r["configurations"] for r in rows if r["method"] != "newton"] == ["2", "2"]  # a four-bar has two


@pytest.mark.soak
def test_page_frames(tmp_path):
    try:
        page_frames.main(["--frames", "20", "--out", str(tmp_path)])
    except page_frames.NotInstalledError as missing:
        pytest.skip(f"{missing} is not installed")
    assert {row["moving nodes"] for row in rows_of("page_frames", tmp_path)} == {"40"}


@pytest.mark.soak
def test_view(tmp_path):
    try:
        view.main(["--saves", "2", "--seconds", "0.5", "--out", str(tmp_path), "crank_rocker"])
    except view.NotInstalledError as missing:
        pytest.skip(f"{missing} is not installed")
    (row,) = rows_of("view", tmp_path)
    assert float(row["positions a second"]) > 0.0
    assert 0.0 < float(row["save to seeing, median [s]"]) < 10.0


@pytest.mark.parametrize("arguments", files_entered.MOST, ids=" ".join)
def test_files_entered(arguments):
    assert 40 < len(files_entered.files_entered(arguments)) <= files_entered.MOST[arguments]
