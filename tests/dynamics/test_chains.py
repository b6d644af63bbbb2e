"""The IFToMM benchmark A02: N four-bar windows of unit bars in a row, through positions in which all bars are in line.

On the regular branch all cranks are parallel: with psi from the vertical, J psi'' = G sin psi, J = (N + 1) / 3 + N and
G = g ((N + 1) / 2 + N). Every flat position is a change point of all windows at once.
"""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
from bundled import written
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from gimcli.cli import app
from gimcli.dynamics.simulation import Settings, simulate
from gimcli.kernels.jit import compiled
from gimcli.status import Status

GRAVITY = 9.81


def chain(windows, speed):
    """Return the model file; `speed` is the initial speed of B0 in +x [m/s]."""
    crank, coupler = "mass: 1, inertia: 0.08333333333333333", range(windows)
    cranks = range(windows + 1)
    nodes = ", ".join(f"A{i}: [{i}, 0], B{i}: [{i}, 1]" for i in cranks)
    names = [*(f"c{i}: [A{i}, B{i}]" for i in cranks), *(f"r{i}: [B{i}, B{i + 1}]" for i in coupler)]
    masses = ", ".join(f"{name.split(':')[0]}: {{{crank}}}" for name in names)
    return f"""units: {{length: m, angle: rad}}
nodes: {{{nodes}}}
ground: [{", ".join(f"A{i}" for i in cranks)}]
links: {{{", ".join(names)}}}
masses: {{{masses}}}
gravity: [0, -{GRAVITY}]
actuators: {{q: {{type: rotary, pivot: A0, arm: B0, free: true, start: {math.pi / 2!r}, speed: {-speed!r}}}}}
"""


def constants(windows):
    """Return J and G."""
    return (windows + 1) / 3 + windows, GRAVITY * ((windows + 1) / 2 + windows)


def closed_form(windows, speed, times):
    """Return psi at times [s], from the differential equation of psi."""
    inertia, weight = constants(windows)
    return solve_ivp(
        lambda t, y: [y[1], weight / inertia * math.sin(y[0])], (0.0, times[-1]), [0.0, speed], method="DOP853",
        rtol=1e-13, atol=1e-14, t_eval=times,
    ).y[0]  # fmt: skip


def time_of(windows, speed, angle):
    """Return the time at which psi reaches an angle, from the energy integral."""
    inertia, weight = constants(windows)
    psi = np.polynomial.legendre.leggauss(400)
    x = 0.5 * angle * (psi[0] + 1.0)
    return float(0.5 * angle * np.sum(psi[1] / np.sqrt(speed**2 + 2.0 * weight / inertia * (1.0 - np.cos(x)))))


def check_chain(folder, windows, speed, times, rtol, angle_error, energy_error):
    """Assert that the motion of a chain agrees with the closed form in angle and energy."""
    found = simulate(written(folder, chain(windows, speed)), times, Settings(rtol=rtol), compiled)
    assert found.status is Status.OK
    assert np.abs(math.pi / 2 - found.inputs[0, 0] - closed_form(windows, speed, times)).max() < angle_error
    inertia, weight = constants(windows)
    height, rate = np.sin(found.inputs[0, 0]), found.inputs[1, 0]
    energy = 0.5 * inertia * rate**2 + weight * height
    assert np.abs(energy / energy[0] - 1.0).max() < energy_error
    tips = found.nodes[0, 1::2] - found.nodes[0, ::2]
    assert np.abs(tips - tips[0]).max() < 1e-10  # every crank is parallel


BOUNDS = {1e-6: (1e-3, 1e-6), 1e-9: (1e-6, 1e-9), 1e-12: (1e-6, 1e-9)}


@pytest.mark.few(3)
@pytest.mark.parametrize("rtol", BOUNDS)
@pytest.mark.parametrize("windows", [2, 5])
def test_a_chain_passes_every_flat_position(windows, rtol, tmp_path):
    check_chain(tmp_path, windows, 1.0, np.linspace(0.0, 20.0, 201), rtol, *BOUNDS[rtol])


def test_a_step_whose_error_estimate_cancels_does_not_lengthen_the_next(tmp_path):
    """One step of the chain of 9 is nearly symmetric about the highest position, so that its error estimate cancels."""
    check_chain(tmp_path, 9, 1.0, np.linspace(0.0, 20.0, 201), 1e-9, 1e-6, 1e-9)


@pytest.mark.soak
@pytest.mark.parametrize("rtol", BOUNDS)
@pytest.mark.parametrize("windows", [1, 3, 4, 6, 7, 8, 9, 10, 20, 40])
def test_longer_chains_pass_every_flat_position(windows, rtol, tmp_path):
    simulate(written(tmp_path, chain(1, 1.0)), np.linspace(0.0, 1.0, 3), Settings(), compiled)  # compiles the kernels
    begun = time.process_time()
    check_chain(tmp_path, windows, 1.0, np.linspace(0.0, 20.0, 201), rtol, *BOUNDS[rtol])
    assert time.process_time() - begun < 60.0


def check_three_turns(folder, windows, speeds):
    for speed in speeds.tolist():
        end = time_of(windows, speed, 2.6 * math.pi)
        check_chain(folder, windows, speed, np.linspace(0.0, end, 21), 1e-9, 1e-6, 1e-9)


@pytest.mark.parametrize("windows", [2, 5])
def test_a_chain_passes_flat_positions_at_every_initial_speed(windows, tmp_path):
    check_three_turns(tmp_path, windows, np.linspace(0.3, 9.0, 10))


@pytest.mark.soak
@pytest.mark.parametrize("windows", [*range(1, 11), 20, 40])
def test_longer_chains_pass_flat_positions_at_every_initial_speed(windows, tmp_path):
    check_three_turns(tmp_path, windows, np.linspace(0.3, 9.0, 50 if windows <= 10 else 5))


def test_the_time_of_a_revolution_agrees_with_the_benchmark():
    """N = 40: published to 19 digits."""
    assert time_of(40, 1.0, 2.0 * math.pi) == pytest.approx(1.965601928704650439, abs=1e-12)
    inertia, weight = constants(40)
    assert math.sqrt(1.0 + 4.0 * weight / inertia) == pytest.approx(6.72580088283380199, abs=1e-14)


@pytest.mark.parametrize("windows", [1, 2])
def test_a_coupled_group_passes_its_change_point(windows, tmp_path):
    """The input is the diagonal of the first window: it has a dead point where all bars are in line."""
    text = chain(windows, 1.0).split("actuators")[0]
    text += f"actuators: {{q: {{type: linear, nodes: [A0, B1], free: true, start: {2**0.5!r}, speed: {0.5**0.5!r}}}}}\n"
    times = np.linspace(0.0, 1.2, 7)
    mechanism = written(tmp_path, text)
    found = simulate(mechanism, times, Settings(rtol=1e-9), compiled)
    assert found.status is Status.OK
    psi = closed_form(windows, 1.0, times)
    assert psi[-1] > 2.0  # beyond the flat position
    tips = (found.nodes[0, 1::2] - found.nodes[0, ::2]) * mechanism.scale
    assert np.abs(tips - 1j * np.exp(-1j * psi)).max() < 1e-7


def test_the_message_for_a_flat_start_names_no_option_that_the_command_does_not_have(tmp_path):
    path = tmp_path / "m.yaml"
    flat = chain(2, 1.0).replace(f"start: {math.pi / 2!r}", "start: 0.0")
    for i in range(3):
        flat = flat.replace(f"B{i}: [{i}, 1]", f"B{i}: [{i + 1}, 0]")
    path.write_text(flat)
    for command in ("simulate", "reduce"):
        done = CliRunner().invoke(app, [command, str(path), "-o", str(tmp_path), "--no-png"])
        assert done.exit_code == 5, done.output
        assert "singular" in done.output
        assert "--tolerance" not in done.output
