"""Watt's six-bar swings under its own weight: motion, energies and pin forces.

The model is `models/watt_durango.yaml`: Durango, Giraldo, Calle & Mesa 2014, section 3.3 (figures 6 and 7).

Run from the repository: python examples/watt_swing.py [FOLDER of the picture]
"""

import sys
from pathlib import Path

import numpy as np

from gimcli import load
from gimcli.dynamics.simulation import Settings, simulate
from gimcli.dynamics.simulation_table import reactions
from gimcli.kernels.jit import compiled
from gimcli.output import write
from gimcli.output.graph import Axis, Curve, CurveGraph
from gimcli.output.panels import history_sheet

MODEL = Path(__file__).parents[1] / "models" / "watt_durango.yaml"
PERIOD = 3.59374750406788
"""From an energy integral, computed with 34 digits [s]."""

PEAKS = {"O2": 329.866685, "A": 262.922483, "E": 60.962363}
"""Largest pin forces by the same reference [N]."""


def main(folder: Path | None = None) -> None:
    """Simulate one period, compare it with the reference, and draw it."""
    mechanism = load(MODEL)
    times = np.linspace(0.0, PERIOD, 1801)
    found = simulate(mechanism, times, Settings(rtol=1e-11), compiled)
    first = found.events[0]
    assert first.kind == "standstill"
    assert abs(2.0 * first.time - PERIOD) < 1e-9
    forces = reactions(found)
    amounts = {}
    for pin in forces.statics.pins:
        node = mechanism.nodes[pin.node]
        if node in PEAKS:
            amounts[node] = np.abs(forces.pin(pin, pin.members[1]))
            assert abs(amounts[node].max() - PEAKS[node]) < 0.05, node  # the maximum may be between two rows
    print(f"a period of {2.0 * first.time:.12g} s; energy drift {found.worst_drift:.0e}")
    if folder is None:
        return
    kinetic, potential = found.energy[:2]
    over = Axis("time", "s")
    graphs = [
        CurveGraph(over, Axis("crank", "deg"), [Curve("crank", times, np.degrees(found.inputs[0, 0]))]),
        CurveGraph(over, Axis("speed", "rad/s"), [Curve("crank", times, found.inputs[1, 0])]),
        CurveGraph(
            over, Axis("energy", "J"),
            [Curve(n, times, e) for n, e in (("kinetic", kinetic), ("potential", potential), ("total", found.total))],
        ),
        CurveGraph(over, Axis("pin force", "N"), [Curve(node, times, amounts[node]) for node in PEAKS]),
    ]  # fmt: skip
    sheet = history_sheet(graphs, "Watt's six-bar swings under its own weight")
    write(sheet, folder / "watt_swing.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 and Path(sys.argv[1]).is_dir() else None)
