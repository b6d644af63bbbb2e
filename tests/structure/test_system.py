"""The equations of a mechanism as one system of second degree, and the continuation of its curves."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from bundled import FILES

from gimcli import load
from gimcli.comparison.true_error import Constraints
from gimcli.continuation.arclength import ArclengthConstants, between, place, walk
from gimcli.mechanism import FloatArray
from gimcli.structure.system import System


@pytest.mark.few
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_values_and_derivatives_are_those_of_the_constraints(path: Path) -> None:
    """The quadratic form against `Constraints`, at positions far from assembled ones."""
    system, rng = System(load(path)), np.random.default_rng(5)
    count = len(system.mechanism.actuators)
    x, u = rng.normal(size=system.n), rng.normal(size=count)
    z, constraints = system.nodes(x)[:, None], Constraints(system.mechanism)
    residual, jacobian = constraints.residual(z, u[:, None])[:, 0], constraints.jacobian(z, u[:, None])[0]
    assert np.allclose(system.residual(x, u), system.scale * residual, atol=1e-13)
    assert np.allclose(system.jacobian(x, u), system.scale[:, None] * jacobian, atol=1e-13)
    assert np.array_equal(system.coordinates(system.nodes(x)), x)
    form = system.quadric(u)
    assert np.allclose(form.value(x), system.residual(x, u), atol=1e-13)
    assert np.allclose(form.slope(np.array([x, 2.0 * x]))[1], system.jacobian(2.0 * x, u), atol=1e-13)
    v, w = rng.normal(size=(2, system.n + count))

    def f(step: FloatArray) -> FloatArray:
        return system.residual(x + step[: system.n], u + step[system.n :])

    h = 1e-4
    mixed = (f(h * (v + w)) - f(h * (v - w)) - f(h * (w - v)) + f(-h * (v + w))) / (4.0 * h * h)
    assert np.allclose(system.second(x, u, v, w), mixed, atol=3e-6)
    rate = rng.normal(size=count)
    step = h * np.concatenate([np.zeros(system.n), rate])
    assert np.allclose(system.along_inputs(x, u, rate), (f(step) - f(-step)) / (2.0 * h), atol=1e-6)


class Curve:
    """A plane curve g(x, y) = 0 with the same equation twice: redundant equations must have no influence."""

    def __init__(self, g: Callable[..., float], gradient: Callable[..., list[float]]) -> None:
        self.g, self.gradient = g, gradient

    def linearised(self, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        return np.apply_along_axis(lambda at: [self.g(*at), -2.0 * self.g(*at)], -1, p), self.jacobian(p)

    def jacobian(self, p: FloatArray) -> FloatArray:
        return np.apply_along_axis(lambda at: np.outer([1.0, -2.0], self.gradient(*at)), -1, p)


def test_a_circle_is_followed_through_its_folds() -> None:
    """All points are on it, they cover a whole turn, and its greatest x is found to full accuracy."""
    circle = Curve(lambda x, y: x * x + y * y - 1.0, lambda x, y: [2.0 * x, 2.0 * y])
    policy = ArclengthConstants(points=200)
    start = place(circle, np.array([0.0, -1.0]), np.array([1.0, 0.0]))
    places = [start, *walk(circle, start, policy)]
    p = np.array([q.p for q in places])
    assert np.abs(np.hypot(*p.T) - 1.0).max() < 1e-15
    angle = np.unwrap(np.arctan2(p[:, 1], p[:, 0]))
    assert np.all(np.diff(angle) > 0.0)
    assert angle[-1] - angle[0] > 2.0 * math.pi
    fold = next(k for k in range(len(places)) if places[k + 1].tangent[0] < 0.0)
    found = between(circle, *places[fold : fold + 2], lambda q: float(q.tangent[0]), policy)
    assert found is not None
    assert np.abs(found.p - [1.0, 0.0]).max() < 1e-13


def test_the_orientation_changes_at_a_crossing() -> None:
    """Bernoulli's lemniscate crosses itself at the origin: (x^2 + y^2)^2 = x^2 - y^2."""
    curve = Curve(
        lambda x, y: (x * x + y * y) ** 2 - x * x + y * y,
        lambda x, y: [4.0 * x * (x * x + y * y) - 2.0 * x, 4.0 * y * (x * x + y * y) + 2.0 * y],
    )
    start = place(curve, np.array([1.0, 0.0]), np.array([0.0, 1.0]))
    places = [start, *walk(curve, start, ArclengthConstants(points=300))]
    turned = [b.p for a, b in pairwise(places) if a.orientation(a.left) * b.orientation(a.left) < 0.0]
    assert len(turned) >= 2  # in both senses
    assert all(np.hypot(*p) < 0.06 for p in turned)


@pytest.mark.few
@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_linear_equations_are_split_from_the_others(path: Path) -> None:
    system, rng = System(load(path)), np.random.default_rng(6)
    whole = system.quadric(np.zeros(len(system.mechanism.actuators)))
    whole = whole.rows(range(whole.m - len(system.mechanism.actuators)))
    flat, others = whole.split_linear(system.coordinates(system.mechanism.drawn))
    y, v = rng.normal(size=(2, 5, flat.basis.shape[1]))
    curved = np.any(whole.q, axis=(1, 2)) | (others.m == whole.m)
    assert np.allclose(whole.value(flat.lift(y))[:, ~curved], 0.0, atol=1e-12)
    assert np.allclose(whole.value(flat.lift(y))[:, curved], others.value(y), atol=1e-12)
    assert np.allclose(whole.slope(flat.lift(y))[:, curved] @ flat.basis, others.slope(y), atol=1e-12)
    assert np.allclose(flat.drop(flat.lift(y)), y, atol=1e-12)
    assert np.allclose(np.linalg.norm(flat.lift(y) - flat.lift(v), axis=1), np.linalg.norm(y - v, axis=1), rtol=1e-12)


def test_rounding_errors_of_a_short_link_are_those_of_its_length(tmp_path: Path) -> None:
    """A parallelogram with cranks 1 and coupler 1/1000, at any angle: squares of coordinates would leave 1e-14."""
    (tmp_path / "m.yaml").write_text(
        "units: {length: unit}\nnodes: {O2: [0, 0], O4: [0.001, 0], A: [0, 1], B: [0.001, 1]}\nground: [O2, O4]\n"
        "links: {crank: [O2, A], coupler: [A, B], follower: [O4, B]}\n"
        "actuators: {m: {type: rotary, pivot: O2, arm: A}}\n"
    )
    mechanism = load(tmp_path / "m.yaml")
    system, names = System(mechanism), mechanism.nodes
    coupler = system.names.index("coupler")
    at_drawing = dict(zip(names, mechanism.drawn, strict=True))
    for angle in np.linspace(0.1, 6.1, 25).tolist():
        arm = (at_drawing["A"] - at_drawing["O2"]) * np.exp(1j * angle)
        turned = {**at_drawing, "A": at_drawing["O2"] + arm, "B": at_drawing["O4"] + arm}
        x = system.coordinates(np.array([turned[name] for name in names]))
        assert abs(system.residual(x, mechanism.drawn_inputs)[coupler]) <= 8.0 * np.finfo(float).eps
