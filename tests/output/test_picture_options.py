"""Options of pictures: size, resolution, title, light poses and style have their effect in every kind of picture."""

from __future__ import annotations

import numpy as np
import pytest
from bundled import MODELS
from drawn_styles import marks, strokes
from in_process import gim
from matplotlib.image import imread

import gimcli
from gimcli import UsageError
from gimcli.output.figure import figure_of
from gimcli.output.picture import GHOSTS, LAYOUT, Frame, PictureLayout
from gimcli.output.printed import PictureOptions, read_look, settings_of
from gimcli.output.style import GHOST, INK, PALETTE, PAPER

STYLE = (
    "axes.prop_cycle: cycler('color', ['00ffff', 'ff00ff'])\nlines.linewidth: 3\nfont.size: 12\ntext.color: 000080\n"
)


@pytest.fixture(scope="module")
def motion():
    return gimcli.trace(gimcli.load(MODELS / "crank_rocker.yaml"), 12, plot="omega", derivatives=1)


@pytest.fixture(scope="module")
def results(motion):
    """One result for each kind of picture."""

    def load(name):
        return gimcli.load(MODELS / f"{name}.yaml")

    return [
        motion, gimcli.trace(load("jansen"), 12), gimcli.solve(load("crank_rocker"), velocities=True),
        gimcli.configurations(load("crank_rocker")), gimcli.groups(load("jansen")), gimcli.sequence(load("jansen")),
        gimcli.forces(load("watt_1"), 6), gimcli.singularities(load("crank_rocker")),
        gimcli.workspace(load("chebyshev")),
        gimcli.circuits(load("crank_rocker"), values=8),
    ]  # fmt: skip


def pixels(path):
    height, width, _ = imread(path).shape
    return width, height


def test_a_picture_has_the_size_and_resolution_that_are_requested(motion, tmp_path):
    motion.save(tmp_path / "a.png", size="127x88.9mm", dpi=100)
    assert pixels(tmp_path / "a.png") == (500, 350)
    motion.save(tmp_path / "b.png", size="5x3.5in", dpi=40)
    assert pixels(tmp_path / "b.png") == (200, 140)
    motion.save(tmp_path / "c.svg", size="10x8cm")
    assert 'width="283.464567pt" height="226.771654pt"' in (tmp_path / "c.svg").read_text(encoding="utf-8")


def test_a_usual_picture_is_fine_enough_to_be_printed(motion, tmp_path):
    motion.save(tmp_path / "a.png")
    assert pixels(tmp_path / "a.png")[0] >= 1000


def test_every_kind_of_picture_fills_its_size(results):
    """The axes touch no border, do not overlap, and scales stay equal."""
    options = PictureOptions.checked("150x130mm")
    for found in results:
        printed = options.printed(found.picture())
        figure = figure_of(printed)
        assert tuple(figure.get_size_inches()) == pytest.approx(options.size)
        boxes = [axes.get_position() for axes in figure.axes]
        for box in boxes:
            assert 0.0 < box.x0 < box.x1 < 1.0
            assert 0.0 < box.y0 < box.y1 < 1.0
        apart = [a.y0 >= b.y1 or b.y0 >= a.y1 or a.x0 >= b.x1 or b.x0 >= a.x1 for a in boxes for b in boxes if a != b]
        assert all(apart)
        content = printed.content
        for picture in getattr(content, "pictures", getattr(content, "panels", (content,))):
            if picture.again is not None and not picture.bare:
                span, frame = picture.frame.high - picture.frame.low, picture.frame
                assert span.real / frame.width == pytest.approx(span.imag / frame.height)


def test_the_title_is_replaced_or_left_out(results):
    for found in results:
        content = PictureOptions.checked(title="My title").printed(found.picture()).content
        assert content.title == "My title"
        below = [] if getattr(content, "columns", 0) else [one for one in content.pictures if one is not content]
        assert all(picture.title == "" for picture in below)
    for found in (results[0], results[3]):
        printed = PictureOptions.checked(title="").printed(found.picture())
        texts = [text.get_text() for text in figure_of(printed).texts]
        assert found.mechanism.name not in " ".join(texts)


def test_the_number_of_light_poses(motion):
    def light(picture):
        return sum(len(paths) for pen, paths in strokes(picture).items() if pen == GHOST)

    usual = motion.picture().pictures[0]
    counts = [
        light(PictureOptions.checked(ghosts=n).printed(motion.picture()).content.pictures[0])
        for n in (1, GHOSTS, 7, "none")
    ]
    assert counts == [light(usual) // GHOSTS, light(usual), 7 * light(usual) // GHOSTS, 0]


def test_light_poses_of_chosen_members(motion):
    def ghosts(option):
        drawing = PictureOptions.checked(ghosts=option).printed(motion.picture()).content.pictures[0]
        return [path for pen, paths in strokes(drawing).items() if pen == GHOST for path in paths]

    chosen = ghosts("5:rocker")
    assert len(chosen) == 5
    ends = motion.mechanism.members[[m.name for m in motion.mechanism.members].index("rocker")].nodes
    pivot = next(n for n in ends if n in motion.mechanism.members[0].nodes)
    at = motion.mechanism.to_file(motion.mechanism.drawn)[pivot]
    assert all(np.min(np.abs(path - at)) < 1e-9 for path in chosen)
    with pytest.raises(UsageError):
        ghosts("2:rod")


def test_a_style_file_has_effect(motion, tmp_path):
    path = tmp_path / "my.mplstyle"
    path.write_text(STYLE, encoding="utf-8")
    options = PictureOptions.checked(style=str(path))
    plain, styled = (o.printed(motion.picture()).content.pictures[0] for o in (PictureOptions(), options))
    widths = {pen.color: pen.width for pen in strokes(plain)}
    found = {pen.color: pen.width for pen in strokes(styled)}
    assert PALETTE[0] in widths
    assert PALETTE[0] not in found
    assert found["#00ffff"] == 2 * widths[PALETTE[0]]
    assert {INK, "#000080"} & set(found) == {"#000080"}
    assert {text.color for text in styled.texts} == {"#000080"}
    assert styled.frame.font == 1.5
    assert settings_of(options.look)["axes.labelsize"] == 13.5


def test_a_dark_style_exchanges_black_and_white(motion):
    styled = PictureOptions.checked(style="dark_background").printed(motion.picture()).content.pictures[0]
    faces = {mark.face for mark in marks(styled)}
    assert "#000000" in faces
    assert PAPER not in faces
    assert "#ffffff" in {pen.color for pen in strokes(styled)}


def test_the_size_and_the_resolution_of_a_style_are_used_without_options(motion, tmp_path):
    path = tmp_path / "my.mplstyle"
    path.write_text("figure.figsize: 5, 4\nsavefig.dpi: 60\n", encoding="utf-8")
    motion.save(tmp_path / "a.png", style=path)
    assert pixels(tmp_path / "a.png") == (300, 240)
    motion.save(tmp_path / "b.png", style=path, dpi=100)
    assert pixels(tmp_path / "b.png") == (500, 400)


@pytest.mark.parametrize("name", ["bad key: 1", "font.size: large", "font.size 3", "\0"])
def test_a_style_file_with_errors_is_refused_with_its_line(tmp_path, name):
    path = tmp_path / "my.mplstyle"
    path.write_text(f"font.size: 9\n\n{name}", encoding="utf-8")
    with pytest.raises(UsageError):
        read_look(str(path))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (["--size", "160"], "size: expected width x height"), (["--size", "160x90"], "size: expected width x height"),
        (["--size", "5x5mm"], "size: expected sides from"), (["--size", "30x26mm"], "leaves no space for the axes"),
        (["--dpi", "5"], "dpi: expected a number from 20"), (["--ghosts", "few"], "ghosts: expected a number"),
        (["--style", "grayscal"], "did you mean 'grayscale'"), (["--dpi", "2400", "--size", "40x40in"], "pixels"),
        (["--style", "https://example.org/a.mplstyle"], "no file or matplotlib style"),
    ],
)  # fmt: skip
def test_wrong_options_are_refused(options, text, tmp_path):
    done = gim("trace", MODELS / "crank_rocker.yaml", "-n", "4", "-o", tmp_path / "a.png", *options)
    assert done.code == 2
    assert text in done.error
    assert not list(tmp_path.iterdir())


def test_commands_that_only_print_without_a_file_take_the_options(tmp_path):
    cases = [("solve", "crank_rocker"), ("groups", "crank_rocker")]
    for command, model in cases:
        path = tmp_path / f"{command}.png"
        assert (
            gim(command, MODELS / f"{model}.yaml", "-o", path, "--size", "4x4in", "--dpi", "50", "--title", "").code
            == 0
        )
        assert pixels(path) == (200, 200)


def test_a_window_that_fills_its_size_contains_the_points():
    points = np.array([0.0, 3.0 + 1.0j])
    for layout in (LAYOUT, PictureLayout(2.0, 5.0, fills=True), PictureLayout(5.0, 1.0, fills=True)):
        frame = Frame.around(points, layout)
        assert frame.low.real < 0.0 < 3.0 < frame.high.real
        assert frame.low.imag < 0.0 < 1.0 < frame.high.imag
        span = frame.high - frame.low
        assert span.real / frame.width == pytest.approx(span.imag / frame.height)
        assert not layout.fills or (frame.width, frame.height) == (layout.width, layout.height)
