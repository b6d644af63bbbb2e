"""Inputs set by hand: each position against a closed form, on the branch of the one before, however far it is."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable

import numpy as np
import pytest
from bundled import FEWEST, MODELS
from closed_linkages import meeting
from four_bars import cosines, four_bar

from gimcli import Mechanism, UsageError, load
from gimcli.motion.dragging import FARTHEST, InputDrag
from gimcli.motion.motion import trace
from gimcli.status import Status

NORTON = (40.0, 120.0, 80.0, 100.0)
"""The crank-rocker of Norton, Design of Machinery, example 4-1."""

ROCKER = (4.0, 1.5, 2.0, 4.0)
"""A triple rocker: its limits are where coupler and follower are stretched, or folded over each other."""
STRETCHED, FOLDED = (math.acos(cosine) for cosine in cosines(*ROCKER))


def dragged(mechanism: Mechanism) -> InputDrag:
    return InputDrag(mechanism, [(mechanism.drawn_inputs, mechanism.drawn)])


def coupler_end(lengths: tuple[float, ...], side: int) -> Callable[[float], complex]:
    crank, coupler, follower, ground = lengths
    return lambda angle: complex(meeting(cmath.rect(crank, angle), coupler, complex(ground), follower, side))


def node(mechanism: Mechanism, z: np.ndarray, name: str) -> complex:
    return complex(mechanism.to_file(z)[mechanism.nodes.index(name)])


@pytest.mark.parametrize("side", [1, -1])
def test_a_crank_is_dragged_through_turns_in_small_and_large_steps(tmp_path, side):
    mechanism = four_bar(tmp_path, *NORTON, angle=1.0, side=side)
    drag, exact = dragged(mechanism), coupler_end(NORTON, side)
    angles = [*np.linspace(1.0, 1.0 + 2.0 * math.pi, 24), 0.2, 12.0, -9.0, -9.0, 3.3, 3.3 + 1e-14, 3.4]
    for angle in angles:
        found = drag.to(np.array([angle]))
        assert found.status is Status.OK
        assert abs(node(mechanism, found.z, "B") - exact(angle)) < 1e-10 * 120.0


@pytest.mark.parametrize(("angle", "limit"), [(2.0, STRETCHED), (0.0, FOLDED)])
@pytest.mark.parametrize("side", [1, -1])
def test_it_stops_at_a_limit_and_returns_on_the_same_side(tmp_path, angle, limit, side):
    mechanism = four_bar(tmp_path, *ROCKER, angle=0.5, side=side)
    drag, exact = dragged(mechanism), coupler_end(ROCKER, side)
    for beyond in (angle, angle + 0.1, limit + math.copysign(1e-6, angle - limit)):
        found = drag.to(np.array([beyond]))
        assert found.status is Status.LIMIT
        assert found.inputs == pytest.approx([limit], abs=1e-10)
        a, o4 = cmath.rect(ROCKER[0], limit), complex(ROCKER[3])
        reach = ROCKER[1] if limit == STRETCHED else -ROCKER[1]  # folded: B is beyond A, seen from O4
        assert abs(node(mechanism, found.z, "B") - (a + reach * (o4 - a) / abs(o4 - a))) < 1e-6
    at = drag.to(np.array([limit]))
    assert at.status is Status.OK
    for angle_inside in (limit + math.copysign(1e-3, 0.5 - limit), 0.4, 0.6):
        found = drag.to(np.array([angle_inside]))
        assert found.status is Status.OK
        assert abs(node(mechanism, found.z, "B") - exact(angle_inside)) < 1e-9


def test_it_passes_change_points_straight_and_may_stop_in_them():
    """Parallelogram: A and B have the same direction; its change points are at 0 and 180 degrees."""
    mechanism = load(MODELS / "parallelogram.yaml")
    drag = dragged(mechanism)
    o2, o4 = (node(mechanism, mechanism.drawn, name) for name in ("O2", "O4"))
    for degrees in (90.0, 180.0, 180.0, 170.0, 190.0, 180.0, 360.0, 365.0, -180.0, 40.0):
        found = drag.to(np.radians([degrees]))
        assert found.status is Status.OK
        a, b = (node(mechanism, found.z, name) for name in ("A", "B"))
        assert abs((a - o2) - (b - o4)) < 1e-10
        assert cmath.phase((a - o2) / cmath.rect(1.0, math.radians(degrees))) == pytest.approx(0.0, abs=1e-12)


def test_a_step_may_be_as_small_as_a_rounding_error():
    """The first input of this law has more digits than the value that a page sends."""
    mechanism = load(MODELS / "gim_fig13a.yaml")
    motion = trace(mechanism, 12)
    drag = InputDrag(mechanism, [(motion.inputs[:, 0], motion.z[:, 0])])
    for change in (1e-12, 1e-10, 1e-8, 1e-6):
        found = drag.to(motion.inputs[:, 0] + change)
        assert found.status is Status.OK
        assert np.max(np.abs(found.z - motion.z[:, 0])) < 1e-12 + 10.0 * change


def test_several_inputs_are_dragged_one_at_a_time():
    """Three actuators change one after the other; the end is that of the motion in which all change at once."""
    mechanism = load(MODELS / "platform_3rpr.yaml")
    motion = trace(mechanism, 40)
    drag = InputDrag(mechanism, [(motion.inputs[:, 0], motion.z[:, 0])])
    inputs = motion.inputs[:, 0].copy()
    for k in range(len(inputs)):
        inputs = inputs.copy()
        inputs[k] = motion.inputs[k, 12]
        assert drag.to(inputs).status is Status.OK
    assert np.max(np.abs(drag.last.z - motion.z[:, 12])) < 1e-9


def test_it_begins_at_the_first_regular_position():
    """The first row of this motion is the change point of the parallelogram at 0 degrees."""
    mechanism = load(MODELS / "parallelogram.yaml")
    motion = trace(mechanism, 12)
    singular = np.array([0.0])
    row = next(k for k in range(13) if abs(math.sin(motion.inputs[0, k])) > 0.1)
    o2, a, b = (mechanism.nodes.index(name) for name in ("O2", "A", "B"))
    flat = mechanism.drawn.copy()
    flat[a], flat[b] = flat[o2] + abs(flat[a] - flat[o2]), flat[mechanism.nodes.index("O4")] + abs(flat[a] - flat[o2])
    drag = InputDrag(mechanism, [(singular, flat), (motion.inputs[:, row], motion.z[:, row])])
    assert drag.last.inputs == motion.inputs[:, row]
    with pytest.raises(UsageError, match="no regular position"):
        InputDrag(mechanism, [(singular, flat)])


def test_a_step_of_very_many_turns_is_refused():
    drag = dragged(load(MODELS / "parallelogram.yaml"))
    with pytest.raises(UsageError, match=f"at most {FARTHEST:g} turns"):
        drag.to(np.array([3.0 + 2.0 * math.pi * FARTHEST]))


@pytest.mark.few(*FEWEST)
def test_the_order_of_the_inputs_does_not_matter(model):
    """Rows of a motion, in random order and in small steps back and forth, have the positions of the motion."""
    mechanism = load(model)
    motion = trace(mechanism, 120)
    good = np.flatnonzero(motion.good)
    drag = InputDrag(mechanism, ((motion.inputs[:, k], motion.z[:, k]) for k in good))
    generator = np.random.default_rng(1)
    small = np.abs(np.cumsum(generator.integers(-3, 4, 20))) % len(good)
    for k in good[[*generator.integers(0, len(good), 6), *small]]:
        found = drag.to(motion.inputs[:, k])
        assert found.status is Status.OK
        assert np.max(np.abs(found.z - motion.z[:, k])) < 1e-9
