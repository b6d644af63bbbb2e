"""Derivatives by tape: plain and compiled, compared with independent methods, near singular positions, influence."""

from dataclasses import replace
from functools import partial

import chains
import mpmath as mp
import numpy as np
import pytest
import series
import yaml
from bundled import MODELS, run_model
from influence_coefficients import Influence
from mp_derivatives import exact
from random_mechanisms import Growth
from rated import rated

from gimcli import UsageError, load
from gimcli.kernels import jit, reflections
from gimcli.kernels.lanes import ROWS, WIDTH
from gimcli.mechanism import Point
from gimcli.motion.motion import stream, trace
from gimcli.motion.solve import solve
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options
from gimcli.rates.derivatives import ORDERS, Differentiator, MotionRates, TracedRates, law_rates, rates
from gimcli.rates.member_angles import LawAngles
from gimcli.structure.plan import make_plan

STEPS = 2 * ROWS + 40
"""Rows for three blocks."""

EPS = float(np.finfo(float).eps)


def both(mechanism, motion):
    """Return points and angles, plain and compiled."""
    names = (*mechanism.nodes, *(p.name for p in mechanism.points))
    made = Differentiator(mechanism, make_plan(mechanism), ORDERS, names)
    given = law_rates(mechanism, motion.time, 3)
    return made(motion.z, given, plain), made(motion.z, given, jit.compiled)


def assert_same_bits(mechanism, motion):
    for one, other in zip(*both(mechanism, motion), strict=True):
        assert np.array_equal(one, other, equal_nan=True)


@pytest.mark.few(
    "antiparallelogram", "crank_rocker", "elliptic_trammel", "gim_fig11", "parallel_guide", "platform_3rpr"
)
def test_compiled_rows_have_the_bits_of_plain_ones(model):
    mechanism = load(model)
    assert_same_bits(mechanism, trace(mechanism, STEPS))


@pytest.mark.few(12)
@pytest.mark.parametrize("seed", range(300, 330))
def test_random_mechanisms_have_the_derivatives_of_their_series(seed, tmp_path):
    """Compared with Taylor series through the plan, with gradients by unit speeds and singular values (numpy)."""
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(Growth(seed, 1 + seed % 5).model()))
    mechanism = load(path)
    motion = trace(mechanism, 300)
    assert_same_bits(mechanism, motion)
    assert_agree(mechanism, motion)


@pytest.mark.few
def test_derivatives_agree_with_series(model):
    mechanism = load(model)
    assert_agree(mechanism, trace(mechanism, 180))


def assert_agree(mechanism, motion):
    """Assert that derivatives of each row and order differ by less than 1e-9 of the greatest."""
    now, then = (method(mechanism, motion.time, motion.z, 3) for method in (rates, series.rates))
    assert np.array_equal(np.isnan(now.nodes[1]), np.isnan(then.nodes[1]))
    for k in range(1, 4):
        most = np.nanmax(np.abs(then.nodes[k]), axis=0, initial=1.0)
        assert np.nanmax(np.abs(now.nodes[k] - then.nodes[k]) / most, initial=0.0) < 1e-9
    for index in range(len(mechanism.members)):
        one, other = now.angular(index), then.angular(index)
        for k in range(3):
            most = np.maximum(np.nan_to_num(np.abs(other[k])), max(1.0, mechanism.duration ** -(k + 1)))
            assert np.nanmax(np.abs(one[k] - other[k]) / most, initial=0.0) < 1e-8


# --- closed forms ------------------------------------------------------------------------------------------


def ram(t):
    """Return the ram (slider) of a Whitworth mechanism: crank 2 about 0, slotted arm about -i, radius 1.5, rod 5."""
    crank = 2 * mp.expj(mp.radians(60 + 360 * t))
    arm = crank + 1j
    pin = -1j - mp.mpf("1.5") * arm / abs(arm)
    return pin.real + mp.sqrt(25 - (pin.imag + 1) ** 2) - 1j


def test_whitworth_to_the_jerk():
    mechanism = load(MODELS / "whitworth.yaml")
    motion = trace(mechanism, 24)
    actual = rates(mechanism, motion.time, motion.z, 3).point("R") * mechanism.scale
    actual[0] += mechanism.origin
    for k, time in enumerate(motion.time):
        expected = exact(ram, time, 3)
        assert np.max(np.abs(actual[:, k] - expected) / np.maximum(np.abs(expected), 1.0)) < 1e-10


PUBLISHED = {
    "C": (-14.371115330251182 + 1.9161487107001576j, 1.7132148670250689 - 14.24180076339657j),
    "E": (-16.37638723679786 + 0.5124583761174841j, 2.354906866810082 - 14.391762561005676j),
    "F": (-16.705164880012152 - 2.2273553173349536j, 1.5296161164289317 - 18.730960876346256j),
}
PUBLISHED_TURNS = {
    "BCE": (0.20052719065466765, -0.03602139204420397),
    "CD": (0.9580743553500788, -0.23660185385226712),
    "EF": (-0.1095925477380975, -0.17500919579599042),
    "FG": (1.1136776586674768, 0.06339598256008096),
}


@pytest.mark.parametrize("run", [plain, jit.compiled])
def test_the_published_velocities_of_a_stephenson_mechanism(run):
    """Verification tables of PMKS, stephenson_iii_example_2, row 0: the crank at pi / 3 rad/s without acceleration."""
    mechanism = load(MODELS / "stephenson_3.yaml")
    rate = np.array([np.pi / 3])
    position = solve(mechanism, np.array([np.arctan2(12.0, -2.0)]), Options())
    actual = Influence(mechanism, run=run).at(position.z, position.inputs, rate)
    for name, (velocity, acceleration) in PUBLISHED.items():
        node = mechanism.nodes.index(name)
        assert actual.points_rate[node] * mechanism.scale == pytest.approx(velocity, rel=1e-11)
        assert actual.points_bias[node] * mechanism.scale == pytest.approx(acceleration, rel=1e-11)
    for number, member in enumerate(mechanism.members[1:]):
        if member.name in PUBLISHED_TURNS:
            omega, alpha = PUBLISHED_TURNS[member.name]
            assert actual.angles_rate[number] == pytest.approx(omega, rel=1e-11)
            assert actual.angles_bias[number] == pytest.approx(alpha, rel=1e-11)


@pytest.mark.parametrize("gap", [1e-3, 1e-6, 1e-9])
def test_errors_near_a_change_point_agree_with_the_condition_number(gap):
    """Crank 1, frame 2, coupler 1 + gap, rocker 2: nearly flat at 0 deg.

    The exact velocity of the pin is computed from the exact position at the rounded angle of the crank.
    """

    def change(data):
        data["nodes"] = {"O2": [0, 0], "O4": [2, 0], "A": [1, 0.1], "B": [1.5, 2.0]}
        data["links"] = {"crank": {"nodes": ["O2", "A"], "length": 1}, "rocker": {"nodes": ["O4", "B"], "length": 2}}
        data["elements"] = {}
        data["links"]["coupler"] = {"nodes": ["A", "B"], "length": 1 + gap}
        data["points"], data["trace"] = {}, ["B"]
        data["actuators"]["motor"] = {"type": "rotary", "pivot": "O2", "arm": "A", "law": {"from": 40, "to": -1}}

    m = run_model("crank_rocker", 41, change=change)
    assert m.motion.solved >= 40
    found = rates(m.mechanism, m.motion.time, m.motion.z, 2).point("B") * m.mechanism.scale
    for row in np.flatnonzero(m.motion.good):
        exactly = pin(m.motion.inputs[0, row], found[0, row], gap)
        speed = np.radians(-41.0)
        lost = EPS / abs(complex(exactly[3])) ** 2  # rounding of a length, divided by the square of the sine
        for k, factor in ((1, 10.0), (2, 200.0)):
            wanted = complex(exactly[k]) * speed**k
            assert abs(found[k, row] - wanted) < factor * lost * max(1.0, abs(wanted))


def pin(angle, near, gap):
    """Return B, dB/dtheta, d2B/dtheta2 and the sine between its bars, with 50 digits."""
    with mp.workdps(50):
        theta, b, a = mp.mpf(float(angle)), 1 + mp.mpf(gap), mp.mpf(2)

        def place(t, side):
            crank = mp.expj(t)
            arm = 2 - crank
            far = abs(arm)
            along = (b**2 - a**2 + far**2) / (2 * far)
            return crank + arm / far * (along + side * 1j * mp.sqrt(b**2 - along**2))

        side = min((1, -1), key=lambda s: abs(complex(place(theta, s)) - near))
        parts = [mp.diff(lambda t: place(t, side), theta, k) for k in range(3)]
        one, other = parts[0] - mp.expj(theta), parts[0] - 2
        return [*parts, (one.conjugate() * other).imag / abs(one * other)]


@pytest.mark.few(2)
@pytest.mark.parametrize("run", [plain, jit.compiled])
@pytest.mark.parametrize("stages", [3, 100])
def test_chains_agree_with_their_closed_forms(stages, run):
    """Scissors of bars 2: y = n sqrt(4 - w^2); windows: all bars have the angular velocity of the crank."""
    mechanism, _ = chains.loaded(chains.scissor(stages))
    motion = trace(mechanism, 20)
    actual = Influence(mechanism, points=[f"L{stages}"], run=run).over(motion.z, motion.inputs, np.ones((1, 21)))
    width = motion.inputs[0] * mechanism.scale
    height = np.sqrt(4.0 - width**2)
    assert np.allclose(actual.points[0, 0], -1j * stages * width / height, rtol=1e-12)
    assert np.allclose(actual.points_bias[0] / mechanism.scale, -4j * stages / height**3, rtol=1e-12)
    mechanism, _ = chains.loaded(chains.windows(stages))
    motion = trace(mechanism, 20)
    actual = Influence(mechanism, points=[f"B{stages}"], run=run).over(motion.z, motion.inputs, np.ones((1, 21)))
    crank = np.exp(1j * motion.inputs[0])
    assert np.allclose(actual.points[0, 0] * mechanism.scale, 1j * crank, rtol=1e-9)
    assert np.allclose(actual.points_bias[0] * mechanism.scale, -crank, rtol=1e-9)


# --- rows ----------------------------------------------------------------------------------------------------


def test_rows_do_not_depend_on_each_other():
    """Each row is bit-equal alone, among others, and after rows without a position."""
    mechanism = load(MODELS / "platform_3rrr.yaml")
    motion = trace(mechanism, STEPS)
    made = Differentiator(mechanism, make_plan(mechanism), ORDERS[:2], mechanism.nodes)
    given = law_rates(mechanism, motion.time, 2)
    for run in (plain, jit.compiled):
        whole, _ = made(motion.z, given, run)
        for k in (0, 1, ROWS - 1, ROWS, STEPS):
            assert np.array_equal(made(motion.z[:, [k]], given[:, :, [k]], run)[0][..., 0], whole[..., k])
        z = motion.z.copy()
        z[:, ::3] = complex(np.nan, np.nan)
        holed, angles = made(z, given, run)
        assert np.isnan(holed[:, :, ::3]).all()
        assert np.isnan(angles[:, :, ::3]).all()
        rest = np.arange(STEPS + 1) % 3 > 0
        assert np.array_equal(holed[..., rest], whole[..., rest])


@pytest.mark.parametrize("run", [plain, jit.compiled])
def test_a_crank_without_a_position_has_no_velocity(run):
    """The input alone determines its velocity; a row without a position is empty nevertheless."""

    def change(data):
        for part, names in (("nodes", "B"), ("links", "rocker"), ("links", "coupler"), ("elements", "coupler")):
            data.get(part, {}).pop(names, None)
        data["points"], data["trace"] = {}, ["A"]

    motion = run_model("crank_rocker", 10, change=change).motion
    z = motion.z.copy()
    z[:, 4] = complex(np.nan, np.nan)
    mechanism = motion.mechanism
    made = Differentiator(mechanism, make_plan(mechanism), ORDERS[:2], mechanism.nodes)
    found = MotionRates(mechanism, 2, *made(z, law_rates(mechanism, motion.time, 2), run))
    assert np.array_equal(np.isnan(found.nodes).all(axis=(0, 1)), np.arange(11) == 4)
    assert np.array_equal(np.isnan(found.angular(1)).all(axis=0), np.arange(11) == 4)


@pytest.mark.parametrize("run", [plain, jit.compiled])
def test_a_singular_group_has_no_velocity(run):
    """A platform on three parallel legs can move across them."""

    mechanism = load(MODELS / "platform_3rrr.yaml")
    plan = make_plan(mechanism)
    made = Differentiator(mechanism, plan, ORDERS[:1], mechanism.nodes)
    motion = trace(mechanism, 2)
    z = motion.z[:, [0, 0]].copy()
    names = list(mechanism.nodes)
    elbows, corners = platform(mechanism)
    for elbow, corner in zip(elbows, corners, strict=True):  # all legs parallel in the second row
        z[names.index(elbow), 1] = z[names.index(corner), 1] + abs(z[names.index(elbow), 1] - z[names.index(corner), 1])
    given = law_rates(mechanism, motion.time[[0, 0]], 1)
    points, angles = made(z, given, run)
    assert np.isfinite(points[:, :, 0]).all()
    assert np.isnan(points[:, :, 1]).all()
    assert np.isnan(angles[:, :, 1]).all()


def platform(mechanism):
    """Return the elbows of the legs, and the corners of the platform."""
    corners = next(m.nodes for m in mechanism.members[1:] if len(m.nodes) == 3)
    names = mechanism.nodes
    driven = {a.members[0] for a in mechanism.actuators}
    legs = [m.nodes for k, m in enumerate(mechanism.members) if k and k not in driven and len(m.nodes) == 2]
    pairs = [sorted(leg, key=lambda n: n in corners) for leg in legs]
    return [names[p[0]] for p in pairs], [names[p[1]] for p in pairs]


@pytest.mark.parametrize("jit_mode", ["on", "off"])
def test_pieces_give_the_same_columns_as_the_whole_motion(jit_mode):
    mechanism = load(MODELS / "crank_rocker.yaml")
    whole = rated(trace(mechanism, STEPS), 2)
    actual = TracedRates(mechanism, mechanism.traced, 2, STEPS, jit_mode)
    in_pieces = partial(stream, mechanism, STEPS, Options(), rows=300)
    angles = LawAngles(mechanism, STEPS, in_pieces)
    pieces = [rated(piece, 2, actual, angles) for piece in in_pieces()]
    for name in whole.names:
        if ".v" in name or ".a" in name or "omega" in name:
            joined = np.concatenate([piece.floats(name) for piece in pieces])
            assert np.array_equal(joined, whole.floats(name)), name


# --- influence coefficients ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["gim_fig11", "platform_3rpr", "platform_3rrr", "five_bar", "excavator", "jansen"])
@pytest.mark.parametrize("run", [plain, jit.compiled])
def test_coefficients_give_the_velocities_and_accelerations_of_the_laws(name, run):
    """z' = B q', z'' = B q'' + bias, bias = (dB/dq q') q'; likewise for the angles of members."""
    mechanism = load(MODELS / f"{name}.yaml")
    motion = trace(mechanism, 50)
    _, first, second = law_rates(mechanism, motion.time, 2)
    second += np.linspace(-3.0, 2.0, len(motion.time))
    whole = series.rates(driven(mechanism, motion, first, second), np.arange(51.0), motion.z, 2)
    b = Influence(mechanism, run=run).over(motion.z, motion.inputs, first)
    angular = np.stack([whole.angular(k) for k in range(1, len(mechanism.members))], axis=1)
    for now, rate, bias, change, actual in (
        (b.points, b.points_rate, b.points_bias, b.points_change, whole.nodes[1:]),
        (b.angles, b.angles_rate, b.angles_bias, b.angles_change, angular),
    ):
        most = np.nanmax(np.abs(actual))
        assert np.nanmax(np.abs(np.einsum("par,ar->pr", now, first) - actual[0])) < 1e-11 * most
        assert np.nanmax(np.abs(rate - actual[0])) < 1e-11 * most
        assert np.nanmax(np.abs(np.einsum("par,ar->pr", now, second) + bias - actual[1])) < 1e-11 * most
        assert np.nanmax(np.abs(np.einsum("par,ar->pr", change, first) - bias)) < 1e-11 * most


def driven(mechanism, motion, first, second):
    """Return the mechanism with laws whose time is the number of the row."""

    def law(k):
        table = (motion.inputs[k], first[k], second[k])
        return lambda time, order=0: table[order][np.rint(time).astype(int)]

    actuators = tuple(replace(a, law=law(k)) for k, a in enumerate(mechanism.actuators))
    return replace(mechanism, actuators=actuators, duration=1.0)


@pytest.mark.parametrize("name", ["gim_fig11", "platform_3rrr", "crank_rocker"])
def test_one_position_and_a_row_of_many_agree(name):
    mechanism = load(MODELS / f"{name}.yaml")
    motion = trace(mechanism, 20)
    first = law_rates(mechanism, motion.time, 1)[1]
    for run in (plain, jit.compiled):
        influence = Influence(mechanism, run=run)
        many = influence.over(motion.z, motion.inputs, first)
        for k in (0, 7, 20):
            z, q, rate = motion.z[:, k], motion.inputs[:, k], first[:, k]
            alone = influence.at(z, q, rate)
            for part in vars(alone):
                assert np.array_equal(getattr(alone, part), getattr(many, part)[..., k])
            assert np.array_equal(influence.at(z, q).points, many.points[..., k])


def test_the_influence_of_a_crank_on_a_slider():
    """x = cos t + sqrt(9 - (sin t - 1/2)^2): dx/dt, and a centre of mass a third along the rod."""
    mechanism = load(MODELS / "slider_crank.yaml")
    motion = trace(mechanism, 30)
    rod = next(k for k, m in enumerate(mechanism.members) if m.name == "rod")
    shape = mechanism.members[rod].shape
    names = [mechanism.nodes[n] for n in mechanism.members[rod].nodes]
    centre = Point("centre", rod, complex(shape[0] + (shape[1] - shape[0]) / 3))
    t = motion.inputs[0]
    h = np.sin(t) - 0.5
    root = np.sqrt(9 - h**2)
    slider = -np.sin(t) - h * np.cos(t) / root
    bend = -np.cos(t) - (np.cos(t) ** 2 - h * np.sin(t)) / root - h**2 * np.cos(t) ** 2 / root**3
    crank = 1j * np.exp(1j * t)
    made = Influence(mechanism, points=["B", centre])
    actual = made.over(motion.z, motion.inputs, np.full((1, 31), 2.0))
    first, third = (actual.points[k, 0] * mechanism.scale for k in (0, 1))
    assert np.max(np.abs(first - slider)) < 1e-13
    ends = {"A": crank, "B": slider}
    assert np.max(np.abs(third - (2 * ends[names[0]] + ends[names[1]]) / 3)) < 1e-13
    assert np.max(np.abs(actual.points_bias[0] * mechanism.scale - 4.0 * bend)) < 1e-12


def test_coefficients_at_a_singular_position_are_nan():
    motion = run_model("parallelogram", 8, laws={"motor": {"from": -90, "to": 270}}).motion
    flat = np.abs(np.sin(motion.inputs[0])) < 1e-9
    actual = Influence(motion.mechanism).over(motion.z, motion.inputs)
    assert np.array_equal(np.isnan(actual.points).all(axis=(0, 1)), flat)
    assert np.array_equal(np.isnan(actual.angles).any(axis=(0, 1)), flat)


def test_a_mechanism_without_inputs_has_no_influence():
    mechanism = load(MODELS / "crank_rocker.yaml")
    with pytest.raises(UsageError, match="no actuator"):
        Influence(replace(mechanism, actuators=()))


# --- linear algebra ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("m", "n"), [(1, 1), (2, 2), (6, 6), (9, 6), (14, 12)])
@pytest.mark.parametrize("run", [plain, jit.compiled])
def test_reflections_over_lanes_agree_with_lapack(m, n, run):
    generator = np.random.default_rng(m + n)
    table, right = generator.standard_normal((m, n, 5)), generator.standard_normal((m, 5))
    table[0, 0] = 0.0
    w = np.zeros((m * n + 3 * n + m + 2) * WIDTH)
    lanes = w.reshape(-1, WIDTH)
    a, d, b, dot, square = 0, m * n, m * n + 3 * n, m * n + 3 * n + m, m * n + 3 * n + m + 1
    lanes[:d, :5], lanes[b:dot, :5] = table.reshape(m * n, 5), right
    if n == 1:
        lanes[0, :5] = 2.0
        table[0, 0] = 2.0
    run(reflections.factor_rows)(w, a, d, m, n, dot, 5)
    run(reflections.inverse_square)(w, a, d, n, square, 5)
    run(reflections.solve_rows)(w, a, d, m, n, b, dot, 5)
    for r in range(5):
        expected = np.linalg.lstsq(table[:, :, r], right[:, r], rcond=None)[0]
        assert np.allclose(lanes[b : b + n, r], expected, rtol=1e-11, atol=1e-12)
        norm = np.sum(np.linalg.svd(table[:, :, r], compute_uv=False) ** -2.0)
        assert lanes[square, r] == pytest.approx(norm, rel=1e-10)
