"""Driving links and Assur groups: published formations, and the definition of a group."""

from __future__ import annotations

import json
from itertools import combinations

import pytest
from bundled import MODELS
from typer.testing import CliRunner

from gimcli import StructureError, load
from gimcli.cli import app
from gimcli.mechanism import SPAN
from gimcli.structure.assur import formation
from gimcli.structure.dulmage_mendelsohn import components, match, split
from gimcli.structure.mobility import drawn_mobility

FORMATIONS = {
    # Durango et al. 2014, eq. 7 and section 3.3: driving link 2, dyad (3,4) on 2 and the frame, dyad (5,6) on 3 and 4
    "watt_1": ("1,1^(2) 2,0^(3,4) 2,0^(5,6)", "0 20 43", [(1, 1, ""), (2, 2, "RRR"), (2, 2, "RRR")]),
    "watt_durango": ("1,1^(2) 2,0^(3,4) 2,0^(5,6)", "0 20 43", [(1, 1, ""), (2, 2, "RRR"), (2, 2, "RRR")]),
    "slider_crank": ("1,1^(2) 2,0^(3,4)", "0 20", [(1, 1, ""), (2, 2, "RRP")]),
    "scotch_yoke": ("1,1^(2) 2,0^(3,4)", "0 20", [(1, 1, ""), (2, 2, "RPP")]),
    # crank and slotted lever, then a rod and a ram on a guide
    "whitworth": ("1,1^(2) 2,0^(3,4) 2,0^(5,6)", "0 20 30", [(1, 1, ""), (2, 2, "RPR"), (2, 2, "RRP")]),
    # driven at the far side, Stephenson's chain III is a triad; chain II a loop of four links (Artobolevskii)
    "stephenson_3_far": ("1,1^(2) 4,0^(3,4,5,6)", "0 200", [(1, 1, ""), (3, 3, "")]),
    "stephenson_2": ("1,1^(2) 4,0^(3,4,5,6)", "0 20", [(1, 1, ""), (4, 2, "")]),
    # driven by the height of a node: a block on the vertical, and a slider on it across the vertical
    "suspension": ("1,1^(2) 4,0^(3,4,5,6)", "0 200", [(1, 1, ""), (3, 3, "")]),
    "platform_3rrr": ("1,1^(2) 1,1^(3) 1,1^(4) 4,0^(5,6,7,8)", "0 0 0 432", [(1, 1, "")] * 3 + [(3, 3, "")]),
    # three rams are three links whose lengths are inputs
    "platform_3rpr": ("4,3^(2,3,4,5)", "000", [(3, 3, "")]),
    # every ram and what it lifts is a dyad, and the bucket with its link another
    "excavator": ("2,1^(2,3) 2,1^(4,5) 2,1^(6,7) 2,0^(8,9)", "00 22 44 64", [(2, 2, "RRR")] * 4),
}


@pytest.mark.parametrize("name", FORMATIONS)
def test_known_formations(name):
    formula, bases, kinds = FORMATIONS[name]
    found = formation(load(MODELS / f"{name}.yaml"))
    assert " ".join(found.formula) == formula
    joined = [sorted((found.numbers[k] for k in found.bases(group)), reverse=True) for group in found.groups]
    assert [[int(digit) for digit in text] for text in bases.split()] == joined
    assert [(g.grade, g.order, g.dyad) for g in found.groups] == kinds


@pytest.mark.few
def test_every_group_has_mobility_zero_and_every_part_of_it_more(model):
    """Assur's definition: 3 n - 2 p - drivers = 0 for a group, and > 0 for every part of it."""
    mechanism = load(model)
    found = formation(mechanism)
    formed = {0}
    for group in found.groups:
        pairs = [*group.outer, *group.inner]
        inside = [k for k in group.drivers if mechanism.actuators[k].kind != SPAN]  # a ram is a link
        assert 3 * len(group.links) - 2 * len(pairs) - len(inside) == -group.surplus
        assert all(base in formed for base in found.bases(group))
        formed |= set(group.links)
        if group.surplus or inside or len(group.links) > 10:
            continue
        for count in range(1, len(group.links)):
            for part in combinations(group.links, count):
                own = [p for p in pairs if {*p.bodies} - set(group.links) or {*p.bodies} <= set(part)]
                own = [p for p in own if {*p.bodies} & set(part)]
                assert 3 * count - 2 * len(own) > 0, [found.links[k] for k in part]
    assert len(formed) == len(found.numbers)
    added = [formula.split("^")[0].split(",") for formula in found.formula]
    assert [int(links) for links, _ in added] == [len(group.links) for group in found.groups]
    assert sum(int(freedoms) for _, freedoms in added) == drawn_mobility(mechanism).mobility


def test_the_order_of_the_file_does_not_change_the_groups(tmp_path):
    text = (MODELS / "watt_1.yaml").read_text()
    lines = text.splitlines(keepends=True)
    first = next(k for k, line in enumerate(lines) if "link_5:" in line)
    lines[first], lines[first + 1] = lines[first + 1], lines[first]
    (tmp_path / "m.yaml").write_text("".join(lines))
    one, two = formation(load(MODELS / "watt_1.yaml")), formation(load(tmp_path / "m.yaml"))

    def names(found):
        return [{found.links[k] for k in g.links} for g in found.groups]

    assert names(one) == names(two)


def test_an_undriven_mechanism_has_no_formation(tmp_path):
    text = (MODELS / "five_bar.yaml").read_text()
    start, end = text.index("  motor_2:"), text.index("\npoints:") if "\npoints:" in text else len(text)
    (tmp_path / "m.yaml").write_text(text[:start] + text[end:])
    with pytest.raises(StructureError):
        formation(load(tmp_path / "m.yaml"))


def test_the_command_prints_the_formation(tmp_path):
    result = CliRunner().invoke(app, ["groups", str(MODELS / "watt_1.yaml"), "--json"])
    report = json.loads(result.stdout)
    assert report["formula"] == ["1,1^(2)", "2,0^(3,4)", "2,0^(5,6)"]
    assert report["links"] == {"ground": 0, "crank": 2, "link_3": 3, "link_4": 4, "link_5": 5, "link_6": 6}
    last = report["groups"][-1]
    assert (last["class"], last["order"], last["dyad"], last["on"]) == (2, 2, "RRR", ["link_3", "link_4"])
    assert [(p["kind"], p["at"]) for p in last["inner"]] == [("R", "E")]
    assert report["groups"][0]["driven_by"] == ["motor"]
    picture = tmp_path / "w.png"
    result = CliRunner().invoke(app, ["groups", str(MODELS / "watt_1.yaml"), "--png", str(picture)])
    assert result.exit_code == 0
    assert "2,0^(5,6)" in result.stdout
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_components_are_listed_after_those_they_depend_on():
    needs = [[1], [2], [1, 3], [], [0, 3], [5]]
    found = components(needs)
    assert sorted(map(tuple, found)) == [(0,), (1, 2), (3,), (4,), (5,)]
    place = {node: k for k, part in enumerate(found) for node in part}
    assert all(place[other] <= place[node] for node, others in enumerate(needs) for other in others)


def test_a_deep_chain_is_split_without_recursion():
    count = 20_000
    blocks = split(count, [[k, k + 1] if k + 1 < count else [k] for k in range(count)])
    assert [len(block.rows) for block in blocks] == [1] * count
    assert blocks[0].rows == (0,) or blocks[-1].rows == (0,)


def test_an_unmatched_unknown_is_added_to_the_block_of_its_equations():
    """Three unknowns in two equations with a common unknown, and a third equation with its own unknown."""
    blocks = split(3, [[0], [0, 1], [1], [2]])
    assert {(b.rows, b.columns) for b in blocks} == {((0, 1), (0, 1, 2)), ((2,), (3,))}
    assert match(2, []) == []
