"""A model with formulas has the results of the model in which their values are written, to the last bit."""

from math import atan2, cos, hypot, pi, sin, sqrt

import numpy as np
import pytest

import gimcli

MODEL = """
{first}
units: {{length: mm, angle: deg, mass: kg}}
nodes: {{O2: [0, 0], O4: ["{frame}", "{down}"], A: ["{ax}", "{ay}"], B: [143.19, 67.34]}}
ground: [O2, O4]
links:
  crank: {{nodes: [O2, A], length: "{crank}"}}
  rod: {{nodes: [A, B], length: "{rod}"}}
  rocker: {{nodes: [O4, B], length: "{rocker}"}}
actuators: {{motor: {{type: rotary, pivot: O2, arm: A, law: {{from: "{start}", to: "{end}"}}}}}}
points: {{P: {{on: rod, local: ["{half}", "{crank}"]}}}}
trace: [P, B]
masses: {{rod: {{mass: "{mass}", inertia: "{inertia}"}}, rocker: {{mass: "{mass}", inertia: "{inertia}"}}}}
gravity: [0, -9.81]
loads: {{push: {{on: rocker, at: ["{rocker}", 0], force: ["{down}", "{mass}"]}}}}
springs: {{coil: {{nodes: [B, O2], stiffness: "{stiffness}", free: "{rocker}"}}}}
"""

FORMULAS = {
    "first": "parameters: {a: 40, b: 3*a, c: 2*a, t: 'atan2(25.71, 30.64)/deg', m: 0.5 + a/100}",
    "frame": "hypot(c, a*sqrt(2)) + 2", "down": "-a/20", "ax": "a*cos(t*deg)", "ay": "a*sin(t*deg)", "crank": "a",
    "rod": "b", "rocker": "c", "start": "t", "end": "t + 360", "half": "b/2", "mass": "m", "inertia": "m*1e-3",
    "stiffness": "2e3/a",
}  # fmt: skip

VERBS = {
    "trace": lambda m: gimcli.trace(m, derivatives=2),
    "solve": lambda m: gimcli.solve(m, motor=77),
    "configurations": gimcli.configurations,
    "forces": gimcli.forces,
    "reduce": gimcli.reduce,
    "circuits": gimcli.circuits,
    "check": gimcli.check,
}


def values(a):
    """Return the values of the formulas, computed by Python."""
    deg, c, m = pi / 180, 2 * a, 0.5 + a / 100
    t = atan2(25.71, 30.64) / deg
    return {
        "frame": hypot(c, a * sqrt(2)) + 2, "down": -a / 20, "ax": a * cos(t * deg), "ay": a * sin(t * deg), "crank": a,
        "rod": 3 * a, "rocker": c, "start": t, "end": t + 360, "half": 3 * a / 2, "mass": m, "inertia": m * 1e-3,
        "stiffness": 2e3 / a,
    }  # fmt: skip


def content(result):
    """Return columns and report as text, in which NaN equals NaN."""
    return repr({name: np.asarray(column).tolist() for name, column in result.items()}), repr(result.report())


@pytest.mark.parametrize("verb", VERBS)
def test_results_are_those_of_the_numbers(verb):
    numbers = MODEL.format(first="source: numbers", **{name: repr(x) for name, x in values(37.3).items()})
    formulas = gimcli.loads(MODEL.format(**FORMULAS)).with_({"a": 37.3})
    assert content(VERBS[verb](formulas)) == content(VERBS[verb](gimcli.loads(numbers.replace('"', ""))))
