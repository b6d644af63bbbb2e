"""Static equilibria compared with closed forms, with the linearised equations, and under changes of the frame."""

from __future__ import annotations

import itertools
import json
import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from bundled import MODELS
from in_process import gim
from scipy import optimize

from gimcli import equilibrium, forces, load, solve
from gimcli.continuation.released import ReleasedPositions
from gimcli.dynamics.equilibria_balance import StaticBalance, released_inputs_line
from gimcli.dynamics.equilibria_search import EquilibriumSearch
from gimcli.dynamics.small_motions import linearised
from gimcli.motion.solve import solve as solve_position
from gimcli.positions.options import Options
from gimcli.status import Status

G = 9.81
ROOT = 1e-11
"""Accuracy of a simple root, rad or relative to the size."""


def bar(**more):
    """A bar of 2 kg, its centre 0.3 m from the pivot O."""
    return {
        "units": {"length": "m", "angle": "rad"},
        "nodes": {"O": [0, 0], "A": [0.2, 0], "H": [0, 0.25]}, "ground": ["O", "H"], "links": {"bar": ["O", "A"]},
        "actuators": {"q": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 6}}},
        "masses": {"bar": {"mass": 2, "inertia": 0.06, "centre": [0.3, 0]}}, "gravity": [0, -G], **more,
    }  # fmt: skip


def values(found, name="q"):
    return [one["inputs"][name] for one in found.equilibria]


def words(found):
    return [one["stability"] for one in found.equilibria]


# -- one released input: closed forms ---------------------------------------------------------------


def test_a_balanced_bar_is_in_equilibrium_everywhere():
    """k a h = m g r: V = k (a^2 + h^2)/2 at all angles."""
    found = equilibrium(load(bar(springs={"s": {"nodes": ["A", "H"], "stiffness": 117.72, "free": 0}})))
    assert found.everywhere
    assert found.answered
    assert not found.equilibria
    assert np.abs(found.curve()["potential"] - 6.03315).max() < 1e-14
    assert abs(found.holding["q"]) < 1e-13


def test_a_stiffer_spring_holds_the_bar_upright():
    found = equilibrium(load(bar(springs={"s": {"nodes": ["A", "H"], "stiffness": 120, "free": 0}})))
    assert words(found) == ["stable", "unstable"]
    assert np.abs(np.array(values(found)) - [math.pi / 2, 1.5 * math.pi]).max() < 1e-12
    slope = 120 * 0.2 * 0.25 - 2 * G * 0.3
    assert [one["stiffness"][0][0] for one in found.equilibria] == pytest.approx([slope, -slope], abs=1e-13)


def upright(stiffness):
    """An upright bar, weight times distance of its centre 9.81 N m, on a torsion spring."""
    nodes = {"O": [0, 0], "A": [0, 1]}
    return bar(
        nodes=nodes, ground=["O"], springs={"s": {"pivot": "O", "arm": "A", "stiffness": stiffness}},
        masses={"bar": {"mass": 2, "inertia": 0.06, "centre": [0.5, 0]}},
        actuators={"q": {"pivot": "O", "arm": "A", "law": {"from": math.pi / 2, "to": 2}}},
    )  # fmt: skip


@pytest.mark.parametrize(
    ("ratio", "tilt", "slope"),
    [(2.0, 1.89549426703398095, 1.638045048285238), (1.25, 1.13110258565128291, 0.4679220538934336)],
)
def test_beyond_the_pitchfork_the_bar_tilts_to_both_sides(ratio, tilt, slope):
    found = equilibrium(load(upright(G / ratio)))
    assert words(found) == ["stable", "unstable", "stable"]
    assert np.array(values(found)) - math.pi / 2 == pytest.approx([-tilt, 0.0, tilt], abs=ROOT)
    stiffness = [one["stiffness"][0][0] * ratio / G for one in found.equilibria]
    assert stiffness == pytest.approx([slope, 1.0 - ratio, slope], abs=1e-12)


def test_before_the_pitchfork_the_bar_is_stable_and_at_it_the_root_is_triple():
    (one,) = equilibrium(load(upright(G / 0.9))).equilibria
    assert one["stability"] == "stable"
    assert one["inputs"]["q"] == pytest.approx(math.pi / 2, abs=ROOT)
    (one,) = equilibrium(load(upright(G))).equilibria
    assert one["multiplicity"] == 3
    assert one["stability"] == "stable"
    assert one["inputs"]["q"] == pytest.approx(math.pi / 2, abs=1e-9)


def test_a_soft_torsion_spring_is_wound_over_several_turns():
    """kappa phi = m g c sin phi has roots as long as kappa |phi| <= m g c: here in three turns on each side."""
    kappa = 0.5
    phi = np.linspace(-25.0, 25.0, 1_000_000)
    expected = int(np.sum(np.diff(np.sign(kappa * phi - G * np.sin(phi))) != 0))  # phi has no sample at 0
    found = equilibrium(load(upright(kappa)))
    assert found.count == expected
    assert found.complete  # all turns were examined
    assert found.report()["winds"]
    phi = np.array(values(found)) - math.pi / 2
    assert np.abs(kappa * phi - G * np.sin(phi)).max() < 1e-11
    assert set(words(found)[::2]) == {"stable"}
    assert set(words(found)[1::2]) == {"unstable"}
    potential = [one["potential"] for one in found.equilibria]
    assert potential == pytest.approx(0.5 * kappa * phi**2 + G * np.cos(phi), abs=1e-12)


def snapped(push=0.0):
    """A slider between two stable places, with a spring of 500 N/m and 0.2 m to a point 0.12 m above its guide."""
    return {
        "units": {"length": "m"},
        "nodes": {"L": [-0.5, 0], "R": [0.5, 0], "H": [0, 0.12], "P": [0.16, 0], "Q": [0.2, 0]},
        "ground": ["L", "R", "H"], "links": {"slider": ["P", "Q"]},
        "prismatic": {"slide": {"nodes": ["P", "Q"], "guide": ["L", "R"]}},
        "actuators": {"x": {"type": "linear", "node": "P", "guide": ["L", "R"], "law": {"from": 0.66, "to": 0.34}}},
        "springs": {"s": {"nodes": ["P", "H"], "stiffness": 500, "free": 0.2}},
        "loads": {"push": {"on": "slider", "local": [0, 0], "force": [push, 0]}},
    }  # fmt: skip


SNAP, SNAP_AT = 15.50574566059658, 0.07643548892524978


def test_a_slider_snaps_over_with_the_greatest_force_of_its_spring():
    found = equilibrium(load(snapped()))
    assert words(found) == ["stable", "unstable", "stable"]
    assert np.array(values(found, "x")) - 0.5 == pytest.approx([-0.16, 0.0, 0.16], abs=ROOT)
    assert [one["stiffness"][0][0] for one in found.equilibria] == pytest.approx([320, -1000 / 3, 320], abs=1e-9)
    (push,) = found.equilibria[2]["pushes"]
    assert push["effort"] == pytest.approx(-SNAP, abs=1e-11)
    assert push["barrier"] == pytest.approx(1.6, abs=1e-13)
    assert push["at"]["x"] - 0.5 == pytest.approx(SNAP_AT, abs=1e-11)
    assert push["to"] == 2
    assert push["sense"] == "down"


def test_the_snap_force_as_a_load_gives_a_double_root():
    found = equilibrium(load(snapped(-SNAP)))
    assert [(one["stability"], one["multiplicity"]) for one in found.equilibria] == [("stable", 1), ("undecided", 2)]
    assert values(found, "x")[1] - 0.5 == pytest.approx(SNAP_AT, abs=1e-11)
    assert equilibrium(load(snapped(-SNAP - 1e-6))).count == 1
    three = equilibrium(load(snapped(-SNAP + 1e-6)))
    assert words(three) == ["stable", "unstable", "stable"]
    assert three.equilibria[2]["pushes"][0]["effort"] == pytest.approx(-1e-6, rel=1e-6)


def bistable(shift=0.0, turn=0.0, size=1.0, more=None):
    """The four-bar 2, 7, 9, 6 with a torsion spring between coupler and rocker, relaxed at 60 deg of the crank."""
    place = complex(shift, -2.0 * shift)
    unit = complex(math.cos(turn), math.sin(turn)) * size
    b = _elbow(6.0, 2.0 * complex(0.5, math.sqrt(0.75)))
    nodes = {name: z * unit + place for name, z in (("O", 0j), ("A", 1 + 3**0.5 * 1j), ("B", b), ("C", 6 + 0j))}
    return {
        "units": {"length": "m", "angle": "rad"},
        "nodes": {name: [z.real, z.imag] for name, z in nodes.items()}, "ground": ["O", "C"],
        "links": {"crank": ["O", "A"], "coupler": ["A", "B"], "rocker": ["B", "C"]},
        "actuators": {"q": {"pivot": "O", "arm": "A", "reference": "C", "law": {"by": 1}}},
        "springs": {"s": {"pivot": "B", "arm": "A", "reference": "C", "stiffness": 3}}, **(more or {}),
    }  # fmt: skip


def _elbow(d, a):
    """Return the joint of bars 7 from a and 9 from d, above the line."""
    span = abs(d - a)
    x = (span**2 + 49 - 81) / (2 * span)
    return a + (d - a) / span * complex(x, math.sqrt(49 - x * x))


def four(found):
    """Return the values of the four-bar by the angle of the crank, within half a turn."""
    return sorted(
        (math.remainder(one["inputs"]["q"], 2 * math.pi), one["potential"], one["stiffness"][0][0])
        for one in found.equilibria
    )


BISTABLE = [
    (-math.pi / 3, 0.0, 0.2368421052631579), (0.0, 0.05272302331036461, -0.2515305706518346),
    (math.pi / 3, 0.0, 0.2368421052631579), (math.pi, 0.2305237364883918, -0.2629774152784181),
]  # fmt: skip


@pytest.mark.few(2)
@pytest.mark.parametrize(("shift", "turn", "size"), [(0, 0, 1), (30, 1.0, 1), (0, -2.5, 100), (-5, 0.3, 0.01)])
def test_a_bistable_four_bar(shift, turn, size):
    found = equilibrium(load(bistable(shift, turn, size)))
    got = four(found)
    if got[0][0] < -3.0:  # -pi and pi are the same
        got = [*got[1:], (math.pi, *got[0][1:])]
    assert np.array(got) == pytest.approx(np.array(BISTABLE), abs=1e-10)
    one = next(
        one for one in found.equilibria if abs(math.remainder(one["inputs"]["q"] - math.pi / 3, 2 * math.pi)) < 1e-6
    )
    pushes = {push["sense"]: push for push in one["pushes"]}
    inside, outside = pushes["down"], pushes["up"]
    assert inside["effort"] == pytest.approx(-0.07864832964083584, abs=1e-11)
    assert outside["effort"] == pytest.approx(0.1738089638995884, abs=1e-11)
    assert math.remainder(math.degrees(inside["at"]["q"]), 360) == pytest.approx(28.92954274424213, abs=1e-7)
    assert math.remainder(math.degrees(outside["at"]["q"]), 360) == pytest.approx(120.4672798540357, abs=1e-7)
    assert inside["barrier"] == pytest.approx(0.05272302331036461, abs=1e-12)
    assert outside["barrier"] == pytest.approx(0.2305237364883918, abs=1e-12)


def knee(force):
    """Two bars of 0.1 m whose end slides against a spring of 20 kN/m, relaxed at 10 deg, with a force on the knee."""
    a = math.radians(10)
    x, y = 0.1 * math.cos(a), 0.1 * math.sin(a)
    return {
        "units": {"length": "m"}, "nodes": {"O": [0, 0], "A": [x, y], "B": [2 * x, 0], "R": [0.3, 0]},
        "ground": ["O", "R"], "links": {"one": ["O", "A"], "two": ["A", "B"]},
        "prismatic": {"slide": {"node": "B", "guide": ["O", "R"]}},
        "actuators": {"q": {"pivot": "O", "arm": "A", "law": {"by": -20}}},
        "springs": {"s": {"node": "B", "guide": ["O", "R"], "stiffness": 20000}},
        "loads": {"push": {"on": "A", "force": [0, -force]}},
    }  # fmt: skip


def test_the_knee_snaps_over_at_its_greatest_force():
    snap, at = 8.185490674998929, 5.783338305714001
    near = [one for one in equilibrium(load(knee(snap))).equilibria if abs(one["inputs"]["q"] - at) < 1e-3]
    assert [(one["multiplicity"], one["stability"]) for one in near] == [(2, "undecided")]
    assert near[0]["inputs"]["q"] == pytest.approx(at, abs=1e-9)
    counts = [equilibrium(load(knee(force))).count for force in (0.999 * snap, snap, 1.001 * snap)]
    assert [count - counts[2] for count in counts] == [2, 1, 0]


def slider_crank():
    return {
        "units": {"length": "m"}, "nodes": {"O": [0, 0], "A": [0.1, 0], "B": [0.4, 0], "G": [1, 0]},
        "ground": ["O", "G"], "links": {"crank": ["O", "A"], "rod": ["A", "B"]},
        "prismatic": {"slide": {"node": "B", "guide": ["O", "G"]}},
        "actuators": {"q": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 360}}},
        "masses": {"crank": {"mass": 0.5, "inertia": 0}, "rod": {"mass": 0.8, "inertia": 0}, "B": 1.2},
        "gravity": [0, -G], "springs": {"s": {"node": "B", "guide": ["O", "G"], "stiffness": 600, "free": 0.33}},
    }  # fmt: skip


def test_a_slider_crank_has_four_equilibria():
    found = equilibrium(load(slider_crank()))
    places = [6.587611473323631, 61.2555238981577, 173.0053793000439, 360 - 66.28447331089764]
    assert values(found) == pytest.approx(places, abs=1e-10)
    slopes = [one["stiffness"][0][0] for one in found.equilibria]
    assert slopes == pytest.approx([-5.40201917976, 5.63896718131813, -5.23066521382, 7.17105902024866], abs=1e-10)
    assert words(found) == ["unstable", "stable", "unstable", "stable"]
    assert found.complete


@pytest.mark.few(3)
@pytest.mark.parametrize("kind", ["torque", "effort", "follower", "table", "follower table"])
def test_a_constant_torque_on_a_bar_has_two_equilibria_one_or_none(kind, tmp_path):
    """T = m g r cos q, with the torque as a load, a driving effort, and forces that have no potential."""
    (tmp_path / "table.csv").write_text("q,factor\n-9,1\n0,1\n9,1\n")
    greatest = 2 * G * 0.3
    for part, count in ((0.5, 2), (1.0, 1), (1.001, 0)):
        torque, model = part * greatest, bar()
        own = {"on": "bar", "torque": torque} if "follower" not in kind else {
            "on": "bar", "local": [0.2, 0], "follower": [0, torque / 0.2]
        }  # fmt: skip
        if "table" in kind:
            own |= {"table": str(tmp_path / "table.csv"), "over": "q"}
        if kind == "effort":
            model["actuators"]["q"] |= {"free": True, "effort": {"constant": torque}}
        else:
            model["loads"] = {"load": own}
        found = equilibrium(load(model))
        assert found.count == count
        assert found.report()["conservative"] is (kind in ("torque", "effort"))
        assert found.report()["gain"] == pytest.approx(-2 * math.pi * torque, rel=1e-9)
        assert np.cos(values(found)) == pytest.approx([part] * count, abs=1e-11)
        if count == 2:  # stable where the weight's torque grows against the sense of the motion
            angle = math.acos(part)
            stable = next(one for one in found.equilibria if one["stability"] == "stable")
            assert math.sin(stable["inputs"]["q"]) < 0
            up = next(push for push in stable["pushes"] if push["sense"] == "up")
            assert up["effort"] == pytest.approx(greatest - torque, abs=1e-11)
            assert up["barrier"] == pytest.approx(2 * greatest * math.sin(angle) - 2 * torque * angle, abs=1e-8)


def test_tables_over_time_are_taken_at_the_time(tmp_path):
    (tmp_path / "table.csv").write_text("time,factor\n0,0\n1,1\n2,2\n")
    model = bar(loads={"load": {"on": "bar", "torque": 2.0, "table": str(tmp_path / "table.csv")}})
    for time in (0.0, 1.0, 2.0):
        found = equilibrium(load(model), time=time)
        assert np.cos(values(found)) == pytest.approx([2.0 * time / (0.6 * G)] * 2, abs=1e-12)


def test_the_input_turns_back_at_its_limits_without_loss_of_a_root():
    """A rocker that is driven has limits, the crank of the same mechanism has none: the equilibria are the same."""
    model = bistable(more={"masses": {"A": 1.0, "B": 2.0}, "gravity": [0, -G]})
    model["actuators"] = {"q": {"pivot": "C", "arm": "B", "reference": "O", "law": {"by": -0.2}}}
    found, other = equilibrium(load(model)), bistable(more={"masses": {"A": 1.0, "B": 2.0}, "gravity": [0, -G]})
    assert found.report()["closed"]
    assert len(set(words(found)[::2])) == len(set(words(found)[1::2])) == 1
    by_crank = equilibrium(load(other))
    mine = sorted((one["potential"], *one["nodes"]["A"]) for one in found.equilibria)
    theirs = sorted((one["potential"], *one["nodes"]["A"]) for one in by_crank.equilibria)
    assert np.array(mine) == pytest.approx(np.array(theirs), abs=1e-9)
    assert any(push["effort"] is None for one in found.equilibria for push in one["pushes"])  # beyond a limit


def test_a_constant_force_along_a_line_has_no_equilibrium():
    """A block on an incline, and with a spring that bears it: k s = m g sin of 30 deg."""
    unit = complex(math.sqrt(0.75), 0.5)
    nodes = {name: [(s * unit).real, (s * unit).imag] for name, s in (("L", -1), ("R", 1), ("P", 0), ("Q", 0.2))}
    model = bar(
        nodes=nodes, ground=["L", "R"], links={"block": ["P", "Q"]},
        prismatic={"slide": {"nodes": ["P", "Q"], "guide": ["L", "R"]}}, masses={"block": {"mass": 2, "inertia": 0}},
        actuators={"q": {"type": "linear", "node": "P", "guide": ["L", "R"], "law": {"by": 0.1}}},
    )  # fmt: skip
    assert equilibrium(load(model)).headline().endswith("no equilibrium")
    found = equilibrium(load(model | {"springs": {"s": {"nodes": ["P", "L"], "stiffness": 50, "free": 1}}}))
    assert words(found) == ["stable", "unstable", "stable"]  # also beyond the end of the spring
    assert found.equilibria[2]["inputs"]["q"] == pytest.approx(1 - 2 * G * 0.5 / 50, abs=ROOT)


def test_a_spring_whose_ends_meet_is_unstable_there():
    """The force jumps; the equilibria on both sides are those of its length."""
    model = bar(
        nodes={"O": [0, 0], "A": [0, -1], "H": [0, 1]}, ground=["O", "H"],
        springs={"s": {"nodes": ["A", "H"], "stiffness": 40, "free": 0.5}},
    )  # fmt: skip
    found = equilibrium(load(model))
    assert words(found) == ["stable", "unstable", "stable", "unstable"]
    assert found.equilibria[1]["inputs"]["q"] == pytest.approx(math.pi / 2, abs=1e-9)
    assert found.equilibria[1]["stiffness"] is None


# -- several released inputs ------------------------------------------------------------------------


def chain(count):
    """A chain of equal uniform bars of 1 kg and 1 m between level pivots; inputs are the angles of all but two."""
    span = 3.0 * count / 4.0
    sag = 0.45 * math.sqrt(count**2 - span**2)
    nodes = {f"P{k}": [span * k / count, -4 * sag * k * (count - k) / count**2] for k in range(count + 1)}
    links = {f"b{k}": {"nodes": [f"P{k - 1}", f"P{k}"], "length": 1} for k in range(1, count + 1)}
    drives = {
        f"m{k}": {
            "pivot": f"P{k - 1}",
            "arm": f"P{k}",
            **({"reference": f"P{k - 2}"} if k > 1 else {}),
            "law": {"by": 1},
        }
        for k in range(1, count - 1)
    }
    return {
        "units": {"length": "m"}, "nodes": nodes, "ground": ["P0", f"P{count}"], "links": links, "actuators": drives,
        "masses": {name: {"mass": 1, "inertia": 0} for name in links}, "gravity": [0, -G],
    }  # fmt: skip


def slopes_of(one, count):
    z = np.array([complex(*one["nodes"][f"P{k}"]) for k in range(count + 1)])
    return np.diff(z).imag / np.diff(z).real


def test_a_hanging_chain_of_four_bars():
    found = equilibrium(load(chain(4)), free="m1,m2")
    assert not found.complete
    assert found.answered
    lowest = found.equilibria[0]
    assert lowest["stability"] == "stable"
    assert words(found).count("stable") == 1
    inner, outer = math.radians(24.5130741542914876), math.radians(53.8335261478816019)
    assert np.arctan(slopes_of(lowest, 4)) == pytest.approx([-outer, -inner, inner, outer], abs=1e-11)
    assert -lowest["nodes"]["P2"][1] == pytest.approx(1.22220663518684795, abs=1e-12)


def test_a_chain_of_six_bars_has_tangents_in_proportion_to_odd_numbers():
    lowest = equilibrium(load(chain(6)), free=["m1", "m2", "m3", "m4"], starts=3).equilibria[0]
    slopes = slopes_of(lowest, 6)
    assert slopes / slopes[3] == pytest.approx([-5, -3, -1, 1, 3, 5], abs=1e-9)
    assert lowest["negative"] == 0


def double_pendulum(**more):
    return bar(
        nodes={"O": [0, 0], "A": [0.6, 0.8], "B": [1.6, 0.8]}, ground=["O"],
        links={"one": ["O", "A"], "two": ["A", "B"]},
        actuators={
            "q": {"pivot": "O", "arm": "A", "law": {"by": 1}, "free": True},
            "r": {"pivot": "A", "arm": "B", "reference": "O", "law": {"by": 1}, "free": True},
        },
        masses={"one": {"mass": 1, "inertia": 0}, "two": {"mass": 1, "inertia": 0}}, **more,
    )  # fmt: skip


def test_a_double_pendulum_has_four_equilibria():
    found = equilibrium(load(double_pendulum()))
    assert [one["potential"] for one in found.equilibria] == pytest.approx([-2 * G, -G, G, 2 * G], abs=1e-12)
    assert [one["negative"] for one in found.equilibria] == [0, 1, 1, 2]
    assert np.array(found.equilibria[0]["stiffness"]) == pytest.approx(G * np.array([[2, 0.5], [0.5, 0.5]]), abs=1e-11)


def sprung_pendulum(seed):
    """A double pendulum with a spring at each end, and the potential's gradient (2,) at angles (2,)."""
    rng = np.random.default_rng(seed)
    (one, two), (g, h) = rng.uniform(0.5, 1.5, 2), rng.uniform(-2, 2, (2, 2))
    stiffness, free, mass = rng.uniform(5, 60, 2), rng.uniform(0.2, 1.5, 2), rng.uniform(0.5, 3, 2)
    model = double_pendulum(
        springs={
            name: {"nodes": ends, "stiffness": float(k), "free": float(length)}
            for name, ends, k, length in zip("st", (["G", "A"], ["H", "B"]), stiffness, free, strict=True)
        }
    )  # fmt: skip
    model["nodes"] = {"O": [0, 0], "A": [one, 0], "B": [one + two, 0], "G": g.tolist(), "H": h.tolist()}
    model["ground"], model["masses"] = ["O", "G", "H"], dict(zip("AB", mass.tolist(), strict=True))

    def gradient(q):
        knee = one * np.exp(1j * q[0])
        foot = knee + two * np.exp(1j * q[1])
        stretched = np.array([knee - complex(*g), foot - complex(*h)])
        force = stiffness * (1 - free / np.abs(stretched)) * stretched + 1j * G * mass
        moved = np.array([[1j * knee, 0], [1j * knee, 1j * (foot - knee)]])
        return (force.conj() @ moved).real

    return yaml.safe_load(json.dumps(model)), gradient


def balanced_angles(gradient):
    """The zeros of a gradient on the torus, from 24 x 24 starts of scipy's solver."""
    found = []
    for start in itertools.product(np.linspace(0, 2 * np.pi, 24, endpoint=False), repeat=2):
        q = optimize.root(gradient, start, tol=1e-12).x
        rays = np.exp(1j * q)
        if np.linalg.norm(gradient(q)) < 1e-7 and all(np.abs(rays - known).max() > 1e-5 for known in found):
            found.append(rays)
    return found


@pytest.mark.few(1)
@pytest.mark.parametrize("seed", [19, 0, 7, 8, 21, 27, 28, 32, 35])
def test_a_double_pendulum_on_springs_has_the_equilibria_of_another_solver(seed):
    model, gradient = sprung_pendulum(seed)
    found = equilibrium(load(model)).equilibria
    turned = [(one["inputs"]["q"], one["inputs"]["q"] + one["inputs"]["r"] + np.pi) for one in found]
    rays = np.exp(1j * np.array(turned))
    wanted = balanced_angles(gradient)
    assert len(found) == len(wanted)
    assert all(min(np.abs(one - other).max() for other in wanted) < 1e-9 for one in rays)


def test_the_balanced_lamp_is_in_equilibrium_everywhere():
    """Springs of free length zero with k a h = m g r: V = 9.04686375 J, with any number of inputs released."""
    mechanism = load("balanced_lamp")
    found = equilibrium(mechanism, starts=6)
    assert found.everywhere
    assert found.answered
    for q, r in ((60.0, -170.0), (100.0, -220.0)):
        there = solve(mechanism, shoulder=q, elbow=r)
        arm = 400 * np.exp(1j * math.radians(q))
        assert complex(*there.xy["A"]) == pytest.approx(arm, abs=1e-9)
        assert complex(*there.xy["B"]) == pytest.approx(arm - 350 * np.exp(1j * math.radians(r)), abs=1e-9)
        places = np.array([complex(*there.xy[name]) for name in mechanism.nodes])
        z = (places - mechanism.origin) / mechanism.scale
        state = linearised(mechanism, z, np.radians([q, r]), (0, 1))
        assert state.potential == pytest.approx(9.04686375, abs=1e-12)
        assert np.abs(state.stiffness).max() < 1e-12


def test_a_heavier_lamp_hangs():
    found = equilibrium(load("balanced_lamp").with_({"lamp": 0.7}), starts=10)
    assert [one["negative"] for one in found.equilibria] == [0, 1, 1, 2]
    heights = [one["nodes"]["B"][1] for one in found.equilibria]
    assert heights == pytest.approx([-750, -50, 50, 750], abs=1e-7)
    potential = [one["potential"] - 9.04686375 for one in found.equilibria]
    assert potential == pytest.approx(0.1 * G * 1e-3 * np.array(heights), abs=1e-11)


def test_a_held_input_keeps_its_value():
    model = double_pendulum()
    for one in model["actuators"].values():
        del one["free"]
    found = equilibrium(load(model), {"r": math.pi / 2}, "q")
    assert [one["inputs"]["r"] for one in found.equilibria] == pytest.approx([math.pi / 2] * 2)
    for one in found.equilibria:  # the common centre is above or below the pivot
        a, b = (complex(*one["nodes"][name]) for name in "AB")
        assert (0.5 * a + 0.5 * (a + b)).real == pytest.approx(0.0, abs=ROOT)


def test_without_a_potential_a_definite_matrix_does_not_prove_stability():
    """A follower force along the upper bar: Ziegler's column may flutter although V grows in all directions."""
    follower = {"push": {"on": "two", "local": [1, 0], "follower": [-1.0, 0]}}
    found = equilibrium(load(double_pendulum(loads=follower)))
    assert not found.report()["conservative"]
    assert found.count
    assert "stable" not in words(found)


# -- other methods ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["hatch", "toggle_clamp", "watt_durango", "pick_and_place", "excavator", "suspension"])
def test_forces_and_slopes_agree_with_the_linearised_equations(name):
    """An independent formulation: influence coefficients of the inputs from the equations of the simulation."""
    mechanism = load(MODELS / f"{name}.yaml")
    released, inputs = mechanism.drivers[:2], mechanism.start_inputs
    position = solve_position(mechanism, inputs, Options())
    assert position.status is Status.OK
    expected = linearised(mechanism, position.z, inputs, released)
    freedoms = ReleasedPositions(mechanism, *released_inputs_line(mechanism, released, inputs))
    start = freedoms.settled(freedoms.point(position.z, inputs[list(released)]))
    search = EquilibriumSearch(freedoms, StaticBalance(mechanism, released, 0.0), start, released)
    scale = np.abs(expected.stiffness).max()
    assert search._efforts(search.start) == pytest.approx(-expected.effort, abs=1e-10 * np.abs(expected.effort).max())
    rates = search._rates(search.start)
    own = -np.linalg.solve(rates, np.linalg.solve(rates, search.start.slope).T).T
    metres = np.where([mechanism.actuators[k].rotary for k in released], 1.0, search.balance.metre)
    bends = freedoms.bends(search.start.y, search.start.basis)[:, :, freedoms.system.n :] * metres
    bent = np.einsum("abk,k->ab", bends, expected.effort)  # the basis is straight in no input
    own -= -np.linalg.solve(rates, np.linalg.solve(rates, bent).T).T
    assert own == pytest.approx(expected.stiffness, abs=1e-9 * scale)


@pytest.mark.parametrize("name", ["hatch", "watt_durango"])
def test_each_equilibrium_is_one_of_the_linearised_equations(name):
    mechanism = load(MODELS / f"{name}.yaml")
    for one in equilibrium(mechanism)._found.found:
        there = linearised(mechanism, one.z, one.inputs, (0,))
        assert there.unbalance[0] < 1e-11
        assert there.stiffness[0, 0] == pytest.approx(one.stiffness[0, 0], rel=1e-9)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["watt_1", "watt_durango", "suspension", "swing"])
def test_the_holding_effort_is_that_of_the_inverse_dynamics_of_a_slow_motion(name):
    mechanism = load(MODELS / f"{name}.yaml").with_({"duration": 1e7})
    first = mechanism.actuators[0].name
    found = equilibrium(mechanism, {a.name: v for a, v in _starts(mechanism)}, first)
    assert found.holding[first] == pytest.approx(forces(mechanism, 1)[f"{first}.effort"][0], rel=1e-9)


def _starts(mechanism):
    for k, actuator in enumerate(mechanism.actuators):
        yield actuator, float(mechanism.value_to_file(k, mechanism.start_inputs[k : k + 1])[0])


@pytest.mark.few(3)
@pytest.mark.parametrize("name", ["snap_hinge", "suspension", "toggle_clamp", "garage_door", "watt_1"])
def test_stable_and_unstable_alternate_on_a_closed_circuit(name):
    found = equilibrium(load(MODELS / f"{name}.yaml"))
    assert found.report()["closed"]
    assert found.count % 2 == 0
    by_place = [one.stability for one in sorted(found._found.found, key=lambda one: one.fraction)]
    assert {tuple(by_place[::2]), tuple(by_place[1::2])} == {
        ("stable",) * (found.count // 2),
        ("unstable",) * (found.count // 2),
    }
    for one in found.equilibria:
        assert len(one["pushes"]) == 2 * (one["stability"] == "stable")
        assert all(push["barrier"] > 0.0 for push in one["pushes"])


def test_an_effort_over_its_input_has_a_potential(tmp_path):
    """A table that is a straight line from 3 to -3 N m is a torsion spring: V = m g r sin q - 3 q + q^2/3."""
    (tmp_path / "table.csv").write_text("q,effort\n-9,30\n0,3\n9,-24\n")
    model = bar()
    model["actuators"]["q"] |= {"free": True, "effort": {"table": str(tmp_path / "table.csv"), "over": "value"}}
    found = equilibrium(load(model))
    q, potential = found.curve()["q"], found.curve()["potential"]
    expected = 2 * G * 0.3 * np.sin(q) - 3 * q + 1.5 * q**2
    assert potential - potential[0] == pytest.approx(expected - expected[0], abs=1e-11)
    assert found.report()["conservative"]


def test_an_input_that_follows_moves_with_its_leader():
    """Bars of 1 m and 1 kg, and 0.6 m and 0.5 kg, hanging, q2 = R q1: V'' = g (m1 c1 + R^2 m2 c2)."""
    model = bar(
        nodes={"O": [0, 0], "A": [0, -1], "P": [2, 0], "B": [2, -0.6]}, ground=["O", "P"],
        links={"one": ["O", "A"], "two": ["P", "B"]},
        masses={"one": {"mass": 1, "inertia": 0}, "two": {"mass": 0.5, "inertia": 0}},
    )  # fmt: skip
    for ratio in (-1.0, -2.0, 0.5):
        down = -0.5 * math.pi
        model["actuators"] = {
            "q": {"pivot": "O", "arm": "A", "law": {"from": down, "to": down + 6}},
            "r": {"pivot": "P", "arm": "B", "follows": "q", "ratio": ratio, "phase": down - ratio * down},
        }
        found = equilibrium(load(model))
        lowest = min(found.equilibria, key=lambda one: one["potential"])
        assert lowest["stiffness"][0][0] == pytest.approx(G * (0.5 + ratio**2 * 0.15), abs=1e-11)
        q = np.array(values(found))
        assert 0.5 * np.cos(q) + ratio * 0.15 * np.cos(down + ratio * (q - down)) == pytest.approx(0.0, abs=1e-11)


# -- files and reports ------------------------------------------------------------------------------


def test_pictures_of_one_input_of_several_and_of_everywhere():
    one = equilibrium(load("snap_hinge")).picture()
    assert [picture.labels[1] for picture in one.pictures[1:]] == ["potential [J]", "holding effort [N m]"]
    lamp = load("balanced_lamp")
    assert equilibrium(lamp, starts=2).picture().title.startswith("Balanced lamp: in equilibrium everywhere")
    heavier = equilibrium(lamp.with_({"lamp": 0.7}), starts=4).picture()
    assert {word for word, _ in heavier.legend} <= {"stable", "unstable"}


def test_the_command_names_the_option_and_ends_with_five_without_convergence(tmp_path):
    model = double_pendulum(loads={"t": {"on": "two", "torque": 30.0}})
    (tmp_path / "lost.yaml").write_text(yaml.safe_dump(model).replace("true:", "'on':"))
    done = gim("equilibrium", tmp_path / "lost.yaml", "--starts", 2)
    assert done.code == 5
    assert "2 did not converge" in done.text
    for one in model["actuators"].values():
        del one["free"]
    (tmp_path / "held.yaml").write_text(yaml.safe_dump(model).replace("true:", "'on':"))
    done = gim("equilibrium", tmp_path / "held.yaml")
    assert done.code == 2
    assert done.error.startswith("--free: held has 2 inputs and none is free")


def test_an_npz_file_has_the_curve(tmp_path):
    found = equilibrium(load("snap_hinge"))
    found.save(tmp_path / "hinge.npz")
    with np.load(tmp_path / "hinge.npz") as file:
        assert file["curve.potential"].max() == pytest.approx(found.equilibria[-1]["potential"], rel=1e-3)


# -- errors -----------------------------------------------------------------------------------------


def test_an_iteration_that_does_not_converge_is_listed_and_leaves_the_answer_open():
    found = equilibrium(load(bar()))
    lost = replace(found._found.found[0], status=Status.NOT_CONVERGED)
    found._found = replace(found._found, found=(lost, *found._found.found[1:]))
    assert not found.answered
    assert found.table()["status"].tolist() == ["not-converged", "ok"]


def test_all_starts_without_convergence_leave_the_answer_open():
    """A constant torque greater than any torque of the weight: no equilibrium."""
    found = equilibrium(load(double_pendulum(loads={"t": {"on": "two", "torque": 30.0}})), starts=4)
    assert found.count == 0
    assert found.report()["failed"] == 4
    assert not found.answered


def test_without_equilibria_quantities_have_no_rows():
    found = equilibrium("engine", measure=["|A.f|", "rod.angle"])
    assert found.count == 0
    assert [found[name].shape for name in ("|A.f|", "rod.angle", "crank.angle", "A.f")] == [(0,), (0,), (0,), (0, 2)]
    assert {"|A.f|", "rod.angle"} <= set(found)
    with pytest.raises(KeyError, match="did you mean 'piston"):
        found["piston"]
