"""Graphs of --plot: the text, the columns that it names, and their values."""

import numpy as np
import pytest
import yaml
from bundled import MODELS
from in_process import gim, refused

import gimcli
from gimcli import UsageError
from gimcli.graphs.plots import graphs_of
from gimcli.language.expression import PartKind
from gimcli.language.reader import longest
from gimcli.output.graph import EQUAL, ORDINARY, POLAR

FOUR_BAR = MODELS / "crank_rocker.yaml"


class Known:
    """Names of a made-up command; those that end in .v are vectors."""

    def __init__(self, *names):
        self.names = names

    def longest(self, text):
        return longest(text, self.names.__contains__)

    def kind(self, name):
        return PartKind("rows", "mm", 2 if name.endswith(".v") else 1)

    def code(self, name):
        return (name,)

    def unknown(self, name, rest):
        return UsageError(f"no '{name}' in '{rest}'")

    def across(self):
        return "time", "s"


def read(text, *more):
    """Return form and curves of each graph: the texts of a quantity, and of that below it."""
    graphs = graphs_of(text, Known("P.x", "P.y", "P.v", "crank.angle", *more))
    return [(g.form, [(c.y.text, c.x and c.x.text) for c in g.curves]) for g in graphs]


# --- the text ------------------------------------------------------------------------------------------------


def test_graphs_curves_and_abscissae_are_separated_by_signs():
    assert read("P.x") == [("", [("P.x", None)])]
    assert read("P.x+P.y,P.v") == [("", [("P.x", None), ("P.y", None)]), ("", [("P.v", None)])]
    assert read("P.y/P.x") == [("", [("P.y", "P.x")])]
    assert read(" P.x + P.y , P.v ") == read("P.x+P.y,P.v")
    assert read("P.x P.y") == read("P.x,P.y"), "a space separates graphs, too"
    assert read("|P.v|") == [("", [("|P.v|", None)])]
    assert read("|P.v|/crank.angle+|P.x|/P.y")[0][1][1] == ("|P.x|", "P.y")
    assert [form for form, _ in read("hodograph:P.v,polar:P.v/crank.angle,P.x")] == ["hodograph", "polar", ""]


def test_functions_and_brackets_are_one_quantity():
    text = "hypot(P.x - 1, P.y) / (P.x + 2*P.y) + -P.y, max(P.x, P.y)"
    first, second = "hypot(P.x - 1, P.y)", "-P.y"
    with pytest.raises(UsageError):
        read(text)
    assert read(text.replace(" + -P.y", ""))[0] == ("", [(first, "(P.x + 2*P.y)")])
    assert read(f"{first}+{second}")[0][1] == [(first, None), (second, None)]


def test_an_abscissa_holds_for_the_curves_before_it():
    assert read("P.x+P.y/crank.angle") == [("", [("P.x", "crank.angle"), ("P.y", "crank.angle")])]
    with pytest.raises(UsageError):
        read("P.x/crank.angle+P.y")


@pytest.mark.parametrize("name", ["a+b.x", "a/b.x", "a,b.x", "|a|.x", "a b.x", "polar:a.x", "P.x+P.y"])
def test_a_known_name_may_contain_the_signs(name):
    assert read(name, name) == [("", [(name, None)])]
    assert read(f"P.x+{name}/crank.angle,P.y", name)[0][1][1] == (name, "crank.angle")
    assert read(f"|{name}|", name)[0][1] == [(f"|{name}|", None)]


# --- graphs of a motion ----------------------------------------------------------------------------------------


def drawn(plot, steps=24, **more):
    t = gimcli.trace(gimcli.load(FOUR_BAR), steps, plot=plot, **more)
    return t, t.graphs()


def test_columns_are_drawn_with_their_sign_and_over_the_input():
    t, (one, two) = drawn("P.vx,P.x+P.y")
    assert [c.name for c in two.curves] == ["P.x", "P.y"]
    assert (one.up.name, one.up.unit, one.across.name, one.across.unit) == ("P.vx", "mm/s", "motor", "deg")
    for graph, names in ((one, ["P.vx"]), (two, ["P.x", "P.y"])):
        for c, name in zip(graph.curves, names, strict=True):
            np.testing.assert_array_equal(c.x, t["motor"])
            np.testing.assert_array_equal(c.y, t[name])
    assert t["P.vx"].min() < 0.0 < t["P.vx"].max()


def test_magnitudes_are_those_of_columns_and_of_vectors():
    t, (speed, distance, omega, jerk) = drawn("|P.v|,|P|,|coupler.omega|,|B.j|")
    np.testing.assert_array_equal(speed.curves[0].y, np.hypot(t["P.vx"], t["P.vy"]))
    np.testing.assert_array_equal(distance.curves[0].y, np.hypot(t["P.x"], t["P.y"]))
    np.testing.assert_array_equal(omega.curves[0].y, np.abs(t["coupler.omega"]))
    np.testing.assert_array_equal(jerk.curves[0].y, np.hypot(t["B.jx"], t["B.jy"]))
    assert (speed.up.name, speed.up.unit) == ("|P.v|", "mm/s")


def test_a_quantity_over_another_one():
    t, (path, swing, law) = drawn("P.y/P.x,rocker.angle/crank.angle,P.x+B.x/time")
    assert (path.form, swing.form) == (EQUAL, ORDINARY), "equal axes for the components of one vector"
    np.testing.assert_array_equal(path.curves[0].x, t["P.x"])
    np.testing.assert_array_equal(swing.curves[0].y, t["rocker.angle"])
    np.testing.assert_array_equal(swing.curves[0].x, t["crank.angle"])
    assert (law.across.name, law.across.unit) == ("time", "s")


def test_hodographs_and_polar_diagrams():
    t, (one, polar, over) = drawn("hodograph:P,P.vy/P.vx,polar:P.v,polar:coupler.omega/rocker.angle")
    assert one.form == EQUAL, "the first two are the same graph"
    assert one.origin
    np.testing.assert_array_equal(one.curves[0].x, t["P.vx"])
    np.testing.assert_array_equal(one.curves[0].y, t["P.vy"])
    assert polar.form == POLAR
    np.testing.assert_allclose(polar.curves[0].x, np.radians(t["motor"]))
    np.testing.assert_array_equal(polar.curves[0].y, np.hypot(t["P.vx"], t["P.vy"]))
    np.testing.assert_allclose(over.curves[0].x, np.radians(t["rocker.angle"]))
    np.testing.assert_array_equal(over.curves[0].y, np.abs(t["coupler.omega"]))


def test_words_draw_all_points_or_members_and_one_that_is_named():
    t, (velocity, omega, angle, one, other) = drawn("velocity,omega,angle,omega:rocker,velocity:A")
    assert [c.name for c in velocity.curves] == ["P", "B"]
    np.testing.assert_array_equal(velocity.curves[0].y, np.hypot(t["P.vx"], t["P.vy"]))
    assert [c.name for c in omega.curves] == [c.name for c in angle.curves] == ["crank", "coupler", "rocker"]
    np.testing.assert_array_equal(omega.curves[2].y, t["rocker.omega"])
    np.testing.assert_array_equal(angle.curves[2].y, t["rocker.angle"])
    assert [c.name for c in one.curves] == ["rocker"]
    np.testing.assert_allclose(other.curves[0].y, 2.0 * np.pi * 40.0)  # the end of the crank, one turn a second


def test_measures_and_their_columns():
    t, (both, mu, centre, angle) = drawn(
        "curvature:P.radius+P.x,transmission,centre:frame/coupler.y/centre:frame/coupler.x,angle:coupler/crank",
        measure="transmission",
    )
    np.testing.assert_array_equal(both.curves[0].y, t["curvature:P.radius"])
    np.testing.assert_array_equal(mu.curves[0].y, t["transmission:coupler/rocker"])
    np.testing.assert_array_equal(centre.curves[0].x, t["centre:frame/coupler.x"])
    assert centre.form == EQUAL
    np.testing.assert_array_equal(angle.curves[0].y, t["angle:coupler/crank"])
    assert len(gimcli.trace(t.mechanism, 4, plot="curvature:P").graphs()) == 2, "one graph for each unit"


def test_curves_of_different_units_state_them():
    _, (graph,) = drawn("P.x+crank.angle+step")
    assert graph.up.unit == ""
    assert [c.name for c in graph.curves] == ["P.x [mm]", "crank.angle [deg]", "step"]


def test_only_the_columns_of_the_graphs_are_added():
    names = list(gimcli.trace(gimcli.load(FOUR_BAR), 2).table().names)
    assert [n for n in drawn("rocker.angle")[0].table().names if n not in names] == ["rocker.angle"]
    assert [n for n in drawn("P.y/P.x")[0].table().names if n not in names] == []
    own = [n for n in drawn("A.y")[0].table().names if n not in names]
    assert own == ["A.x", "A.y"], "a node that is not traced"
    assert "P.ax" not in drawn("P.vx")[0].table().names
    np.testing.assert_allclose(
        drawn("A.vx")[1][0].curves[0].y, -80.0 * np.pi * np.sin(np.linspace(0, 2 * np.pi, 25)), atol=1e-9
    )


def test_long_motions_keep_rows_of_the_table(monkeypatch):
    """In pieces of 1000 rows; about 4096 of 9001 rows are drawn."""
    monkeypatch.setattr("gimcli.library.trace.PIECE", 1000)
    t, (graph,) = drawn("rocker.angle/time", 9000)
    assert 3000 < len(graph.curves[0].x) < 4200
    rows = np.round(graph.curves[0].x * 9000).astype(int)
    np.testing.assert_array_equal(graph.curves[0].y, t["rocker.angle"][rows])
    assert rows[-1] == 9000


def test_graphs_of_a_slider_crank_by_its_closed_form():
    """x = r cos q + sqrt(l^2 - r^2 sin^2 q); the rod has the direction -asin(r / l sin q)."""
    r, l, w = 1.0, 3.0, 2.0 * np.pi
    m = gimcli.load(
        {
            "nodes": {"O": [0, 0], "A": [r, 0], "S": [r + l, 0], "G": [9, 0]}, "ground": ["O", "G"],
            "links": {"crank": ["O", "A"], "rod": ["A", "S"]},
            "prismatic": {"piston": {"node": "S", "guide": ["O", "G"]}},
            "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}}, "trace": ["S"],
        }
    )  # fmt: skip
    q = np.linspace(0.0, 2.0 * np.pi, 49)
    root = np.sqrt(l**2 - (r * np.sin(q)) ** 2)
    speed, angle = gimcli.trace(m, 48, plot="S.vx,rod.angle").graphs()
    np.testing.assert_allclose(speed.curves[0].y, -w * r * np.sin(q) * (1.0 + r * np.cos(q) / root), atol=1e-9)
    np.testing.assert_allclose(angle.curves[0].y, np.degrees(-np.arcsin(r / l * np.sin(q))), atol=1e-9)


def test_circuits_have_graphs_of_positions_angles_and_measures():
    t = gimcli.trace(gimcli.load(MODELS / "chebyshev.yaml"), 30, circuit=True, plot="left.angle,P.y/P.x,angle:left")
    angle, path, _ = t.graphs()
    np.testing.assert_array_equal(angle.curves[0].y, t["left.angle"])
    np.testing.assert_array_equal(t["left.angle"], t.angle["left"])
    assert {word for _, word in angle.verticals} == {"limit"}
    assert path.verticals == []
    with pytest.raises(UsageError):
        gimcli.trace(t.mechanism, 30, circuit=True, plot="P.vx")


@pytest.mark.parametrize(
    ("plot", "part"),
    [
        ("P.vz", "did you mean 'P.v"), ("rocker.angel", "did you mean 'rocker.angle'"), ("rockr.angle", "rocker.angle"),
        ("status", "no quantity or column 'status'"), ("Q", "no quantity or column 'Q'"),
        ("P.x/velocity", "several columns"), ("P.x/P", "several columns"), ("P.x/motor+P.y/time", "with one unit"),
        ("hodograph:crank.omega", "expected a point, or a vector"), ("polar:P.x/time", "needs an angle"),
        ("|velocity|", "has more columns"), ("centre:crank/rod", "no member 'rod'"),
        ("transmission:x", "transmission:x"), ("P.x+", "got the end"),
    ],
)  # fmt: skip
def test_wrong_graphs_are_refused(plot, part):
    with pytest.raises(UsageError) as found:
        gimcli.trace(gimcli.load(FOUR_BAR), 4, plot=plot)
    assert part in str(found.value)


# --- dynamics --------------------------------------------------------------------------------------------------


def test_every_column_of_forces_can_be_plotted():
    m = gimcli.load(MODELS / "watt_1.yaml")
    names = [n for n in gimcli.forces(m, 12).table().names if n != "status"]
    f = gimcli.forces(m, 12, plot=names)
    for graph, name in zip(f.graphs(), names, strict=True):
        np.testing.assert_array_equal(graph.curves[0].y, f[name])
    reactions, shaking, effort = gimcli.forces(m, 12, plot="reactions,hodograph:shaking,effort:motor").graphs()
    assert [c.name for c in reactions.curves] == ["O2", "O4", "A", "B", "C", "D", "E"]
    np.testing.assert_array_equal(reactions.curves[2].y, np.hypot(f["A.fx"], f["A.fy"]))
    np.testing.assert_array_equal(shaking.curves[0].x, f["shaking.fx"])
    np.testing.assert_array_equal(effort.curves[0].y, f["motor.effort"])


def test_every_column_of_a_simulation_can_be_plotted():
    m = gimcli.load(MODELS / "watt_durango.yaml")
    names = [n for n in gimcli.simulate(m, 0.2, dt=0.05, reactions=True).table().names if n != "status"]
    s = gimcli.simulate(m, 0.2, dt=0.05, plot=names)
    for graph, name in zip(s.graphs(), names, strict=True):
        np.testing.assert_array_equal(graph.curves[0].y, s[name])
        assert graph.across.name == "time"
    plain = gimcli.simulate(m, 0.2, dt=0.05, plot="energy,crank_angle.speed/crank_angle")
    assert "A.fx" not in plain.table().names, "reactions are found only for their graphs"
    assert [c.name for c in plain.graphs()[0].curves] == ["kinetic", "potential", "drift"]
    for verb, more in ((gimcli.forces, (4,)), (gimcli.simulate, (0.1,))):
        with pytest.raises(UsageError):
            verb(m, *more, plot="energy.kinetik")


def test_graphs_need_a_picture(tmp_path):
    for command, model in (
        ("trace", FOUR_BAR),
        ("forces", MODELS / "watt_1.yaml"),
        ("simulate", MODELS / "watt_durango.yaml"),
    ):
        assert "no picture is written" in refused(command, model, "--plot", "time", "-o", tmp_path / "a.csv")
    gim("forces", MODELS / "watt_1.yaml", "-n", 12, "--plot", "A.fy/A.fx", "--plot", "|B|", "-o", tmp_path / "f.svg")
    assert "A.fy" in (tmp_path / "f.svg").read_text()


def test_the_page_shows_the_columns_of_the_graphs():
    """Also their angles with full turns, although the page has no rows between them (here 270 deg apart)."""
    data = yaml.safe_load(FOUR_BAR.read_text())
    data["actuators"]["motor"]["law"] = {"from": 0, "to": 1080}
    t = gimcli.trace(gimcli.load(data), 4, plot="crank.angle,P.y/P.x,A.vx+A.vy,angle:coupler/crank")
    page = t.animation()
    assert [(g.columns, g.over) for g in page.graphs] == [
        (("crank.angle",), "motor"), (("P.y",), "P.x"), (("A.vx", "A.vy"), "motor"),
        (("angle:coupler/crank",), "motor"),
    ]  # fmt: skip
    rows = page.clips[0].table
    for name in ("crank.angle", "angle:coupler/crank"):
        np.testing.assert_allclose(rows[name][[0, -1]], t[name][[0, -1]])
    assert rows["crank.angle"][-1] == pytest.approx(1080.0)
