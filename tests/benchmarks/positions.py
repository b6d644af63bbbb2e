"""Time per position, compared with loops written by hand for one mechanism and with other programs.

Run: python tests/benchmarks/positions.py [--steps 100000] [--repeats 7]

All programs run alternately in one process on one thread; the best of the repeats counts. A call of `gim` makes a plan,
assembles the start and checks its arguments, in about 1.5 ms. "ns per position" is the time without this, by comparison
with a call of a hundredth of the steps; "ns, whole call" includes it. Ratios of `gim`: time per position over that of
the loop by hand, which prepares nothing (target: at most 1.5), and the same for whole calls. Ratio of another program:
its time over a whole call of `gim` (target: at least 3, for coupled groups 50). The run stops if `gim` differs from the
loop by hand by more than 1e-9 of the size.
"""

from __future__ import annotations

from collections.abc import Callable

from machine import MODELS, Row, compare_all, interleaved  # isort: skip - first: one thread
import by_hand
import numpy as np
import peers

from gimcli import Mechanism, load
from gimcli.motion.motion import Motion, trace
from gimcli.motion.summary import traced_paths
from gimcli.positions.options import Options

COUPLED = {"crank_rocker": False, "jansen": False, "stephenson_3_far": True, "platform_3rrr": True}
HAND = 1.5
PEER = {False: 3.0, True: 50.0}
AGREEMENT = 1e-9
FEWEST = 20


def ours(mechanism: Mechanism, steps: int) -> Motion:
    """Trace a loaded mechanism with compiled kernels."""
    return trace(mechanism, steps, Options(jit="on"))


def sides(name: str, mechanism: Mechanism) -> dict[str, Callable[[int], object]]:
    """Return `gim` and the loops by hand as functions of the number of steps."""
    return {
        "gim": lambda steps: ours(mechanism, steps),
        "gim, with the traced points": lambda steps: traced_paths(ours(mechanism, steps)),
        "by hand": lambda steps: by_hand.trace(name, steps),
        "by hand, all nodes": lambda steps: by_hand.trace(name, steps, True),
    }


def apart(name: str, mechanism: Mechanism, steps: int) -> float:
    """Return the largest difference of the traced points from the loop by hand, relative to the size."""
    theirs = by_hand.trace(name, steps)
    paths = traced_paths(ours(mechanism, steps)).values()
    worst = max(np.max(np.abs(p - (q[0] + 1j * q[1]))) for p, q in zip(paths, theirs, strict=True))
    far = float(worst / (mechanism.size * mechanism.scale))
    if not far <= AGREEMENT:
        raise SystemExit(f"{name}: gim and the loop by hand differ by {far:.1e} of the size")
    return far


def peers_of(name: str, mechanism: Mechanism, steps: int) -> tuple[dict[str, tuple[peers.Trace, int]], list[Row]]:
    """Return the other programs that can solve a mechanism, with their steps, and rows for the others."""
    able: dict[str, tuple[peers.Trace, int]] = {}
    rows: list[Row] = []
    for peer, (build, fewer) in peers.PEERS.items():
        count = max(FEWEST, steps // fewer)
        try:
            run = build(peers.LINKAGES[name])
            path, hand = run(count), by_hand.trace(name, count)[0]
            far = np.max(np.abs(path - (hand[0] + 1j * hand[1])[1:])) / (mechanism.size * mechanism.scale)
            able[peer] = run, count
            rows.append(row(name, peer, count, difference=float(far)))
        except peers.UnableError as reason:
            rows.append(row(name, peer, 0, note=f"cannot: {reason}"))
        except ImportError:
            rows.append(row(name, peer, 0, note="not installed"))
    return able, rows


def row(mechanism: str, program: str, steps: int, **values: object) -> Row:
    """Return a row of the table; cells without a measurement are empty."""
    heads = ("ns, whole call", "ns per position", "ratio", "whole ratio", "target", "met", "difference", "note")
    return {"mechanism": mechanism, "program": program, "steps": steps} | dict.fromkeys(heads, "") | values


def compare(name: str, steps: int, repeats: int) -> list[Row]:
    """Return the rows of one mechanism."""
    mechanism = load(MODELS / f"{name}.yaml")
    far = apart(name, mechanism, steps)
    programs = sides(name, mechanism)
    able, rows = peers_of(name, mechanism, steps)
    few = max(1, steps // 100)
    timed = {(p, n): lambda run=run, n=n: run(n) for p, run in programs.items() for n in (steps, few)}
    timed |= {(p, n): lambda run=run, n=n: run(n) for p, (run, n) in able.items()}
    best = interleaved(timed, repeats)
    whole = {p: best[p, steps] / steps * 1e9 for p in programs}
    each = {p: (best[p, steps] - best[p, few]) / (steps - few) * 1e9 for p in programs}
    each |= {p: whole[p] for p in programs if p.startswith("by hand")}
    result = [
        row(name, p, steps, **{"ns, whole call": round(whole[p], 1), "ns per position": round(each[p], 1)})
        for p in each
    ]
    for line in result:
        program = str(line["program"])
        if program.startswith("gim"):
            ratio = each[program] / whole["by hand"]
            line |= {"ratio": round(ratio, 2), "whole ratio": round(whole[program] / whole["by hand"], 2)}
            line |= {
                "target": f"<= {HAND:g}",
                "met": "yes" if ratio <= HAND else "no",
                "difference": float(f"{far:.1e}"),
            }
    for line in rows:
        if not line["note"]:
            ns = best[str(line["program"]), line["steps"]] / int(str(line["steps"])) * 1e9
            ratio, aim = ns / whole["gim"], PEER[COUPLED[name]]
            line |= {"ns, whole call": round(ns, 1), "ratio": round(ratio, 2), "target": f">= {aim:g}"}
            line |= {"met": "yes" if ratio >= aim else "no", "difference": float(f"{line['difference']:.1e}")}
    return result + rows


def main(arguments: list[str] | None = None) -> None:
    """Compare all mechanisms."""
    compare_all(str(__doc__), COUPLED, compare, "positions", arguments)


if __name__ == "__main__":
    main()
