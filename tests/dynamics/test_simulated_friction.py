"""Dry friction in simulations: closed forms, an independent integration, limits, and agreement with the reactions."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import gimcli
from gimcli.dynamic_data import Friction
from gimcli.dynamics.coulomb import sliding_forces
from gimcli.dynamics.coulomb_solver import FrictionStatus
from gimcli.dynamics.integration import Integration
from gimcli.dynamics.simulation import Settings, simulate
from gimcli.dynamics.simulation_table import reaction_units, reactions, simulation_table
from gimcli.dynamics.statics import statics
from gimcli.kernels.jit import compiled
from gimcli.mechanism import FRAME
from gimcli.positions.dispatch import plain
from gimcli.progress import no_progress
from gimcli.status import Status
from gimcli.structure.joints import sliding_pairs
from gimcli.structure.rotation import members_of

TURNS = (-0.08038, 0.06076, -0.04114, 0.02152, -0.0019)
"""Turning points [m] of a block of 1 kg on a spring of 100 N/m, mu 0.1, from 0.1 m: 2 mu m g / k less each time."""

BLOCK = """
units: {length: m}
nodes: {G: [-1, 0], H: [1, 0], P: [0, 0], Q: [0.2, 0]}
ground: [G, H]
links: {block: {nodes: [P, Q]}}
prismatic: {guide: {nodes: [P, Q], guide: [G, H]}}
actuators: {travel: {node: P, guide: [G, H], free: true}}
masses: {block: {mass: 2, inertia: 0.1, centre: [0.1, 0]}}
"""
PENDULUM = """
units: {length: m}
nodes: {O: [0, 0], A: [0.8, -0.6]}
ground: [O]
links: {rod: {nodes: [O, A]}}
actuators: {swing: {pivot: O, arm: A, free: true}}
masses: {rod: {mass: 2, inertia: 0.1, centre: [0.4, 0]}}
gravity: [0, -9.81]
friction: {O: {mu: 0.3, radius: 0.1}}
"""
CRANK = """
units: {length: m}
nodes: {O: [0, 0], A: [0.1, 0], B: [0.4, 0], C: [0.45, 0], G: [0, 0], H: [1, 0]}
ground: [O, G, H]
links: {crank: {nodes: [O, A]}, rod: {nodes: [A, B]}, slider: {nodes: [B, C]}}
prismatic: {guide: {nodes: [B, C], guide: [G, H]}}
actuators: {motor: {pivot: O, arm: A, free: true, start: 60, speed: 300, effort: 3, rotor: {inertia: 0.001, ratio: 3}}}
masses: {crank: {mass: 1, inertia: 0.02}, rod: {mass: 0.8, inertia: 0.006}, slider: {mass: 1.2, inertia: 0}}
gravity: [0, -9.81]
friction: {O: {mu: 0.2, radius: 0.02}, A: {mu: 0.2, radius: 0.02}, B: {mu: 0.2, radius: 0.015},
           guide: {mu: 0.1, length: 0.08}}
"""
SLOT = """
units: {length: m}
nodes: {O: [0, 0], A: [0.1, 0.05], Q: [-0.3, 0], R: [0.2, 0.06]}
ground: [O, Q]
links: {crank: {nodes: [O, A]}, arm: {nodes: [Q, R]}}
prismatic: {slot: {node: A, guide: [Q, R]}}
actuators: {motor: {pivot: O, arm: A, free: true, start: 60, speed: 300, effort: 1}}
masses: {crank: {mass: 1, inertia: 0.02}, arm: {mass: 0.8, inertia: 0.006}, A: 0.3}
gravity: [0, -9.81]
friction: {O: {mu: 0.2, radius: 0.02}, slot: {mu: 0.3}, Q: {mu: 0.1, radius: 0.05, viscous: 0.1}}
"""
ROD = """
units: {length: m}
nodes: {G: [-5, 0], H: [5, 0], P: [0, 0], Q: [0.5, 0.8660254037844386]}
ground: [G, H]
links: {rod: {nodes: [P, Q], length: 1}}
prismatic: {floor: {node: P, guide: [G, H]}}
actuators:
  x: {node: P, guide: [G, H], free: true, start: 5, speed: -1}
  tilt: {pivot: P, arm: Q, free: true, start: 60}
masses: {rod: {mass: 1, inertia: 0.08333333333333333, centre: [0.5, 0]}}
gravity: [0, -9.81]
"""


def run(text, end, rows=51, slip=0.0, method="", kernels=compiled):
    return simulate(gimcli.loads(text), np.linspace(0.0, end, rows), Settings(method, slip=slip), kernels)


def spring_block(slip, method="", end=2.0):
    mechanism = gimcli.load(MODELS / "spring_block.yaml")
    return simulate(mechanism, np.linspace(0.0, end, 101), Settings(method, slip=slip), compiled)


def places(found):
    """Return the distance of the block from the place where the spring is unloaded, at the standstills [m]."""
    stops = [e.inputs for e in found.events if e.kind == "standstill"]
    return np.array([found.mechanism.value_to_file(0, u[:1])[0] - 200.0 for u in stops]) / 1000.0


# -- a block on a spring ----------------------------------------------------------------------------


def test_the_block_on_a_spring_without_length_turns_at_the_same_places():
    """A spring of free length 0 between two nodes on the guide has the same force k x."""
    model = MODELS / "spring_block.yaml"
    text = model.read_text().replace("  P: [100, 0] ", "  K: [0, 0]\n  P: [100, 0] ")
    text = text.replace("ground: [G, H]", "ground: [G, H, K]", 1)
    text = text.replace(
        "{node: P, guide: [G, H], stiffness: 100, free: 200}", "{nodes: [K, P], stiffness: 100, free: 0}"
    )
    found = run(text, 2.0, 201, 1e-6)
    assert np.abs(places(found) - TURNS).max() < 1e-8


@pytest.mark.parametrize("method", ["", "radau"])
def test_the_block_on_a_spring_turns_and_sticks_where_the_closed_form_does(method):
    found = spring_block(1e-6, method)
    assert np.abs(places(found) - TURNS).max() < 1e-8
    stops = [e.time for e in found.events if e.kind == "standstill"]
    assert np.abs(np.array(stops) - math.pi / 10.0 * np.arange(1, 6)).max() < 1e-5
    (stuck,) = (e for e in found.events if e.kind == "sticks")
    assert stuck.pair == "guide"
    assert abs(stuck.time - math.pi / 2.0) < 1e-5
    way = 0.5095  # m, of all half swings
    assert abs(found.energy[2, -1] - 0.1 * 9.81 * way) < 1e-7
    assert found.worst_drift < 1e-7


def test_what_should_stand_creeps_less_than_a_ten_thousandth_of_the_amplitude():
    """By default, also over a time ten times as long."""
    for end in (2.0, 20.0):
        found = spring_block(0.0, end=end)
        last = found.mechanism.value_to_file(0, found.inputs[0, 0])[-1] / 1000.0 - 0.2
        assert abs(last - TURNS[-1]) < 1e-5 * 0.1


def test_the_error_halves_with_the_slip_speed():
    errors = []
    for slip in (5e-4, 2.5e-4, 1.25e-4):
        found = spring_block(slip)
        errors.append(found.mechanism.value_to_file(0, found.inputs[0, 0])[-1] / 1000.0 - 0.2 - TURNS[-1])
    ratios = np.array(errors[:-1]) / errors[1:]
    assert np.abs(ratios - 2.0).max() < 0.02


def test_the_integrators_agree():
    """The explicit method resolves a large slip speed; plain and compiled kernels give the same numbers."""
    one, other = (spring_block(1e-2, method, 0.5).inputs[0] for method in ("", "dop853"))
    assert np.abs(one - other).max() < 1e-7
    two = [run(PENDULUM, 0.3, 7, 1e-3, "rk45", kernels).inputs for kernels in (plain, compiled)]
    assert np.abs(two[0] - two[1]).max() < 1e-13


# -- guides -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mu", [0.4, 0.6])
def test_a_block_on_an_incline_slides_if_the_slope_is_above_mu(mu):
    """Slope 0.5; the weight is turned instead of the guide. The normal force has no moment about the middle."""
    angle = math.atan(0.5)
    weight = f"gravity: [{9.81 * math.sin(angle)}, {-9.81 * math.cos(angle)}]\n"
    found = run(BLOCK + weight + f"friction: {{guide: {{mu: {mu}, length: 0.3}}}}", 0.4, slip=1e-7)
    travel = found.inputs[0, 0] * found.mechanism.scale
    gain = 9.81 * (math.sin(angle) - mu * math.cos(angle))
    assert np.abs(travel - travel[0] - 0.5 * max(gain, 0.0) * found.time**2).max() < 1e-6
    assert [e.kind for e in found.events] == ([] if gain > 0.0 else ["sticks"])


@pytest.mark.parametrize("mu", [0.1, 0.3, 0.56, 0.58])
def test_a_drawer_pushed_off_its_line_locks_at_half_its_length_by_the_offset(mu):
    """Two contacts 0.4 m apart, pushed at 0.35 m from the line: locked iff mu >= 0.4 / 0.7."""
    text = (
        BLOCK
        + f"""
loads: {{push: {{on: block, at: [0.1, 0.35], force: [5, 0]}}}}
friction: {{guide: {{mu: {mu}, length: 0.4}}}}
"""
    )
    found = run(text, 0.3, slip=1e-7)
    travel = found.inputs[0, 0] * found.mechanism.scale
    gain = max(0.0, 5.0 * (1.0 - mu * 2.0 * 0.35 / 0.4)) / 2.0
    assert np.abs(travel - travel[0] - 0.5 * gain * found.time**2).max() < 1e-6


def test_a_growing_push_moves_the_block_when_it_exceeds_the_friction(tmp_path):
    (tmp_path / "push.csv").write_text("time,factor\n0,0\n2,2\n", encoding="utf-8")
    text = (
        BLOCK
        + """
gravity: [0, -9.81]
loads: {push: {on: block, at: [0.1, 0], force: [4, 0], table: push.csv, over: time}}
friction: {guide: {mu: 0.2, length: 0.4}}
"""
    )
    (tmp_path / "m.yaml").write_text(text, encoding="utf-8")
    mechanism = gimcli.load(tmp_path / "m.yaml")
    found = simulate(mechanism, np.linspace(0.0, 2.0, 41), Settings(slip=1e-7), compiled)
    sticks, slides = found.events
    assert (sticks.kind, sticks.time, slides.kind) == ("sticks", 0.0, "slides")
    begin = 0.2 * 2.0 * 9.81 / 4.0
    assert abs(slides.time - begin) < 2e-3
    after = np.clip(found.time - begin, 0.0, None)
    assert np.abs((found.inputs[0, 0] - found.inputs[0, 0, 0]) * mechanism.scale - after**3 / 3.0).max() < 5e-6
    assert found.worst_drift < 1e-6  # the energies have a tolerance of their own


# -- pins ---------------------------------------------------------------------------------------------


def test_a_pendulum_with_friction_in_its_pivot_agrees_with_an_own_integration():
    """The pin force of a pendulum in closed form; the moment equation is solved for the acceleration by bisection."""
    mass, inertia, arm, g, slip = 2.0, 0.1, 0.4, 9.81, 1e-4
    rho = 0.1 * 0.3 / math.sqrt(1.09)

    def slopes(_, y):
        q, omega = y

        def miss(alpha):
            across, along = mass * (arm * alpha + g * math.cos(q)), mass * (-arm * omega**2 + g * math.sin(q))
            moment = rho * math.sqrt(across**2 + along**2) * math.tanh(omega / slip)
            return (inertia + mass * arm**2) * alpha + mass * g * arm * math.cos(q) + moment

        return [omega, brentq(miss, -1e3, 1e3, xtol=1e-13, rtol=1e-14)]

    times = np.linspace(0.0, 3.0, 31)
    start = [math.atan2(-0.6, 0.8), 0.0]
    expected = solve_ivp(slopes, (0.0, 3.0), start, method="LSODA", rtol=1e-9, atol=1e-11, t_eval=times).y
    found = run(PENDULUM, 3.0, 31, slip)
    assert np.abs(found.inputs[0, 0] - expected[0]).max() < 1e-6
    assert np.abs(found.inputs[1, 0] - expected[1]).max() < 1e-6
    assert found.worst_drift < 1e-7


def test_the_acceleration_of_a_rod_on_a_rough_line():
    """Sliding with its upper end ahead: N = m g / (1 + 3 cos^2 - 3 mu sin cos). Source: Painlevé 1895."""
    c, s, mu = 0.5, math.sqrt(0.75), 1.3
    found = run(ROD + f"friction: {{floor: {{mu: {mu}}}}}", 0.001, 3)
    normal = 9.81 / (1.0 + 3.0 * c * c - 3.0 * mu * s * c)
    assert abs(found.inputs[2, 1, 0] - 6.0 * normal * (mu * s - c)) < 1e-9 * normal
    assert found.status is Status.OK


def test_a_rod_jams_where_no_normal_force_continues_the_motion():
    """1 + 3 cos^2 < 3 mu sin cos: mu > 1.347 at 60 degrees."""
    found = run(ROD + "friction: {floor: {mu: 1.35}}", 0.1, 3)
    assert found.status is Status.JAMMED
    assert [e.kind for e in found.events] == ["jam"]
    assert run(ROD + "friction: {floor: {mu: 1.34}}", 0.001, 3).status is Status.OK


# -- agreement with the reactions -----------------------------------------------------------------------


@pytest.mark.parametrize("text", [CRANK, SLOT])
def test_reactions_carry_the_friction_of_the_simulation(text):
    """The effort of the free input comes out of the equations of all bodies, and the power is balanced."""
    found = run(text, 0.5)
    forces = reactions(found)
    motor = 3.0 if text is CRANK else 1.0
    assert np.abs(forces.effort(0) - motor).max() < 1e-11
    assert np.abs(forces.power_error).max() < 1e-10
    table = {c.name: c.values for c in simulation_table(found, found.time, forces).columns}
    assert set(reaction_units(found.mechanism)) <= set(table)
    lost = sum(values for name, values in table.items() if name.startswith("friction.power."))
    assert np.all(lost <= 0.0)
    assert found.worst_drift < 1e-7


@pytest.mark.parametrize("text", [CRANK, SLOT])
def test_the_forces_of_the_simulated_motion_are_those_of_exact_friction(text):
    """`gim forces` solves for the friction by itself, from the directions of sliding."""
    found = run(text, 0.5)
    _, unknowns, _, dry = sliding_forces(statics(found.mechanism), found.course(), plain)
    sliding = dry.codes == FrictionStatus.SLIDING
    assert sliding.sum() > 45
    difference = np.abs(unknowns - reactions(found).unknowns)[:, sliding]
    assert difference.max() < 1e-8 * np.nanmax(np.abs(unknowns))


def test_the_friction_of_a_sliding_pin_is_its_circle_times_its_force():
    found = run(CRANK, 0.5)
    table = {c.name: c.values for c in simulation_table(found, found.time, reactions(found)).columns}
    for name, radius in (("O", 0.02), ("A", 0.02), ("B", 0.015)):
        force = np.hypot(table[f"{name}.fx"], table[f"{name}.fy"])
        circle = radius * 0.2 / math.sqrt(1.04)
        moving = np.abs(table[f"friction.power.{name}"]) > 1e-2
        assert moving.sum() > 30
        assert np.abs(np.abs(table[f"{name}.friction"]) - circle * force)[moving].max() < 1e-9
    middle = table["guide.moment"] - 0.025 * table["guide.normal"]  # about the middle between B and C
    two = 0.1 * np.maximum(np.abs(table["guide.normal"]), 2.0 * np.abs(middle) / 0.08)
    moving = np.abs(table["friction.power.guide"]) > 1e-2
    assert np.abs(np.abs(table["guide.friction"]) - two)[moving].max() < 1e-8


def test_a_driven_input_beside_a_free_one_bears_the_friction():
    text = """
units: {length: m}
nodes: {O: [0, 0], A: [0, -1], B: [0.6, -1.8]}
ground: [O]
links: {upper: {nodes: [O, A]}, lower: {nodes: [A, B]}}
actuators:
  one: {pivot: O, arm: A, law: {from: -80, to: 100, profile: cycloidal}, rotor: {inertia: 0.01, ratio: 5}}
  two: {pivot: A, arm: B, reference: O, free: true}
duration: 1
masses: {upper: {mass: 1, inertia: 0.1}, lower: {mass: 1, inertia: 0.1}}
gravity: [0, -9.81]
friction: {O: {mu: 0.4, radius: 0.1}, A: {mu: 0.3, radius: 0.1}}
"""
    found = run(text, 1.0, 21)
    forces = reactions(found)
    assert np.abs(forces.effort(1)).max() < 1e-9
    assert np.abs(forces.effort(0) - found.efforts[0]).max() < 1e-9
    assert found.worst_drift < 1e-7
    assert found.energy[2, -1] > 0.1


# -- limits -------------------------------------------------------------------------------------------


def with_friction_everywhere(mechanism, mu):
    """Return a mechanism with dry friction in all pairs, and at least one free input."""
    dynamics, held = mechanism.dynamics, members_of(mechanism)
    viscous = {f.name: f.damping for f in dynamics.frictions}
    names = [(mechanism.nodes[n], n) for n, members in enumerate(held) if len(members) > 1]
    frictions = [Friction(n, viscous.get(n, 0.0), node=node, mu=mu, radius=0.05) for n, node in names]
    for pair in sliding_pairs(mechanism):
        length = 0.1 if len(pair.slides) > 1 else 0.0
        damping = viscous.get(pair.name, 0.0)
        frictions.append(Friction(pair.name, damping, slide=pair.slides[0], mu=mu, length=length))
    releases = dynamics.releases
    if not any(r.free for r in releases):
        releases = (replace(releases[0], free=True), *releases[1:])
    gears = tuple(replace(gear, pressure_angle=0.0) for gear in mechanism.gears)  # else friction there is refused
    return replace(mechanism, gears=gears, dynamics=replace(dynamics, frictions=tuple(frictions), releases=releases))


def dynamic_models():
    models = {path.stem: gimcli.load(path) for path in sorted(MODELS.glob("*.yaml"))}
    moved = {n: m for n, m in models.items() if any(i.mass and i.member != FRAME for i in m.dynamics.inertias)}
    return [n for n, m in moved.items() if m.actuators and not statics(m).surplus]


@pytest.mark.parametrize("stem", dynamic_models())
def test_the_equations_of_all_bodies_give_the_accelerations_of_the_reduced_ones(stem):
    """Two formulations without friction (a slip speed without bound): weight, loads, springs, dampers, rotors, laws."""
    mechanism = with_friction_everywhere(gimcli.load(MODELS / f"{stem}.yaml"), 0.2)
    work = Integration(mechanism, np.array([0.0, 1.0]), Settings(slip=1e300), plain, no_progress)
    state, equations = work._start(0.0), work.equations
    own = len(equations.free)
    state[own : 2 * own] = np.linspace(0.7, -0.4, own)
    assert equations.move(0.0, state)
    both, efforts = equations.reducer.gain.copy(), equations.reducer.out.q[own:].copy()
    equations.friction = None
    assert equations.move(0.0, state)
    gain, needed = equations.reducer.gain, equations.reducer.out.q[own:]
    assert np.abs(both - gain).max() <= 1e-12 * max(1.0, np.abs(gain).max())
    assert np.abs(efforts - needed).max(initial=0.0) <= 1e-12 * max(1.0, np.abs(equations.reducer.out.q).max())


def test_small_friction_tends_to_none():
    one = run(CRANK.replace("mu: 0.2", "mu: 1e-12").replace("mu: 0.1", "mu: 1e-12"), 0.5)
    other = run(CRANK.split("friction:")[0], 0.5)
    assert np.abs(one.inputs[0] - other.inputs[0]).max() < 1e-7


def test_without_dry_friction_nothing_changes():
    found = run(CRANK.split("friction:")[0], 0.1, 3)
    assert found.friction is None


# -- errors and the command -----------------------------------------------------------------------------


@pytest.mark.usefixtures("unrendered")
def test_the_command_reports_the_slip_speed(tmp_path):
    found = gim("simulate", "spring_block", "--time", "1.6", "--slip", "1e-4", "--reactions", "-o", f"{tmp_path}/")
    assert "guide sticks" in found.text
    assert "slip speed of 1.0e-04 rad/s in pins" in found.text
    head = next(tmp_path.glob("*.csv")).read_text(encoding="utf-8").splitlines()[0]
    assert "guide.friction,friction.power.guide" in head
    report = gim("simulate", "spring_block", "--time", "1.6", "--json", "-o", f"{tmp_path}/").json
    assert report["slip"] == pytest.approx(1e-6 / 1.6)
    assert "guide" in [event.get("pair") for event in report["events"]]
