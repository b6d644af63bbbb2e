"""Tables of sentences: for each package, what causes a message, and the exact message (tests/tables/sentences).

A case has a `cause`: a command line that begins with `gim`, or an expression of Python with all names of gimcli, numpy
as `np`, `yaml`, Path, the numbers Dual and Recording, `formula(text)` in the parameters a = 1.5 and b_2 = -0.25,
`replace` of dataclasses, and `m`, the mechanism of the case. Its `model` is a text of the table's `models`, a shipped
model or the text itself; `change` replaces texts in it, `more` is written below it. A command line finds it as m.yaml,
and the `files` beside it. Either `says` is the whole message, with the kind of error or the exit status, or the text
that an expression gives, or `prints` is a part of what a command prints.

After a change of words: `python tests/oracles/sentences.py` writes the new messages into the tables; read what
`git diff` shows.
"""

import json
import re
from contextlib import chdir
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import yaml
from in_process import ran

import gimcli
from gimcli import shipped
from gimcli.calculus.dual import Dual
from gimcli.calculus.recorded import Recording
from gimcli.model.arithmetic import parsed

TABLES = Path(__file__).parents[1] / "tables" / "sentences"


def formula(text):
    """Return the value of a formula of a model file."""
    names = {"a": 1.5, "b_2": -0.25}
    return parsed(text, names).number(names)


class Names(dict):
    """The names of a cause in Python; the mechanism is read where the cause names it."""

    def __init__(self, text):
        super().__init__(
            text=text,
            np=np,
            yaml=yaml,
            Path=Path,
            gimcli=gimcli,
            Dual=Dual,
            Recording=Recording,
            formula=formula,
            replace=replace,
        )

    def __missing__(self, name):
        if name == "m":
            return gimcli.loads(self["text"])
        try:
            return getattr(gimcli, name)
        except AttributeError:
            raise KeyError(name) from None  # a builtin function


def cases(table):
    """Return the cases of a table, each with the text of its model."""
    data = yaml.load(table.read_text(encoding="utf-8"), getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    return [(case, _text(case, data.get("models", {}))) for case in data["sentences"]]


def _text(case, models):
    text = case.get("model")
    if text in models:
        text = models[text]
    elif text and "\n" not in text:
        text = shipped.path_of(text).read_text(encoding="utf-8")
    for old, new in case.get("change", {}).items():
        assert old in text, f"{old!r} is not in the model"
        text = text.replace(old, str(new), 1)
    return text + case["more"] if "more" in case else text


def said(case, text):
    """Return the message of a case; for a case that `prints`, all that the command prints."""
    with TemporaryDirectory() as folder, chdir(folder):
        for name, content in (case.get("files", {}) | ({} if text is None else {"m.yaml": text})).items():
            Path(name).write_text(content, encoding="utf-8")
        return _answer(case, text).replace(folder, "FOLDER")


def _answer(case, text):
    if case["cause"].startswith("gim "):
        done = ran(*(part.strip("'") for part in re.findall(r"'[^']*'|\S+", case["cause"])[1:]))
        if "prints" in case:
            return " ".join((done.text + done.error).split())
        return f"exit {done.code}: {(done.text + done.error).strip()}"
    try:
        return str(eval(case["cause"], Names(text)))
    except Exception as error:
        return f"{type(error).__name__}: {error.args[0] if isinstance(error, KeyError) else error}"


def rewritten(table):
    """Return the text of a table with the messages of now."""
    now = [said(case, text) for case, text in cases(table) if "says" in case]
    return re.sub(r"(?m)(^ +(?:- )?says:).*$", lambda found: f"{found[1]} {json.dumps(now.pop(0), ensure_ascii=False)}",
                  table.read_text(encoding="utf-8"))  # fmt: skip


if __name__ == "__main__":
    for one in sorted(TABLES.glob("*.yaml")):
        one.write_text(rewritten(one), encoding="utf-8")
