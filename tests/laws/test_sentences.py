"""Each message of the tables: the cause, and the exact words."""

import pytest
from sentences import TABLES, cases, said

CASES = {
    f"{table.stem} {k}: {case['cause']}": (case, text)
    for table in sorted(TABLES.glob("*.yaml"))
    for k, (case, text) in enumerate(cases(table), 1)
}


@pytest.mark.parametrize("case", CASES)
def test_sentence(case):
    row, text = CASES[case]
    if "prints" in row:
        assert row["prints"] in said(row, text)
    else:
        assert said(row, text) == row["says"]
