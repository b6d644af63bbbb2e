"""Arguments that were renamed: the old name works, with a warning that gives the new one."""

import pytest

import gimcli
from gimcli import RENAMED

CALLS = {
    "circuits": ("crank_rocker", {}, {"samples": 4}),
    "reduce": ("watt_durango", {"steps": 4}, {"input": ""}),
    "simulate": ("watt_durango", {"dt": 0.05}, {"time": 0.1, "method": "rk45"}),
    "workspace": ("crank_rocker", {"point": "P"}, {"all": True, "keep": None}),
}
"""Functions with a model, their other arguments, and values of the old names."""


@pytest.mark.parametrize(("verb", "old"), [(verb, old) for verb in RENAMED for old in RENAMED[verb]])
def test_the_old_name_works_and_names_the_new_one(verb, old):
    model, named, values = CALLS[verb]
    m, new, call = gimcli.load(model), RENAMED[verb][old], getattr(gimcli, verb)
    value = m.actuators[0].name if old == "input" else values[old]
    with pytest.warns(DeprecationWarning, match=f"{verb}: the argument `{old}` is now named `{new}`"):
        before = call(m, **named, **{old: value})
    assert before.report() == call(m, **named, **{new: value}).report()


def test_an_argument_is_not_given_by_both_names():
    with (
        pytest.warns(DeprecationWarning, match="`duration`"),
        pytest.raises(TypeError, match="multiple values for keyword argument"),
    ):
        gimcli.simulate("watt_durango", duration=0.1, time=0.2)


@pytest.mark.parametrize(("verb", "model"), [("equilibrium", "snap_hinge"), ("modes", "double_pendulum")])
def test_released_inputs_were_the_second_argument(verb, model):
    m, call = gimcli.load(model), getattr(gimcli, verb)
    name = m.actuators[0].name
    new = call(m, {}, name)
    assert new.report() == call(m, free=name, at={}).report()
    for old in ((name,), (name, {}), ([name], None)):
        with pytest.warns(DeprecationWarning, match=f"{verb}: the second argument is `at`"):
            assert call(m, *old).report() == new.report()
    with pytest.warns(DeprecationWarning, match=f"{verb}: the second argument is `at`"):
        assert call(m, name, at={}).report() == new.report()


def test_inputs_of_equilibrium_are_arguments_by_name():
    m = gimcli.load("snap_hinge")
    name = m.actuators[0].name
    start = float(m.inputs_to_file(m.start_inputs)[name])
    assert gimcli.equilibrium(m, **{name: start}).report() == gimcli.equilibrium(m, at={name: start}).report()


@pytest.mark.parametrize(
    ("verb", "second", "named"),
    [("assembled", 1, {"assembly": 1}), ("assembled", "+", {"assembly": "+"}), ("sensitivity", "P", {"of": "P"})],
)
def test_what_was_before_the_inputs_still_works(verb, second, named):
    m, call = gimcli.load("crank_rocker"), getattr(gimcli, verb)

    def seen(found):
        return found.drawn.tolist() if verb == "assembled" else str(found.report())

    new = seen(call(m, {"motor": 30}, **named))
    with pytest.warns(DeprecationWarning, match=f"{verb}: the second argument is `at`.*give `{next(iter(named))}`"):
        assert seen(call(m, second, at={"motor": 30})) == new
    with pytest.warns(DeprecationWarning, match=f"{verb}: the second argument is `at`"):
        assert seen(call(m, second, motor=30)) == new
    assert seen(call(m, {"motor": 30}, second)) == new
