"""True errors agree with closed forms in high precision; the branch of a position is determined."""

import mpmath
import numpy as np
import pytest
import yaml
from bundled import MODELS
from random_mechanisms import Growth

from gimcli import GimError, load
from gimcli.comparison.true_error import Constraints, refine
from gimcli.motion.motion import trace
from gimcli.structure.residual import residual


def truth_of(name, steps=24):
    motion = trace(load(MODELS / f"{name}.yaml"), steps)
    return motion, refine(motion.mechanism, motion.z, motion.inputs, motion.good)


def deviation(truth, k, row, exact):
    """Return the distance of a true point, the sum of its two parts, from an exact one."""
    point = mpmath.mpc(complex(truth.points[k, row])) + mpmath.mpc(complex(truth.rest[k, row]))
    return float(abs(point - exact))


def test_a_four_bar_agrees_with_the_intersection_of_two_circles_to_30_digits():
    motion, truth = truth_of("crank_rocker")
    mechanism = motion.mechanism
    names = mechanism.nodes
    assert truth.known.all()
    crank, coupler, rocker = (
        next(m for m in mechanism.members[1:] if set(names[n] for n in m.nodes) >= set(pair))
        for pair in (("O2", "A"), ("A", "B"), ("O4", "B"))
    )
    with mpmath.workdps(50):
        lengths = [
            mpmath.mpf(float(abs(m.local(names.index(b)) - m.local(names.index(a)))))
            for m, a, b in ((crank, "O2", "A"), (coupler, "A", "B"), (rocker, "O4", "B"))
        ]
        o, c = (mpmath.mpc(complex(mechanism.drawn[names.index(n)])) for n in ("O2", "O4"))
        for row in range(25):
            a = o + lengths[0] * mpmath.expj(mpmath.mpf(float(motion.inputs[0, row])))
            d = abs(c - a)
            along = (lengths[1] ** 2 - lengths[2] ** 2 + d**2) / (2 * d)
            height = mpmath.sqrt(lengths[1] ** 2 - along**2)
            both = [a + (along + s * 1j * height) * (c - a) / d for s in (1, -1)]
            k = mechanism.traced.index("B")
            assert min(deviation(truth, k, row, b) for b in both) < 1e-29


@pytest.mark.few
def test_refined_positions_have_residuals_of_rounding_and_stay_near_the_given_ones(model):
    motion = trace(load(model), 6)
    truth = refine(motion.mechanism, motion.z, motion.inputs, motion.good)
    assert truth.known.any()
    known = truth.known
    assert np.max(residual(motion.mechanism, truth.z[:, known], motion.inputs[:, known]).total) < 1e-14
    assert np.max(truth.errors(motion.z)[known]) < 1e-11


def test_inclined_guides_and_drives_between_members_are_refined(tmp_path):
    known = 0
    for seed in range(30):
        (tmp_path / "model.yaml").write_text(yaml.safe_dump(Growth(seed, 3).model()))
        try:
            motion = trace(load(tmp_path / "model.yaml"), 12)
        except GimError:
            continue
        truth = refine(motion.mechanism, motion.z, motion.inputs, motion.good)
        rows = truth.known
        known += int(rows.sum())
        assert not (motion.good & ~rows).any() or motion.bridged
        assert np.max(residual(motion.mechanism, truth.z[:, rows], motion.inputs[:, rows]).total, initial=0) < 1e-13
    assert known > 100


def test_errors_are_distances_of_traced_points_relative_to_the_size():
    motion, truth = truth_of("gim_fig13a")
    shifted = motion.z.copy()
    shifted[motion.mechanism.nodes.index("C"), 3] += 1e-7 * motion.mechanism.size * np.exp(0.7j)
    assert np.nanmax(truth.errors(motion.z)) < 1e-15
    error = truth.errors(shifted)
    assert error[3] == pytest.approx(1e-7, rel=1e-6)
    assert np.nanmax(np.delete(error, 3)) < 1e-15


def test_the_mirror_image_of_a_dyad_is_another_branch_although_its_residual_is_zero():
    motion, truth = truth_of("gim_fig13a")
    mechanism = motion.mechanism
    b, c, d = (mechanism.nodes.index(n) for n in "BCD")
    z = motion.z.copy()
    line = z[d] - z[b]
    z[c] = z[b] + ((z[c] - z[b]) / line).conjugate() * line
    assert np.max(residual(mechanism, z, motion.inputs).total) < 1e-13
    assert not truth.same_branch(z, truth.errors(z)).any()


def test_a_rough_position_belongs_to_the_branch_to_which_it_converges():
    motion, truth = truth_of("gim_fig13a")
    z = motion.z.copy()
    z[motion.mechanism.nodes.index("C")] += 0.03 * motion.mechanism.size * np.exp(0.4j)
    error = truth.errors(z)
    assert np.all(error > 0.02)
    assert truth.same_branch(z, error).all()


def test_a_singular_position_has_no_true_position(trace_model):
    motion = trace_model("parallelogram", steps=24, laws={"motor": {"from": 30, "to": 390}}).motion
    assert motion.good.all()
    assert len(motion.bridged) == 2
    truth = refine(motion.mechanism, motion.z, motion.inputs, motion.good)
    flat = np.abs(np.sin(motion.inputs[0])) < 1e-9
    assert np.array_equal(~truth.known, flat)
    assert np.isnan(truth.errors(motion.z)[flat]).all()


@pytest.mark.few
def test_jacobian_of_the_constraints_is_exact(model):
    """For equations of second degree, a difference equals the mean of the two Jacobians times the change."""
    mechanism = load(model)
    system, generator = Constraints(mechanism), np.random.default_rng(0)
    inputs = np.array([[a.drawn] for a in mechanism.actuators])
    z = mechanism.drawn[:, None].copy()
    change = generator.standard_normal((2, len(system.free)))
    ahead = z.copy()
    ahead[system.free, 0] += change[0] + 1j * change[1]
    mean = 0.5 * (system.jacobian(z, inputs)[0] + system.jacobian(ahead, inputs)[0])
    difference = system.residual(ahead, inputs)[:, 0] - system.residual(z, inputs)[:, 0]
    assert np.allclose(mean @ np.stack([change[0], change[1]], axis=1).ravel(), difference, atol=1e-11)
