"""The order of configurations depends on the mechanism and its inputs alone."""

from dataclasses import replace

import numpy as np
import pytest
from bundled import CHOSEN, MODELS
from in_process import gim

from gimcli import load
from gimcli.assemblies import all_configurations
from gimcli.assemblies.assemblies import Configurations, RootReport, in_order
from gimcli.mechanism import FRAME
from gimcli.model.source import read_source

COUPLED = ("double_butterfly", "innocenti_group", "ten_bar")
"""Models with 6, 8 and 6 solutions of a group of 3, 3 and 4 loops."""

NAMES = sorted({*CHOSEN, *COUPLED} & {path.stem for path in MODELS.glob("*.yaml")})


def moved(mechanism, change):
    """Return a mechanism with other initial coordinates of its moving nodes, and the same dimensions."""
    fixed = np.isin(np.arange(len(mechanism.nodes)), mechanism.members[FRAME].nodes)
    return replace(mechanism, drawn=np.where(fixed, mechanism.drawn, change(mechanism.drawn)))


def same(one, other):
    assert one.signs == other.signs
    np.testing.assert_allclose(one.z, other.z, atol=1e-9)


@pytest.mark.few(8)
@pytest.mark.parametrize("name", NAMES)
def test_the_order_does_not_depend_on_the_initial_coordinates(name):
    mechanism = load(MODELS / f"{name}.yaml")
    found = all_configurations(mechanism, mechanism.start_inputs)
    noise = np.random.default_rng(len(name)).normal(0.0, 1e-3, (2, len(mechanism.nodes)))
    for change in (lambda z: z + noise[0] + 1j * noise[1], np.conj):
        same(found, all_configurations(moved(mechanism, change), mechanism.start_inputs))


@pytest.mark.parametrize("factor", [1e-3, 7.0])
@pytest.mark.parametrize("name", ["jansen", "double_butterfly"])
def test_the_order_does_not_depend_on_the_scale(name, factor):
    data = read_source(MODELS / f"{name}.yaml").data
    big = {key: dict(part) if isinstance(part, dict) else part for key, part in data.items()}
    big["nodes"] = {n: [factor * x, factor * y] for n, (x, y) in data["nodes"].items()}
    big["links"] = {
        n: {**link, "length": factor * link["length"]} if isinstance(link, dict) and "length" in link else link
        for n, link in data.get("links", {}).items()
    }
    big["elements"] = {
        n: {**part, "shape": {v: [factor * x, factor * y] for v, (x, y) in part["shape"].items()}}
        for n, part in data.get("elements", {}).items()
    }
    for unscaled in ("points", "trace", "masses"):
        big.pop(unscaled, None)
    small, large = load(MODELS / f"{name}.yaml"), load(big)
    one, other = (all_configurations(m, m.start_inputs) for m in (small, large))
    assert one.signs == other.signs
    order = [large.nodes.index(n) for n in small.nodes]
    np.testing.assert_allclose(small.to_file(one.z) * factor, large.to_file(other.z)[:, order], rtol=1e-9, atol=1e-9)


def test_solutions_of_a_coupled_group_are_sorted_by_coordinates():
    """The rule of the manual, applied to the coordinates that the command prints."""
    report = gim("solve", MODELS / "double_butterfly.yaml", "--all", "--json").json
    (group,) = report["groups"]
    names = [n for n in load(MODELS / "double_butterfly.yaml").nodes if n in group["nodes"]]
    keys = [[round(v, 5) for n in names for v in one["nodes"][n]] for one in report["configurations"]]
    assert keys == sorted(keys)
    assert [one["assembly"] for one in report["configurations"]] == [f"({k})" for k in range(1, len(keys) + 1)]


def test_signs_of_a_dyad_are_sorted_plus_first():
    signs = [one["assembly"] for one in gim("solve", MODELS / "jansen.yaml", "--all", "--json").json["configurations"]]
    assert signs == sorted(signs)  # "+" is before "-"


def listed(mechanism, z, branches, loops):
    """Return a list of configurations as the finder makes it, in any order."""
    groups = tuple(RootReport((mechanism.nodes[-1],), count, 4) for count in loops)
    each = np.arange(len(z), dtype=float)
    return Configurations(mechanism, np.zeros(1), z, each, each, tuple(branches), groups, ())


def test_numbers_do_not_depend_on_rounding_or_on_the_order_of_the_search():
    """Four solutions, two with the same x: shuffled, with other root numbers and with rounding errors."""
    mechanism = load(MODELS / "crank_rocker.yaml")
    last = [0.1 + 0.2j, 0.1 + 0.3j, 0.4 - 0.5j, 0.7 + 0.1j]
    z = np.tile(mechanism.drawn, (4, 1))
    z[:, -1] = last
    generator = np.random.default_rng(5)
    for _ in range(20):
        shuffled, roots = generator.permutation(4), generator.permutation(9)[:4]
        noisy = z[shuffled] + 1e-9 * generator.normal(size=z.shape)
        found = in_order(listed(mechanism, noisy, [(int(k),) for k in roots], (2,)))
        assert found.signs == ("(1)", "(2)", "(3)", "(4)")
        np.testing.assert_allclose(found.z[:, -1], last, atol=1e-8)
        assert found.residual.tolist() == [float(np.flatnonzero(shuffled == k)[0]) for k in range(4)]


def test_a_dyad_before_a_group_is_sorted_first():
    mechanism = load(MODELS / "crank_rocker.yaml")
    z = np.tile(mechanism.drawn, (4, 1))
    z[:, -1] = [0.5, 0.1, 0.2, 0.9]
    found = in_order(listed(mechanism, z, [(1, 3), (1, 5), (0, 8), (0, 2)], (1, 2)))
    assert found.signs == ("+(1)", "+(2)", "-(1)", "-(2)")
    assert found.z[:, -1].real.tolist() == [0.2, 0.9, 0.1, 0.5]
