"""Values of options that are converted without typer: typer's own conversion gives the same."""

import pytest
import typer

from gimcli.cli import COMMANDS, app
from gimcli.cli.command import UNCHECKED, plain_value

TEXTS = ("", "0", "1", "3", "12", "007", "-1", "1.5", "1e-8", "10000001", "9999999999", "auto", "gim", "GIM", "rk4",
         "stop", "a=1", " x", "x\ny", "\udcff", "models", "none.yaml", "٣")  # fmt: skip


def parameters():
    group = typer.main.get_command(app)
    for name in COMMANDS:
        context = typer.Context(group.get_command(typer.Context(group), name))
        for param in context.command.params:
            yield pytest.param(context, param, id=f"{name}-{param.name}")


@pytest.mark.parametrize(("context", "param"), [*parameters()])
def test_a_plain_value_is_the_one_that_typer_gives(context, param):
    param.callback = None  # callbacks are called in both cases
    for value in (None, param.default, *TEXTS, [], [*TEXTS[:12]], ["a=1", "\udcff"]):
        found = plain_value(param, value)
        if found is not UNCHECKED:
            expected = param.process_value(context, value)
            assert (type(found), found) == (type(expected), expected)
