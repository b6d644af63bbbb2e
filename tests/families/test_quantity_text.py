"""The text of kept quantities: values of two designs from the columns of their traces, conditions, refusals."""

import numpy as np
import pytest

import gimcli
from gimcli import UsageError

LENGTHS = [35.0, 40.0]
STEPS = 12
"""Steps of 30 deg: the third row is at 60 deg."""


@pytest.fixture(scope="module")
def mechanism():
    return gimcli.load("crank_rocker")


@pytest.fixture(scope="module")
def traces(mechanism):
    """The columns of both designs, (rows,) each."""
    found = []
    for length in LENGTHS:
        t = gimcli.trace(mechanism.with_({"crank.length": length}), STEPS)
        assert t.complete
        found.append({"x": t["P.x"], "y": t["P.y"], "length": length})
    return found


def swept(mechanism, text, vary=LENGTHS, **options):
    return gimcli.sweep(mechanism, {"crank.length": vary}, steps=STEPS, keep=text, **options)


NUMBERS = {
    "min(P.x)": lambda c: c["x"].min(),
    "max(P.x)": lambda c: c["x"].max(),
    "range(P.x)": lambda c: np.ptp(c["x"]),
    "mean(P.x)": lambda c: c["x"].mean(),
    "rms(P.y)": lambda c: np.sqrt(np.mean(c["y"] ** 2)),
    "at(P.x, motor=60)": lambda c: c["x"][2],
    "max(P.x - P.y)": lambda c: max(c["x"] - c["y"]),
    "max(P.x) - min(P.y) * 2": lambda c: c["x"].max() - 2.0 * c["y"].min(),
    "max(abs(P.x - mean(P.x)))": lambda c: max(abs(c["x"] - c["x"].mean())),
    "-max(P.x)**2": lambda c: -(c["x"].max() ** 2),
    "2**-1 * crank.length": lambda c: 0.5 * c["length"],
    "(max(P.x) + 1) / 2": lambda c: (c["x"].max() + 1.0) / 2.0,
    "hypot(max(P.x), 4)": lambda c: np.hypot(c["x"].max(), 4.0),
    "max(P.x*crank.length)": lambda c: c["x"].max() * c["length"],
    "degrees(pi) * min(P.x)": lambda c: 180.0 * c["x"].min(),
    "1e1 + .5*min(P.x)": lambda c: 10.0 + 0.5 * c["x"].min(),
    "1+" * 499 + "1": lambda c: 500.0,
    "-max(P.x)" + "+min(P.x)" * 100: lambda c: 100.0 * c["x"].min() - c["x"].max(),
    "max(P.x) / 0": lambda c: np.nan,
    "exp(1000 * crank.length)": lambda c: np.nan,
}


def test_numbers(mechanism, traces):
    found = swept(mechanism, list(NUMBERS))
    for text, expected in NUMBERS.items():
        wanted = [float(expected(columns)) for columns in traces]
        assert found[text] == pytest.approx(wanted, rel=1e-9, nan_ok=True), text


def test_texts(mechanism):
    """Grashof: 70 mm is the longest but one, and the shortest and longest together are longer than the others."""
    assert swept(mechanism, "type", [40.0, 70.0])["type"].tolist() == ["crank-rocker", "triple-rocker"]


# min(P.x) is -15.4 mm in the first design and -19.5 mm in the second
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("crank.length > 37", [40.0]), ("crank.length > 37 or min(P.x) > -17", LENGTHS),
        ("not (crank.length > 37) and min(P.x) < 0", [35.0]), ('type == "crank-rocker"', LENGTHS),
        ("type != 'crank-rocker' and crank.length <= 50", []), ("crank.length>=35 and crank.length<40", [35.0]),
        ("crank.length == 40", [40.0]),
    ],
)  # fmt: skip
def test_conditions(mechanism, text, expected):
    assert swept(mechanism, (), where=text)["crank.length"].tolist() == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("0/0 != 1", False), ("not (0/0 > 1)", False), ("1/0 > 1", False), ("not (1/0 < 1 and 1 < 2)", False),
        ("0/0 > 1 or 1 < 2", True), ("not (0/0 > 1 and 1 > 2)", True), ("not (0/0 > 1 or 1 > 2)", False),
    ],
)  # fmt: skip
def test_a_condition_holds_only_where_what_decides_it_is_defined(mechanism, text, expected):
    """Kleene's three-valued logic: unknown, if the defined sides do not decide alone."""
    assert len(swept(mechanism, (), where=text)["crank.length"]) == (2 if expected else 0)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("P.x", "write for example min(P.x)"), ("min(P.z)", "did you mean 'P."), ("min(5)", "takes a column"),
        ("min(P.x", "expected ')'"), ("", "expected a name or number"), ("min(P.x) +", "expected a name or number"),
        ("min(P.x) min(P.y)", "expected the end or an operator"), ("least(P.x)", "no function 'least'"),
        ("at(P.x)", "expected ','"), ("at(P.x, 30)", "needs the value of an input"),
        ("at(P.x, moto=30)", "did you mean 'motor'"), ("at(P.x, motor=400)", "the law of motor is 0 to 360"),
        ("type + 1", "got a text"), ("min(P.x) > 3", "expected a number"), ("type < 'a'", "by == or !="),
        ("(" * 60 + "1" + ")" * 60, "more than 50"), ("1+" * 1500 + "1", "at most 1000"),
        ("mean(transmission:rod/rocker)", "no member, sliding pair or linear actuator 'rod'"),
        ("__import__", "no column"), ("crank", "did you mean 'crank.length'"),
        ("min(P.x) = 3", "the sign of equality is =="),
    ],
)  # fmt: skip
def test_invalid_texts_are_refused(mechanism, text, message):
    with pytest.raises(UsageError) as refused:
        swept(mechanism, [text])
    assert message in str(refused.value)


def test_units(mechanism):
    units = {"min(P.x)": "mm", "range(rocker.omega)": "deg/s", "max(P.x) - min(P.y)": "mm", "max(P.x)/2": ""}
    table = swept(mechanism, list(units)).table()
    assert {column.name: column.unit for column in table.columns if column.name in units} == units


ROCKER = gimcli.load("crank_rocker")


def test_a_short_name_ends_where_its_column_ends():
    keep = ["stroke:P, solved", "stroke:P.x + 3, stroke:P.x - stroke:P.y", "range(P.x)", "range(P.y)"]
    found = gimcli.sweep(ROCKER, {"crank.length": [40]}, steps=12, keep=keep)
    x, y = found["range(P.x)"], found["range(P.y)"]
    assert found["stroke:P"] == np.hypot(x, y)
    assert found["stroke:P.x + 3"] == x + 3.0
    assert found["stroke:P.x - stroke:P.y"] == x - y
    with pytest.raises(UsageError, match="no column or measure 'nope'"):
        gimcli.trace(ROCKER, 4, measure="stroke:nope")


@pytest.mark.parametrize(("keep", "rows", "sentence"), [
    ("P.v", True, "it has 2 columns; name one of them"),
    ("at(P.x / max(P.x), motor=30)", False, "outside of it"),
    ("min(P.x), nope(P.x)", False, "no function 'nope'"),
])  # fmt: skip
def test_what_has_no_value_of_a_row_or_a_design_is_refused(keep, rows, sentence):
    with pytest.raises(UsageError, match=sentence):
        gimcli.sweep(ROCKER, {"crank.length": [40]}, keep=keep, rows=rows)


def test_an_evaluator_takes_one_name():
    values, statuses = gimcli.evaluator(ROCKER, "crank.length", "at(P.x, motor=0)", 12)([[40.0]])
    assert values == pytest.approx(np.array([[gimcli.solve(ROCKER, motor=0)["P.x"]]]))
    assert statuses.tolist() == ["ok"]


def test_graphs_and_columns_have_numbers_and_vectors_by_name():
    own = {"swing": "range(rocker.angle)", "part": "P.x/swing", "speed": "P.v"}
    text = ROCKER.written.source.text + f"\nquantities: {own}\n".replace("'", '"')
    named, plain = gimcli.loads(text), gimcli.trace(ROCKER, 12, measure=["P.vx", "P.vy", "rocker.angle"])
    swing, speed = np.ptp(plain["rocker.angle"]), np.hypot(plain["P.vx"], plain["P.vy"])
    stroke = np.hypot(np.ptp(plain["P.x"]), np.ptp(plain["P.y"]))
    expected = {
        "swing": 0.0 * plain["P.x"] + swing, "part": plain["P.x"] / swing, "|speed|": speed,
        "(P.x/stroke:P)": plain["P.x"] / stroke, "(P.y - swing/2)": plain["P.y"] - swing / 2.0,
    }  # fmt: skip
    for plot, values in expected.items():
        curve = gimcli.trace(named, 12, plot=plot).graphs()[0].curves[0]
        assert curve.y == pytest.approx(values, rel=1e-12), plot
    assert gimcli.trace(named, 12, measure="|speed|")["|speed|"] == pytest.approx(speed)
    for text in ("speed", "P.v*2"):
        with pytest.raises(UsageError, match="it has 2 columns"):
            gimcli.trace(named, 12, measure=text)
