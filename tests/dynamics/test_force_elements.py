"""Springs, dampers, friction and loads of every kind, each compared with a closed form."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from bundled import MODELS, written
from heavy_models import motion_forces, moved, on, total_on_frame, weighted
from in_process import gim
from table_graphs import graph_of
from typer.testing import CliRunner

import gimcli
from gimcli.cli import app
from gimcli.dynamics.force_columns import columns_of, reactions
from gimcli.dynamics.force_motion import ForceMotion
from gimcli.motion.motion import stream, trace
from gimcli.output.panels import panel
from gimcli.structure.steps import NONE
from gimcli.table import Column, Table

CRANK = """\
units: {length: mm}
nodes: {O: [0, 0], A: [300, 0], G: [500, 400]}
ground: [O, G]
links: {crank: [O, A]}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {from: 10, to: 370}}}
duration: 2
"""
TURN = math.pi  # rad/s: a turn in 2 s


def crank(folder, text, steps=16):
    """Return angles, motor torque and forces of a crank of 0.3 m with the sections of `text`."""
    motion = trace(written(folder, CRANK + text), steps)
    forces = motion_forces(motion)
    assert np.all(forces.good)
    assert np.max(np.abs(forces.power_error)) < 1e-12 * max(1.0, np.max(np.abs(forces.drive_power)))
    return motion.inputs[0], forces.effort(0), forces


def test_a_weight_and_its_moment_of_inertia(tmp_path):
    text = "masses: {crank: {mass: 2, inertia: 0.05, centre: [200, 0]}}\ngravity: [0, -9.81]\n"
    angle, torque, found = crank(tmp_path, text)
    assert torque == pytest.approx(2 * 9.81 * 0.2 * np.cos(angle), abs=1e-13)
    push = on(found, "O", "crank")  # weight and centripetal force
    assert np.max(np.abs(push - 2 * 9.81j + 2 * 0.2 * TURN**2 * np.exp(1j * angle))) < 1e-13
    assert found.loads.kinetic == pytest.approx(0.5 * (0.05 + 2 * 0.04) * TURN**2)


def test_the_torque_of_an_accelerated_mass(tmp_path):
    """Quintic law: theta'' = 360 deg (60 t - 180 t^2 + 120 t^3) / T^2."""
    text = CRANK.replace("to: 370}", "to: 370, profile: quintic}") + "masses: {crank: {mass: 2, inertia: 0.05}}\n"
    forces = motion_forces(trace(written(tmp_path, text), 16))
    t = np.linspace(0, 1, 17)
    gain = 2 * math.pi * (60 * t - 180 * t**2 + 120 * t**3) / 4
    assert forces.effort(0) == pytest.approx((0.05 + 2 * 0.15**2) * gain, abs=1e-13)


def test_a_spring_between_two_nodes(tmp_path):
    angle, torque, found = crank(tmp_path, "springs: {s: {nodes: [G, A], stiffness: 200, free: 100}}\n")
    arm = 0.3 * np.exp(1j * angle)
    away = 0.5 + 0.4j - arm
    pull = 200 * (np.abs(away) - 0.1) * away / np.abs(away)
    assert torque == pytest.approx(-(arm.conj() * pull).imag, abs=1e-12)
    assert np.max(np.abs(on(found, "O", "crank") + pull)) < 1e-12
    assert found.loads.potential == pytest.approx(100 * (np.abs(away) - 0.1) ** 2)


def test_the_free_length_of_a_spring_is_its_initial_length_unless_given(tmp_path):
    text = CRANK.replace("from: 10, to: 370", "from: 0, to: 90") + "springs: {s: {nodes: [G, A], stiffness: 200}}\n"
    forces = motion_forces(trace(written(tmp_path, text), 4))
    assert forces.effort(0)[0] == pytest.approx(0.0, abs=1e-12)
    assert abs(forces.effort(0)[1]) > 1.0


def test_the_torque_of_a_torsion_spring_grows_over_whole_turns(tmp_path):
    """3 N m/rad, free at 30 deg: over three turns the torque grows with the angle, also from piece to piece."""
    text = CRANK.replace("to: 370", "to: 1090") + "springs: {s: {pivot: O, arm: A, stiffness: 3, free: 30}}\n"
    mechanism = written(tmp_path, text)
    motion = trace(mechanism, 90)
    assert motion_forces(motion).effort(0) == pytest.approx(3 * (motion.inputs[0] - math.radians(30)), abs=1e-12)
    whole = ForceMotion(mechanism, 91)
    torques = [whole.take(piece).effort(0) for piece in stream(mechanism, 90, rows=20)]
    assert np.concatenate(torques) == pytest.approx(3 * (motion.inputs[0] - math.radians(30)), abs=1e-12)


def test_a_damper_between_two_nodes_and_one_about_a_pivot(tmp_path):
    text = "dampers: {d: {nodes: [A, G], damping: 7}, e: {pivot: O, arm: A, damping: 0.4}}\n"
    angle, torque, found = crank(tmp_path, text)
    arm = 0.3 * np.exp(1j * angle)
    away = 0.5 + 0.4j - arm
    speed = -1j * TURN * arm
    rate = (away.conj() * speed).real / np.abs(away)
    assert torque == pytest.approx(7 * rate**2 / TURN + 0.4 * TURN, abs=1e-12)
    assert found.loads.power["damping"] == pytest.approx(-7 * rate**2 - 0.4 * TURN**2)


def test_friction_in_a_pivot(tmp_path):
    _, torque, _ = crank(tmp_path, "friction: {O: 0.25}\n")
    assert torque == pytest.approx(0.25 * TURN)


LOADS = {
    "force in the frame": ("force: [30, -50]", lambda a, t: 30 - 50j),
    "force that follows": ("follower: [30, -50]", lambda a, t: (30 - 50j) * np.exp(1j * a)),
    "force over time": ("force: [30, -50], table: time.csv", lambda a, t: (30 - 50j) * t),
    "force over the input": ("follower: [30, -50], table: input.csv, over: motor", lambda a, t: (
        (30 - 50j) * np.exp(1j * a) * np.clip(a - math.pi, 0.0, math.pi) / math.pi)),
}  # fmt: skip


@pytest.mark.parametrize("case", LOADS)
def test_forces_on_a_member(case, tmp_path):
    (tmp_path / "time.csv").write_text("t,f\n0,0\n1,1\n2,2\n")
    (tmp_path / "input.csv").write_text("angle,f\n180,0\n270,0.5\n360,1\n")
    text, force = LOADS[case]
    angle, torque, found = crank(tmp_path, f"loads: {{f: {{on: crank, local: [150, 60], {text}}}}}\n")
    place = (0.15 + 0.06j) * np.exp(1j * angle)
    expected = force(angle, np.linspace(0, 2, len(angle)))
    assert torque == pytest.approx(-(place.conj() * expected).imag, abs=1e-11)
    assert np.max(np.abs(on(found, "O", "crank") + expected)) < 1e-12
    assert np.max(np.abs(found.shaking_force - expected)) < 1e-12


def test_at_and_local_give_the_same_point(tmp_path):
    one = crank(tmp_path, "loads: {f: {on: crank, local: [150, 60], force: [30, -50]}}\n")[1]
    two = crank(tmp_path, "loads: {f: {on: crank, at: [150, 60], force: [30, -50]}}\n")[1]
    assert one == pytest.approx(two, abs=1e-13)


def test_a_torque_over_the_input(tmp_path):
    (tmp_path / "input.csv").write_text("0,2\n400,2\n")
    _, torque, _ = crank(tmp_path, "loads: {f: {on: crank, torque: 5, table: input.csv, over: motor}}\n")
    assert torque == pytest.approx(-10.0)


def test_a_load_on_the_frame_has_no_effect(tmp_path):
    text = "loads: {f: {on: ground, at: [1, 1], force: [30, -50]}}\nfriction: {O: 1}\n"
    _, torque, found = crank(tmp_path, text)
    assert torque == pytest.approx(TURN)
    assert np.max(np.abs(on(found, "O", "crank"))) < 1e-12


SLIDER = """\
nodes: {O: [0, 0], A: [1, 0], B: [3, 0], C: [3.5, 0], G: [9, 0]}
ground: [O, G]
links: {crank: [O, A], rod: [A, B]%s}
prismatic: {slide: {%s, guide: [O, G]}}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {from: 20, to: 380}}}
"""
FORMS = {"pin in a slot": ("", "node: B"), "prismatic pair": (", slider: [B, C]", "nodes: [B, C]")}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("element", [
    "friction: {slide: 12}", "dampers: {d: {node: B, guide: [O, G], damping: 12}}",
])  # fmt: skip
def test_friction_and_damping_along_a_guide(form, element, tmp_path):
    """The motor's power is 12 v^2, v being the slider's speed; the reaction of the guide is normal to it."""
    motion = trace(written(tmp_path, SLIDER % FORMS[form] + element + "\n"), 24)
    found = motion_forces(motion)
    a, w = motion.inputs[0], 2 * math.pi
    root = np.sqrt(4 - np.sin(a) ** 2)
    v = -w * np.sin(a) - w * np.sin(a) * np.cos(a) / root
    assert found.effort(0) == pytest.approx(12 * v**2 / w, abs=1e-10)
    rod = (root + 1j * (-np.sin(a))) / 2  # unit vector from A to B: the massless rod pushes along itself
    push = 12 * v / rod.real
    assert found.normal("slide") == pytest.approx(-push * rod.imag, abs=1e-9)


def test_a_spring_along_a_guide_with_a_free_travel(tmp_path):
    text = SLIDER % FORMS["pin in a slot"] + "springs: {s: {node: B, guide: [G, O], stiffness: 40, free: 5}}\n"
    motion = trace(written(tmp_path, text), 24)
    found = motion_forces(motion)
    a = motion.inputs[0]
    root = np.sqrt(4 - np.sin(a) ** 2)
    x = np.cos(a) + root
    slope = -np.sin(a) - np.sin(a) * np.cos(a) / root  # dx/da
    assert found.effort(0) == pytest.approx(-40 * (9 - x - 5) * slope, abs=1e-10)
    assert found.loads.potential == pytest.approx(20 * (4 - x) ** 2)


LEVER = """\
nodes: {G: [0, 0], H: [5, 0], O: [3, 0], A: [4, 0]}
ground: [G, O]
links: {crank: [O, A], lever: [G, H]}
prismatic: {slot: {node: A, guide: [G, H], offset: 0.3}}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {from: 20, to: 380}}}
"""


@pytest.mark.parametrize("element", ["friction: {slot: 12}", "dampers: {d: {node: A, guide: [G, H], damping: 12}}"])
def test_friction_in_a_slot_beside_the_levers_pivot(element, tmp_path):
    """s^2 = |GA|^2 - 0.3^2; a massless lever: s N = 0.3 f, the friction f being 12 s' against the pin."""
    motion = trace(written(tmp_path, LEVER + element + "\n"), 24)
    found = motion_forces(motion)
    a, w = motion.inputs[0], 2 * math.pi
    s = np.sqrt(10 + 6 * np.cos(a) - 0.09)
    rate = -3 * np.sin(a) * w / s
    assert found.effort(0) == pytest.approx(12 * rate**2 / w, abs=1e-10)
    assert found.normal("slot") == pytest.approx(-0.3 * 12 * rate / s, abs=1e-9)
    assert np.max(np.abs(found.shaking_force)) < 1e-9  # no external forces


@pytest.mark.parametrize("nodes", ["[G, A]", "[A, G]"])
def test_a_ram_on_a_pin_of_two_links(nodes, tmp_path):
    """The links are massless and loaded only at their ends, so their forces act along them."""
    text = f"""\
nodes: {{O: [0, 0], A: [1, 2], B: [4, 0], G: [3, -1], H: [9, 0]}}
ground: [O, G, H]
links: {{left: [O, A], right: [A, B]}}
prismatic: {{slide: {{node: B, guide: [O, H]}}}}
actuators: {{ram: {{type: linear, nodes: {nodes}, law: {{by: 0.3}}}}}}
loads: {{push: {{on: right, local: [{math.hypot(3, 2)}, 0], force: [-60, 0]}}}}
"""
    mechanism = written(tmp_path, text)
    motion = trace(mechanism, 4)
    found = motion_forces(motion)
    z = {name: motion.z[k] for k, name in enumerate(mechanism.nodes)}
    left, right = on(found, "A", "left"), on(found, "A", "right")
    for force, bar in ((left, z["A"] - z["O"]), (right, z["B"] - z["A"])):
        assert np.max(np.abs((bar.conj() * force).imag)) < 1e-10
        assert np.min(np.abs(force)) > 1.0
    ram = z["A"] - z["G"]
    assert np.max(np.abs(left + right - found.effort(0) * ram / np.abs(ram))) < 1e-10
    assert right.real == pytest.approx(60.0)


def test_a_moment_in_a_prismatic_pair(tmp_path):
    """The guide takes a torque on the slider, and a force beside the pin."""
    text = (
        SLIDER % FORMS["prismatic pair"]
        + "loads: {t: {on: slider, torque: 6}, f: {on: slider, local: [0.5, 2], force: [0, -8]}}\n"
    )
    found = motion_forces(trace(written(tmp_path, text), 8))
    assert found.effort(0) == pytest.approx(0.0, abs=1e-12)
    assert found.normal("slide") == pytest.approx(8.0)
    assert found.moment("slide") == pytest.approx(0.5 * 8 - 6)  # about B


BLOCK = """\
nodes: {O: [0, 0], A: [0, 1], B: [2, 0], C: [2.5, 0], D: [3, 2], E: [3, 0], G: [9, 0]}
ground: [O, E, G]
links: {%s, crank: [O, A], arm: [B, D]}
prismatic: {slide: {nodes: [B, C], guide: [O, G]}, hook: {node: D, guide: [E, G], offset: 2}}
actuators: {ram: {type: linear, node: B, guide: [O, G], law: {from: 2, to: 2.2}}}
"""


@pytest.mark.parametrize("links", ["slider: [B, C], rod: [A, B]", "rod: [A, B], slider: [B, C]"])
@pytest.mark.parametrize("element", ["", "springs: {s: {node: B, guide: [O, G], stiffness: 50, free: 1}}\n"])
def test_forces_of_guide_ram_and_spring_act_on_the_slider(element, links, tmp_path):
    """Three links at B, the slider named first or second: crank and rod are unloaded, the arm hangs on B and its hook.

    The pin forces of the three links add up to zero: guide, ram and spring act on the slider, not on the pin.
    """
    loads = "loads: {w: {on: arm, at: [2.5, 1], force: [7, -12]}}\n"
    found = motion_forces(trace(written(tmp_path, BLOCK % links + loads + element), 2))
    slider, rod, arm = (on(found, "B", name) for name in ("slider", "rod", "arm"))
    assert np.max(np.abs(slider + rod + arm)) < 1e-12
    assert np.max(np.abs(rod)) < 1e-12
    assert np.max(np.abs(arm - (found.normal("hook") * -1j + complex(-7, 12)))) < 1e-12
    assert found.effort(0) == pytest.approx(
        (50.0 * (found.course.inputs[0] * found.mechanism.scale - 1) if element else 0) - 7
    )
    assert found.normal("slide") == pytest.approx(-slider.imag)
    names = {column.name for column in columns_of(found, reactions(found.statics))}
    assert {"B.slider.fx", "B.rod.fx", "B.arm.fx"} <= names


def test_friction_on_a_pin_in_a_slot_acts_on_the_pin(tmp_path):
    """As a damper along the guide does: the forces of both links on the pin add up to what acts on it."""
    text = """\
nodes: {O: [0, 0], A: [0, 1], B: [2, 0], D: [3, 2], E: [3, 0], G: [9, 0]}
ground: [O, E, G]
links: {crank: [O, A], rod: [A, B], arm: [B, D]}
prismatic: {slide: {node: B, guide: [O, G]}, hook: {node: D, guide: [E, G], offset: 2}}
actuators: {motor: {pivot: O, arm: A, law: {by: 20}}}
"""
    elements = "friction: {slide: 12}\n", "dampers: {d: {node: B, guide: [O, G], damping: 12}}\n"
    one, two = (motion_forces(trace(written(tmp_path, text + element), 4)) for element in elements)
    for name in ("rod", "arm"):
        assert np.max(np.abs(on(one, "B", name) - on(two, "B", name))) < 1e-12
    assert np.min(np.abs(on(one, "B", "rod"))) > 1.0


def test_the_rate_of_the_potential_is_minus_the_power_of_gravity_and_springs():
    """The error of central differences falls by 4 when the step is halved."""

    def sprung(data):
        data["loads"] = {}
        data["springs"] = {
            "s": {"nodes": ["E", "O4"], "stiffness": 300.0, "free": 0.4},
            "t": {"pivot": "E", "arm": "C", "reference": "D", "stiffness": 5.0, "free": 40.0},
        }

    error = {}
    for steps in (200, 400):
        _, forces, _ = moved(weighted(MODELS / "watt_1.yaml", sprung), steps)
        power = forces.loads.power["gravity"] + forces.loads.power["spring"]
        step = forces.course.time[1] - forces.course.time[0]
        slope = (forces.loads.potential[2:] - forces.loads.potential[:-2]) / (2 * step)
        error[steps] = np.max(np.abs(slope + power[1:-1]))
    assert 3.5 < error[200] / error[400] < 4.5


@pytest.mark.few
def test_power_and_frame_forces_balance_with_every_element_on_every_model(model):
    """With springs, dampers and friction: power of all forces = dT/dt, and the force on the frame balances."""

    def sprung(data):
        nodes = list(data["nodes"])
        held = [
            set(v["nodes"] if isinstance(v, dict) else v)
            for s in ("links", "elements")
            for v in data.get(s, {}).values()
        ]
        ground = data["ground"]
        held.append(set(ground if isinstance(ground, list) else ground.get("nodes", [])))
        used = [n for n in nodes if any(n in h for h in held)]
        free = [(a, b) for k, a in enumerate(used) for b in used[:k] if not any({a, b} <= h for h in held)]
        a, b = free[len(free) // 2]
        data["springs"] = {"s": {"nodes": [a, b], "stiffness": 150.0}}
        data["dampers"] = {"d": {"nodes": list(free[0]), "damping": 20.0}}
        data["friction"] = {n: 0.3 for n in used if sum(n in h for h in held) > 1}
        data["friction"] |= dict.fromkeys(data.get("prismatic", {}), 4.0)

    _, forces, good = moved(weighted(model, sprung), 24)
    powers = [forces.drive_power, forces.loads.kinetic_rate, *forces.loads.power.values()]
    assert np.max(np.abs(forces.loads.power["spring"])[good]) > 0.0
    assert np.min(forces.loads.power["damping"][good]) < 0.0
    assert np.max(forces.loads.power["damping"][good]) <= 0.0
    assert np.max(np.abs(forces.power_error[good])) < 1e-9 * max(np.max(np.abs(p[good])) for p in powers)
    if not forces.mechanism.slides:  # friction on a guide of the frame does not act on a pin
        force, _ = total_on_frame(forces)
        for node, push in forces.loads.pins.items():
            if forces.statics.body_of_pin[node] == NONE:
                force = force + push
        assert np.max(np.abs(force - forces.shaking_force)[good]) < 1e-10 * np.nanmax(np.abs(forces.unknowns[:, good]))


def test_the_forces_at_a_pin_balance(tmp_path):
    """Three members and a spring at one pin: the pin forces on the members add up to the spring force."""

    def sprung(data):
        data["springs"] = {"s": {"nodes": ["J1", "G"], "stiffness": 9000.0, "free": 1.0}}

    mechanism = weighted(MODELS / "jansen.yaml", sprung)
    _, forces, good = moved(mechanism, 12)
    pin = next(p for p in forces.statics.pins if mechanism.nodes[p.node] == "J1")
    assert len(pin.members) == 3
    assert pin.loaded
    total = np.sum([forces.pin(pin, member) for member in pin.members], axis=0)
    assert np.max(np.abs(total - forces.loads.pins[pin.node])[good]) < 1e-10 * np.max(np.abs(total[good]))


def test_pieces_give_the_same_results_as_the_whole_motion():
    mechanism = weighted(MODELS / "watt_1.yaml")
    whole, pieces = ForceMotion(mechanism, 61), ForceMotion(mechanism, 61)
    whole.take(trace(mechanism, 60))
    for piece in stream(mechanism, 60, rows=13):
        pieces.take(piece)
    assert pieces.determined == whole.determined == 61
    assert pieces.power == pytest.approx(whole.power)


def test_the_command_writes_columns_picture_and_report(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["forces", str(MODELS / "watt_1.yaml"), "--steps", "36", "--json"])
    assert result.exit_code == 0
    report = json.loads(result.stdout)
    assert (report["csv"], report["png"]) == ("watt_1.forces.csv", "watt_1.forces.png")
    assert (report["steps"], report["solved"], report["status"], report["open"]) == (36, 37, "ok", [])
    assert report["energy_drift"] < 1e-12
    lines = (tmp_path / "watt_1.forces.csv").read_text().splitlines()
    assert len(lines) == 38
    head = lines[0].split(",")
    assert head[:8] == ["step", "time", "motor", "motor.effort", "O2.fx", "O2.fy", "O4.fx", "O4.fy"]
    assert head[-1] == "status"
    assert (tmp_path / "watt_1.forces.png").read_bytes().startswith(b"\x89PNG")
    efforts = [float(line.split(",")[3]) for line in lines[1:]]
    assert max(efforts, key=abs) == pytest.approx(report["peaks"]["motor.effort"]["value"], rel=0.05)
    assert abs(report["peaks"]["motor.effort"]["value"]) >= max(map(abs, efforts))


def test_the_command_names_indeterminate_reactions(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = (MODELS / "parallelogram_third_crank.yaml").read_text() + "\nmasses: {bar: {mass: 1}}\n"
    if "unit" in text.split("nodes:")[0]:
        text = text.replace("length: unit", "length: m")
    (tmp_path / "model.yaml").write_text(text)
    result = CliRunner().invoke(app, ["forces", "--steps", "7", "--json"])
    report = json.loads(result.stdout)
    assert set(report["open"]) == set("ABCDEF")
    assert report["peaks"]["C.unique"]["value"] < 1e-12  # a massless crank that is not driven has no transverse force
    assert "motor.effort" in report["peaks"]
    assert not set(report["open"]) & set(report["peaks"])


@pytest.mark.parametrize(("change", "words"), [
    (lambda text: text, "no masses, loads or springs defined"),
    (lambda text: text.replace("length: mm", "length: unit") + "friction: {O: 1}\n", "units: {length: m}"),
])  # fmt: skip
def test_the_command_rejects_models_without_forces_or_physical_units(change, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.yaml").write_text(change(CRANK))
    result = CliRunner().invoke(app, ["forces"])
    assert result.exit_code != 0
    assert words in str(result.exception)
    assert list(tmp_path.iterdir()) == [tmp_path / "model.yaml"]


def test_rows_up_to_a_dead_point_are_written(tmp_path, monkeypatch):
    """A slider driven through its dead centre: the exit status is 5."""
    monkeypatch.chdir(tmp_path)
    text = """\
nodes: {O: [0, 0], A: [0.6, 0.8], B: [2.4, 0], G: [9, 0]}
ground: [O, G]
links: {crank: {nodes: [O, A], length: 1}, rod: {nodes: [A, B], length: 2}}
prismatic: {slide: {node: B, guide: [O, G]}}
actuators: {ram: {type: linear, node: B, guide: [O, G], law: {from: 2.2, to: 3}}}
masses: {crank: {mass: 1}, rod: {mass: 2}}
"""
    (tmp_path / "model.yaml").write_text(text)
    result = CliRunner().invoke(app, ["forces", "--steps", "8", "--no-png"])
    assert result.exit_code == 5
    rows = (tmp_path / "model.forces.csv").read_text().splitlines()
    assert [row.split(",")[-1] for row in rows[1:-1]] == ["ok"] * 8
    assert rows[-1].split(",")[-1] in ("singular", "unreachable")
    assert rows[-1].split(",")[3] == ""


def test_forces_at_a_change_point_are_empty_with_status_singular(tmp_path, monkeypatch):
    """The flat parallelogram has two velocities: its positions are solved, its forces are empty."""
    monkeypatch.chdir(tmp_path)
    text = (MODELS / "parallelogram.yaml").read_text().replace("{from: 5, to: 170}", "{from: -90, to: 270}")
    text = text.replace("length: unit", "length: m") + "\nmasses: {coupler: {mass: 1}}\n"
    (tmp_path / "model.yaml").write_text(text)
    result = CliRunner().invoke(app, ["forces", "--steps", "8", "--json"])
    assert result.exit_code == 5
    report = json.loads(result.stdout)
    assert (report["solved"], report["status"]) == (7, "singular")
    rows = [row.split(",") for row in (tmp_path / "model.forces.csv").read_text().splitlines()[1:]]
    assert [row[-1] for row in rows] == ["ok", "ok", "singular", "ok", "ok", "ok", "singular", "ok", "ok"]
    assert [row[3] == "" for row in rows] == [row[-1] == "singular" for row in rows]


def test_the_axis_of_the_picture_includes_the_greatest_effort():
    """A short peak must be visible, since drives are chosen by it."""
    over = np.linspace(0.0, 1.0, 1001)
    effort = np.where(np.abs(over - 0.5) < 0.01, 900.0, np.sin(6.0 * over))
    table = Table((Column("time", over, "s"), Column("motor", effort, "N m")))
    frame = panel(graph_of("driving torque", table), 5.0).frame
    assert frame.low.imag < -1.0
    assert frame.high.imag > 900.0


def test_the_benchmark_runs(tmp_path):
    """With few rows; the measured times are not checked."""
    import inverse_dynamics
    import machine

    inverse_dynamics.main(["--steps", "40", "--repeats", "1", "--out", str(tmp_path)])
    lines = machine.result_path("inverse_dynamics", tmp_path).read_text().splitlines()
    assert lines[0] == "mechanism,steps,positions,accelerations,forces"
    assert len(lines) == 3


@pytest.mark.soak
def test_forces_take_at_most_a_few_times_as_long_as_positions():
    """One process, both compiled; the measured ratio is 5, including a varying overhead of numpy."""
    import time

    import inverse_dynamics as bench

    mechanism = bench.weighted("crank_rocker")
    options = bench.Options(jit="on")
    motion, courses = trace(mechanism, 20_000, options), bench.Courses(mechanism, 0, "on")
    bodies, course = bench.statics(mechanism), courses(motion)
    bench.inverse_dynamics(bodies, course, bench.compiled)
    sides = (
        lambda: trace(mechanism, 20_000, options),
        lambda: bench.inverse_dynamics(bodies, courses(motion), bench.compiled),
    )
    best = [math.inf, math.inf]
    for _ in range(5):
        for k, side in enumerate(sides):
            begin = time.thread_time()
            side()
            best[k] = min(best[k], time.thread_time() - begin)
    assert best[1] < 25.0 * best[0]


def test_trace_does_not_import_dynamics():
    """Also for a model with masses, loads and a table."""
    import subprocess
    import sys

    code = f"""
import sys
from gimcli import load
from gimcli.motion.motion import trace
trace(load({str(MODELS / "watt_1.yaml")!r}), 3)
heavy = ("forces", "force_", "loading", "course", "statics", "equilibrium", "scipy.interpolate")
print([name for name in sys.modules if any(part in name.removeprefix("gimcli.") for part in heavy)])
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


# -- near singular positions --------------------------------------------------------------------------------

BESIDE = """
units: {length: m}
nodes: {O: [0, 0], P: [2, 0], A: [0, 1], B: [2, 1]}
ground: [O, P]
links: {crank: [O, A], coupler: [A, B], rocker: [P, B]}
actuators: {q: {type: rotary, pivot: O, arm: A, law: {from: 90, to: 179.99997}}}
masses: {crank: {mass: 1, inertia: 0.1}, coupler: {mass: 1, inertia: 0.1}}
gravity: [0, -9.81]
"""


def test_doubtful_forces_are_left_out_of_peaks_and_plots(tmp_path):
    """Near the flat position of a parallelogram the crank force grows as 1 / sin q, the shaking force does not."""
    mechanism = written(tmp_path, BESIDE)
    motion = trace(mechanism, 100)
    found = ForceMotion(mechanism, 101)
    forces = found.take(motion)
    assert forces.good.all()
    pull = np.abs(forces.pin(forces.statics.pins[0], 1))
    assert pull[-1] > 1e6
    flat, steep = np.abs(np.sin(motion.inputs[0])), ~forces.bounded
    assert np.flatnonzero(steep).tolist() == [100]
    assert flat[-2] < 0.02
    assert found.left_out == 1
    result = gimcli.forces(mechanism, 100, plot="|O|")
    assert result.report()["left_out_at"] == [{"q": pytest.approx(179.99997)}]
    assert result.statistics["O"].greatest.value == pytest.approx(np.max(pull[:-1]))
    (graph,) = result.graphs()
    assert np.array_equal(np.isnan(graph.curves[0].y), steep)
    printed = gim("forces", mechanism.path, "--steps", 100, "-o", tmp_path / "f.csv").text
    assert "1 row is in the table but not in these values and the picture" in " ".join(printed.split())
    assert "exceeds 1 % (at q = 180 deg)" in " ".join(printed.split())


@pytest.mark.parametrize("gap", [0.1, 1e-2, 1e-3, 1e-4, 3e-5, 1e-5])
def test_rows_of_the_summary_have_forces_to_one_percent(tmp_path, gap):
    """The pin force tends to half the weight of the coupler / sin q; its error grows as 1 / sin(q)^2."""
    mechanism = written(tmp_path, BESIDE.replace("to: 179.99997", f"to: {180.0 - gap}"))
    motion = trace(mechanism, 10)
    forces = motion_forces(motion)
    pull = abs(forces.pin(forces.statics.pins[0], 1)[-1] * np.sin(motion.inputs[0][-1]))
    error = abs(pull / (9.81 / 2.0) - 1.0)
    assert forces.bounded[-1] == (gap > 2e-4)
    assert error < 0.01 or not forces.bounded[-1]  # positions on the curve of the motion may be better than the bound


def test_a_lid_with_a_short_lever_arm_has_all_its_rows(tmp_path):
    """A lid of 10 m, 10 kg at its middle, held by a ram 0.3 m from its hinge: F = W 5 cos q / (0.3 sin angle)."""
    text = """
units: {length: m}
nodes: {H: [0, 0], R: [0.3, 0], T: [10, 0], F: [0.3, -1]}
ground: [H, F]
elements: {lid: [H, R, T]}
actuators: {ram: {nodes: [F, R], law: {from: 1, to: 1.2}}}
loads: {end: {on: T, force: [0, -50]}}
"""
    found = gimcli.forces(gimcli.loads(text), 40)
    assert found.report()["left_out"] == 0
    assert found.statistics["ram.effort"].part == 1.0
    assert found["ram.effort"][0] == pytest.approx(50.0 * 10.0 / 0.3, rel=1e-12)  # 1667 N
    q = np.radians(found["ram"] * 0.0) + np.array([lid_angle(length) for length in found["ram"]])
    foot, end = 0.3 - 1j, 0.3 * np.exp(1j * q)
    arm = (end.conj() * (end - foot)).imag / np.abs(end - foot)
    assert found["ram.effort"] == pytest.approx(500.0 * np.cos(q) / arm, rel=1e-9)


def lid_angle(length):
    """Return the angle of R at 0.3 m from the hinge whose distance from the foot of the ram is `length`."""
    foot = complex(0.3, -1.0)
    inner = (0.3**2 + abs(foot) ** 2 - length**2) / (2 * 0.3 * abs(foot))
    return math.acos(inner) + np.angle(foot)


@pytest.mark.filterwarnings("error")
def test_singular_rows_are_empty_without_a_warning(tmp_path):
    """Three parallel cranks, flat at 180 deg: the matrix of their redundant equations loses rank there."""
    text = (MODELS / "parallelogram_third_crank.yaml").read_text().replace("from: 10, to: 170", "from: 0, to: 360")
    text += "masses: {left: {mass: 1, inertia: 0.1}, bar: {mass: 2, inertia: 0.1}}\n"
    forces = motion_forces(trace(written(tmp_path, text), 36))
    assert np.flatnonzero(~forces.good).tolist() == [0, 18, 36]
