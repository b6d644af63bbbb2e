"""Time of velocities and accelerations compared with that of positions, and with pylinkage.

Run: python tests/benchmarks/rates.py [--steps 100000] [--repeats 7]

All programs run alternately in one process on one thread, compiled; the best CPU time of the repeats counts.
"positions" are those of `gim trace` without writing; derivatives are velocities, accelerations and jerks of the traced
points and of all members. "ns per position" is the time per position, by comparison with a call of a hundredth of the
steps. Target: two derivatives take at most 2.5 times the time of the positions. The run stops if accelerations differ
from differences of positions of the loops by hand by more than 1e-6 of the largest acceleration.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from machine import MODELS, Row, compare_all, interleaved  # isort: skip - first: one thread
import by_hand
import numpy as np
import peers
from influence_coefficients import Influence

from gimcli import Mechanism, load
from gimcli.kernels import jit
from gimcli.motion.motion import Motion, trace
from gimcli.positions.options import Options
from gimcli.rates.derivatives import TracedRates

NAMES = ("crank_rocker", "jansen", "stephenson_3_far", "platform_3rrr")
MOST = 2.5
AGREEMENT = 1e-6
CHECKED = 2000
"""Number of steps for the comparison of accelerations with differences."""


def positions(mechanism: Mechanism, steps: int) -> Motion:
    """Trace a loaded mechanism with compiled kernels."""
    return trace(mechanism, steps, Options(jit="on"))


def differentiated(mechanism: Mechanism, steps: int, order: int) -> np.ndarray:
    """Trace with derivatives; return those of the traced points (order, points, rows) in the file's unit."""
    rates_of = TracedRates(mechanism, mechanism.traced, order, steps + 1, "on")
    return rates_of(positions(mechanism, steps))[0] * mechanism.scale


def apart(name: str, mechanism: Mechanism) -> float:
    """Return the largest relative error of accelerations; the reference is differences of the loop by hand."""
    x = by_hand.trace(name, CHECKED)
    z = x[:, 0] + 1j * x[:, 1]
    bend = (-(z[:, 4:] + z[:, :-4]) + 16.0 * (z[:, 3:-1] + z[:, 1:-3]) - 30.0 * z[:, 2:-2]) / 12.0 * CHECKED**2
    found = differentiated(mechanism, CHECKED, 2)[1][:, 2:-2] * mechanism.duration**2
    far = float(np.max(np.abs(found - bend)) / np.max(np.abs(bend)))
    if not far <= AGREEMENT:
        raise SystemExit(f"{name}: accelerations differ by {far:.1e} from differences of positions")
    return far


def peer(name: str, mechanism: Mechanism, steps: int) -> tuple[dict[str, Callable[[int], object]], Row]:
    """Return pylinkage's program, if it can solve the mechanism, and its row."""
    program = "pylinkage, 2 derivatives"
    line = row(name, program, steps)
    try:
        run = peers.pylinkage_rates(peers.LINKAGES[name])
        theirs = run(CHECKED)[2]
    except peers.UnableError as reason:
        return {}, line | {"note": f"cannot: {reason}"}
    except ImportError:
        return {}, line | {"note": "not installed"}
    ours = differentiated(mechanism, CHECKED, 2)[1, 0, 1:] * mechanism.duration**2
    return {program: run}, line | {"difference": float(f"{np.max(np.abs(theirs - ours)) / np.max(np.abs(ours)):.1e}")}


def row(mechanism: str, program: str, steps: int) -> Row:
    """Return a row of the table; cells without a measurement are empty."""
    heads = ("ns, whole call", "ns per position", "ratio", "whole ratio", "difference", "note")
    return {"mechanism": mechanism, "program": program, "steps": steps} | dict.fromkeys(heads, "")


def compare(name: str, steps: int, repeats: int) -> list[Row]:
    """Return the rows of one mechanism."""
    mechanism = load(MODELS / f"{name}.yaml")
    far = apart(name, mechanism)
    programs: dict[str, Callable[[int], object]] = {"positions": lambda n: positions(mechanism, n)}
    for order in (1, 2, 3):
        programs[f"{order} derivatives"] = lambda n, order=order: differentiated(mechanism, n, order)
    others, last = peer(name, mechanism, steps)
    programs |= others
    few = max(1, steps // 100)
    timed = {(p, n): lambda run=run, n=n: run(n) for p, run in programs.items() for n in (steps, few)}
    best = interleaved(timed, repeats, time.thread_time)
    lines = [row(name, p, steps) for p in programs if p not in others] + [last]
    each = {p: (best[p, steps] - best[p, few]) / (steps - few) * 1e9 for p in programs}
    for line in lines:
        p = str(line["program"])
        if p in programs:
            whole = best[p, steps] / steps * 1e9
            line |= {"ns, whole call": round(whole, 1), "ns per position": round(each[p], 1)}
            line |= {"ratio": round(each[p] / each["positions"], 2)}
            line |= {"whole ratio": round(whole / (best["positions", steps] / steps * 1e9), 2)}
    lines[2] |= {"difference": float(f"{far:.1e}"), "note": f"target: a ratio of at most {MOST:g}"}
    return lines + coefficients(name, mechanism, steps, repeats)


def coefficients(name: str, mechanism: Mechanism, steps: int, repeats: int) -> list[Row]:
    """Return rows of the influence coefficients of all nodes: all positions in one call, and one call per position."""
    motion = positions(mechanism, steps)
    influence = Influence(mechanism, run=jit.compiled)
    rate = np.ones_like(motion.inputs)
    z, q, v = (np.ascontiguousarray(part[:, steps // 3]) for part in (motion.z, motion.inputs, rate))
    calls = min(1000, steps)
    timed: dict[str, tuple[int, Callable[[], object]]] = {
        "B": (steps, lambda: influence.over(motion.z, motion.inputs)),
        "B, bias, dB": (steps, lambda: influence.over(motion.z, motion.inputs, rate)),
        "B, one call each": (calls, lambda: [influence.at(z, q) for _ in range(calls)]),
        "B, bias, dB, one call each": (calls, lambda: [influence.at(z, q, v) for _ in range(calls)]),
    }
    best = interleaved({p: run for p, (_, run) in timed.items()}, repeats, time.thread_time)
    return [row(name, p, n) | {"ns, whole call": round(best[p] / n * 1e9, 1)} for p, (n, _) in timed.items()]


def main(arguments: list[str] | None = None) -> None:
    """Compare all mechanisms."""
    compare_all(str(__doc__), NAMES, compare, "rates", arguments)


if __name__ == "__main__":
    main()
