"""Laws whose values exceed the bound of `--at` anywhere are rejected, also those with overflowing coefficients."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from gimcli import ModelError, load
from gimcli.mechanism import MOST_TURNS

MODEL = """\
nodes: {{O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 3]}}
ground: [O, G]
links: {{crank: [O, A], rod: [A, B]}}
prismatic: {{s: {{node: B, guide: [O, G], offset: 3}}}}
actuators: {{m: {{{drive}, law: {law}}}}}
"""
ROTARY, RAM, SLIDER = (
    "type: rotary, pivot: O, arm: A",
    "type: linear, nodes: [O, B]",
    "type: linear, node: B, guide: [O, G]",
)
MOST = 360.0 * MOST_TURNS
DEEP = 4.0 * MOST  # s = t - c t (1 - t) reaches 1/2 - c/4 in the middle


@pytest.fixture
def loaded(tmp_path):
    """Load a model with some input and law; overflow must not cause a warning."""

    def run(drive, law):
        path = tmp_path / "m.yaml"
        path.write_text(MODEL.format(drive=drive, law=law))
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return load(path)

    return run


@pytest.mark.parametrize(
    ("drive", "law"),
    [
        (ROTARY, f"{{polynomial: [0, {DEEP * 0.999}, {-DEEP * 0.999}]}}"),
        (ROTARY, f"{{from: 0, to: {MOST}}}"),
        (ROTARY, f"{{by: {MOST - 90.0}}}"),
        (ROTARY, "{polynomial: [1, 1e-300, 1e-320]}"),
        (ROTARY, "{polynomial: [0]}"),
        (ROTARY, "{polynomial: [0, 0, 0]}"),
        (RAM, "{polynomial: [5, -19, 19]}"),
        (SLIDER, "{by: 1, polynomial: [0, 3, -2]}"),
    ],
)
def test_a_law_within_the_bound_is_accepted(drive, law, loaded):
    values = loaded(drive, law).actuators[0].law(np.linspace(0.0, 1.0, 101))
    assert np.all(np.isfinite(values))


@pytest.mark.parametrize("seed", range(40))
def test_an_accepted_polynomial_is_within_the_bound_everywhere(seed, loaded):
    """Random polynomials are accepted or rejected as the maximum on a fine grid of their values requires."""
    rng = np.random.default_rng(seed)
    c = rng.normal(size=rng.integers(2, 9)) * 10.0 ** rng.uniform(-3, 3, size=1)
    t = np.linspace(0.0, 1.0, 100_001)
    highest = np.max(np.abs(np.polynomial.polynomial.polyval(t, c)))
    for factor, fits in ((0.9999, True), (1.0001, False)):
        law = f"{{polynomial: {(c * (factor * MOST / highest)).tolist()}}}"
        if fits:
            found = loaded(ROTARY, law).actuators[0].law(t)
            assert np.max(np.abs(found)) <= math.radians(MOST)
        else:
            with pytest.raises(ModelError):
                loaded(ROTARY, law)


def test_a_polynomial_with_too_many_coefficients_is_rejected(loaded):
    with pytest.raises(ModelError):
        loaded(ROTARY, f"{{polynomial: {[0.0] * 5000}}}")
