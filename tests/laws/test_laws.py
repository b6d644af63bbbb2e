"""Properties of every motion: independence of frame, scale, mirroring, order in the file, steps and method.

This module has its own reader of model files, and reads results from the text of the CSV file.
"""

from __future__ import annotations

import copy
from itertools import pairwise

import numpy as np
import pytest
from specifications import (
    NAMES,
    STEPS,
    apart,
    four_bar,
    known,
    moved,
    ray,
    read,
    run,
    shuffled,
    size,
    unit,
    worst,
)

TIGHT, SHIFTED = 1e-11, 1e-9


@pytest.mark.few
@pytest.mark.parametrize("name", NAMES)
def test_rows_that_are_ok_satisfy_the_file(name):
    m = known(name, 72)
    good = np.array(m.status) == "ok"
    assert np.all(good)
    assert np.max(worst(read(name), m)[good]) <= 1e-10
    assert np.max(m.residual[good]) <= 1e-10


@pytest.mark.few
@pytest.mark.parametrize("name", NAMES)
def test_inputs_follow_the_laws(name):
    for actuator, drive in read(name)["actuators"].items():
        value, law = known(name).value[actuator], drive.get("law")
        if law is None:
            leader = known(name).value[drive["follows"]]
            assert value == pytest.approx(drive["ratio"] * leader + drive["phase"], rel=1e-13, abs=1e-12)
            continue
        if "by" in law:
            assert value[-1] - value[0] == pytest.approx(law["by"], rel=1e-12)
        else:
            assert [value[0], value[-1]] == pytest.approx([law["from"], law["to"]], rel=1e-14)
        if law.get("profile", "uniform") == "uniform":
            assert value == pytest.approx(np.linspace(value[0], value[-1], STEPS + 1), rel=1e-13, abs=1e-12)


# --- other frames ----------------------------------------------------------------------------------------


FRAMES = {
    "turned": ({"turn": 37.0}, TIGHT),
    "million times": ({"scale": 1e6}, TIGHT),
    "millionth": ({"scale": 1e-6}, TIGHT),
    "shifted": ({"shift": 1.0}, SHIFTED),
    "mirrored": ({"mirror": True}, TIGHT),
    "mirrored and turned": ({"mirror": True, "turn": 37.0, "scale": 3.0}, TIGHT),
}


@pytest.mark.few(45)
@pytest.mark.parametrize("frame", FRAMES)
@pytest.mark.parametrize("name", NAMES)
def test_the_frame_of_reference_changes_only_rounding_errors(name, frame):
    spec, here = read(name), known(name)
    change, tolerance = FRAMES[frame]
    if "shift" in change:
        change = {"shift": 1000 * size(spec) * (0.6 + 0.8j)}
    other, there = moved(spec, **change)
    m = run(other)
    assert m.status == here.status
    assert apart(m.z, {node: there(z) for node, z in here.z.items()}, other) <= tolerance


# --- orders ----------------------------------------------------------------------------------------------


@pytest.mark.few
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_the_order_in_the_file_does_not_matter(name, seed):
    spec, here = read(name), known(name)
    other = {"links": {}, "elements": {}, **shuffled(spec, seed)}
    m = run(other)
    assert m.status == here.status
    assert apart(m.z, here.z, spec) <= TIGHT


# --- steps -----------------------------------------------------------------------------------------------


@pytest.mark.few
@pytest.mark.parametrize("name", NAMES)
def test_twice_the_steps_give_the_same_common_rows(name):
    few, many = known(name), known(name, 2 * STEPS)
    assert few.status == many.status[::2]
    assert apart({node: z[::2] for node, z in many.z.items()}, few.z, read(name)) <= TIGHT


@pytest.mark.few
@pytest.mark.parametrize("steps", [1, 3, 5])
@pytest.mark.parametrize("name", NAMES)
def test_coarse_steps_keep_the_branch(name, steps):
    coarse, fine = known(name, steps), known(name, 360)
    assert set(coarse.status) == {"ok"}
    common = {node: z[:: 360 // steps] for node, z in fine.z.items()}
    assert apart(coarse.z, common, read(name)) <= TIGHT


TURNING = [
    name
    for name in NAMES
    if all(
        d.get("type") == "rotary" and abs(d["law"].get("by", d["law"].get("to", 0) - d["law"].get("from", 0))) == 360
        for d in read(name)["actuators"].values()
        if "law" in d
    )
]


@pytest.mark.parametrize("name", TURNING)
def test_a_full_turn_returns_to_the_start(name):
    m = known(name, 72)
    assert max(abs(z[-1] - z[0]) for z in m.z.values()) <= TIGHT * size(read(name))


# --- methods ---------------------------------------------------------------------------------------------


@pytest.mark.few
@pytest.mark.parametrize("name", NAMES)
def test_newton_agrees_with_auto(name):
    m, auto = known(name, method="newton"), known(name)
    assert m.status == auto.status
    assert apart(m.z, auto.z, read(name)) <= 1e-10


GIM = {"method": "gim", "tolerance": 1e-8, "jit": "off", "sweeps": 2000}


@pytest.mark.few
@pytest.mark.parametrize("name", NAMES)
def test_gim_agrees_or_has_another_status(name):
    steps = 8
    m, auto = run(read(name), steps, **GIM), known(name, steps)
    good = [k for k, status in enumerate(m.status) if status == "ok"]
    assert {"ok", "not-converged", "stalled", "other-configuration"} >= set(m.status)
    for node, z in m.z.items():
        assert np.all(np.isnan(np.delete(z, good)))
        assert np.max(abs(z - auto.z[node])[good], initial=0.0) <= 1e-5 * size(read(name))
    if good:
        assert np.max(worst(read(name), m)[good]) <= 1e-7


COUPLED = [
    "double_butterfly", "double_butterfly_symmetric", "gim_fig11", "gim_fig13c", "plantigrade", "platform_3rpr",
    "platform_3rrr", "stephenson_2", "stephenson_3_far", "ten_bar",
]  # fmt: skip


@pytest.mark.parametrize("name", COUPLED)
def test_plain_and_compiled_agree_bit_for_bit(name):
    assert run(read(name), 12, jit="off").text == run(read(name), 12, jit="on").text


@pytest.mark.parametrize("name", ["gim_fig11", "gim_fig13b", "platform_3rrr", "whitworth"])
def test_plain_and_compiled_sweeps_agree_bit_for_bit(name):
    plain, compiled = (run(read(name), 6, **{**GIM, "jit": jit}) for jit in ("off", "on"))
    assert plain.text == compiled.text


# --- straight through flat positions ---------------------------------------------------------------------


def third_crank():
    spec = {"nodes": {"O2": 0, "E": 1, "D": 2, "A": None, "F": None, "C": None}, "ground": ["O2", "E", "D"]}
    spec["links"] = {o + a: {"nodes": [o, a], "length": 1} for o, a in (("O2", "A"), ("E", "F"), ("D", "C"))}
    spec["elements"] = {"bar": {"nodes": ["A", "F", "C"], "shape": {"A": [0, 0], "F": [1, 0], "C": [2, 0]}}}
    return spec


def about(a, b, p):
    """Mirror p in the line a-b."""
    return a + unit(b - a) ** 2 * np.conj(p - a)


FLAT = {
    "parallelogram": (four_bar(1, 3, 1, 3), lambda t: {"B": 3 + ray(t)}),
    "long parallelogram": (four_bar(3, 1, 3, 1), lambda t: {"B": 1 + 3 * ray(t)}),
    "antiparallelogram": (four_bar(1, 3, 1, 3), lambda t: {"B": about(ray(t), 3, 3 + ray(t))}),
    "long antiparallelogram": (four_bar(3, 1, 3, 1), lambda t: {"B": about(3 * ray(t), 1, 1 + 3 * ray(t))}),
    "rhombus": (four_bar(1, 1, 1, 1), lambda t: {"B": 1 + ray(t)}),
    "folded rhombus": (four_bar(1, 1, 1, 1), lambda t: {"B": 0 * ray(t)}),
    "kite": (four_bar(1, 1, 3, 3), lambda t: {"B": about(ray(t), 3, 0j)}),
    "folded kite": (four_bar(1, 1, 3, 3), lambda t: {"B": 0 * ray(t)}),
    "kite about its axis": (
        four_bar(1, 3, 3, 1), lambda t: {"B": ray(t / 2) * (ray(t / 2).real + np.sqrt(9 - ray(t / 2).imag ** 2))},
    ),
    "third crank": (third_crank(), lambda t: {"F": 1 + ray(t), "C": 2 + ray(t)}),
}  # fmt: skip
"""Specification, and positions of the moving nodes at the crank angle t [deg]; A is the pin of the crank."""


def flat(linkage, start, sense):
    spec, places = FLAT[linkage]
    spec = copy.deepcopy(spec)
    crank = next(iter(spec["links"].values()))["length"]
    drawn = {"A": crank * ray(50.0), **places(50.0)}
    spec["nodes"] = {n: complex(drawn[n] if z is None else z) for n, z in spec["nodes"].items()}
    spec["nodes"] = {n: [z.real, z.imag] for n, z in spec["nodes"].items()}
    law = {"from": start, "to": start + sense * 360}
    spec["actuators"] = {"motor": {"type": "rotary", "pivot": "O2", "arm": "A", "law": law}}
    return spec, lambda t: {"A": crank * ray(t), **places(t)}


@pytest.mark.few(25)
@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize("start", [20.0, 65.5, 90.0, 20.0 + 1e-6, 20.0 - 1e-9, 20.0 + 1e-12])
@pytest.mark.parametrize("steps", [360, 359, 50, 7, 4, 6, 8])
@pytest.mark.parametrize("linkage", FLAT)
def test_straight_through_the_flat_positions(linkage, start, sense, steps):
    spec, places = flat(linkage, start, sense)
    m = run(spec, steps)
    assert set(m.status) == {"ok"}
    for node, z in places(m.value["motor"]).items():
        assert np.max(abs(m.z[node] - z)) <= 1e-9 * size(spec)
    assert np.max(worst(spec, m)) <= 1e-10


@pytest.mark.few(5)
@pytest.mark.parametrize("linkage", FLAT)
def test_solved_rows_after_a_start_in_the_flat_position_are_accurate(linkage):
    """The coordinates are those of another position, so the branch is known; not all rows need to be solved."""
    spec, places = flat(linkage, 0.0, 1)
    m = run(spec, 36)
    good = np.array(m.status) == "ok"
    for node, z in places(m.value["motor"]).items():
        assert np.max(abs(m.z[node] - z)[good], initial=0.0) <= 1e-9 * size(spec)


# --- the tests themselves --------------------------------------------------------------------------------


def test_a_wrong_row_is_detected():
    name = "crank_rocker"
    m = run(read(name))
    assert np.max(worst(read(name), m)) <= 1e-10
    m.z["B"] = m.z["B"] + 1e-7
    assert np.max(worst(read(name), m)) > 1e-10


def test_expected_positions_are_continuous():
    """So a jump to another branch is detected."""
    t = np.linspace(20, 380, 3601)
    for linkage, (_, places) in FLAT.items():
        for z in places(t).values():
            assert max(abs(b - a) for a, b in pairwise(z)) < 0.02, linkage
