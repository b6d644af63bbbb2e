"""Random mechanisms, with sliders, n-ary members and coupled groups: results do not depend on steps and method."""

import numpy as np
import pytest
import yaml
from random_mechanisms import Growth

from gimcli import GimError, load
from gimcli.motion.motion import trace
from gimcli.positions.options import Options
from gimcli.status import Status


def check(seed, groups, folder):
    path = folder / "model.yaml"
    path.write_text(yaml.safe_dump(Growth(seed, groups).model()))
    mechanism = load(path)
    try:
        coarse = trace(mechanism, 24)
    except GimError:
        return False  # the moved actuator does not drive all freedoms
    if coarse.first_status is Status.SINGULAR:
        return False  # the same, found by the rank
    fine, newton = trace(mechanism, 96), trace(mechanism, 24, Options(method="newton"))
    assert np.max(np.abs(coarse.z[:, 0] - mechanism.drawn)) < 1e-9 * mechanism.size
    for other, z, good in ((fine, fine.z[:, ::4], fine.good[::4]), (newton, newton.z, newton.good)):
        assert np.array_equal(coarse.good, good)
        assert np.max(np.abs(coarse.z - z)[:, good], initial=0.0) < 1e-8 * mechanism.size
        assert (coarse.limit is None) == (other.limit is None)
        assert coarse.limit is None or abs(coarse.limit - other.limit) < 1e-6
    return True


@pytest.mark.few(8)
@pytest.mark.parametrize("seed", range(60))
def test_random_mechanism(seed, tmp_path):
    check(seed, 1 + seed % 5, tmp_path)


@pytest.mark.soak
def test_most_random_mechanisms_are_driven(tmp_path):
    assert sum(check(seed, 3, tmp_path) for seed in range(100, 110)) >= 7


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(1000, 1500))
def test_large_random_mechanism(seed, tmp_path):
    check(seed, 8, tmp_path)
