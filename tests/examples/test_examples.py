"""Every example asserts its own physics; here each is run."""

import runpy

import pytest
from bundled import ROOT

LONG = ("nine_points", "table1_operations")
EXAMPLES = [
    pytest.param(path, id=path.stem, marks=[pytest.mark.soak] if path.stem in LONG else [])
    for path in sorted((ROOT / "examples").glob("*.py"))
]


@pytest.mark.parametrize("path", EXAMPLES)
def test_example(path):
    runpy.run_path(str(path), run_name="__main__")
