"""Tables of laws, efforts and loads: only regular files of limited size are read, and each row is checked."""

from __future__ import annotations

import os
import re
import time

import pytest

from gimcli import ModelError, load
from gimcli.model.source import MOST_BYTES
from gimcli.model.tables import MOST_ROWS

MODELS = {
    "law": "actuators: {m: {type: rotary, pivot: O, arm: A, law: {table: NAME}}}\n",
    "effort": "actuators: {m: {type: rotary, pivot: O, arm: A, free: true, effort: {table: NAME}}}\n",
    "load": "loads: {work: {on: crank, torque: 1, table: NAME}}\n",
}
TOP = (
    "nodes: {O: [0, 0], G: [4, 0], A: [0, 1], B: [4, 3]}\nground: [O, G]\n"
    "links: {crank: [O, A], a: [A, B], b: [G, B]}\n"
)


@pytest.fixture(params=MODELS)
def refused(request, tmp_path):
    """Load a model with a table as law, effort or load; return the error, which must come within 5 s."""

    def run(name):
        path = tmp_path / "m.yaml"
        path.write_text(TOP + MODELS[request.param].replace("NAME", str(name)))
        began = time.process_time()
        with pytest.raises(ModelError) as caught:
            load(path)
        assert time.process_time() - began < 5.0
        assert len(caught.value.faults) == 1
        return caught.value.faults[0]

    return run


@pytest.mark.skipif(not os.path.exists("/dev/zero"), reason="no devices")
@pytest.mark.parametrize("name", ["/dev/zero", "/dev/null", "/dev/tty"])
def test_a_device_is_rejected(name, refused):
    assert f"table {name}: is a device or a pipe; name a CSV file" in refused(name)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_is_rejected(refused, tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    assert "is a device or a pipe" in refused("pipe.csv")


ROWS = {
    "too many bytes": ("0,0\n1,1\n" + " " * MOST_BYTES, "too large"),
    "too many rows": ("".join(f"{k},0\n" for k in range(MOST_ROWS + 1)), f"more than {MOST_ROWS} rows"),
    "infinite": ("0,0\n1,inf\n2,0\n", "line 2"),
    "infinite in the first row": ("inf,0\n1,1\n2,0\n", "line 1"),
    "not a number in the first row": ("0,nan\n1,1\n2,0\n", "line 1"),
    "text in one cell of the first row": ("0,one\n1,1\n2,0\n", "line 1"),
    "overflow": ("0,0\n1,1e400\n2,0\n", "line 2"),
    "too large": ("0,0\n1,1e200\n2,0\n", "line 2"),
    "not increasing": ("t,v\n0,0\n2,1\n1,2\n", "line 4"),
    "same time twice": ("0,0\n1,1\n1,2\n", "line 3"),
    "times that differ by rounding": ("0,0\n1,1\n1.0000000000001,2\n2,2\n", "line 3"),
    "control character": ("0,0\n1,1\x07\n", "not a text file"),
    "zero byte": ("0,0\n1,1\x00\n", "not a text file"),
    "three columns": ("0,0\n1,1,1\n", "line 2"),
}


@pytest.mark.few(14)
@pytest.mark.parametrize("case", ROWS)
def test_rows_are_checked(case, refused, tmp_path):
    text, message = ROWS[case]
    (tmp_path / "t.csv").write_text(text)
    assert re.search(rf"m\.yaml:\d+:\d+: table t\.csv: .*{message}", refused("t.csv"))


@pytest.mark.parametrize(
    "text", ["time,value\n0,0\n1,2\n", "\ufeff0,0\r\n1,2\r\n", "t [s] , deg\n\n0,0\n , \n1,2", "0,0\n1,2"]
)
def test_tables_with_header_spaces_and_other_line_ends_are_read(text, tmp_path):
    (tmp_path / "t.csv").write_text(text, encoding="utf-8", newline="")
    (tmp_path / "m.yaml").write_text(TOP + MODELS["law"].replace("NAME", "t.csv"))
    mechanism = load(tmp_path / "m.yaml")
    assert mechanism.duration == 1.0
