"""The rules of the paper: its worked example, dyadic decompositions, and where they give no convergent sequence."""

import json

import numpy as np
import pytest
from bundled import FILES, MANUAL, MODELS
from in_process import printed as gim
from random_mechanisms import Growth

import gimcli
from gimcli import StructureError, load, loads
from gimcli.gim.rules import PaperRules
from gimcli.gim.sequence import find_sequence, gradients
from gimcli.gim.sweeper import Sweeper
from gimcli.mechanism import SPAN
from gimcli.motion.solve import solve
from gimcli.positions.dispatch import plain
from gimcli.positions.options import Options
from gimcli.structure.plan import make_plan
from gimcli.structure.steps import Dyad

FIG_11 = [  # Petuya et al. 2004, Fig. 11: moved node, constraint, nodes that stay, state reached, reason
    ("D", "FD", "F", "P2", "input"),
    ("A", "OA", "O", "P1", "input"),
    ("E", "FDE F-D-E", "D F", "P1", "II"),
    ("E", "FDE F-E", "F", "P2", "I"),
    ("B", "DB", "D", "P1", "II"),
    ("C", "EC", "E", "P1", "II"),
    ("B", "ABC A-B", "A", "P2", "criteria"),
    ("C", "ABC B-C", "B", "P2", "II"),
    ("A", "ABC A-B-C", "B C", "P2", "II"),
]

REFUSED = {"elliptic_trammel": "motor", "engine": "cylinder", "scotch_yoke": "slot", "suspension": "wheel"}
"""The absolute angle of a coupler, a slider beside its line, a yoke that cannot rotate, a height without a guide."""

INCOMPLETE = {"lift_table", "plantigrade"}
"""All inputs are between moving nodes: no rule has an origin."""

DIVERGENT = {"innocenti_group", "platform_3rpr", "stephenson_2", "ten_bar"}


def parts(mechanism):
    return [one.mechanism for one in mechanism.machines] if len(mechanism.machines) > 1 else [mechanism]


def body(mechanism, restriction):
    """Return the member, pair or actuator of a restriction."""
    names = [*(m.name for m in mechanism.members), *(r.pair or r.name for r in mechanism.pairs)]
    names += [a.name for a in mechanism.actuators]
    return max((n for n in names if restriction == n or restriction.startswith(f"{n} ")), key=len)


def places(mechanism, rules):
    """Return for each node the two restrictions that place it, after checking that they place it in one sweep.

    In a dyadic decomposition a node is placed by two restrictions, all other nodes of which are placed before.
    """
    placed, by = set(rules.fixed) | {m.node for m in rules.placed}, {}
    for move in rules.moves:
        if move.rule == "surplus":
            continue
        assert move.node not in placed
        by.setdefault(move.node, []).append(move.restriction)
        if len(by[move.node]) == 2:
            assert all(n in placed for r in by[move.node] for n in r.nodes if n != move.node)
            placed.add(move.node)
    assert all(len(own) == 2 for own in by.values())
    return {mechanism.nodes[n]: own for n, own in by.items()}


def dyads(mechanism, placing):
    """Return the nodes that two different bodies place, with these."""
    named = {(node, frozenset(body(mechanism, r.name) for r in own)) for node, own in placing.items()}
    return {(node, own) for node, own in named if len(own) == 2}


def greatest_cosine(z, mechanism, placing):
    """Return the greatest squared cosine between the two loci of a node: the factor of alternating projections."""
    found = [0.0]
    for node, (first, second) in placing.items():
        a, b = gradients((first, second), z)[:, mechanism.nodes.index(node)]
        found.append(((a.conjugate() * b).real / (abs(a) * abs(b))) ** 2)
    return max(found)


# -- the worked example ------------------------------------------------------------------------------------


def test_fig_11_move_by_move():
    found = gimcli.sequence(load(MODELS / "gim_fig11.yaml"), strategy="classic")
    (group,) = found.report()["groups"]
    moves = [(s["node"], s["constraint"], " ".join(s["about"]), s["states"], s["rule"]) for s in group["steps"]]
    assert [(node, by, about, states[node], rule) for node, by, about, states, rule in moves] == FIG_11
    assert group["kind"] == "strongly coupled"


def test_fig_11_is_explained():
    printed = " ".join(gim("sequence", MODELS / "gim_fig11.yaml", "--strategy", "classic", "--explain").split())
    for text in (
        "3. E is moved to its angle about D from F; rule II: D is stable (P2); it can only move E",
        "4. E is moved to its distance from F; rule I: it has been moved once (P1); fixed (P): F",
        "7. B is moved to its distance from A; criteria: most unused restrictions (1) of the available nodes (P1):"
        " A, B, C; the first of them is the origin; it was moved by a distance, so by a distance",
        "9. A is moved to its angle about B from C; rule II",
    ):
        assert text in printed


def test_a_ternary_member_is_no_origin_for_each_of_its_equations():
    """Counted equation by equation, B of Fig. 11 would have two unused restrictions, and the moves would diverge."""
    rules = PaperRules(load(MODELS / "gim_fig11.yaml"))
    (chosen,) = [m for m in rules.moves if m.rule == "criteria"]
    assert [rules.mechanism.nodes[n] for n in (*chosen.about, chosen.node)] == ["A", "B"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_after_a_distance_the_criteria_impose_a_distance(path):
    """An angle is imposed from an available node that a distance moved only if no distance acts on this node."""
    mechanism = load(path)
    if path.stem in REFUSED or len(mechanism.machines) > 1:
        return
    rules = PaperRules(mechanism)
    counts = dict.fromkeys(rules.counts, 0) | {m.node: 2 for m in rules.placed}
    last = {}
    for k, move in enumerate(rules.moves):
        if move.rule == "criteria":
            assert any(counts.get(n) == 1 for n in move.about)
            for origin in (n for n in move.about if counts.get(n) == 1 and last[n] == SPAN):
                later = [m.restriction for m in rules.moves[k + 1 :] if m.restriction.kind == SPAN]
                ends = {n for r in later if origin in r.nodes for n in r.nodes if n != origin}
                assert move.restriction.kind == SPAN or all(counts.get(n, 2) == 2 for n in ends)
        counts[move.node], last[move.node] = counts[move.node] + 1, move.restriction.kind


# -- weakly coupled mechanisms ------------------------------------------------------------------------------


@pytest.mark.few
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_rules_one_and_two_alone_give_the_dyadic_decomposition(path):
    """Of every model without a coupled group; the dyads are those of the closed forms, which loci find."""
    for mechanism in parts(load(path)):
        plan = make_plan(mechanism)
        if plan.coupled or path.stem in REFUSED:
            continue
        rules = PaperRules(mechanism)
        assert rules.missing == ()
        assert {m.rule for m in rules.moves} <= {"input", "I", "II", *(["surplus"] if plan.surplus else [])}
        placing = places(mechanism, rules)
        closed = {
            (mechanism.nodes[s.node], frozenset(body(mechanism, one.name) for one in (s.first, s.second)))
            for s in plan.steps
            if isinstance(s, Dyad)
        }
        if plan.surplus:
            continue
        own = dyads(mechanism, placing)
        assert closed <= own
        # closed forms place the arm of a driven angle, and the nodes of a guide whose direction is known, as carried
        carried = {a.name for a in mechanism.actuators} | {r.pair or r.name for r in mechanism.pairs}
        assert all(names & carried for _, names in own - closed)
        z = solve(mechanism, mechanism.drawn_inputs, Options(tolerance=1e-13)).z
        cosine = greatest_cosine(z, mechanism, placing)
        assert find_sequence(mechanism, z, "classic").radius == pytest.approx(cosine, abs=1e-5)


class Dyads(Growth):
    """A mechanism of dyads; `built` has each new node with the two bodies that place it."""

    def __init__(self, seed, groups):
        self.built = {}
        super().__init__(seed, groups, "crank")

    def rrr(self):
        count = len(self.bodies)
        super().rrr()
        if len(self.bodies) > count:
            first, second = list(self.bodies)[-2:]
            self.built[self.bodies[first][1]] = frozenset((first, second))

    def rrp(self):
        """Add a link with a slider on the line of two ground nodes."""
        if ends := self.pick():
            u, v = self.random.sample(self.ground, 2)
            if ends[0] not in self.ground:
                new = self.node(self.place(u) + self.random.uniform(0.1, 0.9) * (self.place(v) - self.place(u)))
                self._slider(ends[0], new, new, u, v)

    def rpr(self):
        """Add a link on which an existing node slides."""
        if (ends := self.pick(2)) and not set(ends) <= set(self.ground):
            new = self.node(self.place(ends[0]) + 1.5 * (self.place(ends[1]) - self.place(ends[0])))
            self._slider(ends[0], new, ends[1], ends[0], new)

    def _slider(self, end, new, node, u, v):
        self.body([end, new])
        self.slide([node], u, v)
        self.built[new] = frozenset((list(self.bodies)[-1], list(self.pairs)[-1]))


@pytest.mark.few(30)
@pytest.mark.parametrize("seed", range(60))
def test_random_dyads_are_found_as_they_were_built(seed):
    kinds = Growth(seed, 0).random.choices(["rrr", "rrp", "rpr"], weights=(2, 1, 1), k=2 + seed % 7)
    built = Dyads(seed, kinds)
    model = built.model()
    model["nodes"] = dict(built.random.sample(list(model["nodes"].items()), len(model["nodes"])))  # ties need no order
    mechanism = loads(json.dumps(model))
    rules = PaperRules(mechanism)
    assert {m.rule for m in rules.moves} <= {"input", "I", "II"}
    placing = places(mechanism, rules)
    assert dyads(mechanism, placing) == set(built.built.items())
    z, inputs = mechanism.drawn, mechanism.drawn_inputs
    radius = find_sequence(mechanism, z, "classic").radius
    assert radius == pytest.approx(greatest_cosine(z, mechanism, placing), abs=1e-7)
    if radius < 0.9:
        solved = solve(mechanism, inputs, Options("gim", "classic", 1e-9))
        assert solved.status.word == "ok"
        assert np.max(np.abs(solved.z - z)) < 1e-6


def test_a_member_with_two_ground_nodes_is_fixed_and_the_named_arm_is_placed():
    spec = {
        "nodes": {"A": [0, 0], "Q": [2, 0.5], "B": [1, 2], "C": [4, 3], "D": [5, 0], "E": [4.5, 0.5], "P": [3.5, -2]},
        "ground": ["A", "D"],
        "links": {"coupler": ["B", "C"], "rocker": ["C", "E"], "second": ["Q", "P"], "third": ["P", "D"]},
        "elements": {"base": ["A", "D", "E"], "crank": ["A", "Q", "B"]},
        "actuators": {"motor": {"type": "rotary", "pivot": "A", "arm": "B", "law": {"by": 20}}},
    }
    rules = PaperRules(loads(json.dumps(spec)))
    assert [rules.mechanism.nodes[m.node] for m in rules.placed] == ["B"]
    assert set(places(rules.mechanism, rules)) == {"Q", "C", "P"}
    assert [m.rule for m in rules.moves if rules.mechanism.nodes[m.node] == "Q"] == ["II", "I"]


# -- what the rules do not give ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_distance_and_no_angle_is_refused_by_name(name):
    mechanism = load(MODELS / f"{name}.yaml")
    with pytest.raises(StructureError):
        gimcli.sequence(mechanism, strategy="classic")
    with pytest.raises(StructureError):
        gimcli.trace(mechanism, 4, method="gim", strategy="classic")
    assert gimcli.sequence(mechanism).report()["groups"]


@pytest.mark.parametrize("name", sorted(INCOMPLETE))
def test_an_incomplete_sequence_is_reported_with_its_nodes_and_radius(name, tmp_path):
    """A direction in which no restriction is imposed keeps its error: the radius is at least 1."""
    mechanism = load(MODELS / f"{name}.yaml")
    (group,) = gimcli.sequence(mechanism, strategy="classic").report()["groups"]
    assert group["incomplete"]
    assert group["radius"] >= 1.0 - 1e-9
    assert (group["predicted_sweeps"], group["observed_sweeps"]) == (None, None)
    picture = tmp_path / "moves.png"
    assert group["incomplete"] in gim("sequence", MODELS / f"{name}.yaml", "--strategy", "classic", "--png", picture)
    assert picture.stat().st_size > 0
    for verb in (gimcli.solve, lambda m, **how: gimcli.trace(m, 4, **how)):
        with pytest.raises(StructureError):
            verb(mechanism, method="gim", strategy="classic")


@pytest.mark.few(2)
@pytest.mark.parametrize("name", sorted(DIVERGENT))
def test_a_sequence_that_does_not_converge_is_reported_with_its_radius(name):
    mechanism = load(MODELS / f"{name}.yaml")
    found = gimcli.sequence(mechanism, strategy="classic").report()["groups"][0]
    assert found["radius"] >= 1.0
    assert (found["incomplete"], found["predicted_sweeps"], found["observed_sweeps"]) == ("", None, None)
    assert "no convergence" in gim("sequence", MODELS / f"{name}.yaml", "--strategy", "classic")
    swept = gimcli.trace(mechanism, 12, method="gim", strategy="classic")
    assert not swept.complete
    assert "spectral radius 1." in swept.report()["reason"]


def test_a_position_that_is_not_solved_has_the_radius():
    found = gimcli.solve(load(MODELS / "ten_bar.yaml"), method="gim", strategy="classic")
    assert found.status == "stalled"
    assert "spectral radius 1." in found.report()["reason"]
    other = gimcli.solve(load(MODELS / "ten_bar.yaml"), method="gim", sequence="j2>j13", tolerance=1e-12)
    assert "spectral radius" not in other.reason


def test_a_sequence_by_the_rules_is_not_exchanged():
    mechanism = load(MODELS / "ten_bar.yaml")
    sweeper = Sweeper(mechanism, Options(method="gim", strategy="classic"), plain)
    assert not sweeper.exchange(mechanism.drawn, 0.0)


def test_the_manual_compares_both_on_all_coupled_models():
    """Radius and sweeps, from 1 % of the size to 1e-10, of the rules and of the best admissible sequence."""
    lines = (MANUAL / "method.md").read_text(encoding="utf-8").splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("| coupled model"))
    table = {}
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        name, *cells = (cell.strip(" `") for cell in line.strip("|").split("|"))
        table[name] = cells
    coupled = [path for path in FILES if any(make_plan(m).coupled for m in parts(load(path)))]
    assert list(table) == [path.stem for path in coupled]
    for path in coupled:
        refused = path.stem in REFUSED
        by_rules = ["-", "refused"] if refused else stated(gimcli.sequence(load(path), strategy="classic"))
        assert table[path.stem] == [*by_rules, *stated(gimcli.sequence(load(path)))], path.stem


def stated(found):
    """Return the radius and the sweeps of a sequence as the manual writes them."""
    groups = found.report()["groups"]
    sweeps = [g["observed_sweeps"] for g in groups]
    radius = max(g["radius"] for g in groups)
    missing = "incomplete" if any(g["incomplete"] for g in groups) else "-"
    return [f"{radius:.4f}", missing if None in sweeps else str(max(sweeps))]
