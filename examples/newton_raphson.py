"""Newton-Raphson on the examples of Fraczek & Wojtyra's lecture notes: where it converges, and how it fails.

One equation and its failures (1.4 to 1.6), a quintic whose start decides the root (1.7), a slotted arm (the subject of
1.2 and 1.3) with its pin at a given place (1.8) and as a model with a crank of our own dimensions, a circle and a line
(1.9), dependent equations (1.10, 1.11). A failure is an answer in words, not an exception.

Run from the repository: python examples/newton_raphson.py [FOLDER of the picture]
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import gimcli
from gimcli.mechanism import FloatArray
from gimcli.output import write
from gimcli.output.graph import Axis, Curve, CurveGraph
from gimcli.output.panels import history_sheet
from gimcli.structure.constraint_jacobian import full_pivoting

TOLERANCE, UPDATES = 1e-10, 24
"""The largest residual at the end, and the largest number of updates, as in the notes."""

QUINTIC = np.array([1.0, -18.0, 105.0, -210.0, 104.0, -192.0])
"""(x^2 + 1)(x - 4)(x - 6)(x - 8), multiplied out; the other two roots are complex."""

PIVOT, CRANK = 3.0 + 2.0j, 2.0
"""Of the crank of the slotted arm, which turns about the origin: at 90 deg the pin is at (3, 4), as in 1.8."""

ARM = {
    "name": "Slotted arm",
    "units": {"length": "m", "angle": "deg"},
    "nodes": {"O": [0, 0], "C": [3, 2], "B": [3, 4], "D": [3.6, 4.8]},
    "ground": ["O", "C"],
    "links": {"crank": {"nodes": ["C", "B"], "length": 2}, "arm": {"nodes": ["O", "D"], "length": 6}},
    "prismatic": {"slot": {"node": "B", "guide": ["O", "D"]}},
    "actuators": {"motor": {"type": "rotary", "pivot": "C", "arm": "B", "law": {"from": 90, "to": 450}}},
    "trace": ["B"],
}

System = Callable[[FloatArray], tuple[Sequence[float], Sequence[Sequence[float]]]]
"""Residuals (n,) and their Jacobian (n, n) at q (n,)."""


@dataclass(frozen=True)
class Run:
    """Iterates (updates + 1, n) with the residuals (updates, n) before each update, and how the iteration ended."""

    word: str
    iterates: FloatArray
    residuals: FloatArray

    @property
    def last(self) -> FloatArray:
        """The last iterate (n,)."""
        return self.iterates[-1]


def newton(system: System, *start: float) -> Run:
    """Iterate until the residual before an update is small; the word is `converged`, or why it is not."""
    iterates, residuals, word = [np.array(start)], [], f"no convergence in {UPDATES} updates"
    for _ in range(UPDATES):
        residual, jacobian = map(np.array, system(iterates[-1]))
        residuals.append(residual)
        if full_pivoting(jacobian)[0] < len(start):
            word = "singular derivative" if len(start) == 1 else "singular Jacobian"
            break
        iterates.append(iterates[-1] - np.linalg.solve(jacobian, residual))
        if np.abs(residual).max() <= TOLERANCE:
            word = "converged"
            break
    return Run(word, np.array(iterates), np.array(residuals))


def parabola(c: float) -> System:
    """Return x^2 + c = 0 (1.4 to 1.6)."""
    return lambda q: ([q[0] ** 2 + c], [[2.0 * q[0]]])


def quintic(q: FloatArray) -> tuple[list[float], list[list[float]]]:
    """Return the quintic of 1.7 and its derivative."""
    x = q[0]
    return [(x * x + 1.0) * (x - 4.0) * (x - 6.0) * (x - 8.0)], [[float(np.polyval(np.polyder(QUINTIC), x))]]


def slotted_arm(pin: complex) -> System:
    """Return the equations of an arm with its pin at a given place; q: distance of the pin, angle of the arm (1.8)."""

    def equations(q: FloatArray) -> tuple[list[float], list[list[float]]]:
        r, (c, s) = q[0], (np.cos(q[1]), np.sin(q[1]))
        return [r * c - pin.real, r * s - pin.imag], [[c, -r * s], [s, r * c]]

    return equations


def circle_and_line(r: float) -> System:
    """Return r (cos, sin) = (3, y), a circle and the line x = 3; q: angle, y (1.9)."""

    def equations(q: FloatArray) -> tuple[list[float], list[list[float]]]:
        c, s = np.cos(q[0]), np.sin(q[0])
        return [r * c - 3.0, r * s - q[1]], [[-r * s, 0.0], [r * c, -1.0]]

    return equations


def dependent(q: FloatArray) -> tuple[list[float], list[list[float]]]:
    """Return three equations of which the third follows from the others: F3 = (F1^2 - F2) / 2 (1.10)."""
    a, b, c = q
    values = [a + b + c, a * a + b * b + c * c - 6.0, a * b + a * c + b * c + 3.0]
    return values, [[1.0, 1.0, 1.0], [2.0 * a, 2.0 * b, 2.0 * c], [b + c, a + c, a + b]]


def independent(q: FloatArray) -> tuple[list[float], list[list[float]]]:
    """Return the same with q3 = 1 in the place of the equation that elimination finds without a pivot."""
    values, rows = dependent(q)
    (spare,) = full_pivoting(np.array(rows))[1]
    values[spare], rows[spare] = q[2] - 1.0, [0.0, 0.0, 1.0]
    return values, rows


def arm_of_the_model() -> None:
    """Compare the model's arm with its closed form over a turn, and one position with Newton-Raphson."""
    model = gimcli.load(ARM)
    motion = gimcli.trace(model, steps=72, measure="angle:arm")
    pin = PIVOT + CRANK * np.exp(1j * np.radians(motion["motor"]))
    assert np.abs(motion["angle:arm"] - np.degrees(np.angle(pin))).max() < 1e-11, "the arm points to the pin"
    position = gimcli.solve(model, motor=90)
    r, angle = newton(slotted_arm(3.0 + 4.0j), 4.0, np.pi / 4.0).last
    assert abs(np.radians(position.angle["arm"]) - angle) < 1e-13, "the same angle, atan(4/3)"
    assert abs(abs(complex(*position.xy["B"])) - r) < 1e-13, "and the same distance, 5"


def basins(first: float, last: float) -> CurveGraph:
    """Return the root over the start, with gaps where the root changes or is not found in 24 updates."""
    starts = np.linspace(first, last, 1401)
    found = [newton(quintic, x) for x in starts]
    ends = np.array([run.last[0].round(9) if run.word == "converged" else np.nan for run in found])
    change = np.flatnonzero(np.diff(ends) != 0.0) + 1
    gaps = np.insert(starts, change, starts[change]), np.insert(ends, change, np.nan)
    return CurveGraph(Axis("start"), Axis("root"), [Curve("root", *gaps)])


def picture(runs: dict[str, Run], folder: Path) -> None:
    """Draw the residuals of the quintic, and the root over the start; a residual of 0 has no logarithm."""
    curves = []
    for start, run in runs.items():
        size = np.abs(run.residuals[:, 0])
        size[size == 0.0] = np.nan
        curves.append(Curve(f"from {start}", np.arange(len(size)), np.log10(size)))
    residuals = CurveGraph(Axis("updates"), Axis("log10 |f|"), curves)
    graphs = [residuals, basins(-3.0, 11.0), basins(2.2, 2.6)]
    sheet = history_sheet(graphs, "Newton-Raphson on (x² + 1)(x - 4)(x - 6)(x - 8)")
    write(sheet, folder / "newton_raphson.png")


def main(folder: Path | None = None) -> None:
    """Solve all examples, compare them with the notes, and draw the quintic."""
    root = newton(parabola(-2.0), 1.0)
    assert abs(root.last[0] - np.sqrt(2.0)) < 1e-15, "1.4"
    assert newton(parabola(-2.0), 0.0).word == "singular derivative", "1.5"
    assert newton(parabola(2.0), 1.5).word == "no convergence in 24 updates", "1.6: no real root"
    runs = {f"{x:g}": newton(quintic, x) for x in (2.3, 2.4, 2.5, -2.0)}
    ends = [run.last[0] if run.word == "converged" else None for run in runs.values()]
    assert ends[3] is None, "1.7: not in 24 updates from -2"
    assert np.abs(np.array(ends[:3], float) - [6.0, 8.0, 4.0]).max() < 1e-13, "1.7: neighbouring starts, other roots"
    arm_of_the_model()
    upper, lower = newton(circle_and_line(4.0), np.pi / 4.0, 1.0), newton(circle_and_line(4.0), -np.pi / 4.0, -1.0)
    exact = np.array([np.arccos(0.75), np.sqrt(7.0)])
    assert max(np.abs(upper.last - exact).max(), np.abs(lower.last + exact).max()) < 1e-14, "1.9: two intersections"
    none = newton(circle_and_line(2.0), np.pi / 4.0, 1.0)
    assert none.word != "converged", "1.9: no intersection"
    assert np.abs(none.residuals).max(axis=1).min() >= 1.0, "the line is 1 away from the circle"
    assert full_pivoting(np.array(dependent(np.array([1.0, -2.0, 1.0]))[1]))[0] == 2, "1.10: rank 2 of 3"
    three, two = newton(dependent, 2.0, -3.0, 1.5), newton(independent, 2.0, -3.0, 1.5)
    assert three.word == "singular Jacobian", "1.10: no unique solution"
    assert np.abs(two.last - [1.0, -2.0, 1.0]).max() < 1e-14, "one of the solutions"
    assert np.abs(dependent(two.last)[0]).max() < 1e-14, "the spare equation holds too"
    for start, run in runs.items():
        print(f"quintic from {start}: {run.word}, x = {run.last[0]:.12g}")
    print(f"circle of radius 2 and line x = 3: {none.word}; dependent equations: {three.word}")
    if folder is not None:
        picture(runs, folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 and Path(sys.argv[1]).is_dir() else None)
