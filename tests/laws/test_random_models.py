"""Random mechanisms: all commands that follow their motion agree."""

import pytest
from mechanism_laws import Subject

SUITE = [8, 13, 18, 22, 23, 24, 28, 44, 220, 295]
"""Seeds of fast cases; together they have all kinds of inputs, profiles and initial coordinates."""


def agree(seed, folder, samples):
    assert Subject(seed, folder, samples).check() == []


@pytest.mark.few(4)
@pytest.mark.parametrize("seed", SUITE)
def test_commands_agree_about_a_random_mechanism(seed, tmp_path):
    agree(seed, tmp_path, 4)


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(1000))
def test_commands_agree_about_a_thousand_random_mechanisms(seed, tmp_path):
    agree(seed, tmp_path, 6)
