"""`examples/newton_raphson.py` against the printed iterations of Fraczek & Wojtyra's lecture notes, 1.4 to 1.10."""

import csv
import math
import runpy
from types import SimpleNamespace

import numpy as np
import pytest
from bundled import ROOT, TABLES

N = SimpleNamespace(**runpy.run_path(str(ROOT / "examples" / "newton_raphson.py")))


def quintic_rows(start):
    with (TABLES / "newton_quintic.csv").open(newline="") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    return [row for row in rows if row["x0"] == start]


def test_root_of_two():
    run = N.newton(N.parabola(-2.0), 1.0)
    printed = [1.0, 1.5, 1.416666666666667, 1.41421568627451, 1.41421356237469, 1.414213562373095]
    assert run.word == "converged"
    assert run.iterates[:, 0] == pytest.approx(printed, abs=1e-14)


@pytest.mark.parametrize(("c", "start", "word"), [
    (-2.0, 0.0, "singular derivative"), (2.0, 1.5, "no convergence in 24 updates"), (2.0, 0.0, "singular derivative"),
])  # fmt: skip
def test_failures_are_words(c, start, word):
    run = N.newton(N.parabola(c), start)
    assert run.word == word
    assert len(run.residuals) == (1 if start == 0.0 else 24)


@pytest.mark.parametrize(("start", "root"), [(2.3, 6.0), (2.4, 8.0), (2.5, 4.0), (-2.0, None)])
def test_quintic(start, root):
    run, rows = N.newton(N.quintic, start), quintic_rows(start)
    assert len(rows) == len(run.residuals)
    assert run.residuals[:, 0] == pytest.approx([row["f"] for row in rows], rel=1e-9, abs=1e-10)
    assert run.iterates[1:, 0] == pytest.approx([row["x_next"] for row in rows], rel=1e-10)
    slopes = [N.quintic(x)[1][0][0] for x in run.iterates[:-1]]
    assert slopes == pytest.approx([row["fx"] for row in rows], rel=1e-9)
    if root is None:
        assert run.word == "no convergence in 24 updates"
    else:
        assert run.word == "converged"
        assert run.last[0] == pytest.approx(root, abs=1e-13)


def test_slotted_arm():
    run = N.newton(N.slotted_arm(3.0 + 4.0j), 4.0, math.pi / 4)
    lengths = [4.0, 4.949747468305833, 4.996958835002408, 4.999999699023702, 4.999999999999888]
    assert run.word == "converged"
    assert run.iterates[:5, 0] == pytest.approx(lengths, abs=1e-14)
    assert run.last[1] == pytest.approx(0.9272952180016122, abs=1e-15)


def test_slotted_arm_at_its_pivot():
    """The determinant is r: with the pin in the pivot the arm has no direction."""
    assert N.newton(N.slotted_arm(3.0 + 4.0j), 0.0, 0.5).word == "singular Jacobian"


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_circle_and_line(side):
    run = N.newton(N.circle_and_line(4.0), side * math.pi / 4, side)
    assert run.word == "converged"
    assert side * run.last == pytest.approx([0.7227342478134157, 2.645751311064591], abs=1e-15)


def test_circle_that_does_not_reach_the_line():
    run = N.newton(N.circle_and_line(2.0), math.pi / 4, 1.0)
    assert run.word == "no convergence in 24 updates"
    assert np.linalg.norm(run.residuals, axis=1).min() >= 1.0


@pytest.mark.parametrize("q", [(1.0, -2.0, 1.0), (0.3, 1.7, -2.2)])
def test_dependent_equations(q):
    """Of the elementary symmetric polynomials and the power sum one depends on the others: rank 2 everywhere."""
    values, rows = N.dependent(np.array(q))
    assert values[2] == pytest.approx((values[0] ** 2 - values[1]) / 2, abs=1e-14)
    assert N.full_pivoting(np.array(rows))[0] == 2 == np.linalg.matrix_rank(rows)
    assert N.newton(N.dependent, *q).word == "singular Jacobian"
