"""Gears that the linkage turns: sun and planet, racks of slider-cranks, sectors of rockers, gears inside a loop."""

import numpy as np
import pytest
from coupled_models import rack, sun_and_planet

import gimcli


def turned(origin, length, angle):
    return np.asarray(origin) @ [1, 1j] + length * np.exp(1j * angle)


def complex_of(t, name):
    return t.xy[name] @ [1, 1j]


@pytest.mark.few(2)
@pytest.mark.parametrize("steps", [6, 72])
@pytest.mark.parametrize(
    "gear", [{}, {"members": ("sun", "rod"), "pivots": ("O", "A")}], ids=["rod first", "sun first"]
)
def test_sun_and_planet(steps, gear):
    t = gimcli.trace(gimcli.load(sun_and_planet(**gear)), steps=steps, derivatives=1)
    crank = np.radians(t["motor"])
    rod = np.angle(complex_of(t, "B") - 100.0 * np.exp(1j * crank)) - np.pi / 2.0  # below half a turn
    sun = 2.0 * crank - rod  # Willis: sun - crank = -(rod - crank)
    assert set(t.status) == {"ok"}
    assert np.max(abs(complex_of(t, "S") - 40.0 * np.exp(1j * sun))) < 1e-10
    assert np.allclose(t["sun.omega"], 2.0 * t["crank.omega"] - t["rod.omega"], atol=1e-8)


def slider(turn):
    return 30.0 * np.cos(turn) + np.sqrt(100.0**2 - (30.0 * np.sin(turn)) ** 2)


@pytest.mark.few(2)
@pytest.mark.parametrize("steps", [16, 90])
@pytest.mark.parametrize("radius", [20.0, 3.0])
def test_a_pinion_on_the_rack_of_a_slider_crank(steps, radius):
    """With the small radius the pinion makes several turns between two of 16 rows."""
    t = gimcli.trace(gimcli.load(rack(radius)), steps=steps, derivatives=3)
    turn, w, h = np.radians(t["motor"]), 4.0 * np.pi, 1e-3
    angle = (slider(turn) - 130.0) / radius  # the rack below moves the pinion counter-clockwise
    assert np.max(abs(complex_of(t, "T") - turned([150, radius], radius, angle + np.pi / 2.0))) < 1e-9
    assert np.allclose(t["mesh"] - t["mesh"][0], np.degrees(angle), atol=1e-9)
    values = [slider(turn + k * h) / radius for k in (-2, -1, 0, 1, 2)]
    first = (values[0] - 8.0 * values[1] + 8.0 * values[3] - values[4]) / (12.0 * h) * w
    second = (-values[0] + 16 * values[1] - 30 * values[2] + 16 * values[3] - values[4]) / (12.0 * h**2) * w**2
    assert np.allclose(np.radians(t["pinion.omega"]), first, rtol=1e-7, atol=1e-7 * abs(first).max())
    assert np.allclose(np.radians(t["pinion.alpha"]), second, rtol=1e-7, atol=1e-6 * abs(second).max())


def rocker(law, ground=3.0, **links):
    lengths = {"in": 1.0, "coupler": 2.5, "out": 2.0, **links}
    return {
        "units": {"length": "m", "angle": "rad"},
        "nodes": {
            "O": [0, 0], "Q": [ground, 0], "A": [1, 0], "B": [2.4, 1.9], "S": [ground + 2, 0], "T": [ground + 3, 0],
        },
        "ground": ["O", "Q", "S"],
        "links": {
            "in": {"nodes": ["O", "A"], "length": lengths["in"]},
            "coupler": {"nodes": ["A", "B"], "length": lengths["coupler"]},
            "out": {"nodes": ["Q", "B"], "length": lengths["out"]},
            "gear": {"nodes": ["S", "T"], "length": 1.0},
        },
        "actuators": {"motor": {"pivot": "O", "arm": "A", "law": law}},
        "gears": {"mesh": {"members": ["out", "gear"], "pivots": ["Q", "S"], "ratio": 3}},
        "trace": ["T", "B"],
    }  # fmt: skip


def rocker_angle(turn, a=1.0, b=2.5, c=2.0, d=3.0):
    """Return the angle of the rocker of a crank-rocker, its pin to the left of the line from crank pin to pivot."""
    line = d - a * np.exp(1j * turn)
    apart = abs(line)
    along = (apart**2 + c**2 - b**2) / (2.0 * apart * c)
    return np.angle(-line) - np.arccos(along)


def test_a_sector_gear_on_a_rocker():
    t = gimcli.trace(gimcli.load(rocker({"from": 0.0, "to": 2.0 * np.pi})), steps=40)
    angle = np.unwrap(rocker_angle(t["motor"]))
    assert np.max(abs(complex_of(t, "B") - (3.0 + 2.0 * np.exp(1j * angle)))) < 1e-12
    drawn = np.angle(complex(2.4 - 3.0, 1.9))
    assert np.max(abs(complex_of(t, "T") - (5.0 + np.exp(-3j * (angle - drawn))))) < 1e-11


def test_a_second_gear_turns_with_the_first():
    data = rocker({"from": 0.0, "to": 2.0 * np.pi})
    data["nodes"] |= {"U": [6.0, 0.0], "V": [6.0, 0.5]}
    data["ground"].append("U")
    data["links"]["second"] = ["U", "V"]
    data["gears"]["other"] = {"members": ["gear", "second"], "pivots": ["S", "U"], "teeth": [30, 20]}
    data["trace"] = ["V"]
    t = gimcli.trace(gimcli.load(data), steps=40)
    drawn = np.angle(complex(2.4 - 3.0, 1.9))
    angle = np.unwrap(rocker_angle(t["motor"]))
    angle += 2.0 * np.pi * np.round((drawn - angle[0]) / (2.0 * np.pi))
    second = 1.5 * 3.0 * (angle - drawn)
    assert np.max(abs(complex_of(t, "V") - (6.0 + 0.5j * np.exp(1j * second)))) < 1e-11


def double_rocker(law, geared=True):
    """Return a linkage whose coupler and rocker are in line at a motor angle of +-1.4227, with or without the gear."""
    data = rocker(law, ground=4.0, **{"in": 2.0, "coupler": 2.2})
    data["nodes"] |= {"A": [1.08, 1.68], "B": [3.2, 1.83]}
    if geared:
        return data
    links = {name: link for name, link in data["links"].items() if name != "gear"}
    return {**data, "gears": {}, "links": links, "trace": ["B"]}


LIMIT = np.arccos((20.0 - 4.2**2) / 16.0)
RISE_AND_FALL = "0, 1.0\n1, 1.6\n2, 0.8\n"


@pytest.mark.parametrize(
    ("at_limit", "law"),
    [("stop", {"from": 1.0, "to": 3.0}), ("skip", {"profile": {"table": "law.csv"}}),
     ("reverse", {"from": 1.0, "to": -7.0}), ("reverse", {"profile": {"table": "law.csv"}})],
)  # fmt: skip
def test_a_limit_of_the_linkage_is_the_limit_of_its_gears(tmp_path, at_limit, law):
    """The rows and the limits are those of the linkage without the gear, which turns three times as far, backwards."""
    (tmp_path / "law.csv").write_text(RISE_AND_FALL)
    models = (gimcli.load(double_rocker(law, geared), tmp_path) for geared in (True, False))
    geared, free = (gimcli.trace(m, steps=40, at_limit=at_limit) for m in models)
    assert list(geared.status) == list(free.status)
    solved = np.array(free.status) == "ok"
    assert solved.all() == (at_limit == "reverse")
    assert np.max(abs(geared["motor"] - free["motor"])) < 1e-14
    assert np.max(abs(complex_of(geared, "B") - complex_of(free, "B"))[solved]) < 1e-11
    angle = np.unwrap(np.angle(complex_of(free, "B")[solved] - 4.0))
    gear = 6.0 + np.exp(-3j * (angle - np.angle(complex(3.2 - 4.0, 1.83))))
    assert np.max(abs(complex_of(geared, "T")[solved] - gear)) < 1e-10
    stops = [[event["at"]["motor"] for event in t.events if event["kind"] == "limit"] for t in (geared, free)]
    assert len(stops[0]) == len(stops[1]) > 0
    assert np.allclose(np.abs(stops), LIMIT, atol=1e-9)


def driven_apex():
    """Return the geared five-bar whose apex traces a straight line, driven at the apex."""
    return {
        "units": {"length": "m", "angle": "rad"},
        "nodes": {"O": [0, 0], "Q": [3, 0], "A": [1, 0], "B": [2, 0], "P": [1.5, np.sqrt(8.75)],
                  "G": [1.5, 0], "H": [1.5, 5]},
        "ground": ["O", "Q", "G", "H"],
        "links": {"crank": ["O", "A"], "other": ["Q", "B"],
                  "b1": {"nodes": ["A", "P"], "length": 3}, "b2": {"nodes": ["B", "P"], "length": 3}},
        "actuators": {"cylinder": {"node": "P", "guide": ["G", "H"], "law": {"from": 2.9, "to": 3.6}}},
        "gears": {"mesh": {"members": ["crank", "other"], "pivots": ["O", "Q"], "ratio": 1}},
        "trace": ["A", "B", "P"],
    }  # fmt: skip


def test_a_gear_inside_a_loop():
    """Its cranks turn alike."""
    t = gimcli.trace(gimcli.load(driven_apex()), steps=20, derivatives=1)
    crank = np.angle(complex_of(t, "A"))
    assert set(t.status) == {"ok"}
    height = np.sin(crank) + np.sqrt(9.0 - (1.5 - np.cos(crank)) ** 2)
    assert np.max(abs(height - t["cylinder"])) < 1e-12
    assert np.max(abs(complex_of(t, "B") - (3.0 - np.exp(-1j * crank)))) < 1e-12
    assert np.allclose(t["other.omega"], -t["crank.omega"], atol=1e-9)


def test_one_position():
    p = gimcli.solve(gimcli.load(rack()), motor=400.0)
    angle = (slider(np.radians(400.0)) - 130.0) / 20.0
    assert abs(p.xy["T"] @ [1, 1j] - turned([150, 20], 20.0, angle + np.pi / 2.0)) < 1e-10


def test_another_radius_of_the_pinion():
    m = gimcli.load(rack()).with_({"crank": 25.0})
    t = gimcli.trace(m, steps=12)
    turn = np.radians(t["motor"])
    x = 25.0 * np.cos(turn) + np.sqrt(100.0**2 - (25.0 * np.sin(turn)) ** 2)
    assert np.allclose(np.diff(np.radians(t["mesh"])), np.diff(x) / 20.0, atol=1e-10)
