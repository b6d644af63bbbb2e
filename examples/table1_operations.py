"""Table 1 of the GIM paper: operations of sweeps and of Newton-Raphson, by the paper's formulas and as counted.

The paper: 4, 7, 18, 22 sweeps of 12 operations per moving node; 4, 4-5, 4, 4-5 iterations of 9 E^3 operations, E being
the number of moving links. The paper gives neither dimensions nor sequences; the written sequences reproduce its
numbers of sweeps. Beside them stands what the rules of the paper give with our dimensions (inf: no convergence).

Run from the repository: python examples/table1_operations.py
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gimcli import load
from gimcli.comparison.methods import COORDINATES, follow
from gimcli.comparison.operations import coordinates_cost, paper_iteration, paper_sweep, plan_cost, sweep_cost
from gimcli.gim.sweeper import Sweeper, parse_moves, radius_at
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.motion.assemble import Assembler
from gimcli.motion.solve import random_guess, solve
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options
from gimcli.structure.plan import make_plan
from gimcli.structure.residual import residual

MODELS = Path(__file__).parents[1] / "models"
STOP, TIGHT = 1e-5, 1e-12
STARTS = 50
MOST = 2000  # sweeps by the rules of the paper
HEAD = "           sweeps rules   paper    real  rho  to 1e-12 | absolute  paper   real  joint natural   auto  to 1e-12"


@dataclass(frozen=True)
class Case:
    """One column of the table."""

    model: str
    step: float  # deg, from the drawn position
    sequence: str
    sweeps: int  # in the paper
    rules: float  # sweeps by the rules of the paper, with our dimensions; infinite: more than MOST
    iterations: tuple[int, ...]  # of Newton-Raphson in the paper


CASES = (
    Case("gim_fig13a", 30.0, "B>C D>C", 4, 4, (4,)),
    Case("gim_fig13b", 10.0, "B>C D>C B>E C>E E>F G>F", 7, 7, (4, 5)),
    Case("gim_fig13c", -10.0, "T>X S>V X>W W>U Q>U U>V V>W W>Y R>Y Y>X", 18, 277, (4,)),
    Case(
        "ten_bar",
        5.0,
        "j2>j13 j2>j8 j8>j4 j3>j4 j4>j9 j9>j10 j10>j11 j7>j11 j11>j12 j7>j12 j12>j13 j13>j8 j8>j9 j9>j6 j5>j6 j6>j10",
        22,
        math.inf,
        (4, 5),
    ),
)


def displaced(case: Case) -> tuple[Mechanism, FloatArray, ComplexArray]:
    """Return the mechanism, the inputs one step after the drawn position, and the nodes before the step."""
    mechanism = load(MODELS / f"{case.model}.yaml")
    drawn = mechanism.drawn_inputs
    start = solve(mechanism, drawn, Options(tolerance=1e-13)).z
    return mechanism, drawn + math.radians(case.step), start


def measure(case: Case) -> dict[str, float]:
    """Return sweeps and iterations of one mechanism, and their operations."""
    mechanism, inputs, start = displaced(case)
    swept = [solve(mechanism, inputs, Options("gim", tolerance=t, moves=case.sequence)) for t in (STOP, TIGHT)]
    found = {"sweeps": float(swept[0].sweeps), "tight sweeps": float(swept[1].sweeps), "rho": radius_at(swept[1])}
    ruled = solve(mechanism, inputs, Options("gim", "classic", tolerance=STOP, sweeps=MOST))
    found["rules"] = float(ruled.sweeps) if ruled.status.solved else math.inf
    found["paper"] = paper_sweep(mechanism) * found["sweeps"]
    found["real"] = sweep_cost(mechanism, parse_moves(mechanism, case.sequence)).operations(found["sweeps"])
    unit = 1.0 / mechanism.scale  # corrections in the file's unit and in rad, as in the paper
    for name, make in COORDINATES.items():
        system = make(mechanism)
        counts = [
            float(follow(system, inputs[:, None], start, t, plain, length=unit).iterations[0]) for t in (STOP, TIGHT)
        ]
        found[f"{name} iterations"], found[f"tight {name}"] = counts
        found[f"real {name}"] = coordinates_cost(system).operations(counts[0])
    found["paper absolute"] = paper_iteration(mechanism) * found["absolute iterations"]
    plan = make_plan(mechanism)
    work = Assembler(mechanism, plan, plain, STOP).assemble(inputs, start).work
    found["real auto"] = plan_cost(mechanism, plan).operations(work)
    return found


def from_far(case: Case) -> tuple[int, int]:
    """Return from how many random starts sweeps converge, and Newton-Raphson in absolute coordinates."""
    mechanism, inputs, _ = displaced(case)
    sweeper = Sweeper(mechanism, Options("gim", tolerance=STOP, moves=case.sequence), plain)
    system, swept, newton = COORDINATES["absolute"](mechanism), 0, 0
    for seed in range(STARTS):
        guess = random_guess(mechanism, seed)
        swept += sweeper.settle(inputs, guess).good
        found = follow(system, inputs[:, None], guess, STOP, plain)
        newton += bool(residual(mechanism, found.z, inputs[:, None]).total[0] < 1e-3)
    return swept, newton


def main() -> None:
    """Print the table; check the paper's counts, and show where its conclusion does not hold."""
    rows = [measure(case) for case in CASES]
    print(HEAD)
    for case, r in zip(CASES, rows, strict=True):
        print(
            f"{case.model:10s} {r['sweeps']:6.0f} {r['rules']:5.0f} {r['paper']:7.0f} {r['real']:7.0f} {r['rho']:5.3f}"
            f" {r['tight sweeps']:7.0f}  | {r['absolute iterations']:8.0f} {r['paper absolute']:6.0f}"
            f" {r['real absolute']:6.0f} {r['real joint']:6.0f} {r['real natural']:7.0f} {r['real auto']:6.0f}"
            f" {r['tight absolute']:8.0f}"
        )
        assert r["sweeps"] == case.sweeps, "sweeps as in the paper"
        assert r["rules"] == case.rules, (
            "the rules of the paper: as many sweeps for two, many or too many for the others"
        )
        assert r["absolute iterations"] in case.iterations, "iterations as in the paper"
        assert r["paper"] < r["paper absolute"], "by the paper's formulas, sweeps need fewer operations"
        more = np.log(TIGHT / STOP) / np.log(r["rho"])
        assert abs(r["tight sweeps"] - r["sweeps"] - more) < 1.0 + 0.1 * more, "sweeps increase like ln(eps) / ln(rho)"
        assert r["tight absolute"] <= r["absolute iterations"] + 2, "Newton-Raphson needs one or two iterations more"
        assert r["real auto"] < 0.6 * r["paper absolute"], "with few unknowns it needs fewer than 9 E^3 operations"
    far = [from_far(case) for case in CASES]
    print(
        f"of {STARTS} random starts converge by sweeps:",
        *(s for s, _ in far),
        "and by iterations:",
        *(n for _, n in far),
    )
    assert all(swept < STARTS for swept, _ in far[1:]), "sweeps do not converge from every start"
    assert far[-1][0] < STARTS // 4, "for the ten-bar, sweeps converge from few starts"
    assert [r["paper"] for r in rows] == [48.0, 252.0, 1080.0, 2112.0], "12 nnod nit"
    assert all(r["real auto"] < r["real"] for r in rows[2:]), "fewer operations than sweeps for larger groups"


if __name__ == "__main__":
    main()
