"""Change points of mechanisms with several free inputs, compared with the two differential equations of parallelograms.

Bars are uniform; cranks have length and mass 1, bases and couplers length 2 and mass 2. M s'' = Q is Lagrange's, with
the sums of m u u, m u v, ... of the mass centres u e(p) + v e(q).
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from bundled import written
from scipy.integrate import solve_ivp

from gimcli.dynamics.simulation import Settings, simulate
from gimcli.kernels.jit import compiled
from gimcli.status import Status

GRAVITY = 9.81
CRANK, BAR = "{mass: 1, inertia: 0.08333333333333333}", "{mass: 2, inertia: 0.6666666666666666}"
MASSES = f"masses: {{base: {BAR}, crank: {CRANK}, rocker: {CRANK}, coupler: {BAR}}}"


def at(z):
    return f"[{float(z.real)!r}, {float(z.imag)!r}]"


def turned(angle):
    return complex(math.cos(angle), math.sin(angle))


def solved(gradient, start, times):
    """Return the solution (2, rows) of M q'' = f; `gradient` returns M and f."""

    def slopes(_, y):
        m, right = gradient(*y)
        return np.concatenate([y[2:], np.linalg.solve(m, right)])

    return solve_ivp(slopes, (0.0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-13).y[:2]


def check_motion(folder, text, gradient, start, coordinates, rtol, times, error):
    """Assert that a motion agrees with the two equations; `coordinates` computes q from the inputs (2, rows)."""
    mechanism = written(folder, text)
    found = simulate(mechanism, times, Settings(rtol=rtol), compiled)
    assert found.status is Status.OK
    assert len(found.time) == len(times)
    assert np.abs(coordinates(found.inputs[0], mechanism.dynamics.metre) - solved(gradient, start, times)).max() < error
    assert found.worst_drift < max(100.0 * rtol, 1e-10)
    return found


# -- on a slider ------------------------------------------------------------------------------------------


def on_slider(q, rate, speed):
    """Return a parallelogram whose base slides along x."""
    a = turned(q)
    return f"""units: {{length: m, angle: rad}}
nodes: {{G: [-5, 0], H: [9, 0], O: [0, 0], P: [2, 0], A: {at(a)}, B: {at(2.0 + a)}}}
ground: [G, H]
links: {{base: [O, P], crank: [O, A], coupler: [A, B], rocker: [P, B]}}
prismatic: {{slide: {{nodes: [O, P], guide: [G, H]}}}}
{MASSES}
gravity: [0, -{GRAVITY}]
actuators:
  x: {{type: linear, node: O, guide: [G, H], free: true, start: 5, speed: {speed!r}}}
  q: {{type: rotary, pivot: O, arm: A, reference: P, free: true, start: {q!r}, speed: {rate!r}}}
"""


def slides(x, q, speed, rate):
    s, c = math.sin(q), math.cos(q)
    m = np.array([[6.0, -3.0 * s], [-3.0 * s, 8.0 / 3.0]])
    return m, np.array([3.0 * c * rate * rate, -3.0 * GRAVITY * c])


def check_on_slider(folder, q, rate, speed, rtol, error):
    check_motion(
        folder, on_slider(q, rate, speed), slides, [5.0, q, speed, rate],
        lambda inputs, metre: inputs * np.array([[metre], [1.0]]), rtol, np.linspace(0.0, 3.0, 31), error,
    )  # fmt: skip


ERRORS = {1e-6: 1e-3, 1e-9: 1e-6, 1e-12: 1e-6}
FALLS = (
    (0.8, 4.372881355932204, 0.5),
    (0.8, 5.186440677966102, 0.5),
    (1.0, 0.0, 0.0),
    (0.05, 0.0, 0.0),
    (0.01, 0.0, 1.0),
    (0.8, -3.0, 0.5),
    (0.8, 3.0, 0.5),
)


@pytest.mark.few(4)
@pytest.mark.parametrize("rtol", ERRORS)
@pytest.mark.parametrize("start", FALLS)
def test_a_parallelogram_on_a_slider_remains_a_parallelogram(start, rtol, tmp_path):
    check_on_slider(tmp_path, *start, rtol, ERRORS[rtol])


@pytest.mark.soak
@pytest.mark.parametrize("rtol", ERRORS)
def test_a_parallelogram_on_a_slider_moves_at_every_initial_speed(rtol, tmp_path):
    for rate in np.linspace(-6.0, 6.0, 60).tolist():
        check_on_slider(tmp_path, 0.8, rate, 0.5, rtol, 100.0 * ERRORS[rtol])


# -- on a crank -------------------------------------------------------------------------------------------


def on_crank(p, p_rate, q, q_rate, relative):
    """Return a parallelogram whose base turns about a pin; `relative`: its crank angle is measured from the base."""
    base, a = 2.0 * turned(p), turned(q)
    start, rate, reference = (q - p, q_rate - p_rate, "reference: P, ") if relative else (q, q_rate, "")
    return f"""units: {{length: m, angle: rad}}
nodes: {{O: [0, 0], X: [1, 0], P: {at(base)}, A: {at(a)}, B: {at(base + a)}}}
ground: [O, X]
links: {{base: [O, P], crank: [O, A], coupler: [A, B], rocker: [P, B]}}
{MASSES}
gravity: [0, -{GRAVITY}]
actuators:
  p: {{type: rotary, pivot: O, arm: P, free: true, start: {p!r}, speed: {p_rate!r}}}
  q: {{type: rotary, pivot: O, arm: A, {reference}free: true, start: {start!r}, speed: {rate!r}}}
"""


def linked(inertia_p, inertia_q, mixed, weight_p, weight_q):
    """Return the equations of two bars by their absolute angles."""

    def gradient(p, q, p_rate, q_rate):
        c, s = mixed * math.cos(p - q), mixed * math.sin(p - q)
        m = np.array([[inertia_p, c], [c, inertia_q]])
        pull = GRAVITY * np.array([weight_p * math.cos(p), weight_q * math.cos(q)])
        return m, np.array([-s * q_rate**2, s * p_rate**2]) - pull

    return gradient


SWINGS = ((-0.5, 0.0, 0.5, 0.0), (0.3, 1.0, 0.8, -1.0), (-1.5, 1.0, -1.1, 0.0), (-1.57, 2.0, -1.27, 2.0))


@pytest.mark.few(4)
@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("start", SWINGS)
def test_a_parallelogram_on_a_crank_remains_a_parallelogram(start, relative, tmp_path):
    """Change points are two surfaces in the inputs, where both bars are in line; they depend on one input or both."""
    p, p_rate, q, q_rate = start
    bodies = [(2.0, 1.0, 0.0, 2.0 / 3.0, 0.0), (1.0, 0.0, 0.5, 0.0, 1.0 / 12.0), (1.0, 2.0, 0.5, 0.0, 1.0 / 12.0),
              (2.0, 1.0, 1.0, 2.0 / 3.0, 0.0)]  # fmt: skip  # mass, u, v, inertias that turn with p and with q
    gradient = linked(
        sum(m * u * u + i for m, u, _, i, _ in bodies), sum(m * v * v + i for m, _, v, _, i in bodies),
        sum(m * u * v for m, u, v, _, _ in bodies), sum(b[0] * b[1] for b in bodies), sum(b[0] * b[2] for b in bodies),
    )  # fmt: skip
    check_motion(
        tmp_path, on_crank(*start, relative), gradient, [p, q, p_rate, q_rate],
        lambda inputs, _: np.array([inputs[0], inputs[1] + relative * inputs[0]]), 1e-9,
        np.linspace(0.0, 3.0, 31), 2e-7,
    )  # fmt: skip


# -- a parallelogram on another -------------------------------------------------------------------------------------


def one_on_another(p, p_rate, q, q_rate):
    """Return a parallelogram on the coupler of another."""
    a, c, between = turned(p), turned(p) + turned(q), math.pi + q - p
    return f"""units: {{length: m, angle: rad}}
nodes: {{O: [0, 0], P: [2, 0], A: {at(a)}, B: {at(2 + a)}, C: {at(c)}, D: {at(2 + c)}}}
ground: [O, P]
links: {{c1: [O, A], r1: [P, B], k1: [A, B], c2: [A, C], r2: [B, D], k2: [C, D]}}
masses: {{c1: {CRANK}, r1: {CRANK}, c2: {CRANK}, r2: {CRANK}, k1: {BAR}, k2: {BAR}}}
gravity: [0, -{GRAVITY}]
actuators:
  a: {{type: rotary, pivot: O, arm: A, free: true, start: {p!r}, speed: {p_rate!r}}}
  b: {{type: rotary, pivot: A, arm: C, reference: O, free: true, start: {between!r}, speed: {q_rate - p_rate!r}}}
"""


def check_one_on_another(folder, start, rtol, error):
    p, p_rate, q, q_rate = start
    check_motion(
        folder, one_on_another(*start), linked(2.0 / 3.0 + 6.0, 2.0 / 3.0 + 2.0, 3.0, 7.0, 3.0),
        [p, q, p_rate, q_rate], lambda inputs, _: np.array([inputs[0], inputs[0] + inputs[1] - math.pi]), rtol,
        np.linspace(0.0, 2.0, 21), error,
    )  # fmt: skip


@pytest.mark.few(4)
@pytest.mark.parametrize("rtol", ERRORS)
@pytest.mark.parametrize("start", [(0.6, -1.0, 0.6, -1.0), (0.5, -2.0, 0.5, -2.1), (0.3, 0.0, -0.3, 0.0)])
def test_two_parallelograms_pass_their_flat_positions_together(start, rtol, tmp_path):
    check_one_on_another(tmp_path, start, rtol, ERRORS[rtol])


@pytest.mark.soak
def test_two_parallelograms_pass_or_end_with_a_status(tmp_path):
    """Where the change points of both coincide the simulation may end; the motion up to there is correct."""
    rng, ended = np.random.default_rng(1), 0
    for _ in range(100):
        p, q, p_rate, q_rate = start = rng.uniform(-3.0, 3.0, 4)
        times = np.linspace(0.0, 2.0, 21)
        text = one_on_another(*(float(v) for v in (p, p_rate, q, q_rate)))
        found = simulate(written(tmp_path, text), times, Settings(rtol=1e-9), compiled)
        right = solved(linked(2.0 / 3.0 + 6.0, 2.0 / 3.0 + 2.0, 3.0, 7.0, 3.0), start, times)[:, : len(found.time)]
        assert np.abs(np.array([found.inputs[0, 0], found.inputs[0].sum(axis=0) - math.pi]) - right).max() < 1e-5
        assert found.status in (Status.OK, Status.SINGULAR)
        ended += found.status is not Status.OK
    assert ended < 20


# -- rams whose length becomes zero --------------------------------------------------------------------------------

ON_A_RAIL = """
nodes: {O: [0, 0], G: [-3, 0], H: [5, 0], P: [1, 0], Q: [1.5, 0]}
ground: [O, G, H]
links: {block: [P, Q]}
prismatic: {slide: {nodes: [P, Q], guide: [G, H]}}
masses: {block: {mass: 2}}
actuators: {r: {type: linear, nodes: [O, P], free: true, start: 1, speed: -1.5, effort: 1}}
"""
ON_TWO_RAILS = """
nodes: {O: [0, 0], G: [-5, 0], H: [5, 0], C: [1, 0], D: [1.5, 0], U: [1, 1], P: [1, 1], R: [1, 1.5]}
ground: [O, G, H]
links: {block: [P, R]}
elements: {car: [C, D, U]}
prismatic: {one: {nodes: [C, D], guide: [G, H]}, other: {nodes: [P, R], guide: [C, U]}}
masses: {car: {mass: 1}, block: {mass: 2}}
actuators:
  r: {type: linear, nodes: [O, P], free: true, start: 1.4142135623730951, speed: -1.4142135623730951}
  x: {type: linear, node: C, guide: [G, H], free: true, start: 6, speed: -1}
"""


def ram(node, tip):
    """Return start and speed of a ram between places, the tip at the speed -1, -1."""
    apart = tip - node
    return f"start: {abs(apart)!r}, speed: {-(apart.real + apart.imag) / abs(apart)!r}"


ON_THREE_RAMS = f"""
nodes: {{O: [0, 0], X: [3, 2], P: [1, 1], Q: [1.5, 1]}}
ground: [O, X]
links: {{body: [P, Q]}}
masses: {{body: {{mass: 2, inertia: 0.1, centre: [0, 0]}}}}
actuators:
  r: {{type: linear, nodes: [O, P], free: true, {ram(0.0, 1.0 + 1.0j)}}}
  s: {{type: linear, nodes: [X, P], free: true, {ram(3.0 + 2.0j, 1.0 + 1.0j)}}}
  t: {{type: linear, nodes: [X, Q], free: true, {ram(3.0 + 2.0j, 1.5 + 1.0j)}}}
"""


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize(
    ("text", "ends_at", "path"),
    [
        (ON_A_RAIL, 3.0 - 5.0**0.5, lambda t: 1.0 - 1.5 * t + 0.25 * t * t),
        (ON_TWO_RAILS, 1.0, lambda t: (1.0 - t) * (1.0 + 1.0j)),
        (ON_THREE_RAMS, 1.0, lambda t: (1.0 - t) * (1.0 + 1.0j)),
    ],
    ids=["rail", "rails", "rams"],
)
def test_a_ram_of_zero_length_ends_the_motion_or_is_passed(text, ends_at, path, rtol, tmp_path):
    """A mass moves on a line to the ram's other end, where the direction of the ram's effort is undefined.

    Errors of the steps may pass that point at a small distance; then the path must remain straight.
    """
    mechanism, times = written(tmp_path, text), np.linspace(0.0, 2.0, 21)
    found = simulate(mechanism, times, Settings(rtol=rtol), compiled)
    if found.status is not Status.OK:
        assert ends_at - 0.1 < found.end < ends_at + 0.1
    assert len(found.time) == np.sum(times < (ends_at - 1e-12 if found.status is not Status.OK else np.inf))
    assert found.steps < 1000
    tip = found.nodes[0, mechanism.nodes.index("P")] * mechanism.scale + mechanism.origin
    assert np.abs(tip - path(found.time)).max() < 100.0 * rtol + 1e-10
