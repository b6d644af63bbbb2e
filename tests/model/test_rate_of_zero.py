"""Laws that do not move: a rate of 0 is refused by one sentence, whatever stands beside it."""

import pytest

import gimcli

CRANK = {"nodes": {"O": [0, 0], "A": [1, 0]}, "ground": ["O"], "links": {"crank": ["O", "A"]}}


def loaded(law, **more):
    return gimcli.load(CRANK | {"actuators": {"m": {"pivot": "O", "arm": "A", "law": law}}} | more)


@pytest.mark.parametrize("more", [{}, {"duration": 2}])
@pytest.mark.parametrize("law", [{"rate": 0}, {"rate": 0, "to": 3}, {"rate": 0, "turns": 1}])
def test_a_rate_of_zero_is_refused(law, more):
    with pytest.raises(gimcli.ModelError):
        loaded(law, **more)


@pytest.mark.parametrize("turns", [-1, 0, 1.5])
def test_turns_may_run_backwards(turns):
    motion = gimcli.trace(loaded({"turns": turns}), steps=4)
    assert motion["m"][-1] == pytest.approx(360 * turns)
