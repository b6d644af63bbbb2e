"""Kept quantities and solved rows of whole sweeps against circles, the law of cosines and a Newton iteration."""

import numpy as np
import pytest
from bundled import MODELS
from circles import closes, dyad, four_bar, four_bar_rows

import gimcli

FOUR_BAR = """
units: {length: mm, angle: deg}
nodes: {O: [0, 0], O4: [6, 0], A: [1.7320508075688772, 1], B: [2.5, 8]}
ground: [O, O4]
links: {crank: {nodes: [O, A], length: 2}, rod: {nodes: [A, B], length: 7}, rocker: {nodes: [O4, B], length: 9}}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {from: 30, to: 390}}}
points: {P: {on: rod, local: [3, 2]}}
trace: [P]
"""

SLIDER_CRANK = """
units: {length: mm, angle: deg}
parameters: {e: 20, r: 40, l: 120, u: 2*r/3}
nodes: {O: [0, 0], A: ["r*cos(60*deg)", "r*sin(60*deg)"], B: [139.1, e], G: [50, e], H: [200, e]}
ground: [O, G, H]
links: {crank: {nodes: [O, A], length: r}, rod: {nodes: [A, B], length: l}}
prismatic: {slide: {node: B, guide: [G, H]}}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {from: 60, to: 420}}}
points: {P: {on: rod, local: [u, l/4]}}
"""


def swept(model, vary, keep, count):
    """Return the varied numbers (designs, dimensions), the kept numbers (designs, quantities) and the solved rows."""
    found = gimcli.sweep(model, vary, samples=count, seed=5, keep=["solved", *keep])
    varied = np.array([found[name] for name in vary]).T
    return varied, np.array([found[text] for text in keep]).T, found["solved"]


def degrees(directions):
    return np.degrees(np.unwrap(np.angle(directions)))


def statistics(values):
    return [np.min(values), np.max(values), np.ptp(values), np.mean(values), np.sqrt(np.mean(values**2))]


def texts(column):
    return [f"{word}({column})" for word in ("min", "max", "range", "mean", "rms")]


def test_four_bars():
    m = gimcli.loads(FOUR_BAR)
    bounds = {"O4.x": (3, 9), "crank": (1, 6), "rod": (4, 10), "rocker": (4, 10), "P.x": (-3, 5), "P.y": (-3, 4)}
    vary = {k if "." in k else f"{k}.length": f"uniform({low},{high})" for k, (low, high) in bounds.items()}
    keep = [
        *texts("P.x"),
        *texts("rocker.angle"),
        *texts("transmission"),
        "at(P.y, motor=200)",
        "max(P.x)/crank.length",
    ]
    designs, kept, solved = swept(m, vary, keep, 400)
    rows = np.radians(np.linspace(30, 390, 73))
    for design, own, count in zip(designs, kept, solved, strict=True):
        lengths, (u, v) = design[:4], design[4:]
        assert count == four_bar_rows(*lengths, rows)
        if not count:
            assert np.isnan(own).all()
            continue
        a, b, p = four_bar(*lengths, u, v, rows[: int(count)])
        rocker = b - lengths[0]
        transmission = np.degrees(np.abs(np.angle((a - b) / -rocker)))
        there = four_bar(*lengths, u, v, np.radians([200.0]))[2].imag[0]
        expected = [*statistics(p.real), *statistics(degrees(rocker)), *statistics(transmission)]
        expected += [there if closes(*lengths, rows[0], np.radians(200.0)) else np.nan, p.real.max() / lengths[1]]
        assert own == pytest.approx(expected, rel=1e-9, abs=1e-9, nan_ok=True)
    assert len(set(solved)) > 10


def test_slider_cranks_with_parameters():
    m = gimcli.loads(SLIDER_CRANK)
    vary = {"r": "uniform(10,90)", "l": "uniform(30,150)", "e": "uniform(-30,40)"}
    designs, kept, solved = swept(m, vary, [*texts("P.y"), *texts("rod.angle"), "max(B.x)/l - r/l"], 300)
    rows = np.radians(np.linspace(60, 420, 73))
    fine = np.radians(np.linspace(60, 420, 72 * 200 + 1))
    for (r, long, e), own, count in zip(designs, kept, solved, strict=True):
        beyond = np.abs(r * np.sin(fine) - e) > long
        assert count == (-(-np.argmax(beyond) // 200) if beyond.any() else 73)
        if not count:
            continue
        a = r * np.exp(1j * rows[: int(count)])
        rod = np.sqrt(long**2 - (a.imag - e) ** 2) + 1j * (e - a.imag)
        p = a + rod / long * (2 * r / 3 + 0.25j * long)
        expected = [*statistics(p.imag), *statistics(degrees(rod)), (a + rod).real.max() / long - r / long]
        assert own == pytest.approx(expected, rel=1e-9, abs=1e-9)


def jansen(lengths, angles):
    """Return foot, J5 and the leg g of Jansen legs by circles, and whether all dyads close."""
    m, j, k, c, f, g = lengths
    pivot, crank = -38 - 7.8j, m * np.exp(1j * angles)
    upper, one = dyad(crank, j, pivot, 41.5, -1)
    lower, two = dyad(crank, k, pivot, c, 1)
    corner = pivot + (2.6098795180722933 + 40.01497880670621j) / 41.5 * (upper - pivot)
    heel, three = dyad(corner, f, lower, g, -1)
    leg = (heel - lower) / g
    return lower + leg * (-7.746594005449595 + 48.38378118041967j), heel, leg, one & two & three


def test_jansen_legs():
    nominal = {"m": 15, "j": 50, "k": 61.9, "c": 39.3, "f": 39.4, "g": 36.7}
    vary = {f"{k}.length": f"uniform({0.9 * x},{1.1 * x})" for k, x in nominal.items()}
    m = gimcli.load(MODELS / "jansen.yaml")
    designs, kept, solved = swept(m, vary, [*texts("foot.x"), *texts("J5.y"), *texts("g.angle")], 150)
    fine = np.radians(np.linspace(0, 360, 72 * 200 + 1))
    for lengths, own, count in zip(designs, kept, solved, strict=True):
        foot, heel, leg, closed = jansen(lengths, fine)
        assert count == (73 if closed.all() else -(-np.argmin(closed) // 200))
        if count:
            n = int(count) * 200
            expected = [
                *statistics(foot.real[:n:200]),
                *statistics(heel.imag[:n:200]),
                *statistics(degrees(leg[:n:200])),
            ]
            assert own == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert 0 < np.count_nonzero(solved == 73) < 150


def distances(free, pairs, lengths, fixed, guess):
    """Return the coordinates of free points at given distances in pairs, by Newton's method from a guess."""
    z = dict(fixed)
    for _ in range(20):
        z.update(zip(free, guess[::2] + 1j * guess[1::2], strict=True))
        f, jacobian = np.zeros(len(pairs)), np.zeros((len(pairs), 2 * len(free)))
        for k, ((p, q), length) in enumerate(zip(pairs, lengths, strict=True)):
            d = z[p] - z[q]
            f[k] = (abs(d) ** 2 - length**2) / 2
            for point, sign in ((p, 1), (q, -1)):
                if point in free:
                    i = 2 * free.index(point)
                    jacobian[k, i : i + 2] = sign * d.real, sign * d.imag
        guess = guess - np.linalg.solve(jacobian, f)
    assert np.abs(f).max() < 1e-10
    return guess


def test_platforms_of_three_legs():
    m = gimcli.load(MODELS / "platform_3rrr.yaml")
    vary = {"distal_0.length": "uniform(5.5,6.5)", "A0.x": "uniform(-9.2,-8.2)", "motor_0.to": "uniform(55,66)"}
    designs, kept, solved = swept(m, vary, [*texts("M.x"), *texts("platform.angle")], 12)
    shape = np.array([0, 5.196152422706632, 2.598076211353316 + 4.5j])
    sides = [abs(shape[k] - shape[k - 1]) for k in range(3)]
    pairs = [*((f"B{k}", f"C{k}") for k in range(3)), *((f"C{k}", f"C{(k - 1) % 3}") for k in range(3))]
    drawn = np.array([-1.7483, -1.6863, 3.3443, -0.6539, -0.0960, 3.2402])
    assert (solved == 73).all()
    for (leg, pivot, to), own in zip(designs, kept, strict=True):
        place, rows = drawn, []
        for s in np.arange(73) / 72:
            angles = np.radians([76 + (to - 76) * s, -164 + 14 * s, -35 - 15 * s])
            b = np.array([pivot - 5j, 8.660254037844386 - 5j, 10j]) + 6 * np.exp(1j * angles)
            fixed = {f"B{k}": b[k] for k in range(3)}
            place = distances(["C0", "C1", "C2"], pairs, [leg, 6, 6, *sides], fixed, place)
            rows.append(place[::2] + 1j * place[1::2])
        c = np.array(rows).T
        along = (c[1] - c[0]) / shape[1]
        middle = c[0] + along * (2.598076211353316 + 1.5j)
        assert own == pytest.approx([*statistics(middle.real), *statistics(degrees(along))], rel=1e-9, abs=1e-9)
