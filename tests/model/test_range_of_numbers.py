"""Every number in every shipped model, out of its range: it is refused, or the model is computed without a warning."""

import random
import re
from contextlib import suppress

import pytest

import gimcli
from gimcli import shipped

SAMPLE = 40
"""Changed files that the suite reads; the soak reads many."""

VALUES = ("0", "-1", "1e308", "-1e308", "1e-308", ".inf", ".nan", "9" * 40, "1e20", "1e-20", "1e100")
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(\.\d+)?(?![\w.])")


def changed(count):
    """Return model files of which one number is changed."""
    source = random.Random(1)
    for _ in range(count):
        text = re.sub("#.*", "", shipped.path_of(source.choice(shipped.names())).read_text(encoding="utf-8"))
        text = re.sub("(?m)^(name|source):.*", "", text)
        match = source.choice(list(NUMBER.finditer(text)))
        yield text[: match.start()] + source.choice(VALUES) + text[match.end() :]


def computed(text):
    """Load, solve, trace and convert a model; errors of gim are answers."""
    with suppress(gimcli.GimError):
        model = gimcli.loads(text, shipped.folder())
        for verb in (gimcli.solve, lambda m: gimcli.trace(m, steps=8), lambda m: gimcli.convert(m, "pmks+")):
            with suppress(gimcli.GimError):
                verb(model)


def test_numbers_out_of_range():
    for text in changed(SAMPLE):
        computed(text)


@pytest.mark.soak
def test_many_numbers_out_of_range():
    for text in changed(5000):
        computed(text)
