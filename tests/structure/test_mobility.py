"""Mobility against the published counts (library of mechanisms; Fraczek & Wojtyra, example 1.12)."""

import numpy as np
import pytest
from bundled import MODELS

from gimcli import load
from gimcli.structure.constraint_jacobian import full_pivoting
from gimcli.structure.mobility import assembled, mobility

# Grübler's count, true mobility, redundant equations
PUBLISHED = {
    "crank_rocker": (1, 1, 0),
    "parallelogram": (1, 1, 0),
    "parallelogram_third_crank": (0, 1, 1),
    "plantigrade": (-2, 1, 3),
    "dixon_k33": (0, 1, 1),
    "peaucellier": (1, 1, 0),
    "floating_hexagon": (3, 3, 0),
    "gim_fig11": (2, 2, 0),
    "five_bar": (2, 2, 0),
    "platform_3rrr": (3, 3, 0),
    "platform_3rpr": (3, 3, 0),
    "excavator": (3, 3, 0),
    "scotch_yoke": (1, 1, 0),
    "whitworth": (1, 1, 0),
    "scissor_lift": (1, 1, 0),
    "elliptic_trammel": (1, 1, 0),
    "ten_bar": (1, 1, 0),
    "double_butterfly": (1, 1, 0),
    "jansen": (1, 1, 0),
    "klann": (1, 1, 0),
}


def analysed(path):
    mechanism = load(path)
    z = assembled(mechanism)
    assert z is not None
    return mobility(mechanism, z)


@pytest.mark.parametrize("name", PUBLISHED)
def test_published_counts(name):
    found = analysed(MODELS / f"{name}.yaml")
    assert (found.gruebler, found.mobility, len(found.redundant)) == PUBLISHED[name]
    assert found.undriven == ()
    assert found.overdriven == ()


def written(tmp_path, text):
    path = tmp_path / "model.yaml"
    path.write_text(text)
    return path


def test_prism_with_parallel_bars_is_infinitesimally_movable_but_rigid(tmp_path):
    """PyRigi's ThreePrism("parallel"): one infinitesimal freedom, no finite one."""
    found = analysed(
        written(
            tmp_path,
            "nodes: {a: [0,0], b: [2,0], c: [1,2], d: [0,6], e: [2,6], f: [1,4]}\n"
            "ground: [a,b,c]\nelements: {top: [d,e,f]}\nlinks: {ad: [a,d], be: [b,e], cf: [c,f]}\n",
        )
    )
    assert (found.apparent, found.mobility) == (1, 0)
    assert found.singular


def test_flat_parallelogram_has_a_rank_loss_but_mobility_one(tmp_path):
    """Fraczek & Wojtyra, example 1.12: the rank is lower at alpha = 0, the mobility is not greater."""
    found = analysed(
        written(
            tmp_path,
            "nodes: {A: [0,0], B: [1,0], C: [4,0], D: [3,0]}\nground: [A,D]\n"
            "links: {crank: [A,B], coupler: [B,C], follower: [D,C]}\n"
            "actuators: {m: {type: rotary, pivot: A, arm: B}}\n",
        )
    )
    assert (found.apparent, found.mobility, found.redundant, found.undriven) == (2, 1, (), ())


def test_four_bars_in_a_row_have_mobility_one_also_in_the_flat_position(tmp_path):
    """Grübler's count is 1 for all N; in the flat position, coordinates minus rank is N + 1 (library, n_fourbar)."""
    for turned, apparent in ((False, 1), (True, 4)):
        lines = ["nodes:"]
        for k in range(4):
            lines += [f"  A{k}: [{2 * k}, 0]", f"  B{k}: [{2 * k + 1}, 0]" if turned else f"  B{k}: [{2 * k}, 1]"]
        lines += ["ground: [A0, A1, A2, A3]", "links:"]
        lines += [f"  v{k}: [A{k}, B{k}]" for k in range(4)] + [f"  h{k}: [B{k}, B{k + 1}]" for k in range(3)]
        found = analysed(written(tmp_path, "\n".join(lines) + "\n"))
        assert (found.gruebler, found.mobility, found.apparent) == (1, 1, apparent)


def test_undriven_nodes_and_overdriven_actuators_are_named(tmp_path):
    base = (
        "nodes: {A: [0,0], B: [1,1], C: [4,2], D: [3,0]}\nground: [A,D]\n"
        "links: {crank: [A,B], coupler: [B,C], follower: [D,C]}\n"
    )
    assert analysed(written(tmp_path, base)).undriven == ("B", "C")
    both = base + ("actuators: {m: {type: rotary, pivot: A, arm: B}, n: {type: rotary, pivot: D, arm: C}}\n")
    found = analysed(written(tmp_path, both))
    assert found.mobility == 1
    assert len(found.overdriven) == 1


def test_full_pivoting_finds_the_rank_of_products():
    generator = np.random.default_rng(1)
    for rank in range(1, 6):
        table = generator.standard_normal((7, rank)) @ generator.standard_normal((rank, 6))
        found, spare = full_pivoting(table)
        assert found == rank
        assert len(spare) == 7 - rank
