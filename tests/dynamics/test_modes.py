"""Natural modes: closed forms, damping, instability, refusals, and the frequency of a simulated motion."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim
from small_vibrations import LAGUERRE, SLIDER_CRANK, chain, geared_pendulums

import gimcli
from gimcli import ModelError, UsageError
from gimcli.structure.residual import residual

G = 9.81


def omegas(text, **arguments):
    """Return the natural frequencies [rad/s] of a model."""
    return gimcli.modes(gimcli.loads(text), **arguments)["omega"]


def bar(more="", mass="{mass: 1, inertia: 1/12}", free="free: true"):
    """Return the text of a hanging bar of 1 m."""
    return (
        "nodes: {O: [0, 0], A: [0, -1]}\nground: [O]\nlinks: {bar: [O, A]}\n"
        f"actuators: {{q: {{pivot: O, arm: A, {free}}}}}\nmasses: {{bar: {mass}}}\ngravity: [0, -{G}]\n{more}"
    )


# -- closed forms -----------------------------------------------------------------------------------


def test_a_uniform_bar():
    assert omegas(bar()) == pytest.approx([3.836013555763327], rel=1e-14)


@pytest.mark.parametrize("n", LAGUERRE)
def test_chains_of_point_masses(n):
    assert omegas(chain(n)) ** 2 / G == pytest.approx(LAGUERRE[n], rel=1e-13)


def test_two_uniform_bars_of_the_shipped_model():
    found = gimcli.modes(gimcli.load("double_pendulum"))
    assert found["omega"] == pytest.approx([2.680114012253375, 7.188670870287714], rel=1e-13)
    assert found["lower.turn"] / found["upper.turn"] == pytest.approx([1.43050087404306, -2.097167540709727], rel=1e-13)
    assert found["elbow.shape"] == pytest.approx(found["lower.turn"] - found["upper.turn"], rel=1e-13)
    assert found["A.dx"] == pytest.approx(found["upper.turn"], rel=1e-13)  # hanging, 1 m
    assert found.stable
    held = gimcli.modes(gimcli.load("double_pendulum"), shoulder=-90, elbow=180)
    assert held["omega"] == pytest.approx(found["omega"])


def test_modes_without_stiffness_have_one_form():
    """Of a balanced linkage every motion is a rigid one: those of one coordinate each, whatever the rounding."""
    found = gimcli.modes(gimcli.load("balanced_lamp"))
    assert list(found["kind"]) == ["rigid body", "rigid body"]
    shapes = np.array([found["shoulder.shape"], found["elbow.shape"]])
    assert shapes == pytest.approx(np.eye(2), abs=1e-12)
    assert found["upper_arm.turn"] == pytest.approx([0, 1], abs=1e-12)


def test_two_point_pendulums_with_a_spring():
    text = f"""
nodes: {{O: [0, 0], P: [3, 0], A: [0, -1], B: [3, -1], C: [0, -0.4], D: [3, -0.4]}}
ground: [O, P]
elements: {{one: {{nodes: [O, A, C]}}, two: {{nodes: [P, B, D]}}}}
actuators: {{q: {{pivot: O, arm: A}}, r: {{pivot: P, arm: B}}}}
masses: {{A: 2, B: 2}}
gravity: [0, -{G}]
springs: {{s: {{nodes: [C, D], stiffness: 30}}}}
"""
    found = gimcli.modes(gimcli.loads(text), free=["q", "r"])
    assert found["omega"] == pytest.approx([3.132091952673165, 3.822302970723278], rel=1e-13)
    assert found["r.shape"] / found["q.shape"] == pytest.approx([1, -1])
    assert omegas(text, free="q")[0] == pytest.approx(math.sqrt(G + 30 * 0.16 / 2), rel=1e-13)


@pytest.mark.parametrize(("ratio", "expected"), [(-1, 4.026343338311588), (-2, 4.338376612041303)])
def test_two_geared_pendulums(ratio, expected):
    for coupling in ("follows", "gears"):
        found = gimcli.modes(gimcli.loads(geared_pendulums(ratio, coupling)))
        assert found["omega"] == pytest.approx([expected], rel=1e-13)
        assert found["two.turn"] / found["one.turn"] == pytest.approx([ratio])


def test_a_slider_crank_with_a_spring():
    assert omegas(SLIDER_CRANK, motor=60)[0] == pytest.approx(16.41976317417809, rel=1e-11)


@pytest.mark.parametrize(
    ("pivots", "inertia", "expected"),
    [(0.3, 0.0, 3.501785258978626), (0.3, 5.0, 3.501785258978626), (0.5, 0.03, 3.710246614049168)],
)
def test_a_bar_hung_on_two_equal_links(pivots, inertia, expected):
    """Links of 0.8 m, a uniform bar of 0.6 m: parallel links whatever its inertia, and links that converge."""
    depth = math.sqrt(0.64 - (pivots - 0.3) ** 2)
    text = f"""
nodes: {{O: [{-pivots}, 0], P: [{pivots}, 0], A: [-0.3, {-depth!r}], B: [0.3, {-depth!r}]}}
ground: [O, P]
links: {{left: [O, A], bar: [A, B], right: [P, B]}}
actuators: {{q: {{pivot: O, arm: A}}}}
masses: {{bar: {{mass: 1, inertia: {inertia}, centre: [0.3, 0]}}}}
gravity: [0, -{G}]
"""
    assert omegas(text)[0] == pytest.approx(expected, rel=1e-13)


def test_slider_crank_with_weight_and_a_spring():
    """From four starts the forces lead to the two stable equilibria; the unstable ones are found where they are."""
    text = f"""
nodes: {{O: [0, 0], A: [0.1, 0], B: [0.4, 0], X: [1, 0]}}
ground: [O, X]
links: {{crank: {{nodes: [O, A], length: 0.1}}, rod: {{nodes: [A, B], length: 0.3}}}}
prismatic: {{guide: {{node: B, guide: [O, X]}}}}
actuators: {{q: {{pivot: O, arm: A}}}}
masses:
  crank: {{mass: 0.5, inertia: {0.5 * 0.01 / 12!r}}}
  rod: {{mass: 0.8, inertia: {0.8 * 0.09 / 12!r}}}
  B: 1.2
gravity: [0, -{G}]
springs: {{s: {{node: B, guide: [O, X], stiffness: 600, free: 0.33}}}}
"""
    mechanism = gimcli.loads(text)
    for start, place, expected in (
        (-100, -66.28447331089764, 17.7026254538752), (30, 61.2555238981577, 15.9743069461253),
        (160, 61.2555238981577, 15.9743069461253), (0, -66.28447331089764, 17.7026254538752),
    ):  # fmt: skip
        found = gimcli.modes(mechanism, settle=True, q=start)
        assert found.inputs["q"] == pytest.approx(place, abs=1e-10)
        assert found["omega"] == pytest.approx([expected], rel=1e-12)
    for place, curvature in ((6.587611473323631, -5.40201917976), (173.0053793000439, -5.23066521382)):
        found = gimcli.modes(mechanism, q=place)
        assert found["kind"][0] == "unstable"
        assert found["modal_stiffness"] == pytest.approx([curvature], rel=1e-11)
        assert -(found["decay"] ** 2) == pytest.approx(found["modal_stiffness"] / found["modal_mass"], rel=1e-12)
        assert math.isnan(found["omega"][0])


BALANCED = f"""
nodes: {{O: [0, 0], H: [0, 0.25], A: [0.2, 0]}}
ground: [O, H]
links: {{bar: [O, A]}}
actuators: {{q: {{pivot: O, arm: A, free: true}}}}
masses: {{bar: {{mass: 2, inertia: 0.06, centre: [0.3, 0]}}}}
gravity: [0, -{G}]
springs: {{s: {{nodes: [A, H], stiffness: 117.72, free: 0}}}}
"""


def test_a_bar_balanced_by_a_spring():
    """k a h = m g r: no stiffness anywhere; a stiffer spring is stable upright, and unstable hanging."""
    for place in (90, 20, -70):
        assert list(gimcli.modes(gimcli.loads(BALANCED), q=place)["kind"]) == ["rigid body"]
    stiffer = gimcli.loads(BALANCED.replace("117.72", "120"))
    assert gimcli.modes(stiffer, q=90)["omega"][0] == pytest.approx(0.6892024376045111, rel=1e-11)
    assert gimcli.modes(stiffer, q=-90)["decay"][0] == pytest.approx(-0.6892024376045111, rel=1e-11)
    assert gimcli.modes(stiffer, q=-80, settle=True).inputs["q"] == pytest.approx(90, abs=1e-9)


TILTED = [(2.0, 1.89549426703398095, 1.638045048285238), (1.25, 1.13110258565128291, 0.4679220538934336)]


@pytest.mark.parametrize(("ratio", "tilt", "stiffness"), TILTED)
def test_an_upright_bar_on_a_torsion_spring(ratio, tilt, stiffness):
    """kappa phi = m g c sin phi; J omega^2 / kappa = 1 - (m g c/kappa) cos phi, and 1 - m g c/kappa upright."""
    spring = f"springs: {{t: {{pivot: O, arm: A, stiffness: {0.5 * G / ratio!r}, free: 90}}}}\n"
    mechanism = gimcli.loads(bar(spring).replace("A: [0, -1]", "A: [0, 1]"))
    found = gimcli.modes(mechanism, settle=True, q=60)
    assert math.radians(90 - found.inputs["q"]) == pytest.approx(tilt, rel=1e-12)
    assert found["omega"][0] ** 2 / 3 / (0.5 * G / ratio) == pytest.approx(stiffness, rel=1e-11)
    assert gimcli.modes(mechanism, q=90)["modal_stiffness"][0] == pytest.approx(
        (1 - ratio) * 0.5 * G / ratio, rel=1e-13
    )


# -- damping and instability ------------------------------------------------------------------------


@pytest.mark.parametrize("share", [0.0, 0.3, 0.99, 1.01, 4.0])
@pytest.mark.parametrize("kind", ["dampers: {d: {pivot: O, arm: A, damping: C}}", "friction: {O: C}", "effort"])
def test_one_damped_freedom(share, kind):
    """lambda = omega (-zeta +- sqrt(zeta^2 - 1)): damper, viscous friction, motor whose torque falls with speed."""
    omega, inertia = math.sqrt(1.5 * G), 1 / 3
    damping = 2 * share * omega * inertia
    text = bar(kind.replace("C", repr(damping)) if kind != "effort" else "")
    if kind == "effort":
        if not share:
            return
        idle = math.degrees(0.2 / damping)
        text = bar("loads: {back: {on: bar, torque: -0.2}}", free=f"free: true, effort: {{stall: 0.2, idle: {idle!r}}}")
    found = gimcli.modes(gimcli.loads(text))
    assert found["omega"] == pytest.approx(omega, rel=1e-12)
    assert found["damping_ratio"] == pytest.approx(share, rel=1e-12)
    if share < 1:
        assert found["damped_omega"] == pytest.approx([omega * math.sqrt(1 - share**2)], rel=1e-10)
        assert found["decay"] == pytest.approx([omega * share], rel=1e-12)
    else:
        assert list(found["kind"]) == ["decay", "decay"]
        root = math.sqrt(share**2 - 1)
        assert found["decay"] == pytest.approx([omega * (share - root), omega * (share + root)], rel=1e-10)


def test_dampers_in_proportion_to_springs_keep_the_shapes():
    """C = beta K: the shapes are those without damping, and the damping ratio is beta omega / 2."""
    pairs = "{{pivot: N0, arm: N1, {0}: {1}}}, {2}: {{pivot: N1, arm: N2, reference: N0, {0}: {3}}}}}\n"
    springs = "gravity: [0, 0]\nsprings: {s: " + pairs.format("stiffness", 5, "t", 3)
    dampers = "dampers: {d: " + pairs.format("damping", 0.25, "e", 0.15)
    text = chain(2).replace("gravity: [0, -9.81]\n", springs)
    bare, damped = (gimcli.modes(gimcli.loads(t)) for t in (text, text + dampers))
    assert damped["omega"] == pytest.approx(bare["omega"], rel=1e-12)
    assert damped["damping_ratio"] == pytest.approx(0.025 * bare["omega"], rel=1e-11)
    assert damped["q2.shape"] == pytest.approx(bare["q2.shape"], rel=1e-11)
    local = text + "dampers: {d: {pivot: N0, arm: N1, damping: 0.25}}\n"
    found = gimcli.modes(gimcli.loads(local))
    assert np.abs(found["q2.shape.imaginary"]).max() > 1e-3
    names = [f"{name}.shape" for name in found.report()["coordinates"]]
    x = np.array([found[name] + 1j * found[f"{name}.imaginary"] for name in names])
    m, k, c = (np.array(found.report()[name]) for name in "MKC")
    values = 1j * found["damped_omega"] - found["decay"]
    assert np.abs(m @ x * values**2 + c @ x * values + k @ x).max() < 1e-12 * np.abs(k).max()


def test_a_free_bar_with_a_damper_has_a_mode_without_stiffness_and_one_that_decays():
    text = chain(1).replace("-9.81", "0") + "dampers: {d: {pivot: N0, arm: N1, damping: 0.5}}\n"
    found = gimcli.modes(gimcli.loads(text))
    assert list(found["kind"]) == ["rigid body", "decay"]
    assert found["decay"] == pytest.approx([0, 0.5])


def test_two_free_bars_with_one_damper():
    """Two shapes without stiffness, one of them damped: the eigenvalue 0 is triple, the fourth one decays."""
    text = chain(2).replace("-9.81", "0") + "dampers: {d: {pivot: N0, arm: N1, damping: 0.5}}\n"
    found = gimcli.modes(gimcli.loads(text))
    assert list(found["kind"]) == ["rigid body", "rigid body", "decay"]


@pytest.mark.parametrize(("load", "kinds"), [(2.08, {"vibration"}), (2.09, {"unstable", "vibration"})])
def test_a_double_pendulum_under_a_follower_force_flutters(load, kinds):
    """Ziegler 1952: masses 2 m and m, two equal springs; it flutters above P L/k = 7/2 - sqrt 2 = 2.0858."""
    text = f"""
nodes: {{O: [0, 0], A: [0, 1], B: [0, 2]}}
ground: [O]
links: {{one: [O, A], two: [A, B]}}
actuators: {{q: {{pivot: O, arm: A}}, r: {{pivot: A, arm: B, reference: O}}}}
masses: {{A: 2, B: 1}}
springs: {{s: {{pivot: O, arm: A, stiffness: 1}}, t: {{pivot: A, arm: B, reference: O, stiffness: 1}}}}
loads: {{push: {{on: two, local: [1, 0], follower: [{-load}, 0]}}}}
"""
    found = gimcli.modes(gimcli.loads(text), free="q,r")
    assert set(found["kind"]) == kinds
    assert all(found["damped_omega"] > 0.1)  # it does not diverge: the unstable mode oscillates


# -- other ways -------------------------------------------------------------------------------------


def test_a_simulated_swing_has_the_frequency_of_the_mode():
    """Small swings about the equilibrium: two standstills are half a period apart, up to the amplitude squared."""
    mechanism = gimcli.load("watt_durango")
    found = gimcli.modes(mechanism, settle=True)
    place = found.inputs["crank_angle"]
    from gimcli.model.source import read_source

    data = read_source(MODELS / "watt_durango.yaml").data
    data["actuators"]["crank_angle"] |= {"start": place + 0.05, "speed": 0}
    motion = gimcli.simulate(gimcli.load(data), 2.0, dt=0.1, standstills=2, rtol=1e-12)
    times = [e["time"] for e in motion.events if e["kind"] == "standstill"]
    assert 2 * math.pi / times[1] == pytest.approx(found["omega"][0], rel=1e-5)


def test_frequencies_do_not_depend_on_units_place_and_direction():
    """The double pendulum in mm, shifted, with everything turned by 30 degrees."""
    turn = np.exp(1j * np.radians(30))
    o, a, b = (1000 * turn * z + 700 - 300j for z in (0, -1j, -2j))
    g = G * turn * -1j
    text = f"""
units: {{length: mm, angle: rad, mass: g}}
nodes: {{O: [{o.real}, {o.imag}], A: [{a.real}, {a.imag}], B: [{b.real}, {b.imag}]}}
ground: [O]
links: {{upper: [O, A], lower: [A, B]}}
actuators: {{s: {{pivot: O, arm: A}}, e: {{pivot: A, arm: B, reference: O}}}}
masses: {{upper: {{mass: 1000, inertia: 1/12}}, lower: {{mass: 1000, inertia: 1/12}}}}
gravity: [{g.real}, {g.imag}]
"""
    assert omegas(text, free="s,e") == pytest.approx([2.680114012253375, 7.188670870287714], rel=1e-12)


def test_the_rotor_of_a_motor_counts_with_the_square_of_its_ratio():
    """Behind a ratio of 20 a rotor of 5e-4 kg m^2 adds 0.2 to J = 1/3 kg m^2."""
    rotor = bar(free="free: true, rotor: {inertia: 5e-4, ratio: 20}")
    assert omegas(rotor) == pytest.approx([math.sqrt(0.5 * G / (1 / 3 + 0.2))], rel=1e-13)


# -- refusals ---------------------------------------------------------------------------------------


def test_a_position_without_balance_is_refused_with_what_remains():
    with pytest.raises(UsageError) as refused:
        gimcli.modes(gimcli.loads(bar()), q=-60)
    assert f"{-0.5 * G * math.cos(math.radians(60)):.6g} N m remain on q (50 %" in str(refused.value)
    assert "or settle" in str(refused.value)
    assert gimcli.modes(gimcli.loads(bar()), q=-60, settle=True)["omega"] == pytest.approx([3.836013555763327])


def test_a_constant_torque_that_is_too_great_has_no_equilibrium(tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text(bar("loads: {t: {on: bar, torque: 6}}"))
    done = gim("modes", path, "--settle", "--json")
    assert (done.code, done.json["status"], done.json["modes"]) == (5, "not-converged", [])
    assert "remain on q" in gim("modes", path, "--settle").text


def test_forces_that_push_an_input_to_its_limit_have_a_status():
    """The slider of a slider-crank is pulled outwards: where crank and rod are in line, its travel ends."""
    text = """
nodes: {O: [0, 0], A: [0, 1], B: [2, 0], X: [4, 0]}
ground: [O, X]
links: {crank: [O, A], rod: [A, B]}
prismatic: {guide: {node: B, guide: [O, X]}}
actuators: {x: {node: B, guide: [O, X]}}
masses: {B: 2}
loads: {pull: {on: B, force: [30, 0]}}
"""
    found = gimcli.modes(gimcli.loads(text), settle=True)
    assert (found.status, found.answered, len(found["kind"])) == ("unreachable", False, 0)
    assert found.inputs["x"] == pytest.approx(1 + math.sqrt(5), abs=1e-3)


def test_the_start_of_a_free_input_is_the_position():
    found = gimcli.modes(gimcli.loads(bar(free="free: true, start: -90, law: {from: 0, to: 90}")))
    assert found.inputs == {"q": -90.0}


# -- the command and its files ----------------------------------------------------------------------


def test_the_command_prints_frequencies_shapes_and_what_is_left_out(tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text(SLIDER_CRANK + "friction: {O: {mu: 0.1, radius: 0.01}}\n")
    done = gim("modes", path)
    assert "2.61329" in done.text
    assert "16.4198" in done.text
    report = json.loads(gim("modes", path, "--json").text)
    assert report["left_out"] == ["O"]
    assert report["modes"][0]["shape"]["B.dx"] == pytest.approx(-0.101678107607332)


def test_positions_of_the_pictures_satisfy_the_constraints():
    """Both extremes and the whole clip, on the two sides of the equilibrium; the amplitude is seen."""
    found = gimcli.modes(gimcli.loads(SLIDER_CRANK), motor=60)
    clip = found.animation().clips[0]
    mechanism = found.mechanism
    z = (clip.positions - mechanism.origin) / mechanism.scale
    inputs = np.radians(clip.table.floats("motor"))[None, :]
    assert residual(mechanism, z.T, inputs).total.max() < 1e-12
    assert clip.closed
    assert inputs.min() < math.radians(50) < math.radians(70) < inputs.max()
    assert inputs[0] == pytest.approx(math.pi / 3 + np.ptp(inputs) / 2 * np.cos(np.linspace(0, 2 * math.pi, 49)))
    assert "shown with an amplitude of" in clip.note


def test_each_mode_has_a_panel_and_a_clip(tmp_path):
    found = gimcli.modes(gimcli.loads(chain(3)))
    assert [panel.title[0] for panel in found.picture().pictures] == ["1", "2", "3"]
    assert len(found.animation().clips) == 3
    found.save(tmp_path / "m.svg", tmp_path / "m.html", tmp_path / "m.csv")
    assert (tmp_path / "m.svg").stat().st_size > 10_000


# -- equilibria on other branches -------------------------------------------------------------------


def test_the_assembly_of_an_equilibrium_is_named():
    """The list names it, the refusal of `modes` names it, and there the frequency is that of its stiffness."""
    mechanism = gimcli.load("hatch")
    second = gimcli.equilibrium(mechanism).report()["equilibria"][1]
    assert second["assembly"] == 2
    with pytest.raises(UsageError):
        gimcli.modes(mechanism, at=second["inputs"])
    there = gimcli.modes(gimcli.assembled(mechanism, assembly=2, at=second["inputs"]), at=second["inputs"])
    assert there.report()["K"][0][0] == pytest.approx(second["stiffness"][0][0], rel=1e-6)


# -- positions in which masses cannot move ----------------------------------------------------------

DEAD = """
units: {length: cm}
nodes: {E: [10, 0], F: [10.5, 0.5], G: [13, 2.5], H: [14, 0]}
ground: [E, H]
links: {crank: [E, F], coupler: [F, G], rocker: [G, H]}
actuators: {q: {pivot: E, arm: F, law: {by: 360}, free: true}}
gravity: [0, -9.81]
"""
CRANK, COUPLER, ROCKER = math.hypot(0.5, 0.5), math.hypot(2.5, 2.0), math.hypot(1.0, 2.5)


def height(q):
    """Return the height [cm] of G above the ground, from two circles, for a crank angle [rad]."""
    f = CRANK * np.exp(1j * q)
    d = 4.0 - f
    along = (abs(d) ** 2 + COUPLER**2 - ROCKER**2) / (2.0 * abs(d))
    return (f + d / abs(d) * (along + 1j * math.sqrt(COUPLER**2 - along**2))).imag


def test_an_equilibrium_in_which_the_only_mass_cannot_move():
    """G is lowest where the crank and the coupler overlap: E-G is the difference of their lengths."""
    away = COUPLER - CRANK
    turn = math.acos((away**2 + 16.0 - ROCKER**2) / (8.0 * away))
    with pytest.raises(ModelError):
        gimcli.modes(gimcli.loads(DEAD + "masses: {G: 2}"), settle=True)
    found = gimcli.modes(gimcli.loads(DEAD + "masses: {G: 2, crank: {mass: 1e-9, inertia: 1e-3}}"), settle=True)
    lowest = math.degrees(turn) + 180.0
    assert found.inputs["q"] == pytest.approx(lowest, abs=1e-6)
    h, q = 1e-4, math.radians(lowest)
    stiffness = 2.0 * 9.81 * 0.01 * (height(q + h) - 2.0 * height(q) + height(q - h)) / h**2
    assert found["omega"] == pytest.approx([math.sqrt(stiffness / 1e-3)], rel=1e-6)
