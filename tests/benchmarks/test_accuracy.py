"""The manual's table of ill-conditioned mechanisms agrees with measurements."""

import pytest
from accuracy import CASES, METHODS, attained
from bundled import MANUAL

ROWS = {
    cells[0]: cells[2:]
    for line in (MANUAL / "accuracy.md").read_text(encoding="utf-8").splitlines()
    if (cells := [c.strip() for c in line.split("|")[1:-1]])
}


def test_every_case_is_in_the_manual():
    assert set(CASES) <= set(ROWS)


@pytest.mark.few(4)
@pytest.mark.parametrize("name", [name for name in CASES if "100" not in name])
def test_the_manual_has_the_measured_accuracy(name):
    for method, cell in zip(METHODS, ROWS[name], strict=True):
        worst, good, rows, why = attained(CASES[name], method)
        number, _, rest = cell.partition(", ")
        if good:
            assert worst <= 3.0 * float(number) + 1e-15, method
        if good < rows:
            assert set(why.split(", ")) <= set((rest.partition(": ")[2] or cell).split(", ")), method
            assert not good or f"{good} of {rows}" in rest, method
