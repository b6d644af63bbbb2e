"""Files of other programs that are damaged in many ways: each becomes a mechanism, or is an error."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path

import pytest
from damaged_texts import changed, cut, with_numbers

import gimcli
from gimcli.exchange.assembling import model_of
from gimcli.exchange.registry import draft_of
from gimcli.model.read import read_data

FILES = sorted(path for path in (Path(__file__).parent / "data").iterdir() if path.suffix not in (".md", ".txt"))


def converted(text: str):
    draft = draft_of(text, "f")
    return draft and read_data(model_of(draft), Path(), "f", draft.left_out)


def read_or_refused(text: str) -> None:
    with suppress(gimcli.GimError):
        if (mechanism := converted(text)) is not None:
            gimcli.mobility(mechanism)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_every_file_is_a_mechanism_that_can_be_assembled(path):
    mechanism = converted(path.read_text(encoding="utf-8"))
    assert mechanism is not None
    assert gimcli.solve(mechanism).status == "ok"


@pytest.mark.soak
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_damaged_files_are_mechanisms_or_errors(path):
    text = path.read_text(encoding="utf-8")
    for damaged in [*cut(text, 300), *changed(text, 1100), *with_numbers(text)[:600]]:
        read_or_refused(damaged)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_some_damaged_files_are_mechanisms_or_errors(path):
    for damaged in changed(path.read_text(encoding="utf-8"), 3, seed=1):
        read_or_refused(damaged)
