"""Files to which tables are appended: the same as those of the whole table."""

import numpy as np
import pyarrow.parquet as pq
import pytest

from gimcli.output.formats import FORMATS
from gimcli.output.npz import NpzStream
from gimcli.table import Column, Table

WORDS = np.array(["ok", "unreachable"])
STREAMED = [suffix for suffix, one in FORMATS.items() if one.stream is not None]


def table(first, last):
    number = np.arange(first, last)
    return Table((Column("n", number), Column("P.x", number / 3.0, "mm"), Column("status", WORDS[number % 2])))


def test_csv_parquet_and_npz_are_streamed():
    assert STREAMED == [".csv", ".parquet", ".npz"]


@pytest.mark.parametrize("suffix", STREAMED)
def test_parts_make_the_file_of_the_whole(suffix, tmp_path):
    form, whole = FORMATS[suffix], table(0, 7)
    with form.stream(tmp_path / f"parts{suffix}", whole.names) as stream:
        for ends in ((0, 4), (4, 4), (4, 7)):
            stream.append(table(*ends))
        assert not (tmp_path / f"parts{suffix}").exists()
    form.write(whole if form.content == "table" else {c.name: c.values for c in whole.columns}, tmp_path / f"w{suffix}")
    parts, own = tmp_path / f"parts{suffix}", tmp_path / f"w{suffix}"
    if suffix == ".npz":
        found, expected = np.load(parts), np.load(own)
        assert found.files == expected.files
        assert all(np.array_equal(found[name], expected[name]) for name in found.files)
    elif suffix == ".parquet":
        assert pq.read_table(parts).equals(pq.read_table(own))
        assert pq.read_table(own)["P.x"].to_pylist() == [k / 3.0 for k in range(7)]
        assert pq.read_schema(own).field("P.x").metadata == {b"unit": b"mm"}
    else:
        assert parts.read_bytes() == own.read_bytes()


def interrupted(suffix, folder):
    with FORMATS[suffix].stream(folder / f"t{suffix}", ["n", "P.x", "status"]) as one:
        one.append(table(0, 4))
        raise KeyboardInterrupt


@pytest.mark.parametrize("suffix", STREAMED)
def test_after_an_error_there_is_no_file(suffix, tmp_path):
    with pytest.raises(KeyboardInterrupt):
        interrupted(suffix, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_npz_refuses_other_columns(tmp_path):
    with pytest.raises(ValueError, match="has columns"), NpzStream(tmp_path / "t.npz", ["n"]) as one:
        one.append(table(0, 1))
