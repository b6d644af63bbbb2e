"""Films: which rows are shown when, what a frame contains, and the files."""

from __future__ import annotations

import shutil
import subprocess
from itertools import pairwise

import numpy as np
import pytest
from bundled import MODELS
from drawn_styles import areas, marks
from in_process import ran
from PIL import Image

import gimcli
from gimcli import OutputError
from gimcli.output import film as film_module, style
from gimcli.output.animation import Animation, Clip
from gimcli.output.curves import pieces
from gimcli.output.film import Frames, frame_rows
from gimcli.output.printed import PictureOptions
from gimcli.table import Column, Table


@pytest.fixture(scope="module")
def motion():
    mechanism = gimcli.load(MODELS / "crank_rocker.yaml")
    found = gimcli.trace(mechanism, 12)
    return mechanism, np.array([found.xy[name] @ [1, 1j] for name in mechanism.nodes]).T


def animation(mechanism, positions, duration=5.0, words=None, **more):
    rows = len(positions)
    time, status = np.linspace(0.0, duration, rows), tuple(words or ["ok"] * rows)
    table = Table((Column("time", time), Column("status", np.array(status))))
    clip = Clip("motion", positions, time, status, table, **{"closed": True, **more})
    return Animation("a film", mechanism, (clip,))


def shown(found, rate):
    return [row for _, row in frame_rows(found, rate)]


def test_a_motion_is_shown_in_real_time(motion):
    rows = shown(animation(*motion, duration=6.0), 10)
    assert len(rows) == 60
    np.testing.assert_array_equal(rows, np.round(np.arange(60) * 12 / 59))


@pytest.mark.parametrize(("duration", "seconds"), [(0.01, 4.0), (3600.0, 10.0), (0.0, 4.0)])
def test_a_very_short_or_long_motion_is_shown_slower_or_faster(motion, duration, seconds):
    assert len(shown(animation(*motion, duration=duration), 10)) == 10 * seconds


def test_an_open_motion_is_shown_to_and_fro_and_a_simulation_only_forward(motion):
    there = shown(animation(*motion, closed=False, forward=True), 10)
    assert shown(animation(*motion, closed=False), 10) == there + there[::-1]


def test_a_single_position_is_shown_for_a_second(motion):
    mechanism, positions = motion
    assert shown(animation(mechanism, positions[:1]), 20) == [0] * 20


def test_a_row_without_a_position_shows_its_status_and_no_mechanism(motion):
    mechanism, positions = motion
    gap = positions.copy()
    gap[3] = np.nan
    frames = Frames(animation(mechanism, gap, words=["ok"] * 3 + ["limit"] + ["ok"] * 9))
    empty, full = (frames.picture(frames.animation.clips[0], row) for row in (3, 4))
    assert style.PLATE not in areas(empty)
    assert [text.text for text in empty.texts] == ["limit"]
    np.testing.assert_allclose(sorted(marks(full)[style.PIN], key=abs), sorted(gap[4], key=abs))
    assert not full.texts


def test_curves_have_gaps_where_rows_are_not_solved_or_another_branch_begins():
    path = np.arange(8.0) + 0j
    path[2] = np.nan
    found = pieces(path, (6,))
    assert [part.real.tolist() for part in found] == [[0, 1], [3, 4, 5], [6, 7]]


def test_a_gif_repeats_and_moves(motion, tmp_path, monkeypatch):
    monkeypatch.setattr(film_module, "SHORTEST", 0.0)
    gimcli.output.write(animation(*motion, duration=1.3), tmp_path / "m.gif")
    with Image.open(tmp_path / "m.gif") as film:
        pictures, time = [], 0
        for frame in range(film.n_frames):
            film.seek(frame)
            time += film.info["duration"]
            pictures.append(np.asarray(film.convert("L")).astype(int))
        assert film.info["loop"] == 0
    assert time == 1300  # ms
    assert len(pictures) == 13  # equal frames are one longer frame
    assert all(np.mean(np.abs(a - b) > 50) > 0.003 for a, b in pairwise(pictures))
    assert [path.name for path in tmp_path.iterdir()] == ["m.gif"]


def test_an_mp4_has_all_frames(motion, tmp_path, monkeypatch):
    monkeypatch.setattr(film_module, "SHORTEST", 0.0)
    if not (shutil.which("ffmpeg") and shutil.which("ffprobe")):
        pytest.skip("ffmpeg is not installed")
    gimcli.output.write(animation(*motion, duration=0.6), tmp_path / "m.mp4")
    command = ["ffprobe", "-v", "error", "-show_entries", "stream=nb_frames,r_frame_rate", "-of", "csv=p=0"]
    found = subprocess.run([*command, tmp_path / "m.mp4"], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "25/1,15"


def test_without_ffmpeg_the_message_names_it_and_no_file_is_left(motion, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(OutputError, match=r"needs the program ffmpeg.*\.gif"):
        gimcli.output.write(animation(*motion), tmp_path / "m.mp4")
    assert not list(tmp_path.iterdir())
    trace = gimcli.trace(motion[0], 3)
    with pytest.raises(OutputError, match="ffmpeg"):  # before the computation
        trace.destinations([tmp_path / "m.mp4"], "m").refuse(())


def test_commands_and_results_write_films(motion, tmp_path, monkeypatch):
    monkeypatch.setattr(film_module, "SHORTEST", 0.0)
    monkeypatch.setattr(film_module, "LONGEST", 0.2)
    path = MODELS / "chebyshev.yaml"
    for name, more in (("trace", ["--steps=8"]), ("circuits", ["--samples=12"]), ("solve", ["--all"])):
        film = tmp_path / f"{name}.gif"
        ran(name, path, *more, "-o", film, "--size=80x80mm", "--dpi=50")
        with Image.open(film) as shown:
            assert shown.size == (157, 157)
    gimcli.trace(motion[0], 4).save(tmp_path / "m.gif", dpi=40)
    assert (tmp_path / "m.gif").exists()


def test_a_damaged_encoder_gives_a_message(motion, tmp_path, monkeypatch):
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\ncat > /dev/null\necho unknown encoder >&2\nexit 1\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    with pytest.raises(OutputError, match="unknown encoder"):
        gimcli.output.write(animation(*motion), tmp_path / "out" / "m.mp4")
    assert not list((tmp_path / "out").glob("*"))


def test_the_options_of_pictures_hold_for_films(motion, tmp_path, monkeypatch):
    monkeypatch.setattr(film_module, "SHORTEST", 0.0)
    options = PictureOptions.checked(size="100x80mm", dpi=127, style="dark_background")
    gimcli.output.write(options.animated(animation(*motion, duration=0.2)), tmp_path / "m.gif")
    with Image.open(tmp_path / "m.gif") as film:
        assert film.size == (500, 400)
        assert sum(film.convert("RGB").getpixel((3, 3))) == 0
