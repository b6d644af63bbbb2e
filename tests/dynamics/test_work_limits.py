"""Stiff motions have their closed form; every search ends after a number of positions, with what was found."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim

import gimcli
from gimcli import ModelError, UsageError
from gimcli.dynamics import equilibria_curve
from gimcli.dynamics.integration import Integration
from gimcli.dynamics.integrators import INTEGRATORS
from gimcli.dynamics.simulation import simulate
from gimcli.dynamics.simulation_types import SIMULATION, Settings
from gimcli.kernels.jit import compiled
from gimcli.positions.dispatch import plain
from gimcli.status import Status

PENDULUM = {
    "nodes": {"O": [0, 0], "A": [0.5, 0]}, "ground": ["O"], "links": {"arm": ["O", "A"]},
    "actuators": {"q": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 360}, "free": True, "start": -30}},
    "masses": {"A": 2}, "gravity": [0, -9.81],
}  # fmt: skip
WEIGHT, INERTIA = 2 * 9.81 * 0.5, 2 * 0.25


def replaced(model, old, new):
    """Load a shipped model with another text in its file."""
    text = (MODELS / f"{model}.yaml").read_text(encoding="utf-8")
    assert old in text
    return gimcli.loads(text.replace(old, new))


@pytest.mark.parametrize("damping", [1e4, 1e7])
def test_a_strongly_damped_pendulum_creeps_down(damping):
    """c q' = -m g L cos q up to (J m g L / c^2): tan of half the angle from the top decays by e^(-m g L t / c)."""
    time = 0.3 * damping / WEIGHT
    notes = []
    model = gimcli.load({**PENDULUM, "dampers": {"d": {"pivot": "O", "arm": "A", "damping": damping}}})
    found = gimcli.simulate(model, time, dt=time / 4, notify=notes.append)
    exact = 2 * np.arctan(math.tan(math.radians(30)) * np.exp(-WEIGHT * found["time"] / damping)) - math.pi / 2
    assert len(found.time) == 5
    assert np.abs(np.radians(found["q"]) - exact).max() < 3 * INERTIA * WEIGHT / damping**2 + 1e-8
    assert any("stiff" in note for note in notes)


def test_a_strongly_damped_rotor_stops_after_its_closed_form():
    """J w' = -c w turns by w0 J / c."""
    turning = {**PENDULUM, "gravity": [0, 0], "friction": {"O": 1e6}}
    turning["actuators"] = {"q": {**PENDULUM["actuators"]["q"], "start": 0, "speed": 90}}
    found = gimcli.simulate(gimcli.load(turning), 1.0, dt=0.25)
    assert np.abs(found["q"][1:] - 90 * INERTIA / 1e6).max() < 1e-9


def test_a_fast_motion_without_damping_is_not_stiff():
    turning = {**PENDULUM, "gravity": [0, 0], "friction": {"O": 1e-9}}
    turning["actuators"] = {"q": {**PENDULUM["actuators"]["q"], "start": 0, "speed": 1e7}}
    notices = []
    found = gimcli.simulate(gimcli.load(turning), 0.2, dt=0.05, notify=notices.append)
    assert not any("stiff" in text for text in notices)
    assert len(found.time) == 5


@pytest.mark.parametrize("change", ["friction: {A: 1e5}", "friction: {A: 1e5, B: 1e-300}"])
def test_a_wiper_with_stiff_friction_ends(change):
    found = gimcli.simulate(replaced("wiper", "friction: {A: 0.002, B: 0.002}", change), 5.0)
    assert found.report()["status"] == "ok"
    assert found.report()["evaluations"] < 2000


def test_a_wiper_with_a_stiff_damper_turns_with_the_torque_over_the_damping():
    """The start is at rest: the rocker's angle changes by less than (6 N m + weight and wind) t / c."""
    found = gimcli.simulate(replaced("wiper", "damping: 0.55", "damping: 1e9"), 5.0)
    assert found.report()["status"] == "ok"
    assert found.report()["evaluations"] < 2000
    assert np.ptp(np.radians(found["motor"])) < 100 * 5.0 / 1e9


def test_speeds_beyond_any_count_of_turns_are_refused():
    with pytest.raises(ModelError):
        replaced("swing", "speed: 0", "speed: 1e300")
    with pytest.raises(UsageError):
        gimcli.simulate(replaced("swing", "speed: 0", "speed: 1e20"))


@pytest.mark.few(5)
@pytest.mark.parametrize("run", [plain, compiled])
@pytest.mark.parametrize("method", ["", "radau", "lsoda", "rk4", "euler"])
def test_a_simulation_ends_at_its_bound_with_the_rows_until_then(method, run):
    model = gimcli.load({**PENDULUM, "friction": {"O": 0.1}} if method != "euler" else PENDULUM)
    times = np.linspace(0.0, 1000.0, 100_001)
    settings = Settings(method, step=1e-2, work=20_000)
    found = simulate(model, times, settings, run)
    assert found.status is Status.WORK_LIMIT
    assert 1 < len(found.time) < 100_001
    assert found.evaluations * SIMULATION.call < 4 * settings.work or run is compiled
    whole = simulate(model, found.time, replace(settings, work=10**9), run)
    assert np.abs(whole.inputs - found.inputs).max() < 1e-6


def test_a_simulation_ends_at_its_seconds(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    asked = gim("simulate", "swing", "--seconds", 0, "--no-png")
    assert asked.code == 5
    assert "work-limit" in asked.text
    assert "work-limit" in (tmp_path / "swing.simulation.csv").read_text()


def test_the_step_after_an_infinite_slope_fails():
    """The square of the speed overflows: no first step exists."""
    model = gimcli.load("swing")
    release = replace(model.dynamics.releases[0], speed=1e300)
    model = replace(model, dynamics=replace(model.dynamics, releases=(release,)))
    with np.errstate(all="ignore"):
        found = Integration(model, np.linspace(0, 5, 3), Settings(), compiled, lambda a, b: None).simulation()
    assert found.status is not Status.OK
    assert len(found.time) < 3


def test_a_failed_step_is_a_status_without_a_warning():
    """A tolerance of 0 at a state of 0."""
    control = {"rtol": 1e-9, "atol": np.zeros(1), "least": 1e-12, "jacobian": lambda t, y: np.zeros((1, 1))}
    solver = INTEGRATORS["lsoda"].begin(lambda t, y: np.ones(1), 0.0, np.zeros(1), 2.0, **control)
    solver.step()
    assert solver.status == "failed"


def test_equilibria_end_at_the_bound(monkeypatch):
    monkeypatch.setattr(equilibria_curve, "BALANCE", replace(equilibria_curve.BALANCE, work=100))
    found = gimcli.equilibrium(gimcli.load("snap_hinge"))
    assert found.limited
    assert found.report()["status"] == "work-limit"
    assert gimcli.equilibrium(gimcli.load("double_pendulum"), seconds=0).report()["status"] == "work-limit"
