"""Masses and loads at nodes: closed forms of piston, pendulum, trammel and oscillator, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from heavy_models import motion_forces

import gimcli
from gimcli import ModelError
from gimcli.model.source import read_source
from gimcli.motion.motion import trace
from gimcli.positions.options import Options

R, L, SPEED, PISTON, GAS = 0.05, 0.2, 30.0, 0.8, 500.0
ENGINE = f"""\
units: {{angle: rad}}
nodes: {{O: [0, 0], A: [{R}, 0], B: [{R + L}, 0], G: [1, 0]}}
ground: [O, G]
links: {{crank: [O, A], rod: [A, B]}}
prismatic: {{slide: {{node: B, guide: [O, G]}}}}
actuators: {{motor: {{pivot: O, arm: A, law: {{from: 0.3, rate: {SPEED}, turns: 1}}}}}}
"""


def forces(text: str, steps: int = 12) -> tuple[Any, np.ndarray]:
    """Return the forces of a slider-crank along its motion, and the angles of its crank."""
    found = gimcli.forces(gimcli.loads(text), steps=steps)
    assert set(found.status) == {"ok"}
    return found, found["motor"]


def piston(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the acceleration of the piston, its derivative by the crank angle, and the slope of the rod.

    x = r cos q + sqrt(l^2 - r^2 sin^2 q), at constant speed.
    """
    s, c = R * np.sin(angle), R * np.cos(angle)
    root = np.sqrt(L**2 - s**2)
    slope = -s - s * c / root
    second = -c - (c**2 - s**2) / root - (s * c) ** 2 / root**3
    return second * SPEED**2, slope, -s / root


@pytest.mark.parametrize("name", ["B", "slide"])
def test_the_crank_torque_of_a_piston_mass_and_a_gas_force(name: str) -> None:
    """By virtual work; the rod without mass is a two-force member, and the guide bears the transverse force."""
    loaded = f"masses: {{{name}: {PISTON}}}\nloads: {{gas: {{on: {name}, force: [-{GAS}, 0]}}}}\n"
    found, angle = forces(ENGINE + loaded)
    acceleration, slope, rod = piston(angle)
    thrust = PISTON * acceleration + GAS
    assert found["motor.effort"] == pytest.approx(thrust * slope, abs=1e-9)
    assert found["A.fx"] == pytest.approx(thrust, abs=1e-9)
    assert found["A.fy"] == pytest.approx(thrust * rod, abs=1e-9)
    assert found["slide.normal"] == pytest.approx(-thrust * rod, abs=1e-9)
    assert found["shaking.fx"] == pytest.approx(-PISTON * acceleration - GAS, abs=1e-9)


def test_a_mass_at_a_node_is_a_mass_at_this_end_of_the_member() -> None:
    """All but the forces at the pin itself, which then carries the mass, are those of a mass on the member."""
    gravity = "gravity: [0, -9.81]\n"
    ours, _ = forces(ENGINE + gravity + "masses: {B: 0.8, A: {mass: 0.4}}\n")
    theirs, _ = forces(ENGINE + gravity + f"masses: {{rod: {{mass: 0.8, inertia: 0, centre: [{L}, 0]}}, "
                       f"crank: {{mass: 0.4, inertia: 0, centre: [{R}, 0]}}}}\n")  # fmt: skip
    same = ["motor.effort", "O.fx", "O.fy", "slide.normal", "shaking.fx", "shaking.fy", "shaking.moment",
            "power.gravity", "energy.kinetic", "energy.potential"]  # fmt: skip
    for column in same:
        assert ours[column] == pytest.approx(theirs[column], rel=1e-9, abs=1e-9), column
    assert ours["A.rod.fx"] == pytest.approx(theirs["A.fx"], abs=1e-9)


def test_the_pin_carries_its_mass() -> None:
    """The forces of the pin on crank and rod add up to its weight less mass times acceleration."""
    mass, gravity = 0.4, np.array([0.5, -9.81])
    found, angle = forces(ENGINE + f"masses: {{A: {mass}, B: 1}}\ngravity: {gravity.tolist()}\n")
    for axis, part, weight in (("x", np.cos(angle), gravity[0]), ("y", np.sin(angle), gravity[1])):
        total = found[f"A.crank.f{axis}"] + found[f"A.rod.f{axis}"]
        assert total == pytest.approx(mass * (weight + SPEED**2 * R * part), abs=1e-9)


def test_a_force_on_a_pin_is_shared_by_its_members() -> None:
    found, _ = forces(ENGINE + "loads: {push: {on: A, force: [30, -40]}}\n")
    assert found["A.crank.fx"] + found["A.rod.fx"] == pytest.approx(np.full(13, 30.0))
    assert found["A.crank.fy"] + found["A.rod.fy"] == pytest.approx(np.full(13, -40.0))


def test_a_bob_at_a_node_has_the_period_of_the_elliptic_integral() -> None:
    length, amplitude = 0.7, 1.9
    ends = [length * math.sin(amplitude), -length * math.cos(amplitude)]
    text = f"""
units: {{angle: rad}}
nodes: {{O: [0, 0], A: {ends}}}
ground: [O]
links: {{rod: [O, A]}}
actuators: {{swing: {{pivot: O, arm: A, free: true}}}}
masses: {{A: 3}}
gravity: [0, -9.81]
"""
    a, b = 1.0, math.cos(amplitude / 2.0)
    for _ in range(6):
        a, b = (a + b) / 2.0, math.sqrt(a * b)
    period = 2.0 * math.pi * math.sqrt(length / 9.81) / a
    found = gimcli.simulate(gimcli.loads(text), period, dt=period / 4, rtol=1e-10)
    start = amplitude - math.pi / 2.0
    assert found["swing"] == pytest.approx([start, -math.pi / 2, -math.pi - start, -math.pi / 2, start], abs=1e-7)


TRAMMEL = """\
units: {length: mm, angle: rad, mass: g}
nodes: {O: [0, 0], X: [4, 0], Y: [0, 4], A: [300, 0], M: [150, 200], B: [0, 400]}
ground: [O, X, Y]
elements: {bar: [A, M, B]}
prismatic: {along_x: {node: A, guide: [O, X]}, along_y: {node: B, guide: [O, Y]}}
actuators: {angle: {pivot: A, arm: B, free: true, law: {rate: 2, turns: 1}}}
"""


def test_equal_masses_at_the_ends_of_a_trammel_have_a_constant_inertia() -> None:
    """A runs as L cos q, B as L sin q: the kinetic energy is m L^2 q'^2 / 2."""
    found = gimcli.reduce(gimcli.loads(TRAMMEL + "masses: {A: 2500, B: 2500}\n"), steps=12)
    assert found["J"] == pytest.approx(np.full(13, 2.5 * 0.5**2))
    moved = gimcli.forces(gimcli.loads(TRAMMEL + "masses: {A: 2500, B: 2500}\n"), steps=12)
    assert moved["angle.effort"] == pytest.approx(np.zeros(13), abs=1e-9)


def test_a_mass_in_the_middle_of_a_trammel_swings_as_a_pendulum_of_half_its_length() -> None:
    """The middle of the bar stays at half the length of the bar from the crossing of the guides."""
    found = gimcli.simulate(gimcli.loads(TRAMMEL + "masses: {M: 70}\ngravity: [0, -9.81]\n"), 1.2, dt=0.2, rtol=1e-10)
    pendulum = gimcli.simulate(
        gimcli.loads("""
units: {angle: rad}
nodes: {O: [0, 0], A: [0.15, 0.2]}
ground: [O]
links: {rod: [O, A]}
actuators: {swing: {pivot: O, arm: A, free: true}}
masses: {rod: {mass: 1, inertia: 0, centre: [0.25, 0]}}
gravity: [0, -9.81]
"""), 1.2, dt=0.2, rtol=1e-10)  # fmt: skip
    assert found["M.x"] / 1000 == pytest.approx(pendulum["A.x"], abs=1e-7)
    assert found["M.y"] / 1000 == pytest.approx(pendulum["A.y"], abs=1e-7)


OSCILLATOR = """\
nodes: {O: [0, 0], B: [0.5, 0], G: [1, 0]}
ground: [O, G]
prismatic: {slide: {node: B, guide: [O, G]}}
springs: {coil: {nodes: [O, B], stiffness: 80, free: 0.4}}
masses: {B: 5}
"""


def test_a_mass_on_a_spring_needs_no_member() -> None:
    """x = free + amplitude cos(w t), with w^2 = k / m."""
    text = OSCILLATOR + "actuators: {travel: {node: B, guide: [O, G], free: true}}\n"
    found = gimcli.simulate(gimcli.loads(text), 2.0, dt=0.25, rtol=1e-10)
    assert found["travel"] == pytest.approx(0.4 + 0.1 * np.cos(4.0 * found["time"]), abs=1e-8)


def test_the_force_that_drives_a_mass_on_a_spring() -> None:
    """F = m a + k (x - free), with x = 0.5 + 0.2 (3 s^2 - 2 s^3) over 2 s."""
    text = OSCILLATOR + "duration: 2\nactuators: {m: {node: B, guide: [O, G], law: {by: 0.2, profile: cubic}}}\n"
    found = gimcli.forces(gimcli.loads(text), steps=8)
    s = found["time"] / 2.0
    expected = 5 * 0.2 * (6 - 12 * s) / 4 + 80 * (0.1 + 0.2 * (3 * s**2 - 2 * s**3))
    assert found["m.effort"] == pytest.approx(expected, abs=1e-9)
    assert found["slide.normal"] == pytest.approx(np.zeros(9), abs=1e-12)


ALL = sorted(path.stem for path in Path("models").glob("*.yaml"))
FEW = ["scissor_lift", "scotch_yoke", "whitworth"]


@pytest.mark.parametrize("name", [*FEW, *(pytest.param(n, marks=pytest.mark.soak) for n in ALL if n not in FEW)])
def test_power_balances_with_masses_and_loads_at_all_nodes(name: str) -> None:
    """Inverse dynamics and the reduced equation, of other kernels, agree on energies; power balances."""
    rng = np.random.default_rng(2)
    data = dict(read_source(Path(f"models/{name}.yaml")).data)
    length = {**data.get("units", {}), "length": "mm"}
    nodes = gimcli.load(data, "models").nodes
    data |= {"units": length, "masses": {node: float(rng.uniform(0.5, 2)) for node in nodes}, "gravity": [1, -9]}
    data["loads"] = {f"f{k}": {"on": node, "force": rng.normal(size=2).tolist()} for k, node in enumerate(nodes)}
    model = gimcli.load(data, "models")
    found = motion_forces(trace(model, 12, Options(jit="off")))
    good = found.good
    assert good.sum() > 6
    largest = np.abs(found.loads.kinetic_rate[good]).max() + np.abs(found.drive_power[good]).max()
    assert np.abs(found.power_error[good]).max() <= 1e-12 * largest
    if len(model.actuators) == 1:
        actuator = model.actuators[0]
        speed = (
            actuator.law(np.linspace(0, 1, 13), 1) / model.duration * (1.0 if actuator.rotary else model.scale * 1e-3)
        )
        energy = 0.5 * gimcli.reduce(model, steps=12)["J"] * speed**2
        assert energy[good] == pytest.approx(found.loads.kinetic[good], rel=1e-9)


@pytest.mark.parametrize(("text", "fragments"), [
    ("masses: {B: {mass: 1, inertia: 2}}", ["`inertia`", "'B' is a node", "name a member"]),
    ("masses: {B: {mass: 1, centre: [1, 2]}}", ["`centre`", "'B' is a node"]),
    ("masses: {crnk: 1}", ["member 'crnk'", "did you mean 'crank'"]),
    ("masses: {slid: 1}", ["'slid' is neither a member nor a node", "did you mean 'slide'"]),
    ("masses: {Z: 1}", ["node 'Z' belongs to no member or pair"]),
    ("masses: {both: 1}", ["'both' slides a member", "A or B"]),
    ("masses: {B: [1]}", ["expected a number or a mapping", "got [1]"]),
    ("masses: {B: -1}", ["masses.B", "of at least 0"]),
    ("loads: {f: {on: B, torque: 3}}", ["`torque`", "'B' is a node", "`force`"]),
    ("loads: {f: {on: B, follower: [3, 0]}}", ["`follower`", "'B' is a node"]),
    ("loads: {f: {on: B, force: [3, 0], at: [1, 2]}}", ["`at`", "'B' is a node", "remove it"]),
    ("loads: {f: {on: crnk, force: [3, 0]}}", ["member 'crnk'", "did you mean 'crank'"]),
])  # fmt: skip
def test_what_a_node_cannot_bear_is_refused(text: str, fragments: list[str]) -> None:
    model = ENGINE.replace("nodes: {", "nodes: {Z: [1, 1], ").replace(
        "{slide:", "{both: {nodes: [A, B], guide: [O, G]}, slide:"
    )
    with pytest.raises(ModelError) as caught:
        gimcli.loads(model + text)
    assert len(caught.value.faults) == 1
    assert all(fragment in str(caught.value) for fragment in fragments), str(caught.value)


def test_a_member_wins_over_a_node_of_its_name() -> None:
    text = ENGINE.replace("rod: [", "B: [") + "masses: {B: {mass: 2, inertia: 1}}\n"
    (inertia,) = gimcli.loads(text).dynamics.inertias
    assert (inertia.member, inertia.node, inertia.moment) == (2, -1, 1.0)


def test_a_mass_at_a_fixed_node_has_no_effect() -> None:
    model = gimcli.loads(ENGINE + "masses: {G: 1, B: 1}\nloads: {f: {on: O, force: [1, 0]}}\n")
    texts = [one["text"] for one in gimcli.check(model).warnings]
    assert any("mass of G has no effect" in text for text in texts)
    assert any("load f has no effect" in text for text in texts)
    assert gimcli.forces(model, steps=4)["motor.effort"] == pytest.approx(
        gimcli.forces(gimcli.loads(ENGINE + "masses: {B: 1}\n"), steps=4)["motor.effort"]
    )


def test_the_mass_of_a_node_is_a_dimension() -> None:
    model = gimcli.loads(ENGINE + "masses: {B: 2}\n")
    assert model.with_({"B.mass": 3}).dynamics.inertias[0].mass == 3.0


def test_pictures_show_masses_and_loads_at_nodes(tmp_path) -> None:
    model = gimcli.loads(ENGINE + "masses: {B: 2}\nloads: {f: {on: B, force: [1, 0]}}\n")
    gimcli.solve(model).save(str(tmp_path / "a.svg"))
    gimcli.trace(model, steps=6).save(str(tmp_path / "a.html"))
    assert (tmp_path / "a.html").stat().st_size > 10_000
