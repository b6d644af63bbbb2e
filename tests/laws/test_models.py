"""The mechanisms in `models/` against exact lines, closed forms, published tables and inversions.

Expected values come from closed forms, from publications (the source is named with the digits) and from independent
programs, never from our own output.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import yaml
from bundled import EXPLICIT, MODELS

NAMES = [path.stem for path in EXPLICIT]
LAWS = []
PLACED = {"four_bar_lengths": {"A": (30.642, 25.712), "B": (143.190, 67.340)}}
"""Nodes without coordinates in the file: from the angles 40 and 57.325 deg of its source."""


# --- an own reader of model files ------------------------------------------------------------------------


@cache
def read(model):
    spec = yaml.safe_load((MODELS / f"{model}.yaml").read_text())
    placed = PLACED.get(model, {})
    spec["nodes"] = {name: complex(*placed.get(name, xy)) for name, xy in spec["nodes"].items()}
    for kind in ("links", "elements"):
        for name, value in spec.get(kind, {}).items():
            spec[kind][name] = value if isinstance(value, dict) else {"nodes": value}
    for value in spec.get("points", {}).values():
        value["on"] = value.get("on", value.get(True))  # YAML 1.1 reads a bare `on` as true
    return spec


def members(model):
    """Yield the nodes of every member, with their coordinates in the frame of the member."""
    spec = read(model)
    for link in spec.get("links", {}).values():
        length = link.get("length")
        drawn = [spec["nodes"][name] for name in link["nodes"]]
        yield link["nodes"], np.array(drawn if length is None else [0, length])
    for element in spec.get("elements", {}).values():
        shape = {name: complex(*xy) for name, xy in element.get("shape", {}).items()} or spec["nodes"]
        yield element["nodes"], np.array([shape[name] for name in element["nodes"]])


def size(model):
    nodes = np.array(list(read(model)["nodes"].values()))
    return np.max(abs(nodes[:, None] - nodes))


# --- small geometry --------------------------------------------------------------------------------------


def ray(degrees):
    return np.exp(1j * np.radians(degrees))


def unit(z):
    return z / abs(z)


def angle(z):
    return np.degrees(np.angle(z))


def turns(z):
    """Return the number of turns of a vector over the rows."""
    return np.sum(np.angle(z[1:] / z[:-1])) / (2 * np.pi)


def on(a, b, along, left=0.0):
    """Return the point with the coordinates `along` and `left` in the frame of a -> b."""
    return a + unit(b - a) * (along + 1j * left)


def meet(a, ra, b, rb, side=1):
    """Return the intersection of circles around a and b, to the left (side 1) or right (-1) of a -> b."""
    d = abs(b - a)
    x = (ra**2 - rb**2 + d**2) / (2 * d)
    return a + (b - a) / d * (x + 1j * side * np.sqrt(ra**2 - x**2))


def extremes(y):
    """Return minimum and maximum of a periodic series, from the parabola through three samples."""
    y = y[:-1]

    def top(y):
        k = int(np.argmax(y))
        a, b, c = y[k - 1], y[k], y[(k + 1) % len(y)]
        return b + (c - a) ** 2 / (8 * (2 * b - a - c))

    return np.array([-top(-y), top(y)])


def rates(z, step):
    """Return first and second derivative in the middle of nine rows (central differences of order 8)."""
    first = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
    second = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
    return first @ z / step, second @ z / step**2


# --- properties of all models ----------------------------------------------------------------------------


@pytest.mark.few
@pytest.mark.parametrize("model", NAMES)
def test_the_whole_law_is_solved(model, trace_model):
    m = trace_model(model, steps=90)
    assert set(m.status) == {"ok"}
    assert len(m.status) == len(m.residual) == 91
    assert np.all(m.residual <= 1e-10)


def constraint_errors(model, m):
    """Yield the errors of all constraints of the file, as lengths over all rows."""
    spec = read(model)
    for names, local in members(model):
        z = np.array([m.xy(name) for name in names])
        yield abs(z[1] - z[0]) - abs(local[1] - local[0])
        for k in range(2, len(names)):
            yield (z[k] - z[0]) - (local[k] - local[0]) * (z[1] - z[0]) / (local[1] - local[0])
    for pair in spec.get("prismatic", {}).values():
        a, b = (m.xy(name) for name in pair["guide"])
        for name in pair.get("nodes", [pair.get("node")]):
            yield ((m.xy(name) - a) / unit(b - a)).imag - pair.get("offset", 0)
    for name, drive in spec["actuators"].items():
        if "pivot" in drive:
            pivot, arm = m.xy(drive["pivot"]), m.xy(drive["arm"])
            reference = unit(m.xy(drive["reference"]) - pivot) if "reference" in drive else 1
            yield (arm - pivot) - abs(arm - pivot) * reference * ray(m.value[name])
        elif "nodes" in drive:
            a, b = (m.xy(node) for node in drive["nodes"])
            yield abs(b - a) - m.value[name]
        else:
            a, b = (m.xy(node) for node in drive["guide"])
            yield ((m.xy(drive["node"]) - a) / unit(b - a)).real - m.value[name]
    ground = spec["ground"]
    for name in ground if isinstance(ground, list) else spec["elements"][ground["member"]]["nodes"]:
        yield m.xy(name) - spec["nodes"][name]
    for name, point in spec.get("points", {}).items():
        if "local" in point:
            a, b = (spec.get("links", {}) | spec.get("elements", {}))[point["on"]]["nodes"][:2]
            yield m.xy(name) - on(m.xy(a), m.xy(b), *point["local"])


@pytest.mark.few
@pytest.mark.parametrize("model", NAMES)
def test_every_position_satisfies_the_file(model, trace_model):
    m = trace_model(model, steps=90)
    for error in constraint_errors(model, m):
        assert np.max(abs(error)) <= 1e-9 * size(model)


def uniform(ends):
    return {name: {"from": float(a), "to": float(b)} for name, (a, b) in ends.items()}


@pytest.mark.few
@pytest.mark.parametrize("model", NAMES)
def test_the_reversed_law_gives_the_same_positions(model, trace_model):
    driven = trace_model(model, steps=90).value
    ends = {name: (driven[name][0], driven[name][-1]) for name in drivers(model)}
    forward = trace_model(model, steps=90, laws=uniform(ends))
    backward = trace_model(model, steps=90, laws=uniform({name: (b, a) for name, (a, b) in ends.items()}))
    for node in read(model)["nodes"]:
        assert np.max(abs(forward.xy(node) - backward.xy(node)[::-1])) <= 1e-8 * size(model)


def drivers(model):
    """Return the actuators that follow no others."""
    return [name for name, drive in read(model)["actuators"].items() if "follows" not in drive]


def turns_fully(model):
    laws = [read(model)["actuators"][name]["law"] for name in drivers(model)]
    return all(abs(law.get("by", law.get("to", 0) - law.get("from", 0))) == 360 for law in laws)


@pytest.mark.parametrize("model", [name for name in NAMES if turns_fully(name)])
def test_a_full_turn_closes(model, trace_model):
    m = trace_model(model, steps=90)
    assert all(abs(abs(m.value[name][-1] - m.value[name][0]) - 360) < 1e-9 for name in drivers(model))
    for node in read(model)["nodes"]:
        assert abs(m.xy(node)[-1] - m.xy(node)[0]) <= 1e-9 * size(model)


# --- properties of single models -------------------------------------------------------------------------


def law(model, steps=360, **motion):
    """Test the pairs (found, expected[, tolerance]) that a function yields for the motion of a model.

    `motion` has the (from, to) of the actuators; by default the laws of the file are used.
    """
    return lambda function: LAWS.append((model, function, steps, uniform(motion) or None)) or function


def test_every_model_has_a_law():
    assert {model for model, *_ in LAWS} | {model for model, *_ in RATES} == set(NAMES)


def freudenstein(m, a, b, c, d):
    """Return the error of Freudenstein's equation of the four-bar a (input), b, c (output), d (frame)."""
    o2, pa, pb, o4 = (m.xy(name) for name in ("O2", "A", "B", "O4"))
    t2, t4 = np.angle(pa - o2), np.angle(pb - o4)
    k1, k2, k3 = d / a, d / c, (a**2 - b**2 + c**2 + d**2) / (2 * a * c)
    return k1 * np.cos(t4) - k2 * np.cos(t2) + k3 - np.cos(t2 - t4)


def transmission_angles(a, b, c, d):
    """Return the transmission angles where the input link is in line with the frame, folded and extended."""
    return np.degrees(np.arccos([(b**2 + c**2 - (d + s * a) ** 2) / (2 * b * c) for s in (-1, 1)]))


@law("crank_rocker")
@law("four_bar_lengths", motor=(0, 360))
def four_bar(m):
    yield freudenstein(m, 40, 120, 80, 100), 0
    mu = abs(angle((m.xy("A") - m.xy("B")) / (m.xy("O4") - m.xy("B"))))
    yield mu[[0, 180]], transmission_angles(40, 120, 80, 100)
    yield mu.min(), 26.384329749407964
    yield mu.max(), 86.41667830152802
    a = 40 * ray(m.value["motor"])
    yield m.xy("B"), meet(a, 120, 100, 80)
    yield m.xy("P"), on(a, m.xy("B"), 60, 40)


@law("crank_rocker", 1, motor=(40, 41))
@law("four_bar_lengths", 1)
def norton_example_4_1(m):
    """Printed: theta3 20.298, theta4 57.325 deg."""
    yield angle(m.xy("B") - m.xy("A"))[0], 20.297882788196475
    yield angle(m.xy("B") - m.xy("O4"))[0], 57.32488007036079


STRETCHED, FOLDED = np.degrees(np.arccos([146 / 160, 50 / 80]))
"""Directions from O2 to B at the dead centres of the crank-rocker (law of cosines)."""


@law("crank_rocker", 1, motor=(STRETCHED, FOLDED + 180))
def swing_between_the_dead_centres(m):
    o4b = m.xy("B") - m.xy("O4")
    yield angle(o4b[1] / o4b[0]), 73.781819649


@law("double_crank")
def drag_link(m):
    yield freudenstein(m, 100, 80, 120, 40), 0
    mu = abs(angle((m.xy("A") - m.xy("B")) / (m.xy("O4") - m.xy("B"))))
    yield mu[[120, 300]], transmission_angles(100, 80, 120, 40)[::-1]
    yield turns(m.xy("B") - m.xy("O4")), 1
    yield m.xy("M"), (m.xy("A") + m.xy("B")) / 2


@law("double_pendulum", shoulder=(-90, -60), elbow=(180, 150))
def two_bars_in_succession(m):
    upper = ray(m.value["shoulder"])
    yield m.xy("A"), upper
    yield m.xy("B"), upper - upper * ray(m.value["elbow"])


@law("wiper")
def welded_arm(m):
    b = meet(30 * ray(m.value["motor"]), 250, 240 + 40j, 60)
    yield m.xy("B"), b
    yield m.xy("T"), 240 + 40j + (b - 240 - 40j) / 60 * (-200 + 346.41j)


@law("garage_door")
def ladder_in_a_corner(m):
    height = m.value["opener"]
    yield m.xy("B"), 1j * height
    yield m.xy("T"), np.sqrt(49 - (7 - height) ** 2) + 7j


@law("spring_block")
def block_along_its_guide(m):
    yield m.xy("P"), m.value["travel"] - 200


@law("gim_fig13a")
def crank_rocker_from_integer_coordinates(m):
    b = abs(20 + 35j) * ray(m.value["motor"])
    yield m.xy("C"), meet(b, abs(75 + 25j), 80, abs(15 + 60j))


@law("parallelogram")
def coupler_translates(m):
    yield m.xy("A"), ray(m.value["motor"])
    yield m.xy("B"), 3 + ray(m.value["motor"])


@law("parallelogram_third_crank")
def translation_of_fraczek_and_wojtyra_1_12(m):
    for node, pivot in (("B", 0), ("F", 1), ("C", 2)):
        yield m.xy(node), pivot + ray(m.value["motor"])


@law("antiparallelogram")
def half_angle_relation(m):
    theta = np.radians(m.value["motor"])
    yield np.tan(np.angle(m.xy("B") - 3) / 2) / np.tan(theta / 2), -2


@law("galloway_kite")
def mirror_in_the_long_diagonal(m):
    a = ray(m.value["motor"])
    yield m.xy("B"), a - unit(3 - a) ** 2 * a.conj()


@law("slider_crank")
def offset_slider(m):
    theta = np.radians(m.value["motor"])
    yield m.xy("B"), np.cos(theta) + np.sqrt(9 - (np.sin(theta) - 0.5) ** 2) + 0.5j
    yield m.xy("P"), (m.xy("A") + m.xy("B")) / 2


@law("slider_crank", motor=(7.180755781458282, 194.47751218592992))
def stroke_between_the_dead_centres(m):
    yield m.xy("B")[[0, -1]].real, np.sqrt([16 - 0.25, 4 - 0.25])
    yield np.ptp(m.xy("B").real), 2.0321352934931776


@law("whitworth")
def slotted_arm_and_ram(m):
    arm = unit(2 * ray(m.value["motor"]) + 1j)
    yield m.xy("D"), -1j + 4 * arm
    yield m.xy("E"), -1j - 1.5 * arm
    yield m.xy("R"), -1j - 1.5 * arm.real + np.sqrt(25 - (1.5 * arm.imag) ** 2)
    yield turns(m.xy("D") - m.xy("C")), 1


@law("whitworth", motor=(-30, 210))
def slow_stroke_takes_240_degrees(m):
    yield m.xy("R")[[0, -1]], [3.5 - 1j, 6.5 - 1j]
    yield np.ptp(m.xy("R").real), 3


@law("crank_shaper")
def oscillating_arm(m):
    yield m.xy("D"), -2j + 4 * unit(ray(m.value["motor"]) + 2j)


@law("crank_shaper", motor=(-30, 210))
def swing_of_60_degrees_in_240(m):
    yield angle(m.xy("D") - m.xy("C"))[[0, -1]], [60, 120]


@law("scotch_yoke")
def pure_cosine(m):
    x = np.cos(np.radians(m.value["motor"]))
    for node, place in (("S", 0), ("W", 3), ("T", 2j)):
        yield m.xy(node), x + place


@law("elliptic_trammel")
def ellipse_and_circle(m):
    psi = ray(m.value["motor"])
    yield m.xy("A"), -2.5 * psi.real
    yield m.xy("B"), 2.5j * psi.imag
    p = m.xy("P")
    yield (p.real / 3.5) ** 2 + p.imag**2, 1
    yield abs(m.xy("M")), 1.25


@law("scott_russell")
def exact_line_of_scott_russell(m):
    theta = np.radians(m.value["motor"])
    yield m.xy("P"), 4j * np.sin(theta)
    yield m.xy("B"), 4 * np.cos(theta)


def lambda_point(a, o4, arm):
    """Return the traced point of a lambda linkage with the crank pin a: |B-A| = |B-O4| = |B-P| = arm (Thales)."""
    d = o4 - a
    return o4 + 1j * d * np.sqrt(4 * arm**2 / abs(d) ** 2 - 1)


@law("hoeken")
def hoeken_norton_table_3_1(m):
    yield m.xy("P"), lambda_point(ray(m.value["motor"]), 2.2, 2.8)
    heights = [4.5989278083376535, 4.598328703526058, 4.598597185498109, 4.595650117230423]
    yield m.xy("P")[[90, 120, 150, 180]].imag, heights


@law("chebyshev_lambda")
def right_angle_of_thales(m):
    theta, p = np.radians(m.value["motor"]), m.xy("P")
    root = 2 * np.sqrt((5 + np.cos(theta)) / (5 - 4 * np.cos(theta)))
    yield p, 2 + np.sin(theta) * root + 1j * (2 - np.cos(theta)) * root
    yield p, lambda_point(ray(m.value["motor"]), 2, 2.5)
    yield p[[0, 90, 180]].imag, 4
    yield p[270].imag, 2 * np.sqrt(6)
    yield p[::-1], 4 - p[(np.arange(361) + 180) % 360].conj()  # the curve is symmetric


@law("chebyshev_lambda", motor=(angle(-5 + 1j * np.sqrt(39)), 180))
def greatest_deviation_of_the_lambda(m):
    yield m.xy("P")[0].imag, 5.25 * np.sqrt(7 / 12)
    yield m.xy("P").imag.max(), 5.25 * np.sqrt(7 / 12)


@law("chebyshev", motor=(angle(3 + 4j), 90))
def exact_positions_of_the_crossed_linkage(m):
    yield m.xy("P")[[0, -1]], [2 + 4j, 4j]


@law("chebyshev")
def straight_within_a_quarter_percent(m):
    a = 5 * ray(m.value["motor"])
    yield m.xy("P"), (a + meet(a, 2, 4, 5, -1)) / 2
    straight = m.xy("P").imag[m.value["motor"] <= 90]
    yield straight.min(), 4, 1e-4
    yield straight.max(), 5.25 * np.sqrt(7 / 12), 1e-5


@law("watt_straight_line")
def watts_curve(m):
    """r^2 = b^2 - (a sin t +- sqrt(c^2 - a^2 cos^2 t))^2 with a^2 = 26, b = 5, c = 1, cleared of radicals."""
    p = m.xy("P")
    r2, d = abs(p) ** 2, (10 * p.real + 2 * p.imag) ** 2 / 104
    yield (r2 * (-2 - r2) + 52 * d) ** 2 - 104 * (r2 - d) * (r2 - 26 * d), 0


@law("watt_straight_line", motor=(-np.degrees(0.3), np.degrees(0.3)))
def stroke_of_watts_linkage(m):
    """Minima and maxima from dense sampling."""
    p = m.xy("P")
    yield [p.imag.min(), p.imag.max()], [-1.5048668883833953, 1.4539647939718738], 1e-5
    yield [p.real.min(), p.real.max()], [-0.007183783619328655, 0.00860545720801765], 1e-5


@law("hart_a_frame")
def exact_line_of_hart(m):
    yield m.xy("P").real, 0


@law("hart_a_frame", 10, motor=(70, angle(0.5 + 1j * np.sqrt(8.75))))
def symmetric_position_of_hart(m):
    yield m.xy("P")[-1], 1j * np.sqrt(35)


@law("peaucellier")
def inversion(m):
    theta, p, q = np.radians(m.value["motor"]), m.xy("P"), m.xy("Q")
    yield q, 18.75 / 4 * (1 + 1j * np.tan(theta / 2))
    yield abs(p) * abs(q), 5**2 - 2.5**2
    yield m.xy("A"), meet(0, 5, p, 2.5)
    yield m.xy("B"), meet(0, 5, p, 2.5, -1)


def legs(q):
    """Return the foot of the lambda leg in the frame of the body; q is the crank angle from A towards C."""
    q = np.radians(q)
    root = 2 * np.sqrt((5 + np.cos(q)) / (5 - 4 * np.cos(q)))
    return 2 - np.sin(q) * root - 1j * (2 - np.cos(q)) * root


@law("plantigrade")
def body_walks_on_lambda_legs(m):
    standing, swinging = legs(m.value["motor"]), legs(m.value["motor"] + 180)
    for node, place in (("A1", 0), ("C1", 2), ("A2", 6), ("C2", 8)):
        yield m.xy(node), place - standing
    yield m.xy("Q1"), swinging - standing
    yield m.xy("Q2"), swinging - standing + 6


@law("watt_1", 24, motor=(0, 360))
def independent_reduction_of_watts_six_bar(m):
    """Positions of B and E from an independent program."""
    places = {
        0: (1.3 + 1.469693845669907j, 1.3 + 1.7235329194992128j),
        15: (1.8348643675799137 + 1.4814988116233125j, 1.9312467953239394 + 1.7176236617394969j),
        90: (1.4180796646955087 + 1.4889274635128138j, 1.5763714880319104 + 1.742194380851056j),
        240: (0.1764563161811858 + 0.4727825930166636j, 0.04942274512054495 + 0.7808226320981813j),
        330: (0.4263640681328359 + 0.9341192105027565j, 0.2807395841836139 + 1.1478885541142156j),
    }
    for degrees, (b, e) in places.items():
        yield m.xy("B")[degrees // 15], b
        yield m.xy("E")[degrees // 15], e
    yield m.xy("D") - m.xy("C"), (1.6 - m.xy("A")) / 2  # midline of the triangle A, B, O4


@law("watt_durango", 24)
def watts_six_bar_from_its_start(m):
    """Positions of B and E from an independent program, from 120 deg on."""
    places = {
        120: (0.923543683818814 + 1.3388079968011017j, 1.050577254879455 + 1.6468480358826199j),
        180: (0.3 + 0.7483314773547883j, 0.3 + 1.1340999463559274j),
        270: (0.18192033530449148 + 0.4889274635128137j, 0.023628511968090016 + 0.7421943808510563j),
        360: (1.3 + 1.469693845669907j, 1.3 + 1.7235329194992128j),
        390: (2.039661335651603 + 1.434119210502756j, 2.185285819600825 + 1.6478885541142154j),
    }
    for degrees, (b, e) in places.items():
        yield m.xy("B")[(degrees - 120) // 15], b
        yield m.xy("E")[(degrees - 120) // 15], e


@law("watt_2")
def two_four_bars_in_series(m):
    yield freudenstein(m, 10, 30, 20, 30), 0
    b = meet(10 * ray(m.value["motor"]), 30, 30, 20)
    c = 30 - 0.75j * (b - 30)
    yield m.xy("B"), b
    yield m.xy("C"), c
    yield m.xy("D"), meet(c, 25, 60, 20)


def stephenson_chain(b):
    """Return the positions of c, e, f and x of our Stephenson chain with a at 0, d at 80 and b given."""
    c = b * (-5 + 55j) / (20 + 35j)
    e = meet(b, abs(75 + 10j), 80, abs(15 + 45j))
    f = 80 + (e - 80) * (-10 + 75j) / (15 + 45j)
    return {"c": c, "e": e, "f": f, "x": meet(c, abs(35 + 40j), f, abs(40 - 20j))}


@law("stephenson_1")
def dyads_of_stephenson_1(m):
    for node, place in stephenson_chain(abs(20 + 35j) * ray(m.value["motor"])).items():
        yield m.xy(node), place


@law("stephenson_2")
def inversion_of_stephenson_1(m):
    """In the frame of the link a-d the coupled group is stephenson_1, a chain of dyads."""

    def seen(node):
        return (m.xy(node) - m.xy("a")) / (m.xy("d") - m.xy("a")) * 80

    for node, place in stephenson_chain(seen("b")).items():
        yield seen(node), place


PMKS_30 = {
    "C": 18.254805866503766 + 24.3695209605412j,
    "E": 10.27902484367159 + 33.610025117557214j,
    "F": 34.88184895723876 + 28.252689433014208j,
}
"""PMKS_Verification, stephenson_iii_example_2, row 0030."""


@law("stephenson_3", 30, motor=(99.46232220802563, 129.46232220802563))
@law("gim_fig13b", 3, motor=(99.46232220802563, 129.46232220802563))
def pmks_verification_at_30_degrees(m):
    for node, place in PMKS_30.items():
        yield m.xy(node)[-1], place


@law("stephenson_3_far", 720)
def range_of_the_crank_driven_from_the_far_side(m):
    """G makes a full turn; A-B moves between the limits that it has as an input (continuation with halved steps)."""
    yield extremes(np.angle(m.xy("B") - m.xy("A"))), [0.7079646291231813, 2.456845953457208], 1e-6


@law("stephenson_3_far")
def inversion_of_stephenson_3(m):
    """C and E follow from B by a dyad; F is on the driven ray."""
    c = meet(m.xy("B"), abs(20 + 9j), 23 + 10j, abs(2 + 15j))
    yield m.xy("C"), c
    yield m.xy("E"), m.xy("B") + (c - m.xy("B")) * (13 + 19j) / (20 + 9j)
    yield m.xy("F"), 45 + 17j + abs(2 - 15j) * ray(m.value["motor"])


def bar_angles(m):
    """Return the angles of the links t3, t4, b1, b2, b3 and b4 of the double butterfly in the last row.

    Six decimals are published, for t2 rotated by -67.38 deg.
    """
    pins = (("V", "U"), ("X", "W"), ("Q", "U"), ("S", "V"), ("T", "X"), ("R", "Y"))
    return np.array([angle(m.xy(b)[-1] - m.xy(a)[-1]) for a, b in pins])


@law("double_butterfly", 20, motor=(72.62, 112.62))
def real_solution_5_of_nielsen_roth_and_wampler(m):
    yield bar_angles(m), [9.338529, -130.981247, 158.033089, -157.254723, 120.062432, 62.953396], 6e-7


@law("gim_fig13c", 36, motor=(472.62, 112.62))
def real_solution_1_after_a_full_turn(m):
    yield bar_angles(m), [-167.467473, -125.129584, -169.415820, -109.625132, -66.373159, -7.367330], 6e-7


@law("double_butterfly_symmetric")
def motion_is_symmetric(m):
    """If r is the rotation of PST, the axis of symmetry is the ray from P at r/2; W is on it."""
    mirror = ray((m.value["motor"] - angle(4 - 3j)) / 2)
    for node, image in (("W", "W"), ("Q", "T"), ("R", "S"), ("U", "X"), ("V", "Y")):
        yield m.xy(image), mirror**2 * m.xy(node).conj()


@law("double_butterfly_symmetric", 20, motor=(-70, angle(4 - 3j) - 50))
def one_of_the_eight_configurations_at_50_degrees(m):
    yield m.xy("W")[-1], 8.730133771054339 * ray(-25)


@law("gim_fig11", 10)
def exact_target_of_fig_11(m):
    """Solution of an independent Newton continuation, refined to 30 digits."""
    yield m.xy("A")[-1], 59.88451811829278 + 102.82821823013627j
    yield m.xy("B")[-1], 89.80891148330772 + 136.06269854404897j
    yield m.xy("C")[-1], 223.10456359883528 + 130.3821064009487j
    yield m.xy("D")[-1], 200.0 + 44.64101615137755j
    yield m.xy("E")[-1], 192.3205080756888 + 97.94228634059948j


@law("klann", 720)
def klann_dyads_and_foot(m):
    """US patent 6,260,862, table 1, position X."""
    o9, o11, o15 = 1.366 + 1.366j, 1.009 + 0.574j, 1.599 + 0.75j
    e27, c29, k35, h37 = 0.741 + 0.75j, 1.331 + 0.75j, 0.232 + 0.866j, 0.866 + 1.5j
    c = o15 + abs(c29 - o15) * ray(m.value["motor"])
    e = meet(c, abs(e27 - c29), o11, abs(e27 - o11), -1)
    k = c + (e - c) * (k35 - c29) / (e27 - c29)
    h = meet(k, abs(h37 - k35), o9, abs(h37 - o9))
    foot = k + (h - k) * (0 - k35) / (h37 - k35)
    for node, place in (("E27", e), ("K35", k), ("H37", h), ("F33", foot)):
        yield m.xy(node), place
    yield extremes(m.xy("F33").real), [-0.00110577302603015, 1.007738670829463], 2e-4  # sampled
    yield extremes(m.xy("F33").imag), [-0.04878582581935852, 0.4786215585514486], 2e-4


@law("jansen")
def jansen_holy_numbers(m):
    g, j1 = -38 - 7.8j, 15 * ray(m.value["motor"])
    j2, j4 = meet(j1, 50, g, 41.5, -1), meet(j1, 61.9, g, 39.3)
    j3 = meet(g, 40.1, j2, 55.8)
    j5 = meet(j3, 39.4, j4, 36.7, -1)
    foot = meet(j4, 49, j5, 65.7)
    for node, place in (("J2", j2), ("J3", j3), ("J4", j4), ("J5", j5), ("foot", foot)):
        yield m.xy(node), place
    yield m.xy("foot")[90], -7.689066230641657 - 90.3893513674043j
    yield extremes(m.xy("foot").real), [-71.52153133755338, -3.6131872627722625], 5e-3  # sampled
    yield extremes(m.xy("foot").imag), [-91.8338848958987, -69.37693907270443], 5e-3


@law("pantograph")
def copy_at_half_size(m):
    r = 1.2 * ray(m.value["motor"])
    yield m.xy("T"), meet(r, 2.2, meet(r, 3.5, 4, 2.5), 2.2)
    yield m.xy("T") + 5 - 2j, 2 * (m.xy("P") + 5 - 2j)
    reach = extremes(abs(m.xy("T") + 5 - 2j))
    yield reach, [4.716030783106435, 6.831024431708834], 2e-3  # sampled at 1 deg
    yield reach, [4.72, 6.83], 5e-3  # PMKS-Web


@law("five_bar")
def dyad_of_two_motors(m):
    b1, b2 = -2 + 5 * ray(m.value["motor_1"]), 2 + 5 * ray(m.value["motor_2"])
    yield m.xy("P"), meet(b1, 6, b2, 6)


# --- gears, belts, racks and actuators that follow others ------------------------------------------------


@law("geared_five_bar")
def dyad_of_two_geared_cranks(m):
    q = m.value["motor"]
    yield m.xy("P"), meet(25 * ray(q), 86, 60 + 15 * ray(90 - 2 * q), 62)


@law("cardan_gear")
def line_and_ellipse_of_cardan(m):
    q = np.radians(m.value["motor"])
    yield m.xy("T"), 80 * np.cos(q)
    yield m.xy("E"), 60 * np.cos(q) + 20j * np.sin(q)


@law("planetary_gear")
def train_of_willis(m):
    arm = m.value["motor"] * 20 / (20 + 60)
    yield m.xy("P"), 40 * ray(arm)
    yield m.xy("M"), 40 * ray(arm) + 20 * ray(arm - 60 / 20 * arm)  # relative to the arm, the ring turns by -arm


@law("belt_drive", 720)
def wheels_in_series(m):
    shaft = m.value["motor"] * 25 / 75
    crank = 400 - 120j + 30 * ray(shaft * 15 / 30)
    yield m.xy("s"), 220 + 60 * ray(90 + shaft)
    yield m.xy("r"), 380 + 120j + 40 * ray(90 - shaft)
    yield m.xy("f"), 640 - 120j + 25 * ray(90 + 6 * shaft / 2)
    yield m.xy("c"), crank
    yield m.xy("T"), crank.real + np.sqrt(140**2 - (crank.imag + 200) ** 2) - 200j


@law("rack_lift")
def rise_by_the_arc_of_the_pinion(m):
    yield m.xy("W"), 150 + 150j + 30j * np.radians(m.value["motor"])
    yield m.xy("A"), 30 * ray(m.value["motor"])


@law("deltoid")
def curve_of_steiner(m):
    z = m.xy("P") / 50
    yield z, 2 * ray(m.value["motor"]) + ray(-2 * m.value["motor"])
    square = abs(z) ** 2
    yield square**2 + 18 * square - 27, 8 * (z**3).real


PLATFORM = np.array([0, 17.04, 13.236373239436618 + 16.096708466836507j])
PLATFORM_GOAL = -14 + 6j + PLATFORM * ray(20)
RAMS = abs(PLATFORM_GOAL - [0, 15.91, 10j])


@law("innocenti_group", 50)
def innocenti_loops(m):
    """The three published loop equations, with the published lengths of the vectors."""
    a0, b0, c0 = 0.7 + 0.2j, 0.6, 0.5 - 0.5j
    plate_2, plate_5 = (m.xy("Q") - m.xy("P")) / 0.8, (m.xy("T") - m.xy("R")) / 0.8
    t1, t3, t4, t6 = (m.xy(b) - m.xy(a) for a, b in (("A0", "P"), ("A1", "Q"), ("A2", "T"), ("A3", "V")))
    for vector, length in ((t1, m.value["ram"]), (t3, 0.4), (t4, 0.6), (t6, 0.9), (plate_2, 1), (plate_5, 1)):
        yield abs(vector), length
    yield t1 + 0.8 * plate_2 - t3, a0
    yield (0.6 + 0.5j) * plate_2 + t3 - t4 + 0.8 * plate_5, b0
    yield t4 + (0.4 + 0.3j) * plate_5 - t6, c0


@law("platform_3rpr", 40, ram_1=(14.98, RAMS[0]), ram_2=(15.38, RAMS[1]), ram_3=(12, RAMS[2]))
def forward_after_inverse_of_the_rams(m):
    """The lengths follow in closed form from the position of the platform; the first row is Innocenti's."""
    b = np.array([m.xy("B1"), m.xy("B2"), m.xy("B3")])
    yield b[0, 0], -14.896128100172762 + 1.582961661962616j
    yield b[1, 0], 1.6337317844182702 + 5.721238138442663j
    yield b[:, -1], PLATFORM_GOAL


def motors(place, turn):
    """Return the motor angles of the 3-RRR for a position of its platform (inverse kinematics)."""
    hubs, corners = 10 * ray([210, -30, 90]), 3 * ray([210, -30, 90])
    return angle(meet(hubs, 6, place + corners * np.exp(1j * turn), 6) - hubs)


MOTORS = np.transpose([motors(0.5 + 0.3j, 0.2), motors(-1 + 1j, -0.2)])


@law("platform_3rrr", 40, **{f"motor_{k}": tuple(pair) for k, pair in enumerate(MOTORS)})
def forward_after_inverse_of_the_motors(m):
    for row, place, turn in ((0, 0.5 + 0.3j, 0.2), (-1, -1 + 1j, -0.2)):
        yield m.xy("M")[row], place
        yield np.angle(m.xy("C1") - m.xy("C0"))[row], turn


@law("floating_hexagon")
def cosine_law_of_the_arms(m):
    rod2 = 3**2 + 3.2**2 - 2 * 3 * 3.2 * np.cos(np.radians(140))
    for k in range(3):
        pivot, rho = 3 * ray(120 * k), m.value[f"cylinder_{k}"]
        arm = ray(120 * k + 120) * np.exp(-1j * np.arccos((9 + rho**2 - rod2) / (6 * rho)))
        yield m.xy(f"S{k}"), pivot + rho * arm
        yield m.xy(f"E{k}"), pivot + 5 * arm
        yield m.xy(f"M{k}"), pivot + (2.5 + 0.8j) * arm


@law("scissor_lift")
def height_of_three_stages(m):
    w = m.value["ram"]
    stage = 1j * np.sqrt(4 - w**2)
    for k in (1, 2, 3):
        yield m.xy(f"L{k}"), k * stage
        yield m.xy(f"R{k}"), k * stage + w
        yield m.xy(f"C{k}"), (k - 0.5) * stage + w / 2


@law("snap_hinge")
def four_bar_with_a_snap(m):
    a = 20 * ray(m.value["motor"])
    yield m.xy("A"), a
    yield m.xy("B"), meet(a, 70, 60, 90)


RAMS_DRAWN = {
    "boom_ram": (167.59189718837808, 167.59189718837808),
    "arm_ram": (158.12019819610975, 158.12019819610975),
    "bucket_ram": (145.92052263929662, 145.92052263929662),
}


@law("excavator", 20, **RAMS_DRAWN | {"boom_ram": (167.59189718837808, 187.59189718837808)})
def boom_ram_out_by_20_cm(m):
    """Independent Newton solution."""
    yield m.xy("H")[-1], 231.09031855442393 + 307.3068737767102j
    yield m.xy("J")[-1], 405.25470852243024 + 334.94257253405925j
    yield m.xy("tip")[-1], 500.008223039923 + 212.5402660970621j
    ce, cd, de = abs(m.xy("E")), abs(m.xy("D")), m.value["boom_ram"]
    swing = angle(m.xy("E") / m.xy("D"))
    yield ce**2 + cd**2 - 2 * ce * cd * np.cos(np.radians(swing)), de**2, 1e-6


@law("dixon_k33")
def dixons_first_motion(m):
    """On the two axes: x_i(t) = sgn sqrt(a_i^2 + t), y_j(t) = sgn sqrt(b_j^2 - t); t from Y0-Y1."""
    d = abs(m.xy("Y1") - m.xy("Y0"))
    t = 1.5**2 - ((d - (2**2 - 1.5**2) / d) / 2) ** 2
    x = [s * np.sqrt(a**2 + t) for s, a in ((1, 1), (1, 2.5), (-1, 3))]
    y = [s * np.sqrt(b**2 - t) for s, b in ((1, 1.5), (-1, 2), (1, 4))]
    frame = (1.5j - 1) / (1j * y[0] - x[0])
    for k in (0, 1, 2):
        yield m.xy(f"X{k}"), 1 + frame * (x[k] - x[0])
        yield m.xy(f"Y{k}"), 1 + frame * (1j * y[k] - x[0])


@pytest.mark.parametrize(
    ("model", "function", "steps", "laws"), LAWS, ids=[f"{row[0]}-{row[1].__name__}" for row in LAWS]
)
def test_law(model, function, steps, laws, trace_model):
    m = trace_model(model, steps=steps, laws=laws)
    assert set(m.status) == {"ok"}
    for found, expected, *tolerance in function(m):
        assert np.max(abs(np.asarray(found) - expected)) <= (tolerance or [1e-9 * size(model)])[0]


# --- velocities and accelerations as differences of positions --------------------------------------------

RATES = [
    # model, {actuator: (value, rate)} in deg and rad/s or lengths, time step, {node: (velocity,
    # acceleration)}
    ("crank_rocker", {"motor": (40, 25)}, 6e-4, {  # Norton, examples 6-7 and 7-1 (alpha = 0 here)
        "A": (-642.7876096865394 + 766.0444431189781j, -625 * 40 * ray(40)),
        "B": (-471.2416927790724 + 302.24290010676293j, -33490.9613496976 + 16825.9734796957j),
    }),
    ("stephenson_3", {"motor": (99.46232220802563, np.pi / 3)}, 0.02, {  # PMKS_Verification, row 0000
        "C": (-14.371115330251182 + 1.9161487107001576j, 1.7132148670250689 - 14.24180076339657j),
        "E": (-16.37638723679786 + 0.5124583761174841j, 2.354906866810082 - 14.391762561005676j),
        "F": (-16.705164880012152 - 2.2273553173349536j, 1.5296161164289317 - 18.730960876346256j),
    }),
    ("stephenson_3", {"motor": (129.46232220802563, np.pi / 3)}, 0.01, {  # PMKS_Verification, row 0030
        "C": (-12.189616867829285 - 4.0253324108455j, 6.708713220946628 - 9.252633692384368j),
        "F": (-16.068402638970756 - 14.448325965525129j, -4.598648204940684 - 45.63153606619353j),
    }),
    ("antiparallelogram", {"motor": (60, 1)}, 0.02, {
        "B": (-1.1311352212694712 + 0.16326530612244866j, 1.0262390670553905 + 1.171532907743382j),
    }),
    ("crank_shaper", {"motor": (60, 1)}, 0.02, {
        "D": (-1.271913261764283 + 0.22189497345082615j, -0.23663303302950262 - 0.3817622010133271j),
    }),
    ("gim_fig13a", {"motor": (60.25511870305778, 1)}, 0.02, {
        "C": (-30.90909090909092 + 7.727272727272716j, -30.82769847232679 - 9.211119459053661j),
    }),
    ("peaucellier", {"motor": (60, 1)}, 0.02, {
        "A": (-1.5918767291002942 + 1.0173688171390374j, 1.0078942237748587 - 1.4912960322194433j),
        "Q": (3.125j, 1.8042195912175802j),
    }),
    ("stephenson_1", {"motor": (60.25511870305778, 1)}, 0.02, {
        "e": (-33.83720930232562 + 11.279069767441888j, -22.949321024144638 - 20.620762951689848j),
        "x": (-55.09437141894204 - 4.917425008425891j, -14.434883968694624 - 37.99486964224094j),
    }),
    ("stephenson_2", {"motor": (-26.56505117707799, 1)}, 1e-4, {  # close to its limit
        "a": (-814 - 74j, -128548.86480005344 + 460.50319999741623j),
        "e": (-313.6 - 238j, -54040.327520021776 - 38694.507600017096j),
    }),
    ("watt_2", {"motor": (60, 10)}, 2e-3, {
        "B": (-70.69595132934194 + 10.204081632653077j, -858.6005830903862 - 133.81733644482577j),
        "D": (80.92459173158784 + 12.690734291191694j, 860.9295968012804 - 204.5800796791624j),
    }),
    ("jansen", {"motor": (0, 1)}, 0.02, {
        "J3": (-3.812276928334724 - 8.798144184810491j, -1.152957593682136 - 8.42762999519408j),
        "foot": (22.554390653830186 + 0.040514300780157254j, 4.322192851473392 - 0.9624260011217016j),
    }),
    ("double_butterfly", {"motor": (112.61986494804043, 1)}, 0.01, {
        "U": (-1.4645178053931383 - 3.630835701147477j, -0.3195310296485894 - 4.517227318096624j),
        "W": (0.31823075540735135 - 1.7712507976629857j, 3.215636822616744 - 2.7475846819621177j),
        "Y": (-0.7521991617125827 + 0.384035773310794j, 1.2863444502546653 - 0.7234834182457486j),
    }),
    ("ten_bar", {"motor": (-45, 1)}, 0.01, {
        "j9": (23.346867112916463 - 42.72358169647966j, -11.596780782419081 + 37.71737050924643j),
        "j10": (-28.482387797653338 - 1.2601777680237836j, 34.23263976606571 - 87.0558765279228j),
        "j12": (-22.741139032153093 - 17.05585427411485j, 71.73767839373907 + 33.601719557815045j),
    }),
    ("five_bar", {"motor_1": (130, 1), "motor_2": (60, -0.5)}, 0.02, {
        "P": (-1.2124893469053892 - 6.470355758659061j, 2.6893296453828768 - 7.821377002831312j),
    }),
    ("excavator", {name: (value, 1) for name, (value, _) in RAMS_DRAWN.items()}, 0.5, {
        "M": (-3.776728323822662 + 6.17736039195628j, -0.09968649139574456 + 0.0040786022273111185j),
        "J": (-3.0354834233949686 + 5.290885042257759j, -0.13468199734841071 - 0.02427569520215588j),
        "tip": (-6.603358181383883 + 5.0353277987728555j, -0.1312075617343238 + 0.0915830888245725j),
    }),
]  # fmt: skip
"""Published values if a source is named; otherwise from truncated power series of an independent program."""


@pytest.mark.parametrize(("model", "inputs", "step", "nodes"), RATES, ids=[row[0] for row in RATES])
def test_positions_have_the_known_velocities_and_accelerations(model, inputs, step, nodes, trace_model):
    ends = {}
    for name, (value, rate) in inputs.items():
        reach = 4 * step * (np.degrees(rate) if "pivot" in read(model)["actuators"][name] else rate)
        ends[name] = (value - reach, value + reach)
    m = trace_model(model, steps=8, laws=uniform(ends), tolerance=1e-13)
    found = np.array([rates(m.xy(node), step) for node in nodes])
    expected = np.array(list(nodes.values()))
    error = np.max(abs(found - expected), axis=0) / np.max(abs(expected), axis=0)
    assert error[0] <= 1e-8
    assert error[1] <= 1e-6
