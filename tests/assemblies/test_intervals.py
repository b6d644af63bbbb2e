"""Interval branch and prune: all real solutions, with a proof of completeness."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from bundled import MODELS
from linkage_loops import framework, loops_of, random_loops
from other_searches import (
    configurations_by_starts,
    configurations_proved,
    distinct,
    platform_angles,
    unmatched,
)

from gimcli import load
from gimcli.assemblies.cosine_rows import RowConstants, contract, cosine_rows
from gimcli.assemblies.intervals import CONSTANTS, IntervalConstants, proved_reach, real_roots
from gimcli.assemblies.krawczyk import image, local, narrow
from gimcli.assemblies.loops import Coefficients

TURN = 2 * np.pi


def wrapped(angle):
    return (np.asarray(angle) + np.pi) % TURN - np.pi


def apart(a, b, angles):
    """Return the largest coordinate distance of points, angles modulo a turn."""
    d = np.abs(np.asarray(a) - b)
    d[..., :angles] = np.abs(wrapped(d[..., :angles]))
    return d


def same(found, expected, angles, tolerance):
    """Return whether two lists contain the same points in any order."""
    found, expected = np.atleast_2d(found), np.atleast_2d(expected)
    if len(found) != len(expected):
        return False
    near = (apart(found[:, None], expected[None], angles) <= tolerance).all(axis=2)
    return bool((near.sum(axis=0) == 1).all() and (near.sum(axis=1) == 1).all())


def contains(result, x, angles):
    """Return whether a solution is in an enclosure or an undecided box, except for rounding of the point itself."""
    slack = 1e-12 * (1 + np.abs(x))
    if (apart(result.roots, x, angles) <= result.radius + slack).all(axis=1).any():
        return True
    middle, half = result.undecided.mean(axis=1), 0.5 * (result.undecided[:, 1] - result.undecided[:, 0])
    return bool((apart(middle, x, angles) <= half + slack).all(axis=1).any())


def searched(C0, C, U, rail, reach=np.inf, constants=None):
    """Return the real solutions of loops."""
    arrays = np.array(C0, complex), np.array(C, complex), np.reshape(U, (len(C0), -1)), np.array(rail, dtype=int)
    return real_roots(Coefficients(*arrays), reach, constants)


def two_bars(d, b, c):
    """Return the coefficients of b θ_1 - c θ_2 = d, a four-bar at a given input."""
    return np.array([-d]), np.array([[b, -c]], dtype=complex), [], []


def two_bars_solved(d, b, c):
    """Return the solutions by the law of cosines."""
    cosine = (b * b + abs(d) ** 2 - c * c) / (2 * b * abs(d))
    if abs(cosine) > 1:
        return np.zeros((0, 2))
    first = np.angle(d) + np.array([1, -1]) * np.arccos(cosine)
    return np.column_stack([first, np.angle(b * np.exp(1j * first) - d)])


# ------------------------------------------------------------------ closed forms


def test_four_bars_agree_with_the_law_of_cosines():
    rng, counts = np.random.default_rng(1), set()
    for _ in range(150):
        a, b, c, g = rng.uniform(0.3, 3.0, 4)
        d = g - a * np.exp(1j * rng.uniform(0, TURN))
        result, expected = searched(*two_bars(d, b, c), 1.0), two_bars_solved(d, b, c)
        assert result.complete
        assert same(result.roots, expected, 2, 1e-9), (d, b, c)
        counts.add(len(expected))
    assert counts == {0, 2}


def test_slider_cranks_agree_with_the_theorem_of_pythagoras():
    rng, counts = np.random.default_rng(2), set()
    for _ in range(150):
        start, b, h = rng.normal() + 1j * rng.normal(), rng.uniform(0.2, 2.0), rng.normal()
        along = np.exp(1j * rng.uniform(0, TURN))  # start + b θ = along (s + i h)
        relative = start * np.conj(along)
        rise = h - relative.imag
        roots = relative.real + np.sqrt(b * b - rise * rise) * np.array([1, -1]) if abs(rise) < b else np.zeros(0)
        roots = roots[np.abs(roots) <= 1.5]
        angle = np.angle(along * (roots + 1j * h) - start)
        loops = np.array([start - 1j * along * h]), np.array([[b]]), np.array([[-along]]), [-1]
        result = searched(*loops, 1.5)
        assert result.complete
        assert same(result.roots, np.column_stack([angle, roots]), 1, 1e-9)
        counts.add(len(roots))
    assert counts == {0, 1, 2}


def test_a_block_on_a_turning_rail():
    """d = (s + i e) θ has the solutions s = ± sqrt(|d|² - e²)."""
    rng = np.random.default_rng(3)
    for _ in range(60):
        d, e = rng.normal() + 1j * rng.normal(), rng.uniform(0, 1)
        result = searched(np.array([-d]), np.array([[1j * e]]), np.array([[1.0]]), [0], 5.0)
        s = np.sqrt(abs(d) ** 2 - e * e) * np.array([1, -1]) if abs(d) > e else np.zeros(0)
        assert result.complete
        assert same(result.roots, np.column_stack([np.angle(d / (s + 1j * e)), s]), 1, 1e-8)


def test_two_slides_agree_with_the_linear_solution():
    loops = np.array([0.3 - 0.4j]), np.zeros((1, 0)), np.array([[1.0, 1j]]), [-1, -1]
    result = searched(*loops, 1.0)
    assert result.complete
    assert same(result.roots, [[-0.3, 0.4]], 0, 1e-12)
    assert len(searched(*loops, [0.2, 1.0]).roots) == 0


def test_a_slide_just_out_of_reach_is_not_listed():
    along, b, h = np.exp(0.4j), 1.3, 0.5  # b θ = along (s + i h): s = ± 1.2
    loops = np.array([-1j * along * h]), np.array([[b]]), np.array([[-along]]), [-1]
    for gap in (1e-2, 1e-5, 1e-9, 1e-12):
        assert len(searched(*loops, 1.2 + gap).roots) == 2
        assert len(searched(*loops, 1.2 - gap).roots) == 0


def test_the_reach_limits_the_list():
    for seed in range(40):
        *coefficients, x = random_loops(2, 1, np.random.default_rng((12, seed)))
        roots = searched(*coefficients, 7.0).roots
        reach = abs(x[3]) * (1 + (1e-3 if seed % 2 else -1e-3))
        cut = searched(*coefficients, reach)
        assert cut.complete
        assert same(cut.roots, roots[np.abs(roots[:, 3]) <= reach], 3, 1e-8)


@pytest.mark.parametrize("angle", [CONSTANTS.seam, CONSTANTS.seam + 1e-13, CONSTANTS.seam - np.pi, np.pi, 0.0])
def test_solutions_where_the_circle_is_cut_open(angle):
    for other in (0.3, CONSTANTS.seam, np.pi, angle + CONSTANTS.cut * TURN):
        d = 2 * np.exp(1j * angle) - 1.5 * np.exp(1j * other)
        result = searched(*two_bars(d, 2.0, 1.5), 1.0)
        if 0.51 < abs(d) < 3.49:
            assert result.complete
            assert len(result.roots) == 2
        assert contains(result, np.array([angle, other]), 2)


# ------------------------------------------------------------------ published cases

# Wampler 2001; Waldron & Sreenivasan 1996: six real configurations, [deg]; t3 t4 b1 b2 b3 b4
BUTTERFLY = [
    [-167.467473, -125.129584, -169.415820, -109.625132, -66.373159, -7.367330],
    [-159.190457, 50.207952, 90.802105, 33.420510, -19.448727, 25.064013],
    [-80.024075, 176.216212, -168.876684, -135.793781, -44.618221, -7.589980],
    [-57.404022, -60.480688, 179.936230, -149.499001, 146.441212, 75.957534],
    [9.338529, -130.981247, 158.033089, -157.254723, 120.062432, 62.953396],
    [29.697645, 74.338361, 52.187355, 0.612784, -9.412867, 25.597619],
]


def double_butterfly(turn):
    """Return the loops, the frame turned relative to the second triangle by a given angle [rad]."""
    second = np.exp(1j * turn)
    corner = -5.6 + 4.2j
    links = [
        {"Q": 0, "R": -13, "T": corner - 2 * second, "S": corner + (-2.4 + 1.8j) * second},
        {"U": 0, "V": -3, "W": -3 + 4j},
        {"W": 0, "X": -6, "Y": -6.46 + 2.69j},
        {"Q": 0, "U": 11},
        {"S": 0, "V": 9},
        {"T": 0, "X": 7},
        {"R": 0, "Y": 12},
    ]
    bars = [(0, "Q", 3, "Q"), (3, "U", 1, "U"), (0, "S", 4, "S"), (4, "V", 1, "V"), (1, "W", 2, "W")]
    return loops_of(links, [*bars, (0, "T", 5, "T"), (5, "X", 2, "X"), (0, "R", 6, "R"), (6, "Y", 2, "Y")])


def test_the_double_butterfly_agrees_with_all_printed_digits():
    result = searched(*double_butterfly(np.radians(-67.38)), 1.0)
    assert result.complete
    assert same(np.degrees(result.roots), np.array(BUTTERFLY), 0, 0.6e-6)
    assert result.boxes < 250  # the number that a simple form of the method needs for two loops


def innocenti():
    """Return the coefficients of a seven-link group with a quaternary link and the dimensions of Innocenti."""
    C = np.zeros((3, 6), dtype=complex)
    C[0, [0, 1, 2]] = 0.7, 0.8, -0.4
    C[1, [1, 2, 3, 4]] = 0.6 + 0.5j, 0.4, -0.6, 0.8
    C[2, [3, 4, 5]] = 0.6, 0.4 + 0.3j, -0.9
    return -np.array([0.7 + 0.2j, 0.6, 0.5 - 0.5j]), C, [], []


def test_innocenti_group_has_eight_real_solutions():
    result = searched(*innocenti(), 1.0)
    assert result.complete
    assert len(result.roots) == 8
    C0, C, _, _ = innocenti()
    assert np.abs(C0 + np.exp(1j * result.roots) @ C.T).max() < 1e-13


def platform(base, plate, legs):
    """Return the coefficients of a 3-RPR platform with given leg lengths; the angle of the plate comes first."""
    links = [dict(zip("abc", base, strict=True)), dict(zip("ABC", plate, strict=True))]
    links += [{k: 0.0, k.upper(): leg} for k, leg in zip("abc", legs, strict=True)]
    joints = [j for i, k in enumerate("abc") for j in ((0, k, 2 + i, k), (2 + i, k.upper(), 1, k.upper()))]
    return loops_of(links, joints)


def triangle(ab, bc, ca):
    x = (ab**2 + ca**2 - bc**2) / (2 * ab)
    return [0.0, ab, x + 1j * np.sqrt(ca**2 - x**2)]


def test_platform_of_innocenti_and_parenti_castelli_has_six_assemblies():
    """Angles as published with the geometry (CuikSuite, 3RPR)."""
    loops = platform([0, 15.91, 10j], triangle(17.04, 16.54, 20.84), [14.98, 15.38, 12.0])
    result = searched(*loops, 1.0)
    published = [
        14.055200800153845,
        33.55657865639533,
        -56.549458316685104,
        -2.7118877032991797,
        122.20641822692713,
        57.41257924585026,
    ]
    assert result.complete
    assert np.degrees(result.roots[:, 0]) == pytest.approx(sorted(published), abs=1e-9)


def test_collinear_platforms_have_at_most_four():
    """Source: Gosselin & Merlet, The direct kinematics of planar parallel manipulators, 1994."""
    rng, counts = np.random.default_rng(5), set()
    for _ in range(30):
        base, plate = rng.normal(size=3), rng.normal(size=3)
        at, turn = rng.normal() + 1j * rng.normal(), np.exp(1j * rng.uniform(0, TURN))
        result = searched(*platform(base, plate, np.abs(at + turn * plate - base)), 1.0)
        assert result.complete
        assert contains(result, np.angle([turn, *(at + turn * plate - base)]), 4)
        counts.add(len(result.roots))
    assert counts <= {2, 4}
    assert 4 in counts


def test_equilateral_platform():
    """Four of six solutions are at infinity: two remain; at legs of 1.5 they coincide."""
    corners = np.exp(1j * TURN * np.arange(3) / 3)
    result = searched(*platform(3 * corners, 1.5 * corners, [2.0] * 3), 1.0)
    assert result.complete
    assert len(result.roots) == 2
    double = searched(*platform(3 * corners, 1.5 * corners, [1.5] * 3), 1.0)
    assert len(double.roots) == 0
    assert not double.complete
    assert contains(double, np.array([0.0, *(np.angle(-corners))]), 4)


def test_three_prism_has_24_embeddings():
    """Source: Capco et al., SIAM J. Appl. Algebra Geometry 2018."""
    bars = {(1, 2): 2, (1, 3): 2, (2, 3): 2, (1, 4): 7 / 4, (3, 6): 27 / 10, (2, 5): 197 / 100, (4, 5): 11 / 5}
    result = searched(*framework({**bars, (4, 6): 29 / 10, (5, 6): 43 / 20}), 1.0)
    assert result.complete
    assert len(result.roots) == 24


# ------------------------------------------------------------------ no solution is lost


@pytest.mark.few(2)
@pytest.mark.parametrize(("loops", "slides"), [(1, 0), (1, 1), (2, 0), (2, 1), (2, 2), (3, 0), (3, 1), (3, 3)])
def test_a_known_solution_is_never_lost(loops, slides):
    for seed in range(40):
        rng = np.random.default_rng((4, loops, slides, seed))
        *coefficients, x = random_loops(loops, slides, rng)
        result = searched(*coefficients, 3.5)
        assert result.complete
        assert contains(result, x, 2 * loops - slides), seed


def boxes_around(x, count, rng):
    """Return boxes (B, d) that contain x, also on their border, from zero width to a full turn."""
    width = 10.0 ** rng.uniform(-15, np.log10(TURN), (count, len(x)))
    share = rng.uniform(0, 1, (count, len(x)))
    share[rng.random((count, len(x))) < 0.2] = 0.0
    share[rng.random((count, len(x))) < 0.2] = 1.0
    low = x - share * width
    return np.minimum(low, x), np.maximum(low + width, x)


@pytest.mark.few(4)
@pytest.mark.parametrize("slides", [0, 1, 2])
@pytest.mark.parametrize("loops", [1, 2, 3])
def test_contraction_keeps_a_solution_in_any_box(loops, slides):
    """About a hundred thousand bounds; the known point fulfils its loops to a few units in the last place."""
    for seed in range(60 // loops):
        rng = np.random.default_rng((5, loops, slides, seed))
        C0, C, U, rail, x = random_loops(loops, slides, rng)
        reach = np.full(slides, 7.0 + TURN)
        low, high = boxes_around(x, 400, rng)
        rows = cosine_rows(C0, C, U, rail, reach, RowConstants())
        new_low, new_high = contract(rows, low.T, high.T)
        assert (new_low - x[:, None] <= 1e-15).all()
        assert (new_high - x[:, None] >= -1e-15).all()
        middle, half = 0.5 * (low + high), 0.5 * (high - low) + 1e-15
        small = (half < 0.25 * np.pi).all(axis=1)
        at = local(Coefficients(C0, C, U, rail), middle[small])
        new_low, new_high = narrow(at, middle[small], half[small])
        assert (new_low <= x + 1e-15).all()
        assert (new_high >= x - 1e-15).all()
        shrunk = (new_high - new_low).sum(axis=1) < 0.9 * 2 * half[small].sum(axis=1)
        assert shrunk.any()


@pytest.mark.parametrize("gap", [1e-1, 1e-3, 1e-5, 1e-6])
def test_two_solutions_close_together(gap):
    """In a nearly flat triangle, the angles of the first bar in the two solutions differ by `gap`."""
    b, c = 2.0, 1.5
    other = np.arcsin(b * np.sin(gap / 2) / c)
    d = np.exp(0.3j) * (b * np.cos(gap / 2) + c * np.cos(other))
    result = searched(*two_bars(d, b, -c), 1.0)
    expected = [[0.3 + gap / 2, 0.3 - other], [0.3 - gap / 2, 0.3 + other]]
    assert result.complete
    assert same(result.roots, expected, 2, 1e-2 * gap + 4e-16 / gap)
    assert (np.abs(result.roots[1] - result.roots[0]) > result.unique.max(axis=0)).all()


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6])
def test_no_box_with_two_solutions_is_proved_unique(gap):
    b, c, rng = 2.0, 1.5, np.random.default_rng(6)
    other = np.arcsin(b * np.sin(gap / 2) / c)
    d = b * np.cos(gap / 2) + c * np.cos(other)
    first, second = np.array([gap / 2, -other]), np.array([-gap / 2, other])
    share = 10.0 ** rng.uniform(-3, 3, (20000, 2, 2)) * gap
    low, high = np.minimum(first, second) - share[:, 0], np.maximum(first, second) + share[:, 1]
    C0, C, *_ = two_bars(d, b, -c)
    at = local(Coefficients(C0, C, np.zeros((1, 0)), np.zeros(0, dtype=int)), 0.5 * (low + high))
    assert not (image(at, 0.5 * (high - low)) < 0.5 * (high - low)).all(axis=1).any()
    single = np.full((1, 2), gap / 20)
    at = local(Coefficients(C0, C, np.zeros((1, 0)), np.zeros(0, dtype=int)), first[None])
    assert (image(at, single) < single).all()


def test_no_box_next_to_a_solution_is_proved():
    """The solution is just outside each box."""
    rng = np.random.default_rng(11)
    C0, C, U, rail, x = random_loops(2, 1, rng)
    half = 10.0 ** rng.uniform(-9, -2, (20000, 1)) * rng.uniform(0.2, 1.0, (20000, 4))
    middle = x + rng.uniform(-1, 1, half.shape) * half
    side = rng.integers(0, 4, len(half))
    every = np.arange(len(half))
    middle[every, side] = x[side] + 1.01 * half[every, side]
    at = local(Coefficients(C0, C, U, rail), middle)
    assert not (image(at, half) < half).all(axis=1).any()
    inside = local(Coefficients(C0, C, U, rail), x + 0.1 * half[half.max(axis=1) < 1e-4])
    small = half[half.max(axis=1) < 1e-4]
    assert (image(inside, small) < small).all(axis=1).mean() > 0.5


def test_a_double_solution_is_in_an_undecided_box():
    result = searched(*two_bars(3.5 * np.exp(0.3j), 2.0, -1.5), 1.0)
    assert not result.complete
    assert len(result.roots) == 0
    assert contains(result, np.array([0.3, 0.3]), 2)
    assert (np.abs(result.undecided - 0.3) < 1e-6).all()


def refined(C0, C, U, rail, x):
    """Return a solution corrected by Newton's method with 40 digits."""
    with mpmath.workdps(40):
        n, z = C.shape[1], [mpmath.mpf(float(v)) for v in x]

        def loops(*z):
            theta = [mpmath.mpc(mpmath.cos(v), mpmath.sin(v)) for v in z[:n]] + [mpmath.mpf(1)]
            out = []
            for k in range(len(C0)):
                f = mpmath.mpc(complex(C0[k])) + sum(mpmath.mpc(complex(C[k, c])) * theta[c] for c in range(n))
                f += sum(mpmath.mpc(complex(U[k, q])) * z[n + q] * theta[rail[q]] for q in range(len(rail)))
                out += [f.real, f.imag]
            return out

        return np.array([float(v) for v in mpmath.findroot(loops, z, tol=1e-60)])


@pytest.mark.parametrize(("loops", "slides"), [(1, 0), (1, 1), (2, 1), (3, 0)])
def test_enclosures_contain_the_solution_of_40_digits(loops, slides):
    for seed in range(6):
        *coefficients, _ = random_loops(loops, slides, np.random.default_rng((7, loops, slides, seed)))
        result = searched(*coefficients, 3.5)
        for x, radius in zip(result.roots, result.radius, strict=True):
            exact = refined(*coefficients, x)
            assert (np.abs(exact - x) <= radius).all()
            assert (radius < 1e-8).all()


# ------------------------------------------------------------------ undecided boxes


def peaucellier(difference):
    """Return Peaucellier's cell at a crank angle of 1 rad; if Q coincides with P, two of its bars can rotate."""
    P = 2 + 2 * np.exp(1j)
    links = [{"O": 0, "P": P}, {"O": 0, "A": 5}, {"O": 0, "B": 5}, {"A": 0, "P": 2.5}, {"B": 0, "P": 2.5}]
    links += [{"A": 0, "Q": 2.5 + difference}, {"B": 0, "Q": 2.5}]
    joints = [(0, "O", 1, "O"), (0, "O", 2, "O"), (1, "A", 3, "A"), (3, "P", 0, "P"), (2, "B", 4, "B")]
    return loops_of(links, [*joints, (4, "P", 0, "P"), (1, "A", 5, "A"), (5, "Q", 6, "Q"), (6, "B", 2, "B")])


def test_peaucellier_has_four_isolated_solutions_and_two_free_branches():
    result = searched(*peaucellier(0.0), 1.0, IntervalConstants(narrowest=0.01))
    assert len(result.roots) == 4
    assert not result.complete
    # if A = B, a bar can rotate: the undecided boxes must contain every value of its angle
    middle, half = result.undecided[..., 5].mean(axis=1), 0.5 * np.diff(result.undecided[..., 5], axis=1)[:, 0]
    for value in np.linspace(-np.pi, np.pi, 100):
        assert (np.abs(wrapped(middle - value)) <= half + 1e-12).any()


def test_a_slightly_perturbed_peaucellier_cell_is_decided():
    result = searched(*peaucellier(1e-3), 1.0)
    assert result.complete
    assert len(result.roots) == 4


def test_a_folded_parallelogram_can_rotate_freely():
    result = searched(*two_bars(0.0, 1.0, 1.0), 1.0, IntervalConstants(boxes=20_000))
    assert len(result.roots) == 0
    for angle in np.linspace(-3, 3, 50):
        assert contains(result, np.array([angle, angle]), 2)


def test_no_solution_is_lost_at_a_limit():
    for seed in range(20):
        *coefficients, x = random_loops(3, 0, np.random.default_rng((8, seed)))
        for boxes in (1, 5, 10, 20):
            assert contains(searched(*coefficients, 1.0, IntervalConstants(boxes=boxes, batch=3)), x, 6)


def test_the_size_of_batches_does_not_change_the_solutions():
    all_ = searched(*innocenti(), 1.0)
    few = searched(*innocenti(), 1.0, IntervalConstants(batch=7))
    assert few.complete
    assert few.roots == pytest.approx(all_.roots, abs=1e-11)


def test_results_do_not_depend_on_scale_and_rotation():
    C0, C, U, rail, _ = random_loops(2, 1, np.random.default_rng(9))
    plain = searched(C0, C, U, rail, 3.5)
    factor = 1e6 * np.exp(1j)
    scaled = searched(C0 * factor, C * factor, U * np.exp(1j), rail, 3.5e6)
    assert plain.complete
    assert scaled.complete
    assert scaled.roots[:, :3] == pytest.approx(plain.roots[:, :3], abs=1e-10)
    assert scaled.roots[:, 3] / 1e6 == pytest.approx(plain.roots[:, 3], abs=1e-10)


@pytest.mark.soak
def test_thousands_of_known_solutions_are_not_lost():
    for seed in range(3000):
        rng = np.random.default_rng((10, seed))
        loops = int(rng.integers(1, 4))
        slides = int(rng.integers(0, loops + 1))
        *coefficients, x = random_loops(loops, slides, rng)
        assert contains(searched(*coefficients, 3.5, IntervalConstants(boxes=400_000)), x, 2 * loops - slides), seed


# ------------------------------------------------------------------ whole mechanisms, against an independent method

PROVED = ["double_butterfly", "excavator", "hart_a_frame", "jansen", "klann", "platform_3rpr", "platform_3rrr"]
PROVED += ["scissor_lift", "scotch_yoke", "slider_crank", "stephenson_1", "stephenson_2", "stephenson_3_far"]
PROVED += ["ten_bar", "watt_1", "whitworth"]


@pytest.mark.few(1)
@pytest.mark.parametrize("name", PROVED)
def test_lists_of_whole_mechanisms_agree_with_random_starts(name):
    """Gauss-Newton in absolute coordinates from 300 starts finds each of these lists completely."""
    mechanism = load(MODELS / f"{name}.yaml")
    inputs = [a.drawn for a in mechanism.actuators]
    proved, complete = configurations_proved(mechanism, inputs)
    assert complete
    known = np.isfinite(proved[0])
    found = distinct(configurations_by_starts(mechanism, inputs, starts=300, iterations=40)[:, known], 1e-6)
    assert len(found) == len(proved)
    assert not unmatched(found, proved[:, known], 1e-7)
    assert not unmatched(mechanism.drawn[None, known], proved[:, known], 1e-2)


def test_random_platforms_agree_with_their_polynomial():
    """Source: Gosselin, Sefrioui & Richard 1992: at most six assemblies."""
    rng, counts = np.random.default_rng(13), set()
    for _ in range(60):
        base, plate = rng.normal(size=(2, 3)) + 1j * rng.normal(size=(2, 3))
        at, turn = rng.normal() + 1j * rng.normal(), np.exp(1j * rng.uniform(0, TURN))
        legs = np.abs(at + turn * plate - base)
        result, expected = searched(*platform(base, plate, legs), 1.0), platform_angles(base, plate, legs)
        assert result.complete
        assert len(result.roots) == len(expected)
        assert result.roots[:, 0] == pytest.approx(expected, abs=1e-6)
        counts.add(len(expected))
    assert counts == {2, 4, 6}


# ------------------------------------------------------------------ bounds of slides


@pytest.mark.parametrize(("loops", "slides"), [(1, 1), (2, 1), (2, 2), (3, 2), (3, 3)])
def test_travels_are_within_their_bounds(loops, slides):
    """In random linkages with a known solution, no travel exceeds its bound."""
    for seed in range(200):
        rng = np.random.default_rng((14, loops, slides, seed))
        C0, C, U, rail, x = random_loops(loops, slides, rng, reach=10.0 ** rng.uniform(-3, 3))
        bound = proved_reach(Coefficients(C0, C, U, rail))
        assert np.isfinite(bound).all()
        assert (np.abs(x[len(x) - slides :]) <= bound).all()


def test_the_bound_of_one_slide_is_the_sum_of_lengths():
    bound = proved_reach(Coefficients(np.array([3.0j]), np.array([[2.0]]), np.array([[-0.5]]), np.array([0])))
    assert bound == pytest.approx([10.0], rel=1e-5)


def test_two_rails_on_the_frame_have_bounds_unless_parallel():
    U, rail = np.array([[1.0, 1j]]), np.array([-1, -1])
    C0, C = np.array([0.3 - 0.4j]), np.zeros((1, 0))
    bound = proved_reach(Coefficients(C0, C, U, rail))
    assert (bound >= [0.3, 0.4]).all()
    assert (bound < 0.51).all()
    assert np.isinf(proved_reach(Coefficients(C0, C, np.array([[1.0, 2.0]]), rail))).all()
    assert np.isinf(proved_reach(Coefficients(C0, np.zeros((1, 2)), U, np.array([0, 1])))).all()  # rails that rotate


def test_without_a_reach_the_list_is_proved_everywhere():
    for seed in range(15):
        *coefficients, x = random_loops(3, 2, np.random.default_rng((15, seed)), reach=20.0)
        result = searched(*coefficients)
        assert result.complete
        assert result.everywhere
        assert contains(result, x, 4)
        short = searched(*coefficients, 0.5 * np.abs(x[4:]).max())
        assert not short.everywhere


def test_a_slot_with_its_pin_at_the_pivot_can_rotate_freely():
    """s θ = 0 has the solution s = 0 for every angle."""
    result = searched([0.0], [[0.0]], [[1.0]], [0], 1.0, IntervalConstants(narrowest=0.05))
    assert not result.complete
    for angle in np.linspace(-3, 3, 40):
        assert contains(result, np.array([angle, 0.0]), 1)


def test_the_search_ends_at_its_number_of_boxes():
    """The bound is a count: a slower machine finds the same."""
    one, other = (searched(*peaucellier(0.0), 1.0, IntervalConstants(boxes=20_000)) for _ in range(2))
    assert one.boxes == other.boxes < 2 * 20_000
    assert np.array_equal(one.roots, other.roots)
