"""Linearised equations of motion: closed forms, and differences of efforts and potential between positions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh
from small_vibrations import LAGUERRE, SLIDER_CRANK, chain, geared_pendulums

from gimcli import ModelError, StructureError, loads
from gimcli.dynamics.small_motions import linearised
from gimcli.motion.solve import solve
from gimcli.positions.options import Options
from gimcli.status import Status

FIVE_BAR = """
units: {length: mm}
nodes: {O: [0, 0], A: [-20, 60], B: [40, 120], C: [130, 70], P: [100, 0]}
ground: [O, P]
links: {a: [O, A], b: [A, B], c: [B, C], d: [C, P]}
actuators:
  one: {pivot: O, arm: A, free: true, effort: 0.3}
  two: {pivot: P, arm: C, free: true, effort: {table: effort.csv, over: value}}
masses: {a: {mass: 1, inertia: 0.001}, b: {mass: 2, inertia: 0.004, centre: [30, 9]}, c: 0.5, B: 0.7}
gravity: [1, -9.81]
springs: {s: {nodes: [O, B], stiffness: 900, free: 40}, t: {pivot: B, arm: C, reference: A, stiffness: 2, free: 40}}
dampers: {e: {nodes: [A, P], damping: 30}, f: {pivot: B, arm: C, reference: A, damping: 0.2}}
friction: {B: 0.05}
loads:
  push: {on: b, local: [10, 5], force: [4, 7]}
  jet: {on: c, local: [5, 8], follower: [3, -6]}
  wind: {on: B, force: [-5, 2], table: wind.csv, over: one}
  twist: {on: c, torque: 0.4}
"""


def at(mechanism, inputs=None, released=None, **arguments):
    """Return the linearised equations at inputs, by default at the initial configuration."""
    inputs = mechanism.drawn_inputs if inputs is None else np.asarray(inputs)
    position = solve(mechanism, inputs, Options(tolerance=1e-13))
    assert position.status is Status.OK
    released = range(len(inputs)) if released is None else released
    return linearised(mechanism, position.z, inputs, tuple(released), **arguments)


def written(tmp_path, text):
    (tmp_path / "effort.csv").write_text("value,effort\n0,0\n50,1\n120,-2\n200,3\n")
    (tmp_path / "wind.csv").write_text("one,factor\n-90,0\n40,1\n110,2\n300,1\n")
    path = tmp_path / "m.yaml"
    path.write_text(text)
    from gimcli import load

    return load(path)


# -- closed forms -----------------------------------------------------------------------------------


@pytest.mark.parametrize("n", LAGUERRE)
def test_chains_of_point_masses_have_the_zeros_of_laguerre_polynomials(n):
    found = at(loads(chain(n)))
    assert found.symmetric
    assert found.units == ("rad",) * n
    assert np.abs(found.effort).max() < 1e-14 * found.effort_scale.max()
    assert eigh(found.stiffness, found.mass, eigvals_only=True) / 9.81 == pytest.approx(LAGUERRE[n], rel=1e-13)


def test_two_uniform_bars():
    """M and K in the directions of the bars; the inputs q are relative to the bar before: phi = T q."""
    found, whole = at(loads(chain(2, "bar"))), np.array([[1.0, 0.0], [1.0, 1.0]])
    mass, stiffness = np.array([[4 / 3, 1 / 2], [1 / 2, 1 / 3]]), 9.81 * np.diag([1.5, 0.5])
    assert found.mass == pytest.approx(whole.T @ mass @ whole, rel=1e-14)
    assert found.stiffness == pytest.approx(whole.T @ stiffness @ whole, rel=1e-14)
    values, modes = eigh(found.stiffness, found.mass)
    modes = whole @ modes
    assert np.sqrt(values) == pytest.approx([2.680114012253375, 7.188670870287714], rel=1e-13)
    assert modes[1] / modes[0] == pytest.approx([1.43050087404306, -2.097167540709727], rel=1e-13)


@pytest.mark.parametrize(("ratio", "expected"), [(-1, 4.026343338311588), (-2, 4.338376612041303)])
@pytest.mark.parametrize("coupling", ["follows", "gears"])
def test_two_geared_pendulums(ratio, expected, coupling):
    """omega^2 = g (m1 c1 + R^2 m2 c2)/(J1 + R^2 J2): bars of 1 m, 1 kg and 0.6 m, 0.5 kg, hanging."""
    mechanism = loads(geared_pendulums(ratio, coupling))
    found = at(mechanism, mechanism.coupled(mechanism.drawn_inputs), mechanism.drivers)
    assert np.abs(found.unbalance).max() < 1e-15
    assert np.sqrt(found.stiffness[0, 0] / found.mass[0, 0]) == pytest.approx(expected, rel=1e-13)
    assert found.input_rates[0] == pytest.approx([1, ratio])


def test_a_slider_crank_with_a_spring():
    """M = Jc + m x'^2 and K = k x'^2 where the spring is relaxed."""
    found = at(loads(SLIDER_CRANK))
    assert np.sqrt(found.stiffness[0, 0] / found.mass[0, 0]) == pytest.approx(16.41976317417809, rel=1e-11)
    assert found.input_rates == pytest.approx(np.ones((1, 1)))
    assert found.node_rates[0, 2] == pytest.approx(-0.101678107607332 / loads(SLIDER_CRANK).scale, rel=1e-12)


def test_a_slider_needs_no_masses_and_snaps_where_the_stiffness_is_negative():
    """K = k (1 - L0/h) + k x^2 L0/(x^2 + h^2)^(3/2), in N/m although the file is in mm; the unbalance is reported."""
    text = """
units: {length: mm}
nodes: {G: [0, 0], X: [1, 0], H: [0, 120], S: [50, 0]}
ground: [G, H, X]
prismatic: {guide: {node: S, guide: [G, X]}}
actuators: {x: {node: S, guide: [G, X]}}
springs: {s: {nodes: [S, H], stiffness: 500, free: 200}}
"""
    mechanism, h, free, k = loads(text), 0.12, 0.2, 500.0
    for x in (0.0, 0.05, 0.16):
        found = at(mechanism, [x / 0.001 / mechanism.scale])
        length = np.hypot(x, h)
        assert found.units == ("m",)
        assert not found.mass.any()
        assert found.stiffness[0, 0] == pytest.approx(k * (1 - free / length + free * x**2 / length**3), rel=1e-12)
        assert found.effort[0] == pytest.approx(-k * (length - free) * x / length, abs=1e-12)
        assert found.potential == pytest.approx(0.5 * k * (length - free) ** 2, abs=1e-15)


def test_at_a_dead_point_of_the_input_other_coordinates_have_the_same_frequency():
    """The slider drives; where crank and rod are in line, it does not determine the position."""
    text = """
nodes: {O: [0, 0], A: [1, 0], B: [3, 0], X: [4, 0]}
ground: [O, X]
links: {crank: [O, A], rod: [A, B]}
prismatic: {guide: {node: B, guide: [O, X]}}
actuators: {DRIVE}
masses: {crank: {mass: 3, inertia: 0.2}, rod: {mass: 1, inertia: 0.5}, B: 2}
springs: {s: {pivot: O, arm: A, stiffness: 40}}
"""
    slider = loads(text.replace("DRIVE", "x: {node: B, guide: [O, X], free: true, effort: 30}"))
    found = linearised(slider, slider.drawn, slider.drawn_inputs, (0,))
    pulled = text + "loads: {pull: {on: B, force: [30, 0]}}"
    crank = at(loads(pulled.replace("DRIVE", "motor: {pivot: O, arm: A}")))
    assert found.names == ("s",)
    assert found.input_rates[0, 0] == pytest.approx(0.0, abs=1e-15)
    ratios = [f.stiffness[0, 0] / f.mass[0, 0] for f in (found, crank)]
    assert ratios[0] == pytest.approx(ratios[1], rel=1e-13)


def test_a_change_point_is_refused():
    text = """
nodes: {O: [0, 0], A: [1, 0], B: [3, 0], C: [2, 0]}
ground: [O, C]
links: {a: [O, A], b: [A, B], c: [B, C]}
actuators: {motor: {pivot: O, arm: A}}
masses: {a: 1}
"""
    mechanism = loads(text)
    with pytest.raises(StructureError):
        linearised(mechanism, mechanism.drawn, mechanism.drawn_inputs, (0,))
    bare = loads(text.replace("masses: {a: 1}", ""))
    with pytest.raises(ModelError):
        linearised(bare, bare.drawn, bare.drawn_inputs, (0,))


# -- differences ------------------------------------------------------------------------------------


@pytest.mark.parametrize("held", [(), (0,), (1,)])
def test_the_stiffness_is_the_derivative_of_the_effort(tmp_path, held):
    """Central differences between positions that are solved independently; all kinds of forces act."""
    mechanism = written(tmp_path, FIVE_BAR)
    released = [k for k in (0, 1) if k not in held]
    inputs, step = mechanism.drawn_inputs, 1e-5
    found = at(mechanism, inputs, released)
    assert found.symmetric is (len(released) == 1)
    for column, k in enumerate(released):
        ahead, behind = (at(mechanism, inputs + side * step * np.eye(2)[k], released) for side in (1, -1))
        slope = (ahead.effort - behind.effort) / (2 * step)
        assert found.stiffness[:, column] == pytest.approx(-slope, rel=1e-7, abs=1e-7 * np.abs(found.stiffness).max())


def test_the_effort_is_the_slope_of_the_potential(tmp_path):
    text = FIVE_BAR[: FIVE_BAR.index("dampers")].replace("effort: 0.3", "").replace(", effort: {table: effort.csv", "")
    mechanism = loads(text.replace(", over: value}}", "}").replace("free: true, }", "free: true}"))
    inputs, step = mechanism.drawn_inputs, 1e-5
    found = at(mechanism, inputs)
    moved = [[at(mechanism, inputs + side * step * unit).potential for side in (1, -1)] for unit in np.eye(2)]
    assert found.effort == pytest.approx([(b - a) / (2 * step) for a, b in moved], rel=1e-8)
    assert found.symmetric
    assert found.stiffness == pytest.approx(found.stiffness.T, rel=1e-13)


def test_the_damping_is_the_derivative_of_the_effort_by_the_speeds(tmp_path):
    """The power that C dissipates equals that of dampers and friction in a moving mechanism."""
    from gimcli.dynamics.reducer import Reducer
    from gimcli.kernels.reduction import DISSIPATED

    mechanism = written(tmp_path, FIVE_BAR)
    found = at(mechanism)
    reducer = Reducer(mechanism, (0, 1))
    assert reducer.start(found.z, found.inputs)
    for speeds in ([1.0, 0.0], [0.0, 1.0], [0.7, -1.3]):
        assert reducer.move(found.inputs, np.array(speeds), np.zeros(2))
        assert speeds @ found.damping @ speeds == pytest.approx(reducer.out.energy[DISSIPATED], rel=1e-12)


def test_a_torque_speed_line_damps():
    """M s'' = stall (1 - s' / idle): the damping is stall / idle."""
    text = chain(1).replace("free: true", "free: true, effort: {stall: 3, idle: 360}")
    assert at(loads(text)).damping[0, 0] == pytest.approx(3 / (2 * np.pi), rel=1e-14)


def test_torsion_springs_continue_through_full_turns():
    text = chain(1) + "springs: {s: {pivot: N0, arm: N1, stiffness: 2, free: -90}}\n"
    mechanism = loads(text)
    inputs = mechanism.drawn_inputs
    first = at(mechanism, inputs)
    turned = at(mechanism, inputs + 2 * np.pi, gauges=first.gauges + 6.0)
    assert first.potential + 0.5 * 2 * (2 * np.pi) ** 2 == pytest.approx(turned.potential, rel=1e-12)


@pytest.mark.parametrize(
    ("degrees", "stiffness", "balanced"), [(20, 117.72, True), (0, 117.72, True), (20, 120, False)]
)
def test_a_balanced_bar_has_no_stiffness(degrees, stiffness, balanced):
    """Weight and a spring of zero free length, k a h = m g r: effort and stiffness are 0 up to rounding everywhere."""
    text = f"""
nodes: {{O: [0, 0], H: [0, 0.25], A: [0.2, 0]}}
ground: [O, H]
links: {{bar: [O, A]}}
actuators: {{q: {{pivot: O, arm: A, free: true}}}}
masses: {{bar: {{mass: 2, inertia: 0.06, centre: [0.3, 0]}}}}
gravity: [0, -9.81]
springs: {{s: {{nodes: [A, H], stiffness: {stiffness}, free: 0}}}}
"""
    found = at(loads(text), [np.radians(degrees)])
    ratios = np.abs([found.effort[0] / found.effort_scale[0], found.stiffness[0, 0] / found.stiffness_scale[0, 0]])
    assert bool(ratios.max() < 1e-15) is balanced
    assert not balanced or found.potential == pytest.approx(6.03315, rel=1e-14)
