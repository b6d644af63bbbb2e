"""Columns of numbers from CSV files: what is read, and what is refused."""

from pathlib import Path

import pytest

from gimcli.errors import UsageError
from gimcli.library.number_columns import number_columns


def written(folder: Path, content: bytes) -> Path:
    path = folder / "designs.csv"
    path.write_bytes(content)
    return path


def test_columns_have_the_names_of_the_first_row(tmp_path):
    path = written(tmp_path, b"\xef\xbb\xbfa , b\r\n\r\n1, 2.5\r\n-3,4e1\r\n")
    assert {name: column.tolist() for name, column in number_columns(path, "designs").items()} == {
        "a": [1.0, -3.0], "b": [2.5, 40.0]
    }  # fmt: skip


@pytest.mark.parametrize(
    ("content", "text"),
    [
        (b"a,b\n", "expected a row of names and rows of numbers"),
        (b"a,a\n1,2\n", "two columns have the same name"),
        (b"a;b\n1;2\n", "the columns are separated by semicolons"),
        (b"a,b\n\n1,2\n3,inf\n", "line 4: expected 2 finite numbers, got '3,inf'"),
        (b"a,b\n1,\xff\n", "is not a text file of designs; name a CSV file"),
        (b"a,b\n1,\x00\n", "is not a text file of designs; name a CSV file"),
        (b'a,b\n1,"' + b"x" * 200_000 + b'"\n', "is not a text file of designs; name a CSV file"),
    ],
)
def test_other_files_are_refused(tmp_path, content, text):
    with pytest.raises(UsageError) as error:
        number_columns(written(tmp_path, content), "designs")
    assert str(error.value).startswith(f"{tmp_path / 'designs.csv'}: {text}")
