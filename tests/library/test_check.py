"""The report on a model: strokes, time ratios, transmission angles and speeds against closed forms; warnings."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from bundled import MODELS
from in_process import gim
from scipy.optimize import brentq, minimize_scalar

import gimcli

LAWS = {"by": 360}


def four_bar(d, a, b, c, law=None, duration=2.0, **more):
    """Return a four-bar linkage with the input at O, drawn at 40 degrees."""
    motor = {"type": "rotary", "pivot": "O", "arm": "A", "law": law or LAWS}
    at = a * np.exp(1j * math.radians(40.0))
    away = d - at
    along = (b**2 - c**2 + abs(away) ** 2) / (2.0 * abs(away))
    end = at + away / abs(away) * complex(along, math.sqrt(b**2 - along**2))
    return {
        "units": {"length": "mm"}, "duration": duration,
        "nodes": {"O": [0, 0], "G": [d, 0], "A": [at.real, at.imag], "B": [end.real, end.imag]},
        "ground": ["O", "G"],
        "links": {
            "crank": {"nodes": ["O", "A"], "length": a}, "coupler": {"nodes": ["A", "B"], "length": b},
            "rocker": {"nodes": ["G", "B"], "length": c},
        },
        "actuators": {"motor": motor}, **more,
    }  # fmt: skip


def slider(a, b, e, duration=2.0):
    """Return a slider-crank whose slider's pin is at the height e."""
    motor = {"type": "rotary", "pivot": "O", "arm": "A", "law": {"from": -0.37, "to": 359.63}}
    return {
        "units": {"length": "mm"}, "duration": duration,
        "nodes": {"O": [0, 0], "A": [a, 0], "B": [a + math.sqrt(b**2 - e**2), e], "P": [0, e], "Q": [9, e]},
        "ground": ["O", "P", "Q"], "links": {"crank": ["O", "A"], "rod": ["A", "B"]},
        "prismatic": {"slide": {"node": "B", "guide": ["P", "Q"]}}, "actuators": {"motor": motor},
    }  # fmt: skip


def report(model):
    return gimcli.check(gimcli.load(model)).report()


def opposite(one, two, three):
    """Return the angle between two sides of a triangle, opposite to the third."""
    return math.acos((one**2 + two**2 - three**2) / (2.0 * one * two))


# -- closed forms -----------------------------------------------------------------------------------


@pytest.mark.parametrize("lengths", [(100.0, 40.0, 120.0, 80.0), (55.0, 15.0, 45.0, 40.0)])
def test_crank_rocker(lengths):
    """Swing and time ratio by the two triangles with crank and coupler in line; Norton, sections 3.4 and 4.10."""
    d, a, b, c = lengths
    found = report(four_bar(d, a, b, c, {"from": 40.37, "to": 400.37}))  # all extremes are between rows
    (rocker,) = found["outputs"]
    far, near = (opposite(d, c, b + s * a) for s in (1.0, -1.0))
    assert rocker["range"] == pytest.approx(math.degrees(far - near), rel=1e-12)
    assert sorted([rocker["least"], rocker["greatest"]]) == pytest.approx(
        sorted(180.0 - math.degrees(v) for v in (far, near)), rel=1e-12
    )
    begin, end = (math.degrees(opposite(d, b + s * a, c)) for s in (1.0, -1.0))
    forward = 180.0 + end - begin  # the crank turns from one position in line to the other
    assert rocker["time_ratio"] == pytest.approx(max(forward, 360 - forward) / min(forward, 360 - forward), rel=1e-9)
    ends = sorted((one["motor"] % 360.0) for one in (rocker["least_at"], rocker["greatest_at"]))
    assert ends == pytest.approx(sorted([begin, end + 180.0]), rel=1e-9)
    (angle,) = found["transmission"]
    extremes = [math.degrees(opposite(b, c, d + s * a)) for s in (1.0, -1.0)]
    assert angle["worst"] == pytest.approx(min(min(v, 180.0 - v) for v in extremes), rel=1e-12)


def test_an_extreme_at_the_first_row_does_not_spoil_the_others():
    """Hoeken's linkage 1 : 2.2 : 2.8 : 2.8 is symmetric about the line of its frame: speeds have extremes at 0."""
    (rocker,) = report(MODELS / "hoeken.yaml")["outputs"]
    assert rocker["range"] == pytest.approx(math.degrees(opposite(2.2, 2.8, 3.8) - opposite(2.2, 2.8, 1.8)), rel=1e-11)


@pytest.mark.parametrize("sizes", [(1.0, 3.0, 0.5), (2.0, 5.0, 0.0), (1.5, 4.0, -1.2)])
def test_slider_crank(sizes):
    """Stroke, time ratio, transmission angle in closed form; speeds by a search on the closed form of the position."""
    a, b, e = sizes
    found = report(slider(a, b, e))
    (out,) = found["outputs"]
    outer, inner = (math.sqrt((b + s * a) ** 2 - e**2) for s in (1.0, -1.0))
    assert out["range"] == pytest.approx(outer - inner, rel=1e-12)
    back = math.asin(e / (b - a)) - math.asin(e / (b + a))  # excess over half a turn
    assert out["time_ratio"] == pytest.approx((math.pi + abs(back)) / (math.pi - abs(back)), rel=1e-9)
    (angle,) = found["transmission"]
    assert angle["worst"] == pytest.approx(math.degrees(math.acos((a + abs(e)) / b)), rel=1e-12)

    def slope(t):  # of the slider by the crank angle
        return -a * np.sin(t) - (a * np.sin(t) - e) * a * np.cos(t) / np.sqrt(b**2 - (a * np.sin(t) - e) ** 2)

    grid = np.linspace(0, 2 * math.pi, 721)
    k = int(np.argmax(np.abs(slope(grid))))
    best = minimize_scalar(lambda t: -abs(slope(t)), bounds=(grid[k] - 0.02, grid[k] + 0.02), method="bounded",
                           options={"xatol": 1e-10})  # fmt: skip
    omega = 2.0 * math.pi / 2.0
    speed = next(p for p in found["peaks"] if (p["name"], p["quantity"]) == ("B", "speed"))
    assert speed["greatest"] == pytest.approx(-best.fun * omega, rel=1e-9)
    assert math.radians(speed["at"]["motor"]) == pytest.approx(best.x % (2 * math.pi), abs=1e-5)
    rod = next(p for p in found["peaks"] if (p["name"], p["quantity"]) == ("rod", "angular speed"))
    swing = a / math.sqrt(b**2 - e**2)  # at crank angles 0 and 180 degrees, unless the offset moves it
    assert rod["greatest"] >= math.degrees(swing * omega) * (1 - 1e-12)


def test_speeds_of_a_scotch_yoke():
    """Harmonic motion: the greatest speed is r w, the greatest acceleration r w^2 (r = 1, one turn in `duration`)."""
    found = report(gimcli_data("scotch_yoke", duration=0.5))
    omega = 2.0 * math.pi / 0.5
    peaks = {(p["name"], p["quantity"]): p["greatest"] for p in found["peaks"]}
    assert peaks["S", "speed"] == pytest.approx(omega, rel=1e-9)
    assert peaks["S", "acceleration"] == pytest.approx(omega**2, rel=1e-9)
    assert {one["name"]: one["range"] for one in found["outputs"]} == pytest.approx({"rail": 2.0, "slot": 2.0})
    assert found["duration"] == 0.5


def gimcli_data(name, **more):
    """Return a bundled model with other sections."""
    from gimcli.model.source import read_source

    return {**read_source(MODELS / f"{name}.yaml").data, **more}


def test_published_quick_returns():
    """Closed forms named in the sources of these models: crank-shaper (swing 60, ratio 2), Whitworth (3, ratio 2)."""
    motor = gimcli_data("crank_shaper")["actuators"]["motor"] | {"law": {"from": 60.37, "to": 420.37}}
    shaper = report(gimcli_data("crank_shaper", actuators={"motor": motor}))
    outputs = {o["name"]: o for o in shaper["outputs"]}
    assert (outputs["arm"]["range"], outputs["arm"]["time_ratio"]) == pytest.approx((60.0, 2.0), rel=1e-9)
    assert outputs["slot"]["range"] == pytest.approx(2.0, rel=1e-12)  # along the arm: frame + crank to frame - crank
    outputs = {o["name"]: o for o in report(MODELS / "whitworth.yaml")["outputs"]}
    assert (outputs["ram"]["range"], outputs["ram"]["time_ratio"]) == pytest.approx((3.0, 2.0), rel=1e-9)
    assert outputs["arm"]["full_turn"]
    assert outputs["arm"]["time_ratio"] is None


def test_a_motion_that_ends_at_a_limit_includes_it():
    """At the limit coupler and rocker are in line: |A G| = b + c. Speeds have no bound there."""
    d, a, b, c = 4.0, 2.0, 3.0, 1.5
    found = report(four_bar(d, a, b, c, {"by": 180}))
    limit = math.degrees(opposite(a, d, b + c))
    (motor,) = found["inputs"]
    assert motor["limit"] == pytest.approx(limit, rel=1e-9)
    assert motor["range"] == pytest.approx([-limit, limit], rel=1e-9)
    end = a * np.exp(1j * math.radians(limit)) - d
    (rocker,) = found["outputs"]
    ends = [rocker["least"], rocker["greatest"]]
    assert min(abs(math.remainder(v - math.degrees(np.angle(end)), 360.0)) for v in ends) < 1e-6
    assert found["transmission"][0]["worst"] == pytest.approx(0.0, abs=1e-6)
    peaks = {(p["name"], p["quantity"]): p["greatest"] for p in found["peaks"]}
    assert math.isinf(peaks["rocker", "angular speed"])
    assert math.isfinite(peaks["A", "speed"])
    assert any(f"motor = {limit:.3f} deg" in one["text"] for one in found["warnings"])


def test_extremes_between_rows_do_not_depend_on_the_rows():
    """The greatest speed of a coupler point agrees with a search on solved positions, far finer than the rows."""
    m = gimcli.load(MODELS / "crank_rocker.yaml")
    peak = next(p for p in report(MODELS / "crank_rocker.yaml")["peaks"] if p["name"] == "P")

    def speed_slope(angle, h=1e-3):
        return sum(s * abs(velocity(m, angle + s * h)) for s in (1.0, -1.0)) / (2.0 * h)

    at = brentq(speed_slope, peak["at"]["motor"] - 1.5, peak["at"]["motor"] + 1.5, xtol=1e-9)
    assert at == pytest.approx(peak["at"]["motor"], abs=1e-4)
    assert abs(velocity(m, at)) == pytest.approx(peak["greatest"], rel=1e-8)


def velocity(m, angle):
    return complex(*gimcli.solve(m, motor=angle % 360.0, velocities=True).report()["velocities"]["P"])


# -- several turns, several inputs, no motion ---------------------------------------------------------


def test_several_turns_give_the_same_values():
    one, three = (report(four_bar(100.0, 40.0, 120.0, 80.0, {"by": n * 360}, n * 2.0)) for n in (1, 3))
    for key in ("range", "time_ratio", "strokes_per_turn"):
        assert three["outputs"][0][key] == pytest.approx(one["outputs"][0][key], rel=1e-9)
    assert three["peaks"][0]["greatest"] == pytest.approx(one["peaks"][0]["greatest"], rel=1e-8)
    half = report(four_bar(100.0, 40.0, 120.0, 80.0, {"by": 200}))
    assert half["outputs"][0]["time_ratio"] is None


def test_a_motion_of_another_size_or_unit_is_the_same():
    small, rad = four_bar(1e-3, 4e-4, 1.2e-3, 8e-4), four_bar(100.0, 40.0, 120.0, 80.0, {"by": 2.0 * math.pi})
    rad["units"] = {"length": "mm", "angle": "rad"}
    base = report(four_bar(100.0, 40.0, 120.0, 80.0))
    for other, factor in ((report(small), 1.0), (report(rad), math.pi / 180.0)):
        assert other["outputs"][0]["range"] == pytest.approx(factor * base["outputs"][0]["range"], rel=1e-9)
        assert other["type"] == base["type"] == "four-bar linkage: crank-rocker"


NO_MOTION = {
    "undriven": (four_bar(4, 1, 4, 3) | {"actuators": {}}, "nothing drives", 0),
    "over-driven": (
        four_bar(4, 1, 4, 3) | {"actuators": {n: {"type": "rotary", "pivot": p, "arm": e, "law": LAWS}
                                              for n, p, e in (("m", "O", "A"), ("n", "G", "B"))}},
        "over-driven", 0,
    ),
    "rigid": ({"nodes": {"O": [0, 0], "G": [4, 0], "A": [1, 1]}, "ground": ["O", "G"],
               "links": {"a": ["O", "A"], "b": ["G", "A"]}}, "form a rigid triangle", 0),
    "apart": ({**four_bar(50, 10, 45, 20), "links": {"crank": ["O", "A"], "coupler": {"nodes": ["A", "B"], "length": 5},
               "rocker": {"nodes": ["G", "B"], "length": 5}}}, "cannot span", 5),
}  # fmt: skip


@pytest.mark.parametrize("name", NO_MOTION)
def test_a_mechanism_without_a_motion_is_described(name, tmp_path):
    model, text, code = NO_MOTION[name]
    (tmp_path / "m.yaml").write_text(json.dumps(model))
    done = gim("check", tmp_path / "m.yaml", "--json")
    assert done.code == code
    assert any(text in one["text"] for one in done.json["warnings"])
    assert done.json["formula"].startswith("F = ")
    assert done.json["peaks"] == []
    printed = gim("check", tmp_path / "m.yaml")
    assert printed.code == code
    assert "Grübler's formula" in printed.text


# -- warnings -------------------------------------------------------------------------------------------

TEXT = """\
units: {length: mm}
nodes:
  O: [0, 0]
  G: [100, 0]
  A: [30.64, 25.71]
  B: [143.19, 67.34]
ground: [O, G]
links:
  crank: {nodes: [O, A], length: 40}
  coupler: [A, B]
  rocker: [G, B]
actuators:
  motor: {type: rotary, pivot: O, arm: A, law: {by: 360}}
"""
EDITS = {
    "fine": ("", "", "duration: 1\n", None, ""),
    "duration": ("", "", "", 12, "no `duration` is given"),
    "node": ("ground:", "  Z: [9, 9]\nground:", "duration: 1\n", 7, "node Z is used by no member"),
    "copy": ("actuators:", "  again: [A, B]\nactuators:", "duration: 1\n", 12, "again has no effect: coupler joins"),
    "gravity": ("", "", "duration: 1\ngravity: [0, -9.8]\n", 15, "`gravity` has no effect without masses"),
    "mass unit": ("{length: mm}", "{length: mm, mass: g}", "duration: 1\n", 1, "`mass` has no effect without masses"),
    "free": ("law: {by: 360}", "law: {by: 360}, free: true", "duration: 1\n", 13, "`free` of motor has no effect"),
    "mass of ground": ("", "", "duration: 1\nmasses:\n  ground: {mass: 1}\n", 16, "the mass of ground has no effect"),
    "mass 0": ("", "", "duration: 1\nmasses:\n  coupler: {mass: 0}\n", 16, "the mass of coupler is 0"),
    "load": ("", "", "duration: 1\nloads:\n  f: {on: ground, at: [0, 0], force: [1, 0]}\n", 16, "acts on the frame"),
    "load 0": ("", "", "duration: 1\nloads:\n  f: {on: coupler, torque: 0}\n", 16, "load f is 0"),
    "damper": ("", "", "duration: 1\ndampers:\n  d: {nodes: [O, B], damping: 0}\n", 16, "damper d has the damping 0"),
    "friction": ("", "", "duration: 1\nfriction:\n  A: 0\n", 16, "friction at A is 0"),
    "no length": ("mm", "unit", "duration: 1\nmasses:\n  coupler: {mass: 1}\n", 15, "`masses` has no effect: the"),
    "triangle": ("actuators:", "  d: [A, C]\n  e: [B, C]\nactuators:", "duration: 1\n", 14, "form a rigid triangle"),
    "far": ("[143.19, 67.34]", "[120, 40]", "duration: 1\n", 6, "node B is assembled "),
}  # fmt: skip


@pytest.mark.parametrize("name", EDITS)
def test_warnings_name_the_line_and_the_remedy(name, tmp_path):
    old, new, tail, line, text = EDITS[name]
    model = TEXT.replace(old, new, 1) + tail
    if name == "triangle":
        model = model.replace("  B: [143.19, 67.34]\n", "  B: [143.19, 67.34]\n  C: [80, 90]\n")
    if name == "far":
        model = model.replace("coupler: [A, B]", "coupler: {nodes: [A, B], length: 120}")
        model = model.replace("rocker: [G, B]", "rocker: {nodes: [G, B], length: 80}")
    path = tmp_path / "m.yaml"
    path.write_text(model)
    done = gim("check", path)
    assert done.code == 0
    lines = [one for one in done.text.splitlines() if one.startswith("warning: ")]
    if not text:
        assert lines == []
        return
    (found,) = lines
    assert text in found
    assert line is None or f"{path}:{line}: " in found


def test_a_plate_drawn_as_a_mirror_image_is_reported():
    model = four_bar(100.0, 40.0, 120.0, 80.0)
    plate = {"nodes": ["A", "B", "P"], "shape": {"A": [0, 0], "B": [120, 0], "P": [60, 50]}}
    links = {name: link for name, link in model["links"].items() if name != "coupler"}
    texts = []
    for y in (95.0, 2.0):
        nodes = {**model["nodes"], "P": [80.0, y]}
        found = report({**model, "nodes": nodes, "links": links, "elements": {"coupler": plate}})
        texts.append(" ".join(one["text"] for one in found["warnings"]))
        assert set(found["drawing"]["mirrored_members"]) == ({"coupler"} if y == 2.0 else set())
    assert "mirror image" in texts[1]
    assert texts[0] == ""


def test_lengths_near_a_change_point_are_reported():
    texts = [
        [one["text"] for one in report(four_bar(100.0, 40.0, 120.0, c))["warnings"]] for c in (60.0001, 60.0, 61.0)
    ]
    assert len(texts[0]) == 1
    assert "p + q - s - l is only" in texts[0][0]
    assert texts[1] == []


def test_distances_from_the_drawing_are_those_of_the_file():
    model = four_bar(100.0, 40.0, 120.0, 80.0)
    exact = report(model)["drawing"]
    assert max(exact["nodes"].values()) < 1e-12
    model["nodes"]["A"] = [1.05 * v for v in model["nodes"]["A"]]  # along the crank: 2 mm too long
    moved = report(model)["drawing"]
    assert moved["nodes"]["A"] == pytest.approx(2.0, rel=1e-9)
    assert moved["node"] == "A"


# -- forms of the report -----------------------------------------------------------------------------------


def test_print_shows_the_report():
    text = repr(gimcli.check(gimcli.load(MODELS / "crank_rocker.yaml")))
    for part in ("four-bar linkage: crank-rocker; 1 warning", "swing 73.7818 deg", "time ratio", "warning: "):
        assert part in text


def test_table_and_json_have_the_same_numbers(tmp_path):
    done = gim("check", MODELS / "slider_crank.yaml", "-o", tmp_path / "c.csv", "-o", tmp_path / "c.json", "--json")
    saved = json.loads((tmp_path / "c.json").read_text())
    assert {key: done.json[key] for key in saved} == saved
    table = gimcli.check(gimcli.load(MODELS / "slider_crank.yaml"))
    rows = dict(zip(table["quantity"], zip(table["value"], table["at"], strict=True), strict=True))
    assert float(rows["stroke"][0]) == done.json["outputs"][0]["range"]
    assert rows["type"][0] == done.json["type"]
    assert rows["time ratio"][1].startswith("motor = ")


@pytest.mark.few("antiparallelogram", "elliptic_trammel", "excavator", "five_bar", "jansen", "stephenson_2")
@pytest.mark.parametrize("name", sorted(path.stem for path in MODELS.glob("*.yaml")))
def test_all_bundled_models_are_described(name):
    found = gimcli.check(gimcli.load(MODELS / f"{name}.yaml"))
    full = found.report()
    assert full["status"] == "ok"
    assert full["solved"] == full["rows"]
    assert full["mobility"] >= full["gruebler"]
    assert [one for one in full["warnings"] if "duration" not in one["text"]] == []
    assert full["type"] in str(found)


@pytest.mark.parametrize("name", ["slider_crank", "undriven", "apart"])
def test_the_page_has_the_report_and_the_motion(name, tmp_path):
    model = MODELS / "slider_crank.yaml" if name == "slider_crank" else NO_MOTION[name][0]
    found = gimcli.check(gimcli.load(model))
    page = found.animation()
    headings = [section.heading for section in page.report]
    printed = [part.splitlines()[0] for part in str(found).split("\n\n")[1:]]
    assert headings == [*printed, *(["Warnings"] if found.warnings else [])]
    rows = {"slider_crank": found.report()["rows"], "undriven": 1, "apart": 1}[name]
    (clip,) = page.clips
    assert len(clip.time) == rows
    assert bool(clip.good.all()) == (name != "apart")
    found.save(tmp_path / "check.html")
    text = (tmp_path / "check.html").read_text(encoding="utf-8")
    assert all(word in text for word in ("redundant constraints", found.type, "Warnings"))


def test_the_table_of_several_machines_has_the_nodes_of_each():
    found = gimcli.check(gimcli.load(MODELS / "floating_hexagon.yaml"))
    nodes = found["name"][found["section"] == "initial coordinates"].tolist()
    assert nodes == [node for one in found.report()["machines"] for node in one["drawing"]["nodes"]]
    assert len(nodes) > len(set(nodes)) > 0
