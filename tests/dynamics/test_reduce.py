"""Reduction to one input, compared with the modular method of the source, and flywheels."""

from __future__ import annotations

import csv
import json
import math

import numpy as np
import pytest
from bundled import MODELS, reference, written
from heavy_models import motion_forces, released
from modular_reduction import STILL, LinkVelocity, modular_reduction, prp, rotating_driver, rpp, rpr, rrp, rrr

from gimcli import StructureError, UsageError, load
from gimcli.dynamics.reduction import chosen_input, flywheel, reduce_to_input
from gimcli.motion.motion import trace
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.assur import DYADS, formation


def modular(mechanism, z):
    """Return J, dJ/dq and tau in SI units."""
    parts = modular_reduction(mechanism, z)
    unit = 1.0 if mechanism.actuators[0].rotary else mechanism.dynamics.metre
    totals = (sum(p.inertia for p in parts), sum(p.inertia_slope for p in parts), sum(p.torque for p in parts))
    return [total / unit**power for total, power in zip(totals, (2, 3, 1), strict=True)]


# -- the reference and closed forms -----------------------------------------------------------------


def test_watt_agrees_with_the_reference():
    rows = reference("watt_six_bar_reduced.csv")
    row_of = {round(angle): k for k, angle in enumerate(rows["theta2_deg"])}
    mechanism = load(MODELS / "watt_durango.yaml")
    found = reduce_to_input(mechanism, 0, 24)
    angles = np.round(np.degrees(found.q)).astype(int) % 360
    columns = {"J_red": "J", "dJ_dq": "dJ_dq", "tau_red": "tau", "V": "V"}
    for name, own in columns.items():
        expected = rows[name][[row_of[k] for k in angles]]
        assert np.abs(found.columns[own] - expected).max() < 2e-12, name
    assert np.abs(found.columns["dV_dq"] + found.columns["tau"]).max() < 1e-14  # there is only weight


def test_a_parallelogram_of_unit_bars_has_an_inertia_of_five_thirds(tmp_path):
    """Its coupler does not turn: where eq. (5) of the source gives 0/0, J is 5/3 and dJ/dq is 0."""
    text = """
nodes: {O: [0, 0], P: [1, 0], A: [0.5, 0.8660254037844386], B: [1.5, 0.8660254037844386]}
ground: [O, P]
links: {crank: [O, A], coupler: [A, B], rocker: [P, B]}
actuators: {q: {type: rotary, pivot: O, arm: A, law: {from: 60, to: 150}}}
masses: {crank: {mass: 1, inertia: 0.08333333333333333}, rocker: {mass: 1, inertia: 0.08333333333333333},
  coupler: {mass: 1, inertia: 0.08333333333333333}}
gravity: [0, -9.81]
"""
    mechanism = written(tmp_path, text)
    found = reduce_to_input(mechanism, 0, 10)
    inertia, slope, torque = modular(mechanism, trace(mechanism, 10, Options(tolerance=1e-13)).z)
    for value in (found.columns["J"], inertia):
        assert np.abs(value - 5.0 / 3.0).max() < 1e-14
    for value in (found.columns["dJ_dq"], slope):
        assert np.abs(value).max() < 1e-13
    for value in (found.columns["tau"], torque):
        assert np.abs(value + 2.0 * 9.81 * np.cos(found.q)).max() < 1e-13


def test_a_slider_crank_agrees_with_its_closed_form(tmp_path):
    """Crank r, massless rod l, slider m: J = I + m x'^2 with x = r cos q + sqrt(l^2 - r^2 sin^2 q); a spring on x."""
    text = """
units: {length: mm}
nodes: {O: [0, 0], A: [300, 0], B: [1100, 0], C: [1200, 0], G: [2000, 0]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B], slider: [B, C]}
prismatic: {slide: {nodes: [B, C], guide: [O, G]}}
actuators: {q: {type: rotary, pivot: O, arm: A, law: {from: 10, to: 370}}}
masses: {crank: {mass: 3, inertia: 0.2, centre: [0, 0]}, slider: {mass: 2}}
springs: {spring: {nodes: [O, B], stiffness: 40, free: 500}}
loads: {push: {on: slider, at: [1100, 0], force: [-25, 0]}}
"""
    found = reduce_to_input(written(tmp_path, text), 0, 90)
    q, r, length = found.q, 0.3, 0.8
    root = np.sqrt(length**2 - r**2 * np.sin(q) ** 2)
    x = r * np.cos(q) + root
    s, c = np.sin(q), np.cos(q)
    first = -r * s - r**2 * s * c / root
    second = -r * c - r**2 * (c**2 - s**2) / root - r**4 * s**2 * c**2 / root**3
    force = -25.0 - 40.0 * (x - 0.5)
    assert np.abs(found.columns["J"] - (0.2 + 2.0 * first**2)).max() < 1e-13
    assert np.abs(found.columns["dJ_dq"] - 4.0 * first * second).max() < 1e-13
    assert np.abs(found.columns["tau"] - force * first).max() < 1e-12
    assert np.abs(found.columns["dtau_dq"] - (force * second - 40.0 * first**2)).max() < 1e-12
    assert np.abs(found.columns["V"] - 20.0 * (x - 0.5) ** 2).max() < 1e-12
    assert np.abs(found.columns["dV_dq"] - 40.0 * (x - 0.5) * first).max() < 1e-12


def test_a_linear_input_has_a_mass(tmp_path):
    """The same slider as input: J is a mass in kg whatever the file's unit."""
    text = """
units: {length: mm}
nodes: {O: [0, 0], G: [2000, 0], P: [500, 0], Q: [600, 0]}
ground: [O, G]
links: {block: [P, Q]}
prismatic: {slide: {nodes: [P, Q], guide: [O, G]}}
actuators: {x: {type: linear, node: P, guide: [O, G], law: {from: 500, to: 900}}}
masses: {block: {mass: 2}}
gravity: [-3, -9.81]
springs: {spring: {nodes: [O, P], stiffness: 50, free: 300}}
"""
    found = reduce_to_input(written(tmp_path, text), 0, 4)
    x = np.linspace(0.5, 0.9, 5)
    assert np.abs(found.columns["J"] - 2.0).max() < 1e-14
    assert np.abs(found.columns["tau"] - (-6.0 - 50.0 * (x - 0.3))).max() < 1e-13
    assert np.abs(found.columns["dtau_dq"] + 50.0).max() < 1e-12


@pytest.mark.few(1)
@pytest.mark.parametrize("stem", ["whitworth", "klann", "crank_shaper", "watt_2", "double_butterfly"])
def test_slopes_agree_with_differences_of_the_values(stem):
    """Differences of fourth order, for models with every kind of pair, a load and a spring."""

    def loaded(data):
        parts = {**data.get("links", {}), **data.get("elements", {})}
        held = {k: set(part if isinstance(part, list) else part["nodes"]) for k, part in parts.items()}
        name, fixed = next(iter(parts)), data["ground"]
        near = set(fixed).union(*(nodes for nodes in held.values() if fixed[0] in nodes))
        far = next(n for n in set().union(*held.values()) if n not in near)
        data["loads"] = {"push": {"on": name, "local": [0.3, 0.2], "follower": [3.0, 1.0]}}
        data["springs"] = {"spring": {"nodes": [fixed[0], far], "stiffness": 5.0}}

    mechanism = released(stem, loaded)
    found = reduce_to_input(mechanism, 0, 1440)
    rows = np.flatnonzero(np.isfinite(found.columns["J"][:-4]) & np.isfinite(found.columns["J"][4:]))[::37] + 2
    rows = rows[2:]  # the double butterfly begins near a dead point
    unit = 1.0 if mechanism.actuators[0].rotary else mechanism.dynamics.metre
    h = (found.q[1] - found.q[0]) * unit
    assert len(rows) > 20
    for value, slope in (
        ("J", "dJ_dq"),
        ("tau", "dtau_dq"),
        ("V", "dV_dq"),
    ):
        f, expected = found.columns[value], found.columns[slope]
        difference = (f[rows - 2] - 8.0 * f[rows - 1] + 8.0 * f[rows + 1] - f[rows + 2]) / (12.0 * h)
        scale = np.abs(expected[rows]).max() + np.abs(f[rows]).max()
        assert np.abs(difference - expected[rows]).max() < 2e-6 * scale, (stem, value)


# -- module by module ---------------------------------------------------------------------------------

DYADIC = ("antiparallelogram", "chebyshev", "crank_rocker", "crank_shaper", "double_crank", "gim_fig13b",
          "hart_a_frame", "jansen", "klann", "pantograph", "peaucellier", "scissor_lift", "scotch_yoke",
          "scott_russell", "slider_crank", "stephenson_1", "stephenson_3", "watt_1", "watt_2", "watt_durango",
          "whitworth")  # fmt: skip


@pytest.mark.few
@pytest.mark.parametrize("stem", DYADIC)
def test_modular_and_general_reduction_agree(stem):
    mechanism = released(stem)
    found = reduce_to_input(mechanism, 0, 24)
    motion = trace(mechanism, 24, Options(tolerance=1e-13))
    good = motion.good & np.isfinite(found.columns["J"])
    assert good.sum() > 10
    values = modular(mechanism, motion.z)
    for value, expected in zip(values, (found.columns["J"], found.columns["dJ_dq"], found.columns["tau"]), strict=True):
        scale = np.abs(expected[good]).max()
        bound = 3e-12 if stem == "antiparallelogram" else 1e-13  # it passes its change point at 1e-6 rad
        assert np.abs(value - expected)[good].max() < bound * scale


PRP = """
nodes: {O: [0, 0], A: [2, 1], B: [1, 0.5], G: [0, 0.5], H: [3, 0.5], C: [2, 2], D: [3, 1.5]}
ground: [O, G, H, D]
links: {slot: [O, A], near: [B, C], far: [D, C]}
prismatic: {inner: {node: B, guide: [O, A]}, outer: {node: B, guide: [G, H]}}
actuators: {q: {type: rotary, pivot: O, arm: A, law: {from: 26.56505117707799, to: 40}}}
masses: {slot: {mass: 1, inertia: 0.1}, near: {mass: 2, inertia: 0.2}, far: {mass: 3, inertia: 0.3}}
gravity: [1, -9.81]
loads: {turn: {on: far, torque: 2}, push: {on: near, local: [0.1, 0.2], follower: [3, 4]}}
"""


def test_two_sliders_on_one_pin_are_a_dyad(tmp_path):
    mechanism = written(tmp_path, PRP)
    assert [g.dyad for g in formation(mechanism).groups] == ["", "PRP", "RRR"]
    found = reduce_to_input(mechanism, 0, 8)
    values = modular(mechanism, trace(mechanism, 8, Options(tolerance=1e-13)).z)
    for value, expected in zip(values, (found.columns["J"], found.columns["dJ_dq"], found.columns["tau"]), strict=True):
        assert np.abs(value - expected).max() < 1e-13 * np.abs(expected).max()


def test_every_dyad_keeps_its_pairs_closed():
    """Velocities and accelerations of the pairs' places agree from both links, on links with random motions."""
    rng = np.random.default_rng(7)

    def any_motion():
        z = rng.normal(size=6)
        return LinkVelocity(complex(z[0], z[1]), complex(z[2], z[3]), complex(z[4], z[5]), *rng.normal(size=2))

    def any_place():
        return complex(*rng.normal(size=2))

    def slides(link, guide, z, u):
        """Return the errors in velocity and acceleration of a link's point at z relative to the line of a guide."""
        (v, a), (vg, ag) = link.at(z), guide.at(z)
        travel = ((v - vg) * u.conjugate()).real
        off = a - ag - 2j * guide.turn * u * travel
        return [((v - vg) * u.conjugate()).imag, (off * u.conjugate()).imag, link.turn - guide.turn]

    def pinned(link, other, z):
        return [abs(p - q) for p, q in zip(link.at(z), other.at(z), strict=True)]

    for _ in range(20):
        one, two, a, d, b = any_motion(), any_motion(), any_place(), any_place(), any_place()
        u, v = (z / abs(z) for z in (any_place(), any_place()))
        left, right = rrr(one, a, two, d, b)
        gaps = pinned(left, one, a) + pinned(right, two, d) + pinned(left, right, b)
        left, right = rrp(one, a, two, u, b)
        gaps += pinned(left, one, a) + pinned(left, right, b) + slides(right, two, b, u)
        left, right = rpr(one, a, two, d, u)
        gaps += pinned(left, one, a) + pinned(right, two, d) + slides(left, right, a, u)
        left, right = prp(one, u, two, v, b)
        gaps += pinned(left, right, b) + slides(left, one, b, u) + slides(right, two, b, v)
        left, right = rpp(one, a, u, two, v)
        gaps += pinned(left, one, a) + slides(left, right, a, u) + slides(right, two, a, v)
        assert np.abs(gaps).max() < 1e-9
    assert set(DYADS) == {"RRR", "RRP", "RPR", "PRP", "RPP"}
    assert rotating_driver(STILL, 0j).at(2.0) == (2j, -2.0)


def test_a_mechanism_without_dyads_is_rejected():
    mechanism = released("double_butterfly")
    with pytest.raises(StructureError):
        modular_reduction(mechanism, mechanism.drawn[:, None])


# -- flywheels ----------------------------------------------------------------------------------------------

WHEEL = """
nodes: {O: [0, 0], A: [1, 0]}
ground: [O]
links: {wheel: [O, A]}
actuators: {q: {type: rotary, pivot: O, arm: A, law: {from: 0, to: 360}}}
masses: {wheel: {mass: 2, inertia: 0.5, centre: [0.25, 0]}}
gravity: [0, -9.81]
"""


def test_the_flywheel_of_an_unbalanced_wheel(tmp_path):
    """Constant J: the work is 2 m g r, and J + J_F = work / (delta w^2) exactly."""
    found = reduce_to_input(written(tmp_path, WHEEL), 0, 360)
    inertia, work, speed = 0.5 + 2.0 * 0.25**2, 2.0 * 2.0 * 9.81 * 0.25, 3.0
    wheel = flywheel(found, speed, 0.1)
    assert wheel.work == pytest.approx(work, rel=1e-9)
    assert wheel.inertia == pytest.approx(work / (0.1 * speed**2) - inertia, rel=1e-9)
    assert wheel.without == pytest.approx(work / (inertia * speed**2), rel=1e-9)
    assert abs(wheel.torque) < 1e-12
    assert flywheel(found, 300.0, 0.1).inertia == 0.0


def test_the_speed_with_the_flywheel_has_the_required_fluctuation():
    """Watt's six-bar at the drive's constant torque: the speed from its own energy balance."""
    mechanism = load(MODELS / "watt_durango.yaml")
    found = reduce_to_input(mechanism, 0, 1800)
    wheel = flywheel(found, 20.0, 0.04)
    total = found.columns["J"] + wheel.inertia
    work = found.columns["V"][0] - found.columns["V"]

    def bounds(start):
        speed = np.sqrt(2.0 * (start + work) / total)
        return speed.min(), speed.max()

    low, high = 0.0, 1e6
    low = -work.min()
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if sum(bounds(middle)) < 2.0 * 20.0 else (low, middle)
    least, greatest = bounds(low)
    assert (greatest - least) / 20.0 == pytest.approx(0.04, rel=1e-6)


# -- the command ----------------------------------------------------------------------------------------------


def test_the_command_writes_report_table_and_picture(tmp_path):
    from typer.testing import CliRunner

    from gimcli.cli import app

    model = str(MODELS / "watt_durango.yaml")
    asked = ["reduce", model, "--steps", "24", "-o", str(tmp_path), "--json", "--fluctuation", "0.05", "--rpm", "300"]
    done = CliRunner().invoke(app, asked)
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    assert report["solved"] == 25
    assert report["flywheel"]["inertia"] > 100.0
    with (tmp_path / "watt_durango.reduced.csv").open() as handle:
        rows = list(csv.DictReader(handle))
    assert list(rows[0])[:5] == ["q", "J", "dJ_dq", "tau", "V"]
    assert float(rows[16]["q"]) == pytest.approx(360.0)
    assert float(rows[16]["J"]) == pytest.approx(16.7215381238818893, abs=1e-12)
    assert report["J"] == [float(row["J"]) for row in rows]
    assert (tmp_path / "watt_durango.reduced.png").stat().st_size > 10_000


def test_rows_out_of_reach_keep_their_status(tmp_path):
    """A crank that cannot turn fully: exit status 5, everything up to the limit written."""
    from typer.testing import CliRunner

    from gimcli.cli import app

    text = """
nodes: {O: [0, 0], A: [0, 2], B: [1, 2.6], P: [2, 0]}
ground: [O, P]
links: {crank: [O, A], coupler: [A, B], rocker: [P, B]}
actuators: {q: {type: rotary, pivot: O, arm: A, law: {from: 90, to: 450}}}
masses: {crank: {mass: 1}}
"""
    (tmp_path / "m.yaml").write_text(text)
    done = CliRunner().invoke(app, ["reduce", str(tmp_path / "m.yaml"), "--steps", "36", "-o", str(tmp_path)])
    assert done.exit_code == 5
    with (tmp_path / "m.reduced.csv").open() as handle:
        words = [row["status"] for row in csv.DictReader(handle)]
    assert words[0] == "ok"
    assert words[-1] == "unreachable"


def test_an_input_is_chosen_by_name():
    mechanism = load(MODELS / "platform_3rrr.yaml")
    assert chosen_input(mechanism, mechanism.actuators[1].name) == 1
    with pytest.raises(UsageError):
        chosen_input(mechanism, "none")


# -- tables over time, redundant equations ----------------------------------------------------------------------


def test_a_table_over_time_is_evaluated_at_the_times_of_the_law(tmp_path):
    """3 N m s on a wheel that turns by q = 2 pi (3 s^2 - 2 s^3), s = t / T: the work is 3 pi."""
    (tmp_path / "t.csv").write_text("t,f\n0,0\n4,1\n")
    text = WHEEL.replace("gravity: [0, -9.81]", "duration: 4\nloads: {pull: {on: wheel, torque: 3, table: t.csv}}")
    text = text.replace("to: 360", "to: 360, profile: {polynomial: [0, 0, 3, -2]}")
    found = reduce_to_input(written(tmp_path, text), 0, 4000)
    s = np.linspace(0.0, 1.0, 4001)
    assert found.columns["tau"] == pytest.approx(3.0 * s, abs=1e-12)
    assert np.all(np.isnan(found.columns["dtau_dq"]))  # tau does not depend on q alone
    work = 2.0 * math.pi * 3.0 * 0.5  # integral of 3 s (6 s - 6 s^2) ds = 3 (2 - 3 / 2)
    assert flywheel(found, 30.0, 0.1).torque == pytest.approx(-work / (2.0 * math.pi), abs=1e-5)


@pytest.mark.few(1)
@pytest.mark.parametrize(("end", "steps", "singular"), [(170, 24, 0), (370, 360, 2)])
def test_other_redundant_equations_are_chosen_where_they_lose_rank(end, steps, singular, tmp_path):
    """Three parallel cranks of 1 m carry a bar: J = m/4 + m/4 + M, tau = -g cos q (m/2 + m/2 + M)."""
    text = (MODELS / "parallelogram_third_crank.yaml").read_text().replace("to: 170", f"to: {end}")
    text += "masses: {left: {mass: 1, inertia: 0}, middle: {mass: 1, inertia: 0}, bar: {mass: 2, inertia: 0.1}}\n"
    mechanism = written(tmp_path, text + "gravity: [0, -9.81]\n")
    found = reduce_to_input(mechanism, 0, steps)
    good = found.codes == Status.OK
    assert np.array_equal(good, motion_forces(trace(mechanism, steps)).good)
    assert np.count_nonzero(~good) == singular  # flat: each crank can turn in either direction
    assert found.columns["J"][good] == pytest.approx(2.5, abs=1e-10)
    assert found.columns["tau"][good] == pytest.approx(-3.0 * 9.81 * np.cos(found.q[good]), abs=1e-9)


def test_a_table_over_an_input_that_follows_has_a_slope(tmp_path):
    """A torque of 3 b / 10 on a wheel, b = 2 q being the angle of another wheel: dtau/dq is 0.6."""
    (tmp_path / "t.csv").write_text("b,f\n-10,-1\n10,1\n")
    text = """
nodes: {O: [0, 0], A: [1, 0], P: [3, 0], B: [4, 0]}
ground: [O, P]
links: {wheel: [O, A], other: [P, B]}
units: {angle: rad}
actuators:
  q: {pivot: O, arm: A, law: {from: 0, to: 1}}
  b: {pivot: P, arm: B, follows: q, ratio: 2}
masses: {wheel: {mass: 2, inertia: 0.5}}
loads: {pull: {on: wheel, torque: 3, table: t.csv, over: b}}
"""
    found = reduce_to_input(written(tmp_path, text), 0, 8)
    assert found.columns["tau"] == pytest.approx(0.6 * found.q, abs=1e-12)
    assert found.columns["dtau_dq"] == pytest.approx(0.6, abs=1e-12)
