"""Derivatives of coordinates and angles by the dimensions of a file: closed forms, Euler's law, differences."""

import numpy as np
import pytest
import yaml
from bundled import FILES
from four_bars import four_bar_text
from random_mechanisms import Growth

from gimcli import GimError, UsageError, load
from gimcli.families.design_sensitivity import DesignSensitivity, moves_nodes
from gimcli.families.design_state import position_items
from gimcli.motion.motion import trace
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options

TABLE = {  # references/families.md, section 4: dt3, dt4 [rad per length or rad], P.x, P.y of a, b, c, d = 2, 7, 9, 6
    "crank.length": (-0.01419934006980844, -0.1206967863242586, 0.9091909347409572, 0.5275284089020182),
    "coupler.length": (-0.2636714500970821, -0.2332436083100963, 0.8015526134003837, 0.5111825942878822),
    "follower.length": (0.2998846392558381, 0.2050777945199527, -0.9116395280021575, -0.5813894823479846),
    "O4.x": (-0.1374771537472253, 0.004733113356602814, 0.4179260660506158, 0.2665283938854416),
    "P.x": (0.0, 0.0, 0.02029257475004486, 0.9997940845044113),
    "P.y": (0.0, 0.0, -0.9997940845044113, 0.02029257475004486),
    "motor": (-0.5990965718586148, -0.3991734790213894, 0.8212340497072181, 2.893525588850298),
}
POINT = 2.0 * np.exp(1j * np.radians(30.0)) + (3.0 + 2.0j) * np.exp(1j * np.radians(88.8372413002617243))


def four_bar(angle="deg"):
    turn = 30.0 if angle == "deg" else float(np.radians(30.0))
    text = four_bar_text(2.0, 7.0, 9.0, 6.0, np.radians(30.0), law=f", law: {{from: {turn!r}, to: {turn * 2!r}}}")
    model = yaml.safe_load(text.replace("angle: deg", f"angle: {angle}"))
    return load(model | {"points": {"P": {"on": "coupler", "local": [3, 2]}}})


def start(mechanism, names, texts):
    """Return the quantities and their derivatives (quantities, dimensions) at the start of the law."""
    motion = trace(mechanism, 1, Options(tolerance=1e-13))
    quantities = [item for text in texts for item in position_items(mechanism, text)]
    found = DesignSensitivity(mechanism, names, quantities, plain)(motion.z, motion.inputs)
    return found.values[:, 0], found.slopes[..., 0]


def test_a_four_bar_has_the_derivatives_of_the_closed_form():
    values, slopes = start(four_bar("rad"), list(TABLE), ["coupler", "follower.angle", "P"])
    assert values[2:] == pytest.approx([POINT.real, POINT.imag], abs=1e-12)
    assert pytest.approx(np.array(list(TABLE.values())), abs=1e-10) == slopes.T


def test_derivatives_are_in_the_units_of_the_file():
    _, slopes = start(four_bar("deg"), ["crank.length", "motor"], ["coupler.angle", "P.x"])
    radian = 180.0 / np.pi
    crank, motor = TABLE["crank.length"], TABLE["motor"]
    wanted = [[crank[0] * radian, motor[0]], [crank[2], motor[2] / radian]]
    assert slopes == pytest.approx(np.array(wanted), abs=1e-9)


def test_scaling_all_lengths_scales_the_point_and_turns_no_member():
    """Euler's law of homogeneous functions."""
    names = [name for name in TABLE if name != "motor"]
    mechanism = four_bar("rad")
    sizes = [d.value for name in names for d in mechanism.written.dimensions.values() if d.name == name]
    values, slopes = start(mechanism, names, ["P", "coupler", "follower", "transmission"])
    assert slopes @ sizes == pytest.approx([*values[:2], 0.0, 0.0, 0.0], abs=1e-11)


def test_transmission_angle_is_the_difference_of_two_directions():
    values, slopes = start(four_bar("rad"), list(TABLE), ["transmission", "angle:follower/coupler"])
    wanted = [row[1] - row[0] for row in TABLE.values()]
    assert np.degrees(values) == pytest.approx([117.286067860350228 - 88.8372413002617243] * 2, abs=1e-9)
    assert slopes[0] == pytest.approx(wanted, abs=1e-10)
    assert slopes[1] == pytest.approx(wanted, abs=1e-10)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
@pytest.mark.few(2)
def test_models_have_the_derivatives_of_differences(path):
    mechanism = load(path)
    motion = traced(mechanism)
    if motion is None:
        pytest.skip("the model has no motion")
    compared, fixed = compare(mechanism, motion)
    assert compared or fixed


RANDOM = [  # kind of groups, drive, seed: loci with offsets, tilted guides, driven heights in coupled groups
    ("true_pair", "distance", 2), ("true_pair", "crank", 5), ("rpr", "travel", 3), ("prp", "travel", 2),
    ("prp", "travel", 0), ("rpr", "elsewhere", 1), ("rrr", "elsewhere", 3), ("true_pair", "distance", 1),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "drive", "seed"), RANDOM)
@pytest.mark.few(2)
def test_random_mechanisms_have_the_derivatives_of_differences(kind, drive, seed):
    grown = Growth(seed, [kind, kind], None if drive == "crank" else drive)
    mechanism = load(grown.explicit(0.0))
    compared, fixed = compare(mechanism, traced(mechanism))
    assert compared > 10
    assert not fixed


def compare(mechanism, motion):
    """Compare all derivatives with differences; return how many were compared, and the dimensions that are fixed."""
    quantities = quantities_of(mechanism)
    given = [d for d in mechanism.written.dimensions.values() if d.given and not d.formula]
    found = DesignSensitivity(mechanism, [d.name for d in given], quantities, plain)
    result = found(motion.z, motion.inputs)
    compared, fixed = 0, found.fixed(motion.z, motion.inputs)
    for k in np.flatnonzero(moves_nodes(found.tables)):
        wanted = difference(mechanism, given[k], motion.inputs, quantities)
        if given[k].name in fixed:
            assert wanted is None, given[k].name  # the changed mechanism contradicts itself
        elif wanted is not None:
            away = np.abs(result.slopes[:, k] - wanted) / np.maximum(1.0, np.abs(wanted))
            assert np.nanmax(away[:, regular(result)], initial=0.0) < 1e-4, given[k].name
            compared += 1
    return compared, fixed


def traced(mechanism):
    try:
        motion = trace(mechanism, 8, Options(tolerance=1e-13))
    except GimError:
        return None
    return motion if motion.good[0] else None


def quantities_of(mechanism):
    found = []
    for text in (*mechanism.traced, *(m.name for m in mechanism.members[1:]), "transmission"):
        try:
            found += position_items(mechanism, text)
        except UsageError:
            assert text == "transmission"
    return found


def regular(result):
    """Return the rows that are not near a dead point: differences of positions are not exact there."""
    most = np.abs(result.slopes).max(axis=(0, 1))
    with np.errstate(invalid="ignore"):
        return result.good & (most < 20.0 * np.nanmedian(most))


def difference(mechanism, one, inputs, quantities):
    """Return the derivatives (quantities, rows) by differences of order 4; None if the laws or the circuit change."""
    step = 1e-5 * max(1.0, abs(one.value))
    found = []
    for change in (step, -step, 2.0 * step, -2.0 * step):
        motion = traced(mechanism.with_({one.name: one.value + change}))
        if motion is None or not np.allclose(motion.inputs, inputs, rtol=0.0, atol=1e-12):
            return None
        own = quantities_of(motion.mechanism)
        found.append(DesignSensitivity(motion.mechanism, [], own, plain)(motion.z, motion.inputs).values)
    turn = 360.0 if mechanism.angle_unit == "deg" else 2.0 * np.pi
    turns = np.array([[turn if one.quantity.circular else 0.0] for one in quantities])
    with np.errstate(invalid="ignore", divide="ignore"):
        whole = [np.where(turns > 0.0, turns * np.round((a - b) / turns), 0.0) for a, b in (found[:2], found[2:])]
    near, far = found[0] - found[1] - whole[0], found[2] - found[3] - whole[1]
    return (8.0 * np.array(near) - np.array(far)) / (12.0 * step)
