"""How many files of the package three short commands enter, and the most that they may.

A file is entered where a function of it, or the body of a class, runs; the bodies of modules do not count.

Usage: python files_entered.py [-v]
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from types import FrameType

import gimcli

MOST = {
    ("solve", "crank_rocker"): 80,
    ("trace", "crank_rocker", "--no-png"): 85,
    ("forces", "crank_press", "-o", "x.csv"): 130,
}
PACKAGE = Path(gimcli.__file__).parent


def run_counted(arguments: list[str]) -> None:
    """Run a command in this process and print the files that it enters to the standard error."""
    entered = set()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call" and frame.f_code.co_name != "<module>":
            entered.add(frame.f_code.co_filename)

    from gimcli.cli import main

    sys.argv = ["gim", *arguments]
    sys.setprofile(note)
    try:
        main()
    except SystemExit as stop:
        if stop.code:
            raise
    finally:
        sys.setprofile(None)
    own = sorted(os.path.relpath(name, PACKAGE) for name in entered if name.startswith(str(PACKAGE) + os.sep))
    print(*own, sep="\n", file=sys.stderr)


def files_entered(arguments: tuple[str, ...]) -> list[str]:
    """Return the files of the package that a command enters."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, __file__, "run", *arguments]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    return [line for line in done.stderr.splitlines() if line.endswith(".py")]


if __name__ == "__main__":
    if sys.argv[1:2] == ["run"]:
        run_counted(sys.argv[2:])
    else:
        for arguments, most in MOST.items():
            found = files_entered(arguments)
            print(f"gim {' '.join(arguments)}: {len(found)} files, at most {most}")
            if "-v" in sys.argv:
                print("", *found, sep="\n    ")
