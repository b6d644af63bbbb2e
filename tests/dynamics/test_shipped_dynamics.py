"""Shipped models with masses: efforts against Lagrange's equation with closed forms, and results of single models."""

from __future__ import annotations

import numpy as np
import pytest
from bundled import run_model
from lagrangian import Machine, meet, ray, unit
from scipy.integrate import trapezoid
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq
from scipy.special import ellipk

import gimcli

PLACES = {}


def place(name):
    """Register the nodes of a model as a function of its input [rad or file's unit]."""

    def keep(function):
        PLACES[name] = function
        return function

    return keep


@place("engine")
def engine(q):
    a = 45 * ray(q)
    b = a.real + np.sqrt(145**2 - (0.8 - a.imag) ** 2) + 0.8j
    return {"A": a, "B": b, "C": b + 40}


@place("knuckle_press")
def knuckle_press(q):
    a = -760 + 420j + 120 * ray(q)
    k = meet(a, 632, 900j, 455, -1)
    b = 1j * (k.imag - np.sqrt(470**2 - k.real**2))
    return {"A": a, "K": k, "B": b, "T": b - 200j}


@place("pump_jack")
def pump_jack(q):
    a, s = 42 * ray(q), 111 + 132j
    e = meet(a, 132, s, 111, 1)
    return {"A": a, "E": e, "H": s - 129 * unit(e - s)}


@place("punch")
def punch(q):
    a = 4 * ray(q)
    b = 1j * (a.imag - np.sqrt(25**2 - a.real**2))
    return {"A": a, "B": b, "C": b - 12j}


@place("shaper")
def shaper(q):
    a = 260j + 90 * ray(q)
    d = 520 * unit(a)
    e = d.real - np.sqrt(150**2 - (540 - d.imag) ** 2) + 540j
    return {"A": a, "D": d, "E": e, "F": e - 300}


@place("wiper")
def wiper(q):
    a, o = 30 * ray(q), 240 + 40j
    b = meet(a, 250, o, 60, 1)
    return {"A": a, "B": b, "T": o + unit(b - o) * (-200 + 346.41j)}


@place("lift_table")
def lift_table(s):
    """The cylinder: s^2 = (0.35 cos)^2 + (0.85 sin)^2 of the angle of the bars."""
    sine = np.sqrt((s**2 - 0.35**2) / (0.85**2 - 0.35**2))
    bar = np.sqrt(1 - sine**2) + 1j * sine
    flat, top = 1.2 * bar.real, 1.2j * sine
    return {"R": flat, "M": 0.6 * bar, "K": 0.85 * bar, "T": top, "S": flat + top, "E": 1.2 + top}


@place("toggle_clamp")
def toggle_clamp(q):
    b = -40 + 40 * ray(q)
    shape = -27.8 + 68.9j
    a = meet(b, 30, 0, abs(shape), 1)
    return {"B": b, "A": a, "T": unit(a) * (80 + 5j) / unit(shape)}


@place("hatch")
def hatch(q):
    rear, front, lid = 1 + 10.5j, 10 + 9j - 18, 9 - 1.5j
    a = abs(rear) * ray(q)
    b = meet(a, abs(lid), 18, abs(front), 1)
    along = unit(b - a) / unit(lid)
    return {"A": a, "B": b, "S": a + along * (36 + 5j - rear), "L": a + along * (95 + 6j - rear)}


@place("garage_door")
def garage_door(q):
    return {"B": 1j * q, "T": np.sqrt(49 - (7 - q) ** 2) + 7j}


@place("swing")
def swing(q):
    a = 2j + 1.5 * ray(q)
    return {"A": a, "B": a + 1.2}


@place("strandbeest")
def strandbeest(q):
    """Jansen's numbers: b 41.5, c 39.3, d 40.1, e 55.8, f 39.4, g 36.7, h 65.7, i 49, j 50, k 61.9, m 15."""
    crank, o = 150 * ray(q), -380 - 78j
    up, low = meet(crank, 500, o, 415, -1), meet(crank, 619, o, 393, 1)
    back = meet(o, 401, up, 558, 1)
    knee = meet(back, 394, low, 367, -1)
    return {"J1": crank, "J2": up, "J4": low, "J3": back, "J5": knee, "foot": meet(low, 490, knee, 657, 1)}


@place("suspension")
def suspension(q):
    """By the angle of the lower arm, for which the wheel has the height q."""
    p, r = 300 + 230j, 360 + 480j
    arm, upper, upright = 350 - 20j, 260 + 10j, -30 + 280j
    wheel = (740 + 310j - (650 + 210j)) / unit(upright)

    def at(turn):
        b = p + arm * ray(turn)
        c = meet(b, abs(upright), r, abs(upper), -1)
        return b, c, b + wheel * unit(c - b)

    turns = [brentq(lambda t, h=h: at(t)[2].imag - h, -0.6, 0.6, xtol=1e-15, rtol=1e-14) for h in np.ravel(q)]
    turn = np.reshape(turns, np.shape(q))
    b, c, w = at(turn)
    return {"B": b, "C": c, "W": w, "D": p + (260 - 5j) * ray(turn)}


def moved(machine, u):
    """Return value [rad or file's unit], speed and acceleration [SI] along the law at the normalised times u."""
    law, seconds = machine.actuator["law"], machine.seconds
    if "by" in law:
        start = complex(*machine.data["nodes"][machine.actuator["arm"]])
        first = np.angle(start - complex(*machine.data["nodes"][machine.actuator["pivot"]])) / machine.degree
        ends = first, first + law["by"]
    elif "turns" in law:
        ends = law["from"], law["from"] + 360 * law["turns"]
    else:
        ends = law["from"], law["to"]
    profile = law.get("profile", "polynomial" if "polynomial" in law else "uniform")
    profile = profile if isinstance(profile, str) else profile.get("name", "polynomial")
    t = np.polynomial.Polynomial([0, 1])
    smooth = {"uniform": t, "quintic": 10 * t**3 - 15 * t**4 + 6 * t**5, "cubic": 3 * t**2 - 2 * t**3}
    smooth["polynomial"] = smooth["cubic"]
    if profile in smooth:
        s = [smooth[profile](u), smooth[profile].deriv(1)(u), smooth[profile].deriv(2)(u)]
    elif profile == "harmonic":
        s = [(1 - np.cos(np.pi * u)) / 2, np.pi * np.sin(np.pi * u) / 2, np.pi**2 * np.cos(np.pi * u) / 2]
    else:
        w = 2 * np.pi
        s = [u - np.sin(w * u) / w, 1 - np.cos(w * u), w * np.sin(w * u)]
    span = ends[1] - ends[0]
    si = machine.degree if machine.rotary else machine.metre
    return (ends[0] + span * s[0]) * machine.file, span * s[1] * si / seconds, span * s[2] * si / seconds**2


@pytest.mark.few(6)
@pytest.mark.parametrize("name", PLACES)
def test_the_effort_is_that_of_lagranges_equation(name):
    """Virtual work of all masses, loads, springs, dampers and friction; every eleventh row of the motion."""
    machine = Machine(name, PLACES[name])
    found = gimcli.forces(gimcli.load(name), steps=110)
    rows = np.arange(0, 111, 10)
    q, speed, acceleration = moved(machine, rows / 110)
    (actuator,) = machine.data["actuators"]
    assert set(found.status) == {"ok"}
    assert np.allclose(found[actuator][rows] * machine.file, q, rtol=0, atol=1e-9 * np.max(abs(q)))
    expected = machine.effort(q, speed, acceleration, rows / 110 * machine.seconds)
    own = found[f"{actuator}.effort"]
    assert np.max(abs(own[rows] - expected)) <= 1e-7 * np.max(abs(own))


# -- single models --------------------------------------------------------------------------------


def test_the_swing_has_the_period_of_a_pendulum():
    """4 K(sin(a/2)) sqrt(J / (m g L)); J from the reduction, which is constant: the seat does not rotate."""
    free = gimcli.load("swing").with_({"O.friction": 0, "Q.friction": 0})
    found = gimcli.simulate(free, 3, standstills=2)
    inertia = (2 + 2) * 1.5**2 / 3 + 155 * 1.5**2
    period = 4 * ellipk(np.sin(0.3) ** 2) * np.sqrt(inertia / (9.81 * (4 * 0.75 + 155 * 1.5)))
    assert found.events[-1]["time"] == pytest.approx(period, abs=1e-8)
    assert found.events[0]["at"]["angle"] == pytest.approx(-np.pi / 2 + 0.6, abs=1e-9)


@pytest.mark.soak
def test_the_wheel_comes_to_rest_where_its_forces_are_in_balance():
    found = gimcli.simulate(gimcli.load("suspension"), 1.0, dt=0.5)
    machine = Machine("suspension", PLACES["suspension"])
    rest = found["wheel"][-1] + np.array([-0.5, 0.0, 0.5])
    force = machine.applied(rest, 0.0, np.full(3, 1.0))
    assert abs(found["wheel.speed"][-1]) < 1e-3
    assert abs(force[1]) < 1e-3 * abs(force[0] - force[2])


def test_the_boom_cylinder_carries_the_moment_of_all_weights():
    """A very slow motion: the weights of boom, arm, bucket and links about C, against the cylinder D-E."""
    slow = gimcli.load("excavator").with_({"duration": 1e4})
    names = ["boom.mass", "arm.mass", "bucket.mass", "h_link.mass", "side_link.mass"]
    masses = [slow.written.dimension(name).value for name in names]
    centres = {"boom": ("C", "H", 200 + 45j), "arm": ("H", "M", 75 + 10j), "bucket": ("M", "L", -55j)}
    z = run_model("excavator", steps=8).xy
    moment = 0.0
    for mass, (first, second, centre) in zip(masses, centres.values(), strict=False):
        moment = moment + mass * (z(first) + unit(z(second) - z(first)) * centre).real
    moment = moment + masses[3] * (z("K") + z("J")).real / 2 + masses[4] * (z("J") + z("L")).real / 2
    arm = (np.conj(z("D")) * unit(z("E") - z("D"))).imag
    found = gimcli.forces(slow, steps=8)["boom_ram.effort"]
    assert found == pytest.approx(9.81 * moment / arm, rel=1e-6)


@pytest.mark.soak
def test_the_punch_loses_the_energy_of_its_stroke():
    """Change of the kinetic energy over the stroke: work of motor, sheet, weight and friction (trapezoidal sums)."""
    machine = Machine("punch", PLACES["punch"])
    found = gimcli.simulate(gimcli.load("punch"), 0.25, dt=0.25 / 2000)
    q, speed = np.radians(found["crank_angle"]), np.radians(found["crank_angle.speed"])
    motor = PchipInterpolator([450, 600, 660, 720, 750, 780], [760, 900, 820, 330, 0, -330])(np.degrees(speed))
    work = trapezoid(machine.applied(q, speed, 0.0) + motor, q)
    energy = machine.inertia(q) * speed**2 / 2
    assert energy[-1] - energy[0] == pytest.approx(work, abs=0.02)
    assert speed.min() < 0.97 * speed.max()


def test_a_time_below_the_default_step_of_rk4_is_simulated():
    engine = gimcli.load("engine")
    one, other = (gimcli.simulate(engine, 5e-4, dt=1e-4, integrator=name) for name in ("dop853", "rk4"))
    assert one["crank_angle"][-1] == pytest.approx(other["crank_angle"][-1], rel=1e-6)


# -- all models with masses -----------------------------------------------------------------------

DYNAMIC = [model.name for model in gimcli.shipped_models() if model.massive]


def test_many_models_have_masses():
    assert {
        *PLACES,
        "balanced_lamp",
        "excavator",
        "pick_and_place",
        "double_pendulum",
        "rack_lift",
        "spring_block",
        "watt_1",
        "watt_durango",
    } == set(DYNAMIC)
    assert len(DYNAMIC) >= 12


@pytest.mark.few("pick_and_place")
@pytest.mark.parametrize("name", [name for name in DYNAMIC if name != "watt_1"])
def test_forces_simulation_and_reduction_run(name):
    """Powers are in balance in each row, the simulation keeps its energy balance, the reduction has all rows."""
    model = gimcli.load(name)
    force = gimcli.forces(model, steps=36)
    power = np.max(abs(np.array([force[c] for c in force if c.startswith("power.") and c != "power.error"])))
    assert set(force.status) == {"ok"}
    assert np.max(abs(force["power.error"])) <= 1e-9 * power
    time = 0.05 * gimcli.trace(model, steps=1)["time"][-1]
    simulated = gimcli.simulate(model, time, dt=time / 10)
    assert simulated.answered
    assert abs(simulated["energy.drift"][-1]) <= 1e-6 * np.max(abs(simulated["energy.kinetic"])) + 1e-9
    assert gimcli.reduce(model, steps=12).answered


def test_a_rack_carries_the_weight_and_a_planetary_gear_divides_the_torque():
    """Closed forms: weight times pitch radius; 20 / (20 + 60) of the torque on the arm, by virtual work."""
    f = gimcli.forces(gimcli.load("rack_lift"), steps=4)
    assert np.allclose(f["motor.effort"], 12 * 9.81 * 0.03, rtol=1e-12)
    assert np.allclose(abs(f["teeth.tangential"]), 12 * 9.81, rtol=1e-12)
    f = gimcli.forces(gimcli.load("planetary_gear"), steps=4)
    assert np.allclose(f["motor.effort"], 20 * 20 / (20 + 60), rtol=1e-12)
    assert np.allclose(abs(f["inner.tangential"]), 20 / 2 / 0.04, rtol=1e-12)  # sun and ring each bear one half
