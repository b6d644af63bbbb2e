"""Output: tables that are read back without loss, atomic files, pictures of all kinds."""

from __future__ import annotations

import csv
import math
import os
import struct
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from drawn_styles import areas, marks, strokes

from gimcli import Mechanism, OutputError, UsageError, output
from gimcli.mechanism import ANGLE, HEIGHT, SPAN, Input, Member, PairRow, Point
from gimcli.output import written_bytes, written_text
from gimcli.output.axes import title_lines
from gimcli.output.csv import CsvStream, write_csv
from gimcli.output.curves import drawn_runs, thinned
from gimcli.output.drawing import history_picture, motion_picture, position_picture
from gimcli.output.pose import MOST_KEYS
from gimcli.output.scene import FLAT, Scene
from gimcli.output.structure import DrawnMove, sequence_picture
from gimcli.output.style import HATCH, curve_pen
from gimcli.structure.convex_hull import convex_hull
from gimcli.table import Column, Table

SCALE = 64.0


def ramp(start, end):
    return lambda time, order=0: start + (end - start) * time if order == 0 else 0 * time + end - start


def mechanism(names, pose, members, slides=(), actuators=(), points=(), **more):
    """Return a mechanism of members (name, nodes); a member's own frame starts at its first node, x to the second."""
    drawn = np.array(pose, dtype=complex)
    origin = complex(drawn.mean())
    built = []
    for index, (name, nodes) in enumerate(members):
        z = drawn[list(nodes)]
        still = index == 0 and not more.get("floating")
        shape = (z - origin) if still else (z - z[0]) * abs(z[1] - z[0]) / (z[1] - z[0])
        built.append(Member(name, tuple(nodes), shape / SCALE))
    at = (0.0 - origin) / SCALE
    lines = [
        PairRow(n, HEIGHT, (k,), (m,), d / SCALE + (at if m == 0 else 0), 1j * u, pair=p) for n, p, k, m, d, u in slides
    ]
    carried = tuple(Point(name, member, local / SCALE) for name, member, local in points)
    normal = (drawn - origin) / SCALE
    traced = tuple(point.name for point in carried)
    return Mechanism(
        "test", tuple(names), normal, tuple(built), tuple(lines), tuple(actuators), carried, traced, 1.0,
        SCALE, origin, **{"length_unit": "mm", **more},
    )  # fmt: skip


def dyad(a, b, left, right):
    """Return the point at given distances from two points, to the left of a -> b (law of cosines)."""
    d = b - a
    x = (abs(d) ** 2 + left**2 - right**2) / (2 * abs(d))
    return a + d / abs(d) * (x + 1j * np.sqrt(left**2 - x**2))


CRANK = 30.0 * np.exp(1j * np.radians(np.linspace(60.0, 420.0, 37)))
MOTOR = Input("motor", ANGLE, (0,), (1, 0), law=ramp(0.0, 6.0))


def four_bar(**more):
    b = dyad(CRANK, 100.0 + 0 * CRANK, 80.0, 70.0)
    poses = np.column_stack([0 * b, CRANK, b, 0 * b + 100.0])
    links = [("ground", (0, 3)), ("crank", (0, 1)), ("coupler", (1, 2)), ("rocker", (3, 2))]
    found = mechanism("OABC", poses[0], links, (), [MOTOR], [("P", 2, 45 + 35j)], **more)
    return found, poses, {"P": CRANK + (b - CRANK) / 80.0 * (45 + 35j), "B": b}


def moves(*steps):
    return [DrawnMove(node, about, f"{node} about {about}") for node, about in steps]


def floating_four_bar():
    return four_bar(floating=True)


def slider_crank():
    b = CRANK.real + np.sqrt(90.0**2 - (CRANK.imag - 8.0) ** 2) + 8.0j
    poses = np.column_stack([0 * b, CRANK, b, 0 * b + 200.0])
    links = [("ground", (0, 3)), ("crank", (0, 1)), ("rod", (1, 2))]
    return mechanism("OABG", poses[0], links, [("s", "s", 2, 0, 8j, 1 + 0j)], [MOTOR]), poses, {"B": b}


def inverted_slider():
    foot = 0 * CRANK - 70j
    tip = foot + 120.0 * (CRANK - foot) / abs(CRANK - foot)
    poses = np.column_stack([0 * CRANK, CRANK, foot, tip])
    links = [("ground", (0, 2)), ("crank", (0, 1)), ("rocker", (2, 3))]
    return mechanism("OACD", poses[0], links, [("s", "s", 1, 2, 0j, 1 + 0j)], [MOTOR]), poses, {"D": tip}


def offset_inverted_slider():
    found, poses, curves = inverted_slider()
    u = (poses[:, 3] - poses[:, 2]) / 120.0
    poses = poses + np.column_stack([0 * u, 0 * u, -10j * u, -10j * u])
    links = [(m.name, m.nodes) for m in found.members]
    return mechanism("OACD", poses[0], links, [("s", "s", 1, 2, 10j, 1 + 0j)], [MOTOR]), poses, curves


def jack():
    turn = np.exp(1j * np.radians(np.linspace(20.0, 70.0, 9)))
    poses = np.column_stack([0 * turn, 0 * turn + 60 - 20j, 80 * turn, 150 * turn * (1 + 0.1j), 50j * turn])
    drive = Input("jack", SPAN, (1, 2), law=ramp(1.0, 2.0), drawn=1.0)
    return mechanism("PUQRS", poses[0], [("ground", (0, 1)), ("boom", (0, 2, 3, 4))], (), [drive]), poses, {}


def press():
    p = 30 + 1j * np.linspace(40.0, 60.0, 9)
    poses = np.column_stack([0 * p, dyad(0 * p, p, 30.0, 45.0), p, p + 20j])
    links = [("ground", (0,)), ("crank", (0, 1)), ("rod", (1, 2)), ("ram", (2, 3))]
    slides = [("r.P", "r", 2, 0, 30 + 0j, 1j), ("r.Q", "r", 3, 0, 30 + 0j, 1j)]
    drive = Input("lift", HEIGHT, (2,), (0,), normal=1j, law=ramp(0.0, 1.0))
    return mechanism("OAPQ", poses[0], links, slides, [drive], length_unit="unit"), poses, {}


def beam():
    b = dyad(CRANK, 100.0 + 0 * CRANK, 80.0, 70.0)
    poses = np.column_stack([0 * b, CRANK, b, 0 * b + 100.0, CRANK + 1.6 * (b - CRANK)])
    links = [("ground", (0, 3)), ("crank", (0, 1)), ("coupler", (1, 2, 4)), ("rocker", (3, 2))]
    return mechanism("OABCD", poses[0], links), poses, {"D": poses[:, 4]}


KINDS = [
    four_bar, floating_four_bar, slider_crank, inverted_slider, offset_inverted_slider, jack, press, beam,
]  # fmt: skip


def table(**columns):
    return Table(tuple(Column(name, np.asarray(values)) for name, values in columns.items()))


def rows_of(path):
    with Path(path).open(newline="", encoding="utf-8") as handle:
        return list(csv.reader(handle))


def left_in(folder):
    return sorted(path.name for path in folder.iterdir())


# ---------------------------------------------------------------- tables


def test_floats_are_read_back_without_loss(tmp_path):
    random = np.random.default_rng(1).integers(0, 2**64, 2000, dtype=np.uint64).view(np.float64)
    special = [0.1, 1e-300, -0.0, 5e-324, 1.7976931348623157e308, np.inf, -np.inf, 1e22, 1 / 3, 123456789.0]
    values = np.concatenate([special, random[~np.isnan(random)]])
    write_csv(table(x=values, y=-values), tmp_path / "t.csv")
    read = np.array(rows_of(tmp_path / "t.csv")[1:], dtype=float)
    assert read[:, 0].tobytes() == values.tobytes()
    assert read[:, 1].tobytes() == (-values).tobytes()


def test_nan_is_an_empty_cell(tmp_path):
    write_csv(table(step=[0, 1, 2], x=[1.5, np.nan, 2.5], status=["ok", "no", "ok"]), tmp_path / "t.csv")
    text = (tmp_path / "t.csv").read_text()
    assert text == "step,x,status\n0,1.5,ok\n1,,no\n2,2.5,ok\n"


def test_a_single_column_keeps_its_empty_rows(tmp_path):
    write_csv(table(x=[np.nan, 1.0]), tmp_path / "t.csv")
    assert rows_of(tmp_path / "t.csv") == [["x"], [""], ["1.0"]]


@pytest.mark.parametrize("awkward", ["a,b", 'say "hi"', "two\nlines", "old\rmac", "", "ä €", "'", " edge "])
def test_names_and_strings_are_quoted(tmp_path, awkward):
    columns = (Column(awkward, np.array([1, 2])), Column("s", np.array([awkward, "plain"])))
    write_csv(Table(columns), tmp_path / "t.csv")
    assert rows_of(tmp_path / "t.csv") == [[awkward, "s"], ["1", awkward], ["2", "plain"]]


def test_integers_stay_integers(tmp_path):
    write_csv(table(n=np.array([2**62 + 1, -3], dtype=np.int64)), tmp_path / "t.csv")
    assert rows_of(tmp_path / "t.csv")[1:] == [[str(2**62 + 1)], ["-3"]]


def test_an_empty_table_is_its_header(tmp_path):
    write_csv(table(x=np.zeros(0), y=np.zeros(0)), tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == "x,y\n"


def test_a_stream_equals_one_table(tmp_path):
    whole = table(n=np.arange(120_000), x=np.sqrt(np.arange(120_000.0)))
    write_csv(whole, tmp_path / "whole.csv")
    with CsvStream(tmp_path / "parts.csv", whole.names) as stream:
        for start in range(0, 120_000, 7001):
            cut = slice(start, start + 7001)
            stream.append(Table(tuple(Column(c.name, c.values[cut]) for c in whole.columns)))
    assert (tmp_path / "parts.csv").read_bytes() == (tmp_path / "whole.csv").read_bytes()


def test_a_stream_refuses_other_columns_and_leaves_no_file(tmp_path):
    stream = CsvStream(tmp_path / "t.csv", ["x"])
    with pytest.raises(ValueError, match="closed"):
        stream.append(table(x=[1.0]))
    with pytest.raises(ValueError, match="columns"), stream:
        stream.append(table(y=[1.0]))
    assert left_in(tmp_path) == []


# ---------------------------------------------------------------- atomic files


def write_and_fail(handle, content, fault):
    handle.write(content)
    raise fault


@pytest.mark.parametrize("fault", [ValueError, KeyboardInterrupt])
@pytest.mark.parametrize("opened", [written_text, written_bytes])
def test_after_a_failure_the_old_file_is_unchanged(tmp_path, opened, fault):
    (tmp_path / "t.csv").write_text("old")
    with pytest.raises(fault), opened(tmp_path / "t.csv") as handle:
        write_and_fail(handle, "new" if opened is written_text else b"new", fault)
    assert (tmp_path / "t.csv").read_text() == "old"
    assert left_in(tmp_path) == ["t.csv"]


def test_a_full_disk_is_an_output_error(tmp_path):
    with (
        pytest.raises(OutputError, match=r"t\.csv: cannot be written: the disk is full"),
        written_text(tmp_path / "t.csv"),
    ):
        raise OSError(28, "No space left on device")
    assert left_in(tmp_path) == []


def test_the_file_appears_only_at_the_end(tmp_path):
    with CsvStream(tmp_path / "t.csv", ["x"]) as stream:
        stream.append(table(x=[1.0]))
        assert not (tmp_path / "t.csv").exists()
    assert left_in(tmp_path) == ["t.csv"]


def test_the_folder_is_created(tmp_path):
    output.write(table(x=[1.0]), tmp_path / "a" / "b" / "t.csv")
    assert (tmp_path / "a" / "b" / "t.csv").exists()


@pytest.mark.parametrize("inner", ["", "deeper"])
def test_a_folder_that_is_a_file_is_refused(tmp_path, inner):
    (tmp_path / "file").write_text("precious")
    with pytest.raises(OutputError, match="is a file, not a folder"):
        write_csv(table(x=[1.0]), tmp_path / "file" / inner / "t.csv")
    assert (tmp_path / "file").read_text() == "precious"


def test_a_target_that_is_a_folder_or_a_device_is_refused(tmp_path):
    (tmp_path / "t.csv").mkdir()
    with pytest.raises(OutputError, match="folder has this name"):
        write_csv(table(x=[1.0]), tmp_path / "t.csv")
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(OutputError, match="regular file"):
        write_csv(table(x=[1.0]), tmp_path / "pipe.csv")
    assert left_in(tmp_path) == ["pipe.csv", "t.csv"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_an_unwritable_folder_is_an_output_error(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(OutputError, match="write permission"):
            write_csv(table(x=[1.0]), tmp_path / "t.csv")
    finally:
        tmp_path.chmod(0o700)


def test_a_refused_folder_is_an_output_error_for_root_too(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(OutputError, match=r"t\.csv: .*no permission; choose a folder"):
        write_csv(table(x=[1.0]), tmp_path / "t.csv")


@pytest.mark.parametrize("content", [table(x=[1.0]), history_picture(np.ones(3), None, "", math.nan, 0)])
def test_an_unknown_suffix_is_refused_with_the_known_ones(tmp_path, content):
    with pytest.raises(UsageError, match=r"expected one of the formats \.csv"):
        output.write(content, tmp_path / "t.bmp")


# ---------------------------------------------------------------- pictures


def size_of(path):
    data = path.read_bytes()
    assert data.startswith(b"\x89PNG")
    assert data.endswith(b"IEND\xaeB`\x82")
    return struct.unpack(">II", data[16:24])


@pytest.mark.few(10)
@pytest.mark.parametrize("suffix", [name for name, one in output.FORMATS.items() if one.content == "picture"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_motion_is_drawn(tmp_path, kind, suffix):
    found, poses, curves = kind()
    path = tmp_path / f"m{suffix}"
    output.write(motion_picture(found, poses[:: len(poses) // 5], curves, kind.__name__), path)
    assert left_in(tmp_path) == [path.name]
    if suffix == ".png":
        width, height = size_of(path)
        assert 1000 <= width < 1100
        assert 450 < height < 1350


@pytest.mark.parametrize("kind", KINDS)
def test_all_parts_of_a_drawing_are_inside_the_window(kind):
    found, poses, curves = kind()
    for picture in (
        motion_picture(found, poses, curves, ""),
        position_picture(found, poses[0], "", {"P": poses[0][1]}),
        sequence_picture(found, poses[0], {"group": moves((1, (0,)), (2, (1, 3)), (2, (0,)))}, ""),
    ):
        paths = [p for group in (*strokes(picture).values(), *areas(picture).values()) for p in group]
        z = np.concatenate([*paths, [text.at for text in picture.texts]])
        assert np.all(np.isfinite(z))
        assert z.real.min() > picture.frame.low.real
        assert z.real.max() < picture.frame.high.real
        assert z.imag.min() > picture.frame.low.imag
        assert z.imag.max() < picture.frame.high.imag


@pytest.mark.parametrize("kind", KINDS)
def test_the_axes_are_equal_and_have_the_unit(kind):
    found, poses, curves = kind()
    picture = motion_picture(found, poses, curves, "")
    span, frame = picture.frame.high - picture.frame.low, picture.frame
    assert span.real / frame.width == pytest.approx(span.imag / frame.height, rel=1e-12)
    assert picture.labels == (("x", "y") if found.length_unit == "unit" else ("x [mm]", "y [mm]"))


def test_a_sequence_has_every_number_and_none_overlaps():
    found, poses, _ = four_bar()
    steps = [
        (1, (0,)),
        (2, (3,)),
        (2, (1,)),
        (1, (2,)),
        (1, (0, 2)),
        (2, (1,)),
        (2, (3,)),
        (1, ()),
        (1, (1,)),
    ]
    picture = sequence_picture(found, poses[0], {"first": moves(*steps[:4]), "second": moves(*steps[4:])}, "")
    rings = {text.text: text.at for text in picture.texts if text.ring}
    assert sorted(rings) == [str(n) for n in range(1, 10)]
    places = np.array(list(rings.values()))
    apart = np.abs(places[:, None] - places) + np.eye(9) * 1e9
    assert apart.min() > 7.0 * picture.frame.point


@pytest.mark.parametrize("kind", KINDS)
def test_the_names_of_the_nodes_are_written(kind):
    found, poses, _ = kind()
    written = {text.text for text in position_picture(found, poses[0], "", {}).texts}
    assert written == {*found.nodes, *(point.name for point in found.points)}


def test_a_floating_mechanism_has_no_ground():
    grounds = []
    for floating in (False, True):
        found, poses, curves = four_bar(floating=floating)
        picture = motion_picture(found, poses, curves, "")
        grounds.append([pen for pen in strokes(picture) if pen == HATCH])
    assert len(grounds[0]) == 1
    assert grounds[1] == []


def test_points_move_with_their_member():
    found, poses, curves = four_bar()
    scene = Scene(found, poses)
    np.testing.assert_allclose(scene.place(scene.tracers["P"], poses), curves["P"], atol=1e-12)


def test_poses_with_a_nan_are_skipped(tmp_path):
    found, poses, curves = four_bar()
    gap = poses.copy()
    gap[0, 1] = np.nan
    assert np.array_equal(
        marks(motion_picture(found, gap[:3], curves, "")).keys(),
        marks(motion_picture(found, poses[1:3], curves, "")).keys(),
    )
    empty = {name: np.full(5, np.nan + 0j) for name in curves}
    output.write(motion_picture(found, np.full_like(poses, np.nan), empty, "nothing was solved"), tmp_path / "m.png")
    output.write(position_picture(found, np.full_like(poses[0], np.nan), "nothing was solved", {}), tmp_path / "p.png")
    assert size_of(tmp_path / "m.png") > (100, 100)


def test_texts_with_special_characters_and_many_curves_are_drawn(tmp_path):
    found, poses, curves = four_bar()
    many = {f"$\\frac{n} _^ 点": curves["P"] + n for n in range(40)}
    output.write(motion_picture(found, poses[:2], many, "100 % $x^ of a very long title " * 8), tmp_path / "m.png")
    assert max(size_of(tmp_path / "m.png")) < 1800


@pytest.mark.parametrize("shift", [0.0, 1e6 + 1e6j])
@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_mechanisms_of_any_size_and_position_are_drawn(tmp_path, size, shift):
    curve = (CRANK + shift) * size
    found, poses, _ = four_bar()
    bare = mechanism("OABC", poses[0], [(m.name, m.nodes) for m in found.members])
    output.write(motion_picture(bare, (poses[:3] + shift) * size, {"c": curve}, ""), tmp_path / "m.png")
    assert size_of(tmp_path / "m.png") > (100, 100)


def test_a_vector_picture_is_the_same_twice(tmp_path):
    found, poses, curves = four_bar()
    for suffix in (".svg", ".pdf"):
        for name in "ab":
            output.write(motion_picture(found, poses[:3], curves, "twice"), tmp_path / (name + suffix))
        assert (tmp_path / f"a{suffix}").read_bytes() == (tmp_path / f"b{suffix}").read_bytes()


def test_a_history_is_drawn(tmp_path):
    sweeps = np.arange(30)
    errors = 2.0 * 0.6**sweeps
    fit = (2.0, -math.log(0.6))
    output.write(history_picture(errors, fit, "history", 0.6, 0), tmp_path / "h.png")
    assert size_of(tmp_path / "h.png") > (100, 100)
    picture = history_picture(errors, fit, "", 0.6, 0)
    for lines in strokes(picture).values():  # fit and prediction pass through the errors
        np.testing.assert_allclose(np.interp(sweeps, lines[0].real, lines[0].imag), np.log10(errors))


@pytest.mark.parametrize("errors", [[], [0.0, 0.0], [np.nan], [1e-3], [1e-320, 1e300]])
def test_a_history_without_numbers_is_drawn(tmp_path, errors):
    fit = (math.nan, math.nan)
    output.write(history_picture(np.array(errors), fit, "history", math.nan, 0), tmp_path / "h.png")
    assert size_of(tmp_path / "h.png") > (100, 100)


def test_the_target_of_a_link_is_written_and_the_link_stays(tmp_path):
    (tmp_path / "there").mkdir()
    link = tmp_path / "link.csv"
    link.symlink_to(tmp_path / "there" / "table.csv")
    write_csv(Table((Column("x", np.array([1.5])),)), link)
    assert link.is_symlink()
    assert (tmp_path / "there" / "table.csv").read_text() == "x\n1.5\n"


def test_a_very_long_title_is_cut():
    lines = title_lines("word " * 2000, 6.0)
    assert len(lines) == 4
    assert lines[-1].endswith(" …")


# ---------------------------------------------------------------- curves and hulls


def test_a_long_curve_gets_fewer_points_and_keeps_its_shape():
    t = np.linspace(0.0, 20.0 * np.pi, 200_001)
    circle = np.exp(1j * t)
    circle[100_000:100_010] = np.nan
    thin = thinned(circle, 0.01)
    assert len(thin) < 20_000
    assert np.isnan(thin).any()
    kept = thin[np.isfinite(thin)]
    assert np.max(np.abs(np.diff(kept))) < 0.03
    assert {thin[0], thin[-1]} == {circle[0], circle[-1]}


def test_the_curves_of_a_legend_differ_without_their_colours():
    pens = [curve_pen(index) for index in range(MOST_KEYS)]
    assert len({(pen.width, pen.dash) for pen in pens}) == MOST_KEYS


def test_a_curve_is_cut_at_gaps_and_a_retraced_arc_is_drawn_once():
    arc = np.exp(1j * 0.5 * np.sin(np.linspace(0.0, 2 * np.pi, 361)))
    (run,) = drawn_runs(arc, 0.003)
    assert [run.imag.min(), run.imag.max()] == [arc.imag.min(), arc.imag.max()]
    ellipse = np.array([3 * z.real + 1j * z.imag for z in np.exp(1j * np.linspace(0, 2 * np.pi, 361))])
    assert len(drawn_runs(ellipse, 0.003)[0]) == 361
    ellipse[100] = np.nan
    assert [len(run) for run in drawn_runs(ellipse, 0.003)] == [100, 260]


def test_a_hull_is_convex_and_that_of_a_line_has_two_points():
    square = np.array([0, 2, 2 + 2j, 2j, 1 + 1j, 1], dtype=complex)
    assert set(convex_hull(square, FLAT)) == {0, 1, 2, 3}
    assert set(convex_hull(np.array([1 + 1j, 0, 3 + 3j, 2 + 2j]), FLAT)) == {1, 2}
    assert len(convex_hull(np.array([1j, 1j]), FLAT)) == 2


# ---------------------------------------------------------------- cost


def test_importing_the_package_imports_no_matplotlib():
    code = "import sys, gimcli.output; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_drawing_imports_no_pyplot(tmp_path):
    code = (
        "import sys, numpy; from gimcli import output; from gimcli.output.drawing import history_picture;"
        f"output.write(history_picture(numpy.ones(3), None, 't', 0.5, 0), {str(tmp_path / 'h.png')!r});"
        "sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
