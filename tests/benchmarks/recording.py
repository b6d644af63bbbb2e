"""Record what every command prints and writes for every shipped model, and compare two recordings.

    python tests/benchmarks/recording.py record FOLDER [--only jansen,watt_1]
    python tests/benchmarks/recording.py compare OLD NEW [--tolerance 1e-12]

The recording of another commit is made in a worktree of it (`git worktree add`). Words must be equal; a number may
differ by the tolerance times the largest number of its text (or times 1). `tradeoff` prints times and is left out.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "oracles"))

from in_process import ran

from gimcli import GimError, load, shipped_models

LINES = {
    "check": "check MODEL --json -o check.csv",
    "check in words": "check MODEL",
    "solve": "solve MODEL --json --velocities -o solve.csv",
    "solve in words": "solve MODEL --velocities",
    "solve --all": "solve MODEL --all --json",
    "trace": "trace MODEL --steps 72 --derivatives 2 --json -o trace.csv",
    "trace in words": "trace MODEL --steps 72 -o trace.csv",
    "trace --circuit": "trace MODEL --steps 72 --circuit --json -o circuit.csv",
    "trace reverse": "trace MODEL --steps 72 --at-limit reverse --json -o reverse.csv",
    "workspace": "workspace MODEL --json -o workspace.csv",
    "sweep": "sweep MODEL --vary NUMBER --steps 36 --json -o sweep.csv",
    "sensitivity": "sensitivity MODEL --json -o sensitivity.csv",
    "mobility": "mobility MODEL --json",
    "mobility in words": "mobility MODEL",
    "groups": "groups MODEL --json",
    "groups in words": "groups MODEL",
    "sequence": "sequence MODEL --explain --json",
    "sequence in words": "sequence MODEL --explain",
    "singularities": "singularities MODEL --json -o singularities.csv",
    "singularities in words": "singularities MODEL",
    "circuits": "circuits MODEL --json -o circuits.csv",
    "equilibrium": "equilibrium MODEL --json -o equilibrium.csv",
    "forces": "forces MODEL --json -o forces.csv",
    "forces in words": "forces MODEL",
    "modes": "modes MODEL --json",
    "simulate": "simulate MODEL --time 0.5 --json -o simulate.csv",
    "reduce": "reduce MODEL --json -o reduce.csv",
    "convert": "convert MODEL --to pmks+",
    "check --long": "check MODEL --long",
}
"""Command lines; NUMBER is the first dimension of the model that is not 0, within 1 %."""

NUMERAL = re.compile(r"-?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


def recorded(model: str) -> dict[str, dict[str, object]]:
    """Return exit status, texts and text files of each command line."""
    found = {}
    for name, line in LINES.items():
        with tempfile.TemporaryDirectory() as folder:
            words = [
                {"MODEL": model, "NUMBER": varied(model) if "NUMBER" in line else ""}.get(w, w) for w in line.split()
            ]
            try:
                done = ran(*words, cwd=folder)
                code, printed = done.code, (done.text, done.error)
            except Exception as error:
                code, printed = -1, ("", f"{type(error).__name__}: {error}")
            files = {path.name: path.read_text() for path in sorted(Path(folder).glob("*.csv"))}
        found[name] = {"code": code, "text": printed[0], "error": printed[1], **files}
    return found


def varied(model: str) -> str:
    """Return three values for the first dimension of a member or node that is not 0."""
    try:
        dimensions = load(model).written.dimensions
    except GimError:
        return "none=1"
    name, value = next((name, one.value) for name, one in dimensions.items() if one.value and "." in name)
    return f"{name}={value}:{1.01 * value}:3"


def compared(old: str, new: str, tolerance: float) -> str:
    """Return the first difference of two texts; an empty text if there is none."""
    if NUMERAL.sub("#", old) != NUMERAL.sub("#", new):
        pairs = zip(old.splitlines(), new.splitlines(), strict=False)
        lines = [(a, b) for a, b in pairs if NUMERAL.sub("#", a) != NUMERAL.sub("#", b)]
        return "words: " + (" -> ".join(text[:150] for text in lines[0]) if lines else "more or fewer lines")
    numbers = [list(map(float, NUMERAL.findall(text))) for text in (old, new)]
    size = max(1.0, max(map(abs, numbers[0]), default=1.0))
    apart = max((abs(a - b) for a, b in zip(*numbers, strict=True)), default=0.0)
    return f"numbers: {apart:.1e} of {size:g}" if not apart <= tolerance * size else ""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("task", choices=("record", "compare"))
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--tolerance", type=float, default=1e-12)
    given = parser.parse_args()
    names = given.only.split(",") if given.only else [one.name for one in shipped_models()]
    if given.task == "record":
        given.folders[0].mkdir(parents=True, exist_ok=True)
        for name in names:
            path = given.folders[0] / f"{name}.json"
            if not path.exists():
                path.write_text(json.dumps(recorded(name), indent=0))
                print(name, flush=True)
        return
    for name in names:
        old, new = (json.loads((folder / f"{name}.json").read_text()) for folder in given.folders)
        for line in old:
            for part in sorted({*old[line], *new.get(line, {})}):
                texts = (str(one.get(line, {}).get(part, "")) for one in (old, new))
                difference = compared(*texts, given.tolerance)
                if difference:
                    print(f"{name}: {line}: {part}: {difference}")


if __name__ == "__main__":
    main()
