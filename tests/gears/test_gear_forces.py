"""Forces of coupled inputs and gears: closed forms, body coordinates with all multipliers, balances."""

import numpy as np
import pytest
from geared_bodies import GearedBodies, ToothedPair
from geared_models import bodies, five_bar, state, train

import gimcli

TAN = np.tan(np.radians(20.0))


def complexes(found, *names):
    return [found[f"{n}.fx"] + 1j * found[f"{n}.fy"] for n in names]


@pytest.mark.parametrize(("ratio", "internal"), [(0.5, False), (1.0, False), (2.0, False), (0.5, True), (2.0, True)])
def test_a_geared_five_bar_against_body_coordinates(ratio, internal):
    m = gimcli.load(five_bar(type="internal" if internal else "external", ratio=ratio))
    found, t = gimcli.forces(m, steps=12), gimcli.trace(m, steps=12)
    other = bodies(ratio, internal)
    o, q, a, b, p = complexes(found, "O", "Q", "A", "B", "P")
    for row in range(13):
        pins, (tooth,), torque = other.forces(*state(other, t, row, 2.0 * np.pi), 1)
        assert np.allclose([x[row] for x in (o, q, a, b, p)], pins, rtol=1e-9, atol=1e-7)
        assert np.isclose(found["motor.effort"][row], torque, rtol=1e-9)
        assert np.isclose(found["mesh.tangential"][row], tooth * np.cos(np.radians(20.0)), rtol=1e-9, atol=1e-8)
        assert np.isclose(abs(complexes(found, "mesh")[0][row]), abs(tooth), rtol=1e-9, atol=1e-8)
    assert np.max(abs(found["power.error"])) < 1e-9 * np.max(abs(found["power.drive"]))


@pytest.mark.parametrize(
    "gear",
    [
        {"ratio": 0.5}, {"ratio": 1, "pressure_angle": 0}, {"ratio": 0.5, "type": "internal"},
        {"ratio": 2, "type": "internal"}, {"ratio": 0.5, "type": "belt"}, {"radii": [0.5, 1.3], "type": "belt"},
        {"radii": [1, 1], "type": "belt"}, {"radii": [0.5, 1.3], "type": "crossed"}, {"ratio": 1, "type": "crossed"},
    ],
)  # fmt: skip
def test_balance_of_the_frame_and_of_power(gear):
    found = gimcli.forces(gimcli.load(five_bar(**gear)), steps=36)
    o, q, frame = complexes(found, "O", "Q", "shaking")
    moment = -(3.0 * q.imag) - found["motor.effort"]
    if "mesh.torque" in found.table().names:  # the couple that the carrier bears
        ratio = -gear["ratio"] if gear["type"] == "crossed" else gear["ratio"]
        moment = moment - (1.0 - ratio) * found["mesh.torque"]
    assert np.allclose(-o - q, frame, atol=1e-9 * np.max(abs(frame)))
    assert np.allclose(moment, found["shaking.moment"], atol=1e-9 * np.max(abs(moment)))
    assert np.max(abs(found["power.error"])) < 1e-9 * np.max(abs(found["power.drive"]))


@pytest.mark.parametrize("coupled", ["external", "belt", "follows"])
def test_dry_friction_beside_gears_closes_the_balance_of_power(coupled):
    data = five_bar(type=coupled, ratio=0.5)
    if coupled == "follows":
        del data["gears"]
        data["actuators"]["second"] = {"pivot": "Q", "arm": "B", "follows": "motor", "ratio": 0.5, "phase": 60}
    smooth = gimcli.forces(gimcli.load(data), steps=12)
    data["friction"] = {"A": {"mu": 0.2, "radius": 0.1}, "P": {"mu": 0.2, "radius": 0.1}}
    found = gimcli.forces(gimcli.load(data), steps=12)
    lost, more = found["friction.power.A"] + found["friction.power.P"], found["power.drive"] - smooth["power.drive"]
    good = np.isfinite(more)  # a pair may be at rest
    assert good.sum() > 9
    assert np.all(more[good] > 0.0)
    assert np.allclose(more[good], -lost[good], rtol=1e-9)
    assert np.allclose(found["motor.effort.least"][good], found["motor.effort"][good])


def test_the_driver_bears_what_its_follower_needs():
    data = five_bar()
    del data["gears"]
    second = {"pivot": "Q", "arm": "B"}
    data["actuators"]["second"] = {**second, "law": {"from": 60, "to": -660}}
    apart = gimcli.forces(gimcli.load(data), steps=36)
    data["actuators"]["second"] = {**second, "follows": "motor", "ratio": -2, "phase": 60}
    found = gimcli.forces(gimcli.load(data), steps=36)
    assert np.allclose(found["second.effort"], apart["second.effort"], rtol=1e-9, atol=1e-9)
    needed = apart["motor.effort"] - 2.0 * apart["second.effort"]
    assert np.allclose(found["motor.effort"], needed, rtol=1e-9, atol=1e-8)
    assert np.allclose(found["power.drive"], apart["power.drive"], rtol=1e-9, atol=1e-8)


def test_a_follower_that_slides_is_paid_in_work():
    data = {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [50, 0], "G": [200, 0], "H": [200, 100], "S": [200, 20]},
        "ground": ["O", "G", "H"],
        "links": {"crank": ["O", "A"]},
        "prismatic": {"guide": {"node": "S", "guide": ["G", "H"]}},
        "actuators": {
            "motor": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 90}},
            "lift": {"node": "S", "guide": ["G", "H"], "follows": "motor", "ratio": 0.4},
        },
        "loads": {"weight": {"on": "S", "force": [0, -120]}},
    }  # fmt: skip
    found = gimcli.forces(gimcli.load(data), steps=4)
    assert np.allclose(found["lift.effort"], 120.0)
    assert np.allclose(found["motor.effort"], 120.0 * 0.4e-3 * 180.0 / np.pi)  # 0.4 mm per deg


def test_a_follower_at_ratio_one_is_a_rigid_coupling():
    data = five_bar(law={"from": 0, "to": 300, "profile": "quintic"})
    del data["gears"]
    data["nodes"]["Q"], data["ground"] = [0, 0], ["O"]
    data["nodes"] = {"O": [0, 0], "A": [1, 0], "B": [0.6, 1.0]}
    data["links"] = {"crank": ["O", "A"], "other": ["O", "B"]}
    data["masses"] = {"crank": {"mass": 3, "inertia": 0.4}, "other": {"mass": 4, "inertia": 0.7}}
    data["trace"] = ["A"]
    data["actuators"]["second"] = {"pivot": "O", "arm": "B", "follows": "motor"}
    coupled = gimcli.forces(gimcli.load(data), steps=24)
    rigid = {**data, "links": {}, "elements": {"both": {"nodes": ["O", "A", "B"]}}}
    rigid["actuators"] = {"motor": data["actuators"]["motor"]}
    one, two = 0.5 + 0.0j, 0.3 + 0.5j
    centre = (3 * one + 4 * two) / 7.0
    inertia = 1.1 + 3 * abs(one - centre) ** 2 + 4 * abs(two - centre) ** 2
    rigid["masses"] = {"both": {"mass": 7, "inertia": inertia, "centre": [centre.real, centre.imag]}}
    whole = gimcli.forces(gimcli.load(rigid), steps=24)
    assert np.allclose(coupled["motor.effort"], whole["motor.effort"], rtol=1e-10, atol=1e-9)
    assert np.allclose(coupled["shaking.fx"], whole["shaking.fx"], atol=1e-9)


# --- closed forms ---------------------------------------------------------------------------------------


def test_tooth_force_of_spur_gears():
    found = gimcli.forces(gimcli.load(train(teeth=[20, 40])), steps=4)
    tangential = 3.0 / 0.06  # the pitch radii are 30 and 60 mm
    assert np.allclose(found["motor.effort"], 1.5)  # the second wheel turns against the motor, along its torque
    assert np.allclose(found["mesh.tangential"], -tangential)
    tooth, one, two = complexes(found, "mesh", "O", "Q")
    assert np.allclose(tooth, tangential * (TAN + 1j))  # at the pitch point, left of Q: away from the first wheel
    assert np.allclose(two, -tooth)
    assert np.allclose(one, tooth)


@pytest.mark.parametrize("teeth", [[20, 50], [50, 20]])
def test_tooth_force_in_a_ring(teeth):
    found = gimcli.forces(gimcli.load(train(teeth=teeth, type="internal")), steps=4)
    radius = 90.0 * teeth[1] / 30.0
    tangential = -3000.0 / radius
    side = 1.0 if teeth[0] > teeth[1] else -1.0  # of the pitch point, from Q
    assert np.allclose(found["mesh.tangential"], tangential)
    assert np.allclose(complexes(found, "mesh")[0], 1j * side * tangential - abs(tangential) * TAN)
    assert np.allclose(found["motor.effort"], -3.0 * teeth[0] / teeth[1])


@pytest.mark.parametrize("torque", [3.0, -3.0])
@pytest.mark.parametrize(("kind", "radii"), [("belt", [20, 50]), ("belt", [50, 20]), ("crossed", [20, 50])])
def test_a_belt_pulls_along_its_tight_strand(kind, radii, torque):
    data = train(type=kind, radii=radii)
    data["loads"]["brake"]["torque"] = torque
    found = gimcli.forces(gimcli.load(data), steps=4)
    assert np.allclose(found["mesh.tension"], -torque / (radii[1] * 1e-3))
    (pull,) = complexes(found, "mesh")
    assert np.allclose(abs(pull), abs(found["mesh.tension"]))
    strands = tangents(radii, kind == "crossed")
    (along,) = [line for normal, line in strands if (np.conj(normal) * line).imag * torque < 0.0]  # resists the torque
    assert np.allclose(pull / abs(pull), along)
    assert np.allclose(complexes(found, "Q")[0], -pull)
    assert np.allclose(complexes(found, "O")[0], pull)
    sense = -1.0 if kind == "crossed" else 1.0
    assert np.allclose(found["motor.effort"], -torque * sense * radii[0] / radii[1])


def tangents(radii, crossed):
    """Return for both strands the normal at the second wheel and the direction from there to the first wheel."""
    found, sense = [], -1.0 if crossed else 1.0
    for side in (1.0, -1.0):
        normal = -np.exp(1j * side * np.arccos((radii[1] - sense * radii[0]) / 90.0))
        line = sense * radii[0] * normal - (90.0 + radii[1] * normal)  # between the points of contact
        assert abs((line * np.conj(normal)).real) < 1e-12 * 90.0
        found.append((normal, line / abs(line)))
    return found


def test_a_belt_without_radii_transmits_couples():
    data = train(type="belt", ratio=0.5)
    found = gimcli.forces(gimcli.load(data), steps=4)
    assert np.allclose(found["mesh.torque"], -3.0)
    assert np.allclose(found["motor.effort"], -1.5)
    assert np.allclose(complexes(found, "O", "Q"), 0.0, atol=1e-12)
    assert np.allclose(found["shaking.moment"], 3.0)


@pytest.mark.parametrize("height", [-20.0, 20.0])
@pytest.mark.parametrize("guided", ["carrier", "rack"])
def test_a_rack_lifts_a_weight(height, guided):
    frame, rack = ["G", "H"], ["U", "V"]
    pair = {"nodes": rack, "guide": frame} if guided == "carrier" else {"nodes": frame, "guide": rack}
    data = {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {
            "O": [0, 0], "A": [20, 0], "G": [height, -100], "H": [height, 100], "U": [height, 0], "V": [height, 30],
        },
        "ground": ["O", "G", "H"], "links": {"pinion": ["O", "A"], "bar": rack},
        "prismatic": {"slide": pair},
        "actuators": {"motor": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 90}}},
        "gears": {"mesh": {"type": "rack", "members": ["pinion", "bar"], "pivots": ["O"], "radii": [20]}},
        "masses": {"bar": {"mass": 5, "inertia": 0.01, "centre": [0, 0]}}, "gravity": [0, -9.81], "trace": ["U"],
    }  # fmt: skip
    found = gimcli.forces(gimcli.load(data), steps=4)
    side = np.sign(height)
    assert np.allclose(found["motor.effort"], 5.0 * 9.81 * 0.02 * side)  # the rack rises on the right side
    (tooth,) = complexes(found, "mesh")
    assert np.allclose(tooth, 5.0 * 9.81 * (1j + side * TAN))
    assert np.allclose(complexes(found, "O")[0], tooth)
    normal = found["slide.normal"] * (-1.0 if guided == "carrier" else 1.0)  # to the left of the guide
    assert np.allclose(normal, -5.0 * 9.81 * side * TAN)
    assert np.max(abs(found["power.error"])) < 1e-12


def planetary(planets=1, **more):
    names = [f"p{k}" for k in range(planets)]
    at = [35.0 * np.exp(2j * np.pi * k / planets) for k in range(planets)]
    nodes = {"O": [0, 0], "S": [20, 0]}
    for n, z in zip(names, at, strict=True):
        nodes |= {f"P{n}": [z.real, z.imag], f"T{n}": [z.real, z.imag + 12]}
    mesh = {"carrier": "arm", "type": "external", "teeth": [40, 30]}
    ring = {**mesh, "type": "internal", "teeth": [100, 30]}
    gears = {}
    for n in names:
        gears |= {f"in_{n}": {**mesh, "members": ["sun", n], "pivots": ["O", f"P{n}"]}}
        gears |= {f"out_{n}": {**ring, "members": ["ground", n], "pivots": ["O", f"P{n}"]}}
    arm = {"arm": ["O", *(f"P{n}" for n in names)]}
    return {
        "units": {"length": "mm", "angle": "deg"}, "nodes": nodes, "ground": ["O"],
        "links": {"sun": ["O", "S"], **{n: [f"P{n}", f"T{n}"] for n in names}, **(arm if planets == 1 else {})},
        "elements": arm if planets > 1 else {},
        "actuators": {"motor": {"pivot": "O", "arm": "S", "law": {"from": 0, "to": 360}}},
        "gears": gears, "loads": {"output": {"on": "arm", "torque": -7.0}}, "trace": ["S"], **more,
    }  # fmt: skip


def test_torques_of_a_planetary_train_follow_from_the_formula_of_willis():
    found = gimcli.forces(gimcli.load(planetary()), steps=12)
    sun = 7.0 / (1.0 + 100.0 / 40.0)
    assert np.allclose(found["motor.effort"], sun)
    assert np.allclose(abs(found["in_p0.tangential"]), sun / 0.02)
    assert np.allclose(abs(found["out_p0.tangential"]), sun / 0.02)
    assert np.allclose(abs(complexes(found, "Pp0")[0]), 2.0 * sun / 0.02)  # radial parts of the planet cancel
    assert np.allclose(found["shaking.moment"], -7.0)  # the motor and the ring are on the frame


def test_three_planets_share_a_torque_indeterminately():
    found = gimcli.forces(gimcli.load(planetary(3)), steps=6)
    assert np.allclose(found["motor.effort"], 2.0)
    assert np.all(np.isnan(found["in_p0.tangential"]))
    assert {"in_p0", "out_p1", "Pp2"} <= set(found.report()["open"])


def test_a_planetary_train_with_masses_against_body_coordinates():
    masses = {"sun": (2.0, 0.003), "p0": (1.0, 0.001), "arm": (1.5, 0.002)}
    own = {"masses": {n: {"mass": m, "inertia": j, "centre": [0, 0]} for n, (m, j) in masses.items()}}
    data = planetary(1, gravity=[0, -9.81], **own)
    data["actuators"]["motor"]["law"] = {"from": 0, "to": 720, "profile": "harmonic"}
    m = gimcli.load(data)
    found, t = gimcli.forces(m, steps=12), gimcli.trace(m, steps=12, derivatives=2)
    gears = [
        ToothedPair(1, 2, 3, 0j, 0.035 + 0j, (0.02, 0.015)),
        ToothedPair(0, 2, 3, 0j, 0.035 + 0j, (0.05, 0.015), True),
    ]
    pins = [(0, 0j, 1, 0j), (0, 0j, 3, 0j), (3, 0.035 + 0j, 2, 0j)]
    other = GearedBodies(list(masses.values()), pins, gears, torques={3: -7.0})
    for row in range(13):
        sun = np.radians(t["motor"][row])
        speed, gain = (t[f"S.{k}x"][row] + 1j * t[f"S.{k}y"][row] for k in "va")
        ray = np.exp(1j * sun)
        omega, alpha = (speed / ray).imag / 20.0, (gain / ray).imag / 20.0
        arm, planet = sun * 2.0 / 7.0, sun * 2.0 / 7.0 * (1.0 - 10.0 / 3.0)
        place = 0.035 * np.exp(1j * arm)
        q = np.array([0, 0, sun, place.real, place.imag, planet, 0, 0, arm])
        rates = []
        for turning, square in ((omega, 0.0), (alpha, omega)):
            along = place * (1j * turning * 2.0 / 7.0 - (square * 2.0 / 7.0) ** 2)
            arms = turning * 2.0 / 7.0
            rates.append([0, 0, turning, along.real, along.imag, arms * (1.0 - 10.0 / 3.0), 0, 0, arms])
        forces, teeth, torque = other.forces(q, np.array(rates[0]), np.array(rates[1]), 1)
        assert np.isclose(found["motor.effort"][row], torque, rtol=1e-9)
        cos = np.cos(np.radians(20.0))
        assert np.allclose([found[f"{n}.tangential"][row] for n in ("in_p0", "out_p0")], teeth * cos, rtol=1e-8)
        expected = [complexes(found, n)[0][row] for n in ("O.sun", "O.arm", "Pp0")]
        assert np.allclose(expected[:2], forces[:2], rtol=1e-8, atol=1e-8)
        assert np.isclose(abs(expected[2]), abs(forces[2]), rtol=1e-8)
