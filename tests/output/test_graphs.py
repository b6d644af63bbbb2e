"""Pictures of graphs: units of the axes, spikes, limits, lines in grey, polar diagrams."""

import itertools

import numpy as np
import pytest
from bundled import MODELS
from canvases import canvas_of
from drawn_styles import strokes
from in_process import gim

import gimcli
from gimcli.output.axis import fitted, short, tick_texts, value_window
from gimcli.output.graph import EQUAL, POLAR, Axis, Curve, CurveGraph
from gimcli.output.panels import panel
from gimcli.output.picture import Frame, Picture
from gimcli.output.style import CUT, VERTICAL, curve_pen


def axes_of(content):
    """Return the axes of a content as they are drawn."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = canvas_of(FigureCanvasAgg, content)
    canvas.draw()
    return canvas.figure.axes


def graph(y, unit="", name="q", over=None):
    x = np.linspace(0.0, 1.0, len(y)) if over is None else over
    return CurveGraph(Axis("time", "s"), Axis(name, unit), [Curve("a", x, y)])


# --- units of the axes -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("label", "largest", "fitting", "factor"),
    [
        ("f [N]", 9999.0, "f [N]", 1.0), ("f [N]", 1e4, "f [kN]", 1e-3), ("t [N m]", 3e6, "t [MN m]", 1e-6),
        ("p [W]", 2e-5, "p [µW]", 1e6), ("e [J]", 5e9, "e [GJ]", 1e-9), ("x [mm]", 2e4, "x [m]", 1e-3),
        ("a [mm/s^2]", 5e5, "a [m/s^2]", 1e-3), ("x [m]", 2e-3, "x [mm]", 1e3), ("x [cm]", 2e4, "x [10³ cm]", 1e-3),
        ("w [deg/s]", 2e5, "w [10³ deg/s]", 1e-3), ("k [1/mm]", 3e-7, "k [10⁻⁹ 1/mm]", 1e9),
        ("x", 1e7, "x [10⁶]", 1e-6),
        ("f [N]", 1e20, "f [10¹⁸ N]", 1e-18), ("a [b] [N]", 2e4, "a [b] [kN]", 1e-3), ("f [N]", 0.0, "f [N]", 1.0),
    ],
)  # fmt: skip
def test_an_axis_has_a_unit_that_fits(label, largest, fitting, factor):
    assert fitted(label, largest) == (fitting, pytest.approx(factor))


def test_short_numbers_have_three_digits():
    assert [short(v) for v in (181234.0, -2.5e-7, 12.0, 0.0)] == ["1.81e5", "-2.5e-7", "12", "0"]


def test_numbers_at_ticks_have_the_digits_that_their_steps_need():
    assert tick_texts(np.array([0.0, 0.25, 0.5])) == ["0.00", "0.25", "0.50"]
    assert tick_texts(np.array([-1000.0, 0.0, 1000.0])) == ["−1000", "0", "1000"]
    assert tick_texts(np.array([1e6, 1e6 + 0.1, 1e6 + 0.2])) == ["1000000.0", "1000000.1", "1000000.2"]


@pytest.mark.parametrize(("scale", "shift"), [(1e7, 0.0), (1e-9, 0.0), (1.0, 1e6), (1e-3, 1234.0)])
def test_no_number_stands_apart_from_its_axis(scale, shift):
    """The texts at the ticks, times the power of ten in the label, are the places of the ticks."""
    y = shift + scale * np.sin(np.linspace(0.0, 6.0, 50))
    for content in (panel(graph(y, "deg/s"), 5.0), drawing_of(y)):
        (axes,) = axes_of(content)
        for axis, ends in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            assert axis.get_offset_text().get_text() == ""
            _, factor = fitted("x [deg/s]", max(map(abs, ends)))
            texts = [float(t.get_text().replace("−", "-")) for t in axis.get_ticklabels()]
            places = axis.get_majorticklocs()
            assert len(places) >= 3
            np.testing.assert_allclose(texts, places * factor, atol=1e-3 * np.ptp(places) * factor)
            assert "10" in axis.get_label_text() or factor == 1.0


def drawing_of(y):
    z = y + 1j * y
    picture = Picture("", Frame.around(z), ("x [deg/s]", "y [deg/s]"))
    picture.draw(curve_pen(0), z)
    return picture


def test_angles_have_ticks_at_parts_of_a_turn():
    (axes,) = axes_of(panel(graph(np.linspace(-180.0, 180.0, 30), "deg"), 5.0))
    assert {int(v) for v in axes.yaxis.get_majorticklocs()} >= {-180, -90, 0, 90, 180}


# --- spikes and limits -----------------------------------------------------------------------------------------


def test_a_spike_at_a_limit_does_not_determine_the_axis():
    """An acceleration grows as s^(-3/2) towards a limit (of the input, at distance s)."""
    s = np.linspace(1.0, -0.2, 600)
    with np.errstate(invalid="ignore"):
        y = np.where(s > 0.0, np.abs(s) ** -1.5, np.nan)
    low, high = value_window([y])
    assert (low, high) == (pytest.approx(1.0, rel=0.2), pytest.approx(31.6 * 1.4, rel=0.1)), "s > 0.1, and a margin"
    picture = panel(graph(y), 5.0)
    assert picture.frame.high.imag < 60.0
    assert [name for name, key in picture.legend if key == CUT] == [f"cut at a pole: a up to {short(np.nanmax(y))}"]
    assert [word for _, word in picture.above] == ["pole"]


def test_a_peak_of_several_rows_determines_the_axis():
    """The working stroke of a press is short; drives are chosen by its torque."""
    x = np.linspace(0.0, 1.0, 361)
    stroke = np.where(np.abs(x - 0.4) < 0.008, 900.0, np.sin(9.0 * x))
    assert value_window([stroke])[1] == 900.0
    bell = np.exp(-(((x - 0.5) / 0.01) ** 2))
    assert value_window([bell])[1] == pytest.approx(1.0)


def test_a_pole_between_two_rows_is_recognised():
    x = np.linspace(-1.0, 1.0, 400)
    for y in (1.0 / x, 1.0 / np.abs(x - 1e-4), np.where(np.abs(x) < 0.004, np.inf, 1.0 / np.abs(x))):
        assert value_window([y])[1] < 20.0


DISTANCE = np.arange(200.0, 0.0, -1.0) / 200.0


@pytest.mark.parametrize("y", [
    211.0 + 1039.0 * np.exp(-40.0 * DISTANCE),  # a force that grows to 1250 N at a limit
    np.exp(-(((DISTANCE - 0.05) / 0.01) ** 2)),  # a peak a few rows before it
    1.0 - 3.0 * np.sqrt(DISTANCE), DISTANCE**0.5,  # a position
    np.where(DISTANCE < 0.3, 900.0, np.sin(9.0 * DISTANCE)), np.where(np.arange(200) == 198, 7.0, 0.0),
])  # fmt: skip
def test_a_finite_peak_at_a_limit_is_shown_whole(y):
    for values in (y, -y):
        assert value_window([values], [np.array([200.0])]) == (values.min(), values.max())
        assert value_window([np.append(values, np.nan)]) == (values.min(), values.max())


@pytest.mark.parametrize("width", [0.3, 1.0, 3.0])
def test_a_narrow_finite_peak_is_shown_whole(width):
    """A force that passes a singular position at a distance: x / (x^2 + e^2), its magnitude and its square."""
    x = np.arange(-100.0, 101.0) / width
    for y in (1.0 / (x**2 + 1.0), (x / (x**2 + 1.0)), 1.0 / np.sqrt(x**2 + 1.0), np.exp(-(x**2))):
        assert value_window([y]) == (y.min(), y.max())


@pytest.mark.parametrize("power", [-0.5, -1.0, -1.5, -3.0])
@pytest.mark.parametrize("background", [0.0, 1.0])
def test_a_pole_at_a_limit_is_cut_wherever_the_rows_are(power, background):
    for beside in (0.01, 0.3, 1.0):
        y = background * np.cos(3.0 * DISTANCE) + (DISTANCE - (1.0 - beside) / 200.0) ** power
        assert value_window([y], [np.array([199.0 + beside])])[1] < (0.5 if beside < 0.5 else 1.0001) * y.max()


def test_a_pole_of_one_curve_hides_no_peak_of_another():
    peak = 40.0 * np.exp(-(((DISTANCE - 0.5) / 0.01) ** 2))
    assert value_window([1.0 / DISTANCE, peak], [np.array([200.0])] * 2)[1] >= peak.max()


@pytest.mark.few(5)
@pytest.mark.parametrize("span", [0.11, 1.0, 7.9, 11.0, 27.0, 95.0, 359.0])
@pytest.mark.parametrize("unit", ["deg", "N"])
def test_an_axis_has_three_ticks_and_zero(span, unit):
    for low in (-0.37 * span, -0.9 * span, 3.0 * span):
        (axes,) = axes_of(panel(graph(low + span * np.linspace(0.0, 1.0, 30), unit), 5.0))
        places = axes.yaxis.get_majorticklocs()
        assert len(places) >= 3
        assert low > 0.0 or np.min(np.abs(places)) < 1e-12 * span


def test_a_constant_with_noise_shows_all_values():
    noise = 360.0 * (1.0 + 1e-15 * np.sin(np.arange(50.0) ** 2))
    assert value_window([noise]) == (noise.min(), noise.max())
    with_pulse = np.where(np.arange(50) == 20, 5.0, 1e-14 * np.sin(np.arange(50.0) ** 2))
    assert value_window([with_pulse])[1] == 5.0
    assert value_window([]) == value_window([np.full(5, np.nan)]) == (0.0, 1.0)


def test_the_axis_ends_at_the_limit_of_a_law_and_marks_it():
    """A four-bar whose input turns from 60 to 330 deg: law of cosines, coupler and rocker are in line at the limit."""
    m = gimcli.load(
        {
            "nodes": {"A": [0, 0], "B": [2, 3.46], "C": [3.2, 4.3], "D": [4, 0]}, "ground": ["A", "D"],
            "links": {"a": {"nodes": ["A", "B"], "length": 4}, "b": {"nodes": ["B", "C"], "length": 1.5},
                      "c": {"nodes": ["D", "C"], "length": 4}},
            "actuators": {"m": {"type": "rotary", "pivot": "A", "arm": "B", "law": {"from": 60, "to": 330}}},
            "trace": ["C"],
        }
    )  # fmt: skip
    limit = np.degrees(np.arccos((4**2 + 4**2 - 5.5**2) / (2 * 4 * 4)))  # AC = 1.5 + 4 at the limit
    found = gimcli.trace(m, 300, plot="c.alpha,C.y/C.x,c.omega/time")
    assert not found.complete
    alpha, path, over_time = found.picture().pictures[1:]
    assert alpha.frame.low.real == pytest.approx(60.0)
    assert alpha.frame.high.real == pytest.approx(limit, abs=1e-6)
    ((place, word),) = alpha.above
    assert (word, place) == ("limit", pytest.approx(limit, abs=1e-6))
    assert len(strokes(alpha)[VERTICAL]) == 1
    assert over_time.frame.high.real == pytest.approx((limit - 60.0) / 270.0, abs=1e-8)
    assert path.above == []
    values = found["c.alpha"][np.isfinite(found["c.alpha"])]
    assert alpha.frame.high.imag - alpha.frame.low.imag < 0.2 * np.ptp(values)


def test_the_words_above_an_axis_stay_inside_and_apart():
    one = CurveGraph(Axis("q"), Axis("y"), [Curve("a", np.arange(9.0), np.arange(9.0))],
                verticals=[(0.0, "change point"), (0.1, "change point"), (8.0, "limit")])  # fmt: skip
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = canvas_of(FigureCanvasAgg, panel(one, 5.0))
    canvas.draw()
    words = [t for t in canvas.figure.axes[0].texts if t.get_text()]
    assert [t.get_text() for t in words] == ["change point", "limit"]
    for text in words:
        box = text.get_window_extent(canvas.get_renderer())
        assert canvas.figure.bbox.x0 < box.x0 < box.x1 < canvas.figure.bbox.x1
        assert box.y1 <= canvas.figure.bbox.y1


# --- lines -----------------------------------------------------------------------------------------------------


def lightness(color):
    """CIE L* of a colour, which grey prints show."""
    from matplotlib.colors import to_rgb

    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(color)]
    y = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
    return 116.0 * y ** (1.0 / 3.0) - 16.0


def test_ten_lines_are_distinguished_in_grey():
    """Two lines differ in dash, or at least 1.8 times in width and by 8 in lightness; none is too light for paper."""
    pens = [curve_pen(index) for index in range(10)]
    for one, other in itertools.combinations(pens, 2):
        widths = sorted((one.width, other.width))
        grey = abs(lightness(one.color) - lightness(other.color))
        assert one.dash != other.dash or (widths[1] >= 1.8 * widths[0] and grey >= 8.0), (one, other)
    assert max(lightness(pen.color) for pen in pens) < 70.0


def test_many_curves_are_counted_and_can_be_named():
    x = np.arange(5.0)
    many = CurveGraph(Axis("q"), Axis("y"), [Curve(f"c{k}", x, k * x) for k in range(20)])
    assert panel(many, 5.0).legend[-1][0] == "and 8 more: name the columns"


def test_a_single_curve_has_its_name_on_the_axis_and_no_legend():
    picture = panel(graph(np.arange(5.0), "mm/s", "velocity |v|"), 5.0)
    assert picture.labels[1] == "velocity |v| of a [mm/s]"
    assert picture.legend == []


# --- polar diagrams, hodographs, dynamics ------------------------------------------------------------------------


def test_a_polar_diagram_has_the_magnitude_as_radius():
    angle = np.linspace(0.0, 2.0 * np.pi, 73)
    one = CurveGraph(Axis("crank"), Axis("|a|", "N"), [Curve("|a|", angle, -3.0 * np.ones(73))], POLAR)
    picture = panel(one, 5.0)
    (curve,) = strokes(picture)[curve_pen(0)]
    np.testing.assert_allclose(curve, 3.0 * np.exp(1j * angle))
    assert picture.bare
    assert "|a| [N] over crank" in picture.title
    assert {"0°", "90°", "3"} <= {text.text for text in picture.texts}
    frame = picture.frame
    assert (frame.high.real - frame.low.real) / frame.width == pytest.approx(
        (frame.high.imag - frame.low.imag) / frame.height
    )


def test_the_hodograph_of_the_shaking_force_is_drawn_when_asked_for():
    """A mechanism without inertia: a load of 7 N at the end of an arm of 1 m needs up to 7 N m."""
    data = {
        "units": {"length": "m"},
        "nodes": {"O": [0, 0], "A": [1, 0]}, "ground": ["O"], "links": {"crank": ["O", "A"]},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
        "loads": {"pull": {"on": "crank", "at": [1, 0], "force": [0, -7]}},
    }  # fmt: skip
    (torque,) = gimcli.forces(gimcli.load(data), 36).graphs()
    assert (torque.up.name, max(torque.curves[0].y)) == ("driving torque", pytest.approx(7.0))
    (asked,) = gimcli.forces(gimcli.load(data), 36, plot="hodograph:shaking").graphs()
    assert asked.form == EQUAL


def test_events_of_a_simulation_are_in_the_legend(tmp_path):
    s = gimcli.simulate(gimcli.load(MODELS / "watt_durango.yaml"), 2.0)
    _, angle, speed, energy = s.picture().pictures
    for picture in (angle, speed):
        assert [name for name, _ in picture.legend] == ["standstill"]
    assert [name for name, _ in energy.legend] == ["kinetic", "potential", "total"]
    assert angle.labels == ("time [s]", "crank_angle [deg]")
    assert speed.labels[1] == "speed of crank_angle [deg/s]"
    gim("simulate", MODELS / "watt_durango.yaml", "--time", "0.1", "-o", tmp_path / "s.svg")
    assert "crank_angle [deg]" in (tmp_path / "s.svg").read_text()
