"""Every example asserts its own physics; here each is run."""

import runpy

import pytest
from bundled import ROOT

EXAMPLES = sorted((ROOT / "examples").glob("*.py"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda p: p.stem)
def test_example(path):
    runpy.run_path(str(path), run_name="__main__")
