"""CPU time of whole commands compared with the necessary imports, run alternately; prints the ratios.

Run: python tests/benchmarks/start_up.py [runs]
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

MODEL = Path(__file__).parents[2] / "models" / "crank_rocker.yaml"
IMPORTS = "import numpy, typer, pydantic, yaml"
GIM = "from gimcli.cli import main; main()"


def cpu(*arguments: str) -> float:
    """Return the CPU time of a child process [s]."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", *arguments], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Compare traces of 360 steps with the necessary imports."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    with tempfile.TemporaryDirectory() as folder:
        trace = (GIM, "trace", str(MODEL), "--steps", "360", "--out", folder)
        pairs = {
            "gim --help / bare python": ((GIM, "--help"), ("pass",)),
            "trace, no picture / imports (at most 1.5)": ((*trace, "--no-png"), (IMPORTS,)),
            "trace with picture / imports and Figure (at most 1.6)": (
                trace,
                (IMPORTS + "; from matplotlib.figure import Figure",),
            ),
        }
        for name, (ours, theirs) in pairs.items():
            cpu(*ours), cpu(*theirs)
            times = [(cpu(*ours), cpu(*theirs)) for _ in range(runs)]
            a, b = (statistics.median(t[k] for t in times) for k in (0, 1))
            ratio = statistics.median(x / y for x, y in times)
            print(f"{name}: {a:.3f} s / {b:.3f} s = {ratio:.2f}")


if __name__ == "__main__":
    main()
