"""Parts of the search for all configurations: counts, pencil, paths, certificates, stored starts."""

from functools import cache

import numpy as np
import pytest
from link_graphs import bars, loaded

from gimcli.assemblies import certificate, constants, root_paths, roots, start_cache
from gimcli.assemblies.assemblies import ConfigurationFinder
from gimcli.assemblies.loops import LoopFamily, values, values_and_jacobian
from gimcli.assemblies.root_paths import corrected, generic_member, generic_start, random_member, track
from gimcli.assemblies.roots import dyad_roots
from gimcli.assemblies.start_cache import Matroid, rank_modulo, root_count


def family_of(rows, rail=()):
    """Return the family of loops in which every coefficient in `rows` is a separate parameter.

    Each loop is a string over the constant, the angles and the slides: "x" is a coefficient, "." is zero.
    """
    count = sum(row.count("x") for row in rows)
    table = np.zeros((len(rows), len(rows[0]), count))
    places = [(k, c) for k, row in enumerate(rows) for c, sign in enumerate(row) if sign == "x"]
    for number, place in enumerate(places):
        table[(*place, number)] = 1.0
    return LoopFamily(table, np.array(rail, dtype=np.int64))


RRR = family_of(["xxx"])
RRP = family_of(["xxx"], [-1])
RPR = family_of(["xxx"], [0])
PRP = family_of(["xxx"], [-1, -1])
TRIAD = family_of(["xxx.x", "x.xxx"])
TRIAD_ONE_SLIDE = family_of(["xxx.x", "x.xxx"], [0])
TRIAD_GROUND_SLIDE = family_of(["xxx.x", "x.xxx"], [-1])
TRIAD_TWO_SLIDES = family_of(["xxxx.", "xx..x"], [0, -1])
DENSE = family_of(["xxxxxxx"] * 3)
FAMILIES = {
    "RRR": RRR, "RRP": RRP, "RPR": RPR, "PRP": PRP, "triad": TRIAD, "one slide": TRIAD_ONE_SLIDE,
    "ground slide": TRIAD_GROUND_SLIDE, "dense": DENSE,
}  # fmt: skip


@cache
def generic_with_roots(name):
    """Return a generic member of a family with all its roots."""
    return generic_start(FAMILIES[name], 0, root_count(FAMILIES[name]))


# ------------------------------------------------------------------ counts


@pytest.mark.parametrize(("name", "count"), [("RRR", 2), ("RRP", 2), ("RPR", 2), ("PRP", 1), ("dense", 20)])
def test_counts_agree_with_closed_forms(name, count):
    """A dyad has two roots, one with two slides has one, and dense loops have binomial(2 L, L): Wampler 2001."""
    assert root_count(FAMILIES[name]) == count


@pytest.mark.few(2)
@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("seed", [0, 1])
def test_counts_agree_with_monodromy(name, seed):
    """Without the count, monodromy stops at the same number."""
    family = FAMILIES[name]
    assert len(generic_start(family, seed, None).w) == root_count(family)


def test_the_count_with_an_angle_in_no_loop_is_zero():
    assert root_count(family_of(["xx.xx", "xx.xx"])) == 0


def test_rank_modulo_a_prime_agrees_with_the_rank_of_integers():
    rows = [(1, 2, 3), (2, 4, 6), (0, 1, 1), (1, 3, 4)]
    assert rank_modulo(rows) == 2
    assert Matroid(DENSE).rank(Matroid(DENSE).everything) == 4


# ------------------------------------------------------------------ pencil and paths


def real_member(family, seed):
    generator = np.random.default_rng(seed)
    count = family.table.shape[2]
    return family.real(generator.standard_normal(count) + 1j * generator.standard_normal(count))


def same(family, a, b):
    gap = certificate.distances(family, a, b)
    return len(a) == len(b) and np.max(np.min(gap, axis=1)) < 1e-8 and np.max(np.min(gap, axis=0)) < 1e-8


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["triad", "one slide", "ground slide", "dense"])
@pytest.mark.parametrize("seed", range(4))
def test_pencil_and_paths_agree(name, seed):
    family = FAMILIES[name]
    loops, count, start = real_member(family, seed), root_count(family), generic_with_roots(name)
    found = roots._by_pencil(family, loops)
    followed = roots._tracked(family, start.H, loops, start.w)
    assert root_paths.pencil_of(family) is not None
    assert len(found.w) == count
    assert (followed.infinite, followed.lost) == (0, 0)
    assert same(family, found.w, followed.proven.w)


def test_paths_without_the_pencil_find_every_root_in_the_same_order(monkeypatch):
    edges = [(1, 2), (1, 3), (2, 3), (1, 4), (3, 6), (2, 5), (4, 5), (4, 6), (5, 6)]
    lengths = dict(zip(edges, [2, 2, 2, 7 / 4, 27 / 10, 197 / 100, 11 / 5, 29 / 10, 43 / 20], strict=True))
    mechanism = loaded(bars(edges, (1, 2), lengths))
    usual = ConfigurationFinder(mechanism).at(np.zeros(0))
    monkeypatch.setattr(roots, "pencil_of", lambda family: None)
    found = ConfigurationFinder(mechanism).at(np.zeros(0))
    assert (found.level, usual.level, len(usual)) == (1, 1, 24)
    np.testing.assert_allclose(found.z, usual.z, atol=1e-10)


@pytest.mark.parametrize("family", [RRR, RRP, RPR, PRP], ids=["RRR", "RRP", "RPR", "PRP"])
def test_dyads_fulfil_their_loops(family):
    generator = np.random.default_rng(3)
    p = generator.standard_normal((200, 3)) + 1j * generator.standard_normal((200, 3))
    H = family.member(p, p.conj())
    found = dyad_roots(family, H)
    assert found.proven.sure.all()
    assert np.max(np.abs(values(family, np.repeat(H, found.each, axis=0), found.proven.w))) < 1e-12
    assert (found.proven.real | found.proven.complex).all()
    if family is RRR:  # the triangle inequality
        a, b, c = np.abs(p).T
        closes = (a < b + c) & (b < c + a) & (c < a + b)
        assert np.array_equal(found.proven.real.reshape(-1, 2).all(axis=1), closes)


def test_jacobian_agrees_with_central_differences():
    generator = np.random.default_rng(5)
    for family in (*FAMILIES.values(), TRIAD_TWO_SLIDES):
        H, w = random_member(family, generator), generator.standard_normal((1, family.angles + family.slides)) + 0.2j
        _, J = values_and_jacobian(family, H, w)
        for column in range(w.shape[1]):
            step = np.zeros_like(w)
            step[0, column] = 1e-6
            slope = (values(family, H, w + step) - values(family, H, w - step)) / 2e-6
            np.testing.assert_allclose(J[0, :, column], slope[0], atol=1e-7)


def test_the_root_of_a_generic_member_satisfies_the_loops():
    for seed, family in enumerate(FAMILIES.values()):
        H, w = generic_member(family, np.random.default_rng(seed))
        assert np.max(np.abs(values(family, H, w))) < 1e-12


def test_paths_forth_and_back_end_at_their_start():
    start = generic_with_roots("dense")
    away = random_member(DENSE, np.random.default_rng(8))
    there = track(DENSE, start.H, away, start.w, constants.SEARCH.tracking)
    back = track(DENSE, away, start.H, corrected(DENSE, away, there.w, 3), constants.SEARCH.tracking)
    assert back.arrived.all()
    assert np.max(np.abs(back.w - start.w)) < 1e-6  # on the same straight line: each root at itself


# ------------------------------------------------------------------ certificate


def test_proved_roots_attract_newton_raphson():
    """Newton-Raphson from anywhere in the ball of uniqueness ends inside the enclosure."""
    start = generic_with_roots("dense")
    proven = certificate.prove(DENSE, start.H, start.w)
    generator = np.random.default_rng(0)
    assert proven.sure.all()
    for share in (0.3, 0.99):
        shift = generator.standard_normal((20, 6)) + 1j * generator.standard_normal((20, 6))
        shift *= (share * proven.large / np.max(np.abs(shift), axis=1))[:, None]
        again = corrected(DENSE, start.H, start.w + shift, 12)
        assert np.max(np.max(np.abs(again - start.w), axis=1) - 2 * proven.small) <= 0.0


def test_balls_of_uniqueness_contain_one_root():
    """No root is inside the ball of another."""
    start = generic_with_roots("dense")
    proven = certificate.prove(DENSE, start.H, start.w)
    gap = certificate.distances(DENSE, start.w, start.w) + 9 * np.eye(20)
    assert np.all(gap > np.maximum(proven.large[:, None], proven.large[None, :]) - 1e-12)


@pytest.mark.parametrize("off", [1e-2, 1.0])
def test_a_point_that_is_no_root_is_not_proved(off):
    start = generic_with_roots("dense")
    proven = certificate.prove(DENSE, start.H, start.w + off)
    truth = certificate.distances(DENSE, start.w + off, start.w)
    assert np.all(np.min(truth, axis=1)[proven.sure] <= proven.small[proven.sure])


def test_a_double_root_is_not_proved():
    """The two roots of a flat triangle coincide."""
    flat = RRR.real(np.array([3.0, 1.0, 2.0], dtype=complex))
    proven = certificate.prove(RRR, flat, np.array([[1j * np.pi, 1j * np.pi]]))
    assert not proven.sure.any()


@pytest.mark.parametrize(("gap", "proved"), [(1e-5, True), (1e-9, False)])
def test_two_roots_are_distinguished_down_to_a_distance_of_1e_5(gap, proved):
    near = RRR.real(np.array([2.0 * np.cos(gap), 1.0, 1.0], dtype=complex))  # theta = -e^(+-i gap)
    w = np.array([[1j * (np.pi + gap), 1j * (np.pi - gap)], [1j * (np.pi - gap), 1j * (np.pi + gap)]])
    assert len(certificate.distinct(RRR, certificate.prove(RRR, near, w)).w) == (2 if proved else 0)


def test_a_root_near_the_real_ones_is_not_proved_real():
    """A triangle with a gap of 1e-6 has roots at a distance of 1e-3 from the unit circle."""
    open_ = RRR.real(np.array([2.0 * np.cosh(1e-3), 1.0, 1.0], dtype=complex))
    w = np.array([[1j * np.pi + 1e-3, 1j * np.pi - 1e-3]])
    proven = certificate.prove(RRR, open_, w)
    assert proven.sure.all()
    assert proven.complex.all()
    assert not proven.real.any()


# ------------------------------------------------------------------ stored starts


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(start_cache, "_STARTS", {})
    return tmp_path / "gimcli" / start_cache.FOLDER


def test_a_start_is_computed_once(own_cache, monkeypatch):
    first = start_cache.known_start(RRR, 0)
    files = sorted(own_cache.iterdir())
    monkeypatch.setattr(start_cache, "_STARTS", {})
    monkeypatch.setattr(start_cache, "generic_start", lambda *_: pytest.fail("found again"))
    again = start_cache.known_start(RRR, 0)
    assert len(files) == 1
    assert np.array_equal(first.w, again.w)
    assert np.array_equal(first.H, again.H)


@pytest.mark.few(3)
@pytest.mark.parametrize("damage", [b"", b"not a file of arrays", "roots lost", "other numbers", "no number"])
def test_a_damaged_start_is_computed_again(own_cache, monkeypatch, damage):
    first = start_cache.known_start(RRR, 0)
    path = next(own_cache.iterdir())
    if isinstance(damage, bytes):
        path.write_bytes(damage)
    else:
        damaged = {"roots lost": first.w[1:], "other numbers": first.w + 0.3, "no number": first.w * np.nan}[damage]
        start_cache._write(path, H=first.H, w=damaged)
    monkeypatch.setattr(start_cache, "_STARTS", {})
    again = start_cache.known_start(RRR, 0)
    np.testing.assert_array_equal(first.w, again.w)


def test_without_a_cache_folder_starts_are_computed_each_time(own_cache, monkeypatch):
    monkeypatch.setattr(start_cache, "user_folder", lambda name: None)
    assert len(start_cache.known_start(RRR, 0).w) == 2
    assert not own_cache.exists()
