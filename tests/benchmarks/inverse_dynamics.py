"""Processor time per step of a four-bar's inverse dynamics: positions, velocities and accelerations, forces.

Run: python tests/benchmarks/inverse_dynamics.py [--steps 100000] [--repeats 7]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import machine

from gimcli import Mechanism, load
from gimcli.dynamic_data import Inertia
from gimcli.dynamics.forces import inverse_dynamics
from gimcli.dynamics.kinematic_history import Courses, Turns
from gimcli.dynamics.statics import statics
from gimcli.kernels.jit import compiled
from gimcli.mechanism import Dynamics
from gimcli.motion.motion import trace
from gimcli.positions.options import Options


def weighted(name: str) -> Mechanism:
    """Return a model with masses and gravity."""
    mechanism = load(machine.MODELS / f"{name}.yaml")
    bars = tuple(Inertia(k, 1.0, 0.01, m.shape.mean()) for k, m in enumerate(mechanism.members[1:], start=1))
    return replace(mechanism, dynamics=Dynamics(1.0, bars, gravity=-9.81j))


def least(call: Callable[[], object], repeats: int) -> float:
    """Return the shortest processor time of some calls [s]."""
    times = []
    for _ in range(repeats):
        begin = time.thread_time()
        call()
        times.append(time.thread_time() - begin)
    return min(times)


def main(arguments: Sequence[str] | None = None) -> None:
    """Time the three parts in one process and write a CSV file."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--out", type=Path, default=machine.RESULTS)
    chosen = parser.parse_args(arguments)
    rows: list[machine.Row] = []
    options = Options(jit="on")
    for name in ("crank_rocker", "watt_1"):
        mechanism = weighted(name)
        motion, courses, bodies = (
            trace(mechanism, chosen.steps, options),
            Courses(mechanism, 0, "on"),
            statics(mechanism),
        )
        course = courses(motion)
        inverse_dynamics(bodies, course, compiled)
        parts = {
            "positions": least(lambda m=mechanism: trace(m, chosen.steps, options), chosen.repeats),
            "accelerations": least(lambda m=motion, c=courses: c(m), chosen.repeats),
            "forces": least(lambda b=bodies, c=course: inverse_dynamics(b, c, compiled, Turns()), chosen.repeats),
        }
        each = {part: 1e9 * seconds / chosen.steps for part, seconds in parts.items()}
        rows.append({"mechanism": name, "steps": chosen.steps, **{k: round(v, 1) for k, v in each.items()}})
        print(
            name, ", ".join(f"{k} {v:.0f} ns" for k, v in each.items()), f"together {sum(each.values()):.0f} ns a step"
        )
    machine.keep("inverse_dynamics", rows, chosen.out)


if __name__ == "__main__":
    main()
