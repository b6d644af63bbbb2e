"""The verb `sensitivity`: tolerances against exact spreads, reductions, dead points, words, refusals."""

import json
import math

import numpy as np
import pytest
import yaml
from bundled import MODELS
from four_bars import four_bar_text

import gimcli
from gimcli import UsageError
from gimcli.families.family import Family
from gimcli.families.tolerances import drawn, sampled_spread

NAMES = ("crank.length", "coupler.length", "follower.length", "O4.x")


def four_bar(tolerance=None, law=", law: {from: 10, to: 60}", **more):
    """Lengths 2, 7, 9, 6, as in references/families.md, section 4."""
    model = yaml.safe_load(four_bar_text(2.0, 7.0, 9.0, 6.0, math.radians(10.0), law=law))
    tolerances = {} if tolerance is None else {"tolerances": dict.fromkeys(NAMES, tolerance)}
    return gimcli.load(model | tolerances | more)


def only(result, name):
    """Return one spread of the first quantity."""
    return dict(result._spreads(0))[name][0]


# references/families.md, section 5: sd, first-order sd, exact sd, mean shift [deg]; the distribution of each length
EXACT = [
    ("normal", 0.06, 0.381866117619826, 0.38190499552643, 0.000470003229),
    ("normal", 0.3, 1.9093305880991, 1.9142489589239, 0.0119245256915),
    ("uniform", 0.05, 0.5511762645055, 0.551281916942, 0.000979704468),
]


@pytest.mark.parametrize(("distribution", "tolerance", "first", "exact", "shift"), EXACT)
def test_tolerances_of_a_four_bar(distribution, tolerance, first, exact, shift):
    mechanism = four_bar(tolerance)
    found = gimcli.sensitivity(mechanism, of="follower", motor=30, samples=40_000, distribution=distribution)
    assert only(found, "sd") == pytest.approx(first, rel=1e-9)
    assert only(found, "worst") == pytest.approx(tolerance / 0.02 * 0.646011406577562, rel=1e-9)
    deviation, error = only(found, "sampled_sd"), only(found, "sampled_sd_error")
    assert abs(deviation - exact) < 4.0 * error
    assert abs(only(found, "mean_shift") - shift) < 4.0 * only(found, "mean_shift_error")
    assert found.sampled.solved.min() == 40_000
    if distribution == "normal":
        assert error == pytest.approx(deviation / math.sqrt(2 * 40_000), rel=0.1)


def test_the_tolerances_of_a_slider_crank():
    """Worst case and first-order spread, references/families.md, section 5; the offset is that of the pivot."""
    r, l, e, t = 40.0, 120.0, 20.0, math.radians(60.0)
    pin = complex(r * math.cos(t), r * math.sin(t))
    model = {
        "nodes": {"O": [0, -e], "A": [pin.real, pin.imag - e], "B": [139.1, 0], "G": [0, 0], "H": [200, 0]},
        "ground": ["O", "G", "H"],
        "links": {"crank": {"nodes": ["O", "A"], "length": r}, "rod": {"nodes": ["A", "B"], "length": l}},
        "prismatic": {"slide": {"node": "B", "guide": ["G", "H"]}},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A", "law": {"from": 60, "to": 90}}},
        "tolerances": {"crank": 0.15, "rod": 0.3, "O.y": 0.06},
    }
    found = gimcli.sensitivity(gimcli.load(model), of="B.x", motor=60, samples=0)
    assert only(found, "sd") == pytest.approx(0.1026856524230372, rel=1e-9)
    assert only(found, "worst") == pytest.approx(3.0 * 0.122888365890413, rel=1e-9)
    assert found.most["B.x"].dimension == "rod.length"
    assert found.most["B.x"].share == pytest.approx((0.1 * 1.007527175682216 / 0.1026856524230372) ** 2, rel=1e-9)


def test_the_uniform_spread_stays_within_the_corners():
    found = gimcli.sensitivity(four_bar(0.05), of="follower", motor=30, distribution="uniform")
    assert only(found, "least") > -1.64383891567
    assert only(found, "greatest") < 1.59859917618
    assert only(found, "least") < -1.2
    assert only(found, "greatest") > 1.2


def test_errors_of_a_skewed_sample():
    """Standard errors of mean and standard deviation from the moments about the mean of a skewed sample."""
    away = np.random.default_rng(5).gamma(1.5, 0.3, 4000) + 2.0
    family = Family(four_bar(), ["crank.length"])
    found = sampled_spread(
        family, family.mechanism.start_inputs[:, None], np.zeros((4000, 1)), lambda at: away[None, :, None]
    )
    centre = away - away.mean()
    fourth, variance = np.mean(centre**4), np.var(away, ddof=1)
    assert found.mean[0, 0] == pytest.approx(away.mean(), rel=1e-12)
    assert found.deviation[0, 0] == pytest.approx(math.sqrt(variance), rel=1e-9)
    assert found.mean_error[0, 0] == pytest.approx(math.sqrt(variance / 4000), rel=1e-9)
    assert found.deviation_error[0, 0] == pytest.approx(
        math.sqrt((fourth - variance**2) / 4000) / (2 * math.sqrt(variance)), rel=1e-6
    )
    assert (found.least[0, 0], found.greatest[0, 0]) == (away.min(), away.max())


def test_random_designs_depend_on_the_seed_only():
    first, second, other = (
        gimcli.sensitivity(four_bar(0.05), of="B", motor=30, samples=500, seed=seed) for seed in (3, 3, 4)
    )
    assert first.sampled.deviation.tolist() == second.sampled.deviation.tolist()
    assert first.sampled.deviation.tolist() != other.sampled.deviation.tolist()
    assert np.std(drawn(0, 100_000, np.array([0.3]), "normal")) == pytest.approx(0.1, rel=0.01)
    assert np.ptp(drawn(0, 100_000, np.array([0.3]), "uniform")) == pytest.approx(0.6, rel=0.01)


def test_the_spread_over_a_motion_is_that_of_each_position():
    mechanism = four_bar(0.05)
    motion = gimcli.sensitivity(mechanism, of="B.y", steps=5, samples=200)
    position = gimcli.sensitivity(mechanism, of="B.y", motor=30, samples=200)
    assert motion["motor"][2] == pytest.approx(30.0)
    for name in ("worst", "rss", "sampled_sd"):
        assert motion[f"B.y.{name}"][2] == pytest.approx(only(position, name), rel=1e-9)
    assert motion["B.y/crank.length"][2] == pytest.approx(position.derivatives["B.y"]["crank.length"], rel=1e-9)


@pytest.mark.parametrize("word", ["min", "max", "range", "mean", "rms"])
def test_numbers_of_a_motion_have_the_derivatives_of_differences(word):
    mechanism = gimcli.load(MODELS / "crank_rocker.yaml")
    texts = [f"{word}({one})" for one in ("P.y", "rocker.angle", "transmission")]
    found = gimcli.sensitivity(mechanism, of=texts, by="crank", steps=24)
    step = 1e-4
    sides = [
        gimcli.sensitivity(mechanism.with_({"crank": 40.0 + h}), of=texts, by="crank", steps=24).value
        for h in (step, -step)
    ]  # fmt: skip
    for name, value in found.derivatives.items():
        assert value["crank.length"] == pytest.approx((sides[0][name] - sides[1][name]) / (2 * step), abs=1e-6)


@pytest.mark.parametrize("text", [
    "rms(P.y) * 2 - min(P.x) / 3", "max(hypot(P.x, P.y) ** 1.5)", "mean(abs(rocker.angle - 90))",
    "log(range(P.y)) + atan2(max(P.x), 20)", "max(sin(radians(rocker.angle))) - 2",
])  # fmt: skip
def test_expressions_have_the_derivatives_of_differences(text):
    mechanism, step = gimcli.load(MODELS / "crank_rocker.yaml"), 1e-4
    found = gimcli.sensitivity(mechanism, of=text, by="crank", steps=24)
    high, low = (
        gimcli.sensitivity(mechanism.with_({"crank": 40.0 + h}), of=text, by="crank", steps=24).value[text]
        for h in (step, -step)
    )
    assert found.derivatives[text]["crank.length"] == pytest.approx((high - low) / (2 * step), abs=1e-6)


def test_expressions_are_those_of_a_sweep():
    """The distance of two points of one member is that of their local coordinates, (60, 40) and (120, 0)."""
    mechanism = gimcli.load(MODELS / "crank_rocker.yaml")
    found = gimcli.sensitivity(mechanism, of="max(hypot(P.x - B.x, P.y - B.y))", steps=6)
    (name,) = found.names
    far = math.hypot(60, 40)
    assert found.value[name] == pytest.approx(far)
    assert [found.derivatives[name][one] for one in ("P.x", "P.y", "coupler.length", "crank.length", "motor")] == (
        pytest.approx([-60 / far, 40 / far, 60 / far, 0.0, 0.0], abs=1e-9)
    )


def test_an_expression_without_a_value_is_reported():
    found = gimcli.sensitivity(gimcli.load(MODELS / "crank_rocker.yaml"), of="log(min(P.x))", steps=6)
    assert math.isnan(found.value["log(min(P.x))"])
    assert not found.answered
    assert "not defined" in found.reason


def test_the_spread_of_an_expression_is_that_of_its_linear_part():
    model = yaml.safe_load(four_bar_text(2.0, 7.0, 9.0, 6.0, 0.2, law=", law: {from: 10, to: 60}"))
    mechanism = gimcli.load(model | {"tolerances": {"crank": 0.01, "coupler": 0.02}})
    found = gimcli.sensitivity(mechanism, of="max(B.y) - min(B.y)", samples=20_000, steps=6)
    assert only(found, "sampled_sd") == pytest.approx(only(found, "sd"), abs=4 * only(found, "sampled_sd_error"))
    assert abs(only(found, "mean_shift")) < 4 * only(found, "mean_shift_error") + 1e-5


def test_a_turning_member_counts_its_turns():
    found = gimcli.sensitivity(gimcli.load(MODELS / "crank_rocker.yaml"), of="range(crank.angle)", steps=24)
    assert found.value["range(crank.angle)"] == pytest.approx(360.0)
    assert found.derivatives["range(crank.angle)"]["crank.length"] == pytest.approx(0.0, abs=1e-9)


def test_a_dead_point_has_a_status_and_no_derivatives():
    """Lengths 5, 7, 9, 6: at this crank angle the coupler and the follower are in line."""
    angle = math.degrees(math.acos(57 / 60))
    text = four_bar_text(
        5.0, 7.0, 9.0, 6.0, math.radians(angle + 2), law=f", law: {{from: {angle + 2!r}, to: {angle!r}}}"
    )
    mechanism = gimcli.loads(text)
    motion = gimcli.sensitivity(mechanism, of="B", steps=2)
    assert motion.status.tolist() == ["ok", "ok", "singular"]
    assert np.isnan(motion["B.x/crank.length"]).tolist() == [False, False, True]
    assert motion.reason.startswith("1 of 3 rows: ")
    assert not motion.answered
    position = gimcli.sensitivity(mechanism, of="B", motor=angle)
    assert position.status in ("singular", "unreachable")
    assert not position.answered
    assert position.report()["quantities"]["B.x"]["derivatives"]["crank.length"]["value"] is None


def test_a_position_out_of_reach_is_reported():
    found = gimcli.sensitivity(gimcli.load(MODELS / "chebyshev.yaml"), motor=179)
    assert found.status != "ok"
    assert not found.answered
    assert found.picture() is None


def test_the_dimension_with_the_largest_effect_is_named():
    found = gimcli.sensitivity(four_bar(), of="follower", motor=30)
    assert found.most["follower.angle"].dimension == "coupler.length"
    assert f"{math.degrees(0.2332436083100963):.4g} deg" in found.most["follower.angle"].text
    tolerated = gimcli.sensitivity(
        four_bar(tolerances={"crank": 0.5, "coupler": 0.01}), of="follower", motor=30, samples=0
    ).most["follower.angle"]  # fmt: skip
    parts = np.array([0.5 * 0.1206967863242586, 0.01 * 0.2332436083100963]) ** 2
    assert tolerated.dimension == "crank.length"
    assert tolerated.share == pytest.approx(parts[0] / parts.sum(), rel=1e-9)


def test_by_default_numbers_that_move_no_node_are_left_out():
    mechanism = gimcli.load(MODELS / "crank_rocker.yaml")
    found = gimcli.sensitivity(mechanism, of="P", motor=30)
    assert list(found.derivatives["P.x"]) == [
        "O2.x", "O2.y", "O4.x", "O4.y", "crank.length", "coupler.length", "rocker.length", "P.x", "P.y", "motor",
    ]  # fmt: skip
    named = gimcli.sensitivity(mechanism, of="P", by=["motor", "crank"], motor=30)
    assert list(named.derivatives["P.x"]) == ["motor", "crank.length"]


def test_tolerances_of_dimensions_that_are_not_named_are_reported_as_left_out():
    found = gimcli.sensitivity(four_bar(0.05), of="follower", by=["crank", "O4.x"], motor=30, samples=0)
    assert found.left_out == ("coupler.length", "follower.length")
    assert found.report()["tolerances_left_out"] == ["coupler.length", "follower.length"]
    parts = np.degrees([0.1206967863242586, 0.004733113356602814])
    assert only(found, "worst") == pytest.approx(0.05 * parts.sum(), rel=1e-9)
    assert gimcli.sensitivity(four_bar(0.05), of="follower", motor=30, samples=0).left_out == ()


def test_formulas_follow_their_parameters():
    model = yaml.safe_load(four_bar_text(2.0, 7.0, 9.0, 6.0, math.radians(30.0), law=", law: {from: 30, to: 60}"))
    model["parameters"] = {"a": 2.0}
    model["links"]["crank"]["length"] = "a"
    model["links"]["coupler"]["length"] = "a + 5"
    found = gimcli.sensitivity(gimcli.load(model), of="follower", motor=30).derivatives["follower.angle"]
    assert "coupler.length" not in found
    assert math.radians(found["a"]) == pytest.approx(-0.1206967863242586 - 0.2332436083100963, abs=1e-10)


def test_masses_do_not_disturb():
    model = yaml.safe_load(four_bar_text(2.0, 7.0, 9.0, 6.0, math.radians(30.0), law=", law: {from: 30, to: 60}"))
    model |= {"units": {"length": "m"}, "masses": {"coupler": {"mass": 2.0}}, "gravity": [0, -9.81]}
    found = gimcli.sensitivity(gimcli.load(model), of="follower", motor=30).derivatives["follower.angle"]
    assert math.radians(found["crank.length"]) == pytest.approx(-0.1206967863242586, abs=1e-10)


def test_dimensions_that_redundant_constraints_fix_are_left_out():
    mechanism = gimcli.load(MODELS / "parallelogram_third_crank.yaml")
    found = gimcli.sensitivity(mechanism, of="B", steps=4)
    assert {"left.length", "middle.length", "A.x"} <= set(found.fixed)
    assert list(found.derivatives["B.x"]) == ["motor"]
    with pytest.raises(UsageError):
        gimcli.sensitivity(mechanism, of="B", by="left", steps=4)


@pytest.mark.filterwarnings("error")
def test_tolerances_that_move_no_node_or_hardly_one():
    with pytest.raises(UsageError):
        gimcli.sensitivity(four_bar(tolerances={"duration": 0.1}), of="B", motor=30, samples=10)
    found = gimcli.sensitivity(four_bar(tolerances={"crank": 1e-300}), of="follower", motor=30, samples=0)
    assert found.most["follower.angle"].share == 1.0


def test_files(tmp_path):
    found = gimcli.sensitivity(four_bar(0.05), of=["B", "follower"], steps=4, samples=50)
    found.save(tmp_path / "s.csv", tmp_path / "s.svg", tmp_path / "s.json")
    head = (tmp_path / "s.csv").read_text().splitlines()[0].split(",")
    assert head[:5] == ["step", "time", "motor", "B.x", "B.x/O2.x"]
    assert "worst case" in (tmp_path / "s.svg").read_text()
    assert json.loads((tmp_path / "s.json").read_text())["monte_carlo"]["samples"] == 50
    bars = gimcli.sensitivity(four_bar(), of="B", motor=30)
    bars.save(tmp_path / "b.svg")
    assert "coupler.length" in (tmp_path / "b.svg").read_text()
    assert bars["dimension"].tolist()[:2] == ["O2.x", "O2.y"]
