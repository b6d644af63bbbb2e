"""Types of mechanisms: Grashof's rule, slider-cranks and six-bar chains, against their definitions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from bundled import MODELS

import gimcli
from gimcli.structure.four_bars import COUPLER, FRAME, INPUT, OUTPUT, FourBar
from gimcli.structure.kinematic_chain import kinematic_chain
from gimcli.structure.loop_types import turns_of_inverted, turns_of_slider_crank
from gimcli.structure.mechanism_types import chain_name, mechanism_type
from gimcli.structure.mobility import gruebler

TURN = np.linspace(0.0, 2.0 * math.pi, 20_001)


# -- four-bar linkages ----------------------------------------------------------------------------


def turns_fully(frame, link, coupler, other):
    """By definition: at each angle of the link, coupler and other link reach from its end to the other pivot."""
    away = np.abs(link * np.exp(1j * TURN) - frame)
    return bool(np.all((away <= coupler + other) & (away >= abs(coupler - other))))


def test_grashof_rule_states_which_links_make_full_turns():
    rng, seen = np.random.default_rng(3), set()
    for lengths in rng.uniform(1.0, 4.0, (300, 4)):
        bar = FourBar(tuple(lengths))
        if bar.kind.startswith("cannot be assembled") or abs(bar.excess) < 1e-3:
            continue
        d, a, b, c = lengths
        assert (bar.code in ("GCCC", "GCRR")) == turns_fully(d, a, b, c)
        assert (bar.code in ("GCCC", "GRRC")) == turns_fully(d, c, b, a)
        seen.add(bar.code)
    assert seen >= {"GCCC", "GCRR", "GRCR", "GRRC", "RRR1", "RRR2", "RRR3", "RRR4"}


@pytest.mark.parametrize(
    ("lengths", "kind", "code"),
    [
        ((100.0, 40.0, 120.0, 80.0), "crank-rocker", "GCRR"),  # Norton, example 4-1
        ((40.0, 100.0, 80.0, 120.0), "double-crank (drag link)", "GCCC"),
        ((120.0, 80.0, 40.0, 100.0), "double-rocker", "GRCR"),
        ((100.0, 80.0, 120.0, 40.0), "crank-rocker driven at the rocker", "GRRC"),
        ((3.0, 1.0, 3.0, 1.0), "parallelogram (change points)", "S2X"),
        ((3.0, 1.0, 1.0, 3.0), "kite (change points)", "S2X"),
        ((2.0, 2.0, 2.0, 2.0), "rhombus (change points)", "S3X"),
        ((3.0, 1.0, 4.0, 2.0), "linkage with change points", "SCRR"),
    ],
)
def test_names_of_four_bars(lengths, kind, code):
    """Barker 1985, table 1; Norton, Design of Machinery, table 2-4."""
    bar = FourBar(lengths)
    assert (bar.kind, bar.code) == (kind, code)
    scaled = FourBar(tuple(0.37 * length for length in lengths))
    assert (scaled.kind, scaled.code) == (kind, code)


def test_triple_rockers_are_coded_by_the_longest_link():
    for place, code in ((FRAME, "RRR1"), (INPUT, "RRR2"), (COUPLER, "RRR3"), (OUTPUT, "RRR4")):
        lengths = [2.0, 2.1, 2.2, 2.3]
        lengths[place] = 4.5
        assert FourBar(tuple(lengths)).code == code
    assert FourBar((10.0, 2.0, 3.0, 4.0)).kind.startswith("cannot be assembled")


# -- slider-cranks --------------------------------------------------------------------------------


def test_slider_cranks_turn_as_the_closed_form_states():
    rng, seen = np.random.default_rng(4), set()
    for a, b, e in rng.uniform((0.5, 0.5, 0.0), (3.0, 3.0, 1.5), (300, 3)):
        found = turns_of_slider_crank(a, b, e)
        if abs(b - a - e) < 1e-3 or abs(a - b - e) < 1e-3 or e > a + b:
            continue
        crank = bool(np.all(np.abs(a * np.sin(TURN) - e) <= b))
        rod = bool(np.all(np.abs(e + b * np.sin(TURN)) <= a))
        expected = "the crank makes full turns" if crank else "the rod makes" if rod else "the crank and the rod swing"
        assert found.startswith(expected)
        seen.add(expected)
    assert len(seen) == 3


def test_inverted_slider_cranks_turn_as_the_closed_form_states():
    rng, seen = np.random.default_rng(5), set()
    for d, a, e in rng.uniform((0.5, 0.5, 0.0), (3.0, 3.0, 1.5), (300, 3)):
        found = turns_of_inverted(d, a, e)
        if min(abs(abs(d - a) - e), abs(a - d - e)) < 1e-3 or e > a + d:
            continue
        crank = bool(np.all(np.abs(a * np.exp(1j * TURN) - d) >= e))  # the block's line is at e from the other pivot
        guide = bool(np.all(np.abs(d * np.sin(TURN) - e) <= a))  # the line in each direction meets the crank's circle
        assert ("crank and the sliding link make full" in found) == (crank and guide)
        assert ("sliding link swings" in found) == (crank and not guide)
        seen.add((crank, guide))
    assert {(True, True), (True, False), (False, False)} <= seen


# -- chains ---------------------------------------------------------------------------------------

WATT = {"t": "PAB", "u": "PCD", "k": "AE", "l": "EC", "m": "BF", "n": "FD"}
STEPHENSON = {"t": "ABC", "u": "DEF", "k": "AD", "l": "BE", "m": "CG", "n": "GF"}
NAMED = {
    "Watt": (WATT, {"t": "II", "u": "II", "k": "I", "l": "I", "m": "I", "n": "I"}),
    "Stephenson": (STEPHENSON, {"t": "III", "u": "III", "k": "I", "l": "I", "m": "II", "n": "II"}),
}


def chain(links, fixed):
    rng = np.random.default_rng(1)
    nodes = sorted({node for nodes in links.values() for node in nodes})
    return gimcli.load(
        {
            "nodes": {node: rng.uniform(0, 9, 2).tolist() for node in nodes},
            "ground": {"member": fixed},
            "links": {name: list(nodes) for name, nodes in links.items() if len(nodes) == 2},
            "elements": {name: list(nodes) for name, nodes in links.items() if len(nodes) > 2},
        }
    )


@pytest.mark.parametrize("name", NAMED)
def test_inversions_of_six_bar_chains(name):
    """Norton, Design of Machinery, figure 2-16: which link is fixed gives the number."""
    links, numbers = NAMED[name]
    for fixed, number in numbers.items():
        assert chain_name(kinematic_chain(chain(links, fixed))) == f"{name} {number} six-bar"


def test_a_double_joint_is_the_limit_of_two_chains():
    links = {"frame": "OGH", "crank": "OA", "coupler": "AB", "rocker": "GB", "rod": "BC", "output": "HC"}
    found = kinematic_chain(chain(links, "frame"))
    assert (chain_name(found), found.multiple) == ("Stephenson III six-bar or Watt II six-bar", ("B",))


def test_a_loop_is_the_same_from_either_end():
    """Links in another order, and the input on the other side, change the words for the roles only."""
    nodes = {"O": [0, 0], "G": [100, 0], "A": [30.64, 25.71], "B": [143.19, 67.34]}
    arms = {"crank": ("O", "A"), "rocker": ("G", "B")}
    found = {}
    for arm, (pivot, end) in arms.items():
        m = gimcli.load(
            {
                "nodes": nodes, "ground": ["G", "O"], "links": {"coupler": ["B", "A"], "rocker": ["G", "B"],
                "crank": ["O", "A"]}, "actuators": {"m": {"type": "rotary", "pivot": pivot, "arm": end}},
            }
        )  # fmt: skip
        found[arm] = mechanism_type(m, m.drawn).name
    assert found == {
        "crank": "four-bar linkage: crank-rocker", "rocker": "four-bar linkage: crank-rocker driven at the rocker",
    }  # fmt: skip


def test_gruebler_formula_agrees_with_the_count_of_mobility():
    """Two codes: links and pairs of the chain, and members with constraints of sliding pairs."""
    for path in sorted(MODELS.glob("*.yaml")):
        m = gimcli.load(path)
        found = kinematic_chain(m)
        assert found.gruebler == gruebler(m), path.stem
        assert found.formula.endswith(f"= {found.gruebler}")
    published = {"plantigrade": -2, "dixon_k33": 0, "parallelogram_third_crank": 0, "floating_hexagon": 3}
    for name, count in published.items():
        assert kinematic_chain(gimcli.load(MODELS / f"{name}.yaml")).gruebler == count
    whitworth = kinematic_chain(gimcli.load(MODELS / "whitworth.yaml"))
    assert whitworth.formula == "F = 3 (n - 1) - 2 j1 - j2 = 3 (6 - 1) - 2 · 7 = 1"
