"""All configurations compared with published cases and independent searches, and laws over all models."""

import cmath
import math
from itertools import pairwise

import numpy as np
import other_searches as oracles
import pytest
import yaml
from bundled import MODELS
from link_graphs import baranov_trusses, bars, loaded, truss, watt_baranov
from random_mechanisms import Growth

from gimcli import StructureError, load
from gimcli.assemblies import all_configurations, configurations_over, drawn_configuration
from gimcli.assemblies.assemblies import ConfigurationFinder
from gimcli.motion.solve import solve
from gimcli.positions.options import Options
from gimcli.status import Status
from gimcli.structure.mobility import assembled, mobility
from gimcli.structure.residual import residual

NO_INPUTS = np.zeros(0)
SINGULAR = {"peaucellier"}
"""Models that can move at constant inputs: a folded kite."""


def model_of(name):
    return load(MODELS / f"{name}.yaml")


def counts(found):
    """Return the generic count, the number of proved complex roots, and the number of configurations."""
    return found.bound, sum(g.roots for g in found.groups), len(found)


# ------------------------------------------------------------------ published cases

DOUBLE_BUTTERFLY = [  # Nielsen & Roth 1999, Wampler 2001: angles of UVW, WXY, and of the bars 11, 9, 7, 12 [deg]
    (-167.467473, -125.129584, -169.415820, -109.625132, -66.373159, -7.367330),
    (-159.190457, 50.207952, 90.802105, 33.420510, -19.448727, 25.064013),
    (-80.024075, 176.216212, -168.876684, -135.793781, -44.618221, -7.589980),
    (-57.404022, -60.480688, 179.936230, -149.499001, 146.441212, 75.957534),
    (9.338529, -130.981247, 158.033089, -157.254723, 120.062432, 62.953396),
    (29.697645, 74.338361, 52.187355, 0.612784, -9.412867, 25.597619),
]


def test_double_butterfly_has_its_published_solutions():
    mechanism = model_of("double_butterfly")
    found = all_configurations(mechanism, np.radians([180.0 - 67.38]))
    at = {n: found.z[:, k] for k, n in enumerate(mechanism.nodes)}
    vectors = [("V", "U"), ("X", "W"), ("Q", "U"), ("S", "V"), ("T", "X"), ("R", "Y")]
    angles = np.degrees(np.angle(np.array([at[b] - at[a] for a, b in vectors]))).T
    assert found.complete
    assert counts(found) == (18, 18, 6)
    np.testing.assert_allclose(angles[np.argsort(angles[:, 0])], DOUBLE_BUTTERFLY, atol=6e-7)


def test_innocenti_group_has_eighteen_roots_eight_real():
    """A seven-link group with one quaternary link has eighteen roots, as published by C. Innocenti."""
    mechanism = model_of("innocenti_group")
    found = all_configurations(mechanism, mechanism.start_inputs)
    assert found.complete
    assert counts(found) == (18, 18, 8)


def test_prism_has_twenty_four_real_embeddings():
    """J. Capco et al. 2018: lengths for which all 24 embeddings of the 3-prism are real."""
    lengths = {(1, 2): 2, (1, 3): 2, (2, 3): 2, (1, 4): 7 / 4, (3, 6): 27 / 10, (2, 5): 197 / 100,
               (4, 5): 11 / 5, (4, 6): 29 / 10, (5, 6): 43 / 20}  # fmt: skip
    found = all_configurations(loaded(bars(list(lengths), (1, 2), lengths)), NO_INPUTS)
    assert found.complete
    assert (found.bound, len(found)) == (24, 24)
    mirrored = [np.min(np.max(np.abs(found.z - z.conj()), axis=1)) for z in found.z]
    assert max(mirrored) < 1e-9  # the fixed bar is on the axis: 12 pairs of mirror images


def test_complete_bipartite_framework_has_sixteen_embeddings():
    """K33 has sixteen complex embeddings, its published Laman number."""
    edges = [(a, b) for a in (1, 3, 5) for b in (2, 4, 6)]
    found = all_configurations(loaded(bars(edges, (1, 2))), NO_INPUTS)
    assert found.complete
    assert counts(found)[:2] == (16, 16)


TRUSSES = {  # 5 links: a 3-RR platform; 7: N. Rojas, F. Thomas 2011; 9: counted by another program
    2: [6],
    3: [14, 16, 18],
    4: [30, 36, 38, 40, 40, 40, 42, 42, 42, 44, 44, 46, 46, 46, 48, 48, 48, 48, 48, 50, 50, 50, 52, 52, 54, 54, 56, 58],
}


@pytest.mark.few(2)
@pytest.mark.parametrize("loops", TRUSSES)
def test_every_baranov_truss_has_all_its_roots(loops):
    """With random dimensions all roots are proved, and the initial position is one of them."""
    found = []
    for seed, joints in enumerate(baranov_trusses(loops)):
        mechanism = loaded(truss(joints, seed, ground=seed % (2 * loops + 1)))
        now = all_configurations(mechanism, NO_INPUTS)
        assert now.level == 1
        assert now.bound == sum(g.roots for g in now.groups)
        assert np.max(now.residual) < 1e-12
        assert np.min(np.max(np.abs(now.z - mechanism.drawn), axis=1)) < 1e-9
        assert len(now) % 2 == 0
        found.append(now.bound)
    assert sorted(found) == TRUSSES[loops]


@pytest.mark.few(2)
@pytest.mark.parametrize("loops", [3, 4, 5])
def test_rings_of_triangles_have_the_published_counts(loops):
    """Watt-Baranov trusses of 7, 9, 11 and 13 links: 14, 30, 62, 126. Source: N. Rojas, F. Thomas."""
    mechanism = loaded(truss(watt_baranov(loops), seed=loops))
    found = all_configurations(mechanism, NO_INPUTS)
    assert counts(found)[:2] == (2 ** (loops + 1) - 2,) * 2
    assert found.complete
    assert np.min(np.max(np.abs(found.z - mechanism.drawn), axis=1)) < 1e-9


@pytest.mark.soak
def test_ring_of_thirteen_links():
    found = all_configurations(loaded(truss(watt_baranov(6), seed=1)), NO_INPUTS)
    assert counts(found)[:2] == (126, 126)
    assert found.complete


# ------------------------------------------------------------------ platforms, by an independent polynomial


def platform(base, plate, legs, turn=0.3):
    """Return the model of a plate on three driven legs."""
    nodes = {f"A{k}": [b.real, b.imag] for k, b in enumerate(base)}
    for k, p in enumerate(plate):
        at = 0.1 + 0.2j + cmath.exp(1j * turn) * p
        nodes[f"B{k}"] = [at.real, at.imag]
    shape = {f"B{k}": [p.real, p.imag] for k, p in enumerate(plate)}
    actuators = {
        f"leg{k}": {"type": "linear", "nodes": [f"A{k}", f"B{k}"], "law": {"from": leg, "to": leg + 0.1}}
        for k, leg in enumerate(legs)
    }
    return {"nodes": nodes, "ground": ["A0", "A1", "A2"], "elements": {"plate": {"nodes": list(shape), "shape": shape}},
            "actuators": actuators}  # fmt: skip


def plate_angles(found):
    """Return the angles of the plate [rad], sorted."""
    names = found.mechanism.nodes
    first, second = names.index("B0"), names.index("B1")
    member = found.mechanism.members[1]
    own = cmath.phase(member.local(second) - member.local(first))
    return np.sort(np.angle((found.z[:, second] - found.z[:, first]) * cmath.exp(-1j * own)))


def test_a_platform_on_three_linear_actuators_has_its_six_published_assemblies():
    """Innocenti & Parenti-Castelli 1998: six real assemblies."""
    mechanism = model_of("platform_3rpr")
    found = all_configurations(mechanism, mechanism.start_inputs)
    assert counts(found) == (6, 6, 6)
    assert found.complete


@pytest.mark.few(10)
@pytest.mark.parametrize("seed", range(20))
def test_random_platforms_agree_with_the_sextic(seed):
    generator = np.random.default_rng(seed)
    base, plate = (generator.uniform(-1, 1, 3) + 1j * generator.uniform(-1, 1, 3) for _ in range(2))
    legs = generator.uniform(0.4, 1.6, 3)
    plate = (plate - plate[0]) * np.exp(-1j * np.angle(plate[1] - plate[0]))
    mechanism = loaded(platform(base.tolist(), plate.tolist(), legs.tolist()))
    found = all_configurations(mechanism, mechanism.start_inputs)
    assert found.complete
    np.testing.assert_allclose(plate_angles(found), oracles.platform_angles(base, plate, legs), atol=1e-7)


def test_collinear_base_and_plate_have_at_most_four_real_assemblies():
    """C. Gosselin, J.-P. Merlet 1994: at most four real assemblies, of six complex ones."""
    real = set()
    for seed in range(25):
        generator = np.random.default_rng(seed)
        base, plate = ([0j, *(complex(x) for x in np.cumsum(generator.uniform(0.5, 2, 2)))] for _ in range(2))
        mechanism = loaded(platform(base, plate, generator.uniform(1, 2.5, 3).tolist()))
        found = all_configurations(mechanism, mechanism.start_inputs)
        assert found.complete
        assert counts(found)[:2] == (6, 6)
        real.add(len(found))
    assert max(real) == 4


# ------------------------------------------------------------------ laws over every model


@pytest.mark.few
def test_the_list_of_every_model_contains_all_results_of_random_starts(model):
    mechanism = load(model)
    inputs = mechanism.start_inputs
    found = all_configurations(mechanism, inputs)
    assert np.max(found.residual) < 1e-12
    assert found.complete == (model.stem not in SINGULAR)
    apart = np.max(np.abs(found.z[:, None] - found.z[None]), axis=2) + np.eye(len(found))
    assert np.min(apart) > 1e-6
    assert len(found) <= found.bound
    assert drawn_configuration(found) is not None
    starts = [solve(mechanism, inputs, Options(seed=seed)) for seed in range(6)]
    settled = [p.z for p in starts if p.status is Status.OK]
    if model.stem not in SINGULAR:
        assert not oracles.unmatched(np.array(settled), found.z)


@pytest.mark.few(16)
@pytest.mark.parametrize("drive", [None, "elsewhere", "distance", "travel"])
@pytest.mark.parametrize("seed", [300, 301, 302, 303, 304, 305, 307, 308, 310, 311])
def test_the_list_of_a_random_mechanism_contains_its_known_configuration(seed, drive, tmp_path):
    """The mechanisms have dyads, triads, n-ary members, both kinds of prismatic pair, and every actuator."""
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(Growth(seed, 3, drive).model()))
    mechanism = load(path)
    inputs = mechanism.drawn_inputs
    found = all_configurations(mechanism, inputs)
    assert found.complete
    assert np.max(found.residual) < 1e-12
    assert np.min(np.max(np.abs(found.z - mechanism.drawn), axis=1)) < 1e-8
    settled = [p.z for seed in range(3) if (p := solve(mechanism, inputs, Options(seed=seed))).status is Status.OK]
    assert not oracles.unmatched(np.array(settled).reshape(-1, len(mechanism.nodes)), found.z)


@pytest.mark.few(6)
@pytest.mark.parametrize(
    "kinds",
    [("triad", "rrp"), ("rpr", "triad"), ("true_pair", "rrr"), ("prp", "triad"), ("nary", "rpr"), ("rrp", "rrp")],
)
@pytest.mark.parametrize("drive", ["elsewhere", "distance"])
def test_random_mechanisms_agree_with_gauss_newton(kinds, drive, tmp_path):
    """Another search in other coordinates, from many starts, finds no other configuration."""
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(Growth(7, kinds, drive).model()))
    mechanism = load(path)
    inputs = mechanism.drawn_inputs
    found = all_configurations(mechanism, inputs)
    others = oracles.configurations_by_starts(mechanism, inputs, starts=300)
    assert found.complete
    assert len(others) > 0
    assert not oracles.unmatched(others, found.z)


# ------------------------------------------------------------------ special dimensions


def four_bar(crank, coupler, rocker, ground):
    return {
        "nodes": {"O": [0, 0], "C": [ground, 0], "A": [crank, 0], "B": [ground, rocker]},
        "ground": ["O", "C"],
        "links": {
            "a": {"nodes": ["O", "A"], "length": crank},
            "b": {"nodes": ["A", "B"], "length": coupler},
            "c": {"nodes": ["C", "B"], "length": rocker},
        },
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
    }


@pytest.mark.few(15)
@pytest.mark.parametrize("seed", range(30))
def test_four_bars_agree_with_the_law_of_cosines(seed):
    generator = np.random.default_rng(seed)
    crank, coupler, rocker, ground = generator.uniform(0.3, 2, 4).tolist()
    angle = generator.uniform(-math.pi, math.pi)
    found = all_configurations(loaded(four_bar(crank, coupler, rocker, ground)), np.array([angle]))
    diagonal = abs(crank * cmath.exp(1j * angle) - ground)
    assert found.complete
    assert len(found) == (2 if abs(coupler - rocker) < diagonal < coupler + rocker else 0)


@pytest.mark.parametrize(("angle", "level", "number"), [(1e-6, 1, 2), (1e-8, 4, 1), (0.0, 4, 1)])
def test_parallelogram_near_its_flat_position(angle, level, number):
    """Two roots 1e-6 apart are proved; if they differ only by rounding there is one, and the list is not complete."""
    found = all_configurations(loaded(four_bar(1, 3, 1, 3)), np.array([angle]))
    assert (found.level, len(found)) == (level, number)
    assert np.max(found.residual) < 1e-10
    assert np.all(np.isfinite(found.radius)) == (level == 1)


@pytest.mark.parametrize(("over", "level", "number"), [(1e-12, 1, 2), (0.0, 4, 1), (-1e-14, 4, 1), (-1e-12, 1, 0)])
def test_slider_crank_with_a_rod_normal_to_its_guide(over, level, number):
    """The slider is at x = +-sqrt(2 over), because the rod is almost normal to its guide."""
    spec = {
        "nodes": {"O": [0, 0], "G": [5, 0], "A": [0, 1], "B": [0.1, 0]},
        "ground": ["O", "G"],
        "links": {"a": ["O", "A"], "b": {"nodes": ["A", "B"], "length": 1.0 + over}},
        "prismatic": {"slide": {"node": "B", "guide": ["O", "G"]}},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
    }
    mechanism = loaded(spec)
    found = all_configurations(mechanism, mechanism.drawn_inputs)
    assert (found.level, len(found)) == (level, number)
    if number == 2:
        x = mechanism.to_file(found.z)[:, mechanism.nodes.index("B")].real
        np.testing.assert_allclose(np.sort(np.abs(x)), math.sqrt(2 * over), rtol=1e-3)


def peaucellier(over):
    data = yaml.safe_load((MODELS / "peaucellier.yaml").read_text())
    data["links"]["OA"]["length"] += over
    del data["units"]
    return loaded(data)


@pytest.mark.parametrize(("over", "number"), [(1e-3, 8), (1e-6, 8)])
def test_a_perturbed_inversor_has_eight_configurations(over, number):
    found = all_configurations(peaucellier(over), np.array([0.5]))
    assert (found.level, len(found)) == (1, number)


def test_an_exact_inversor_has_four_configurations_and_a_free_dyad_if_folded():
    found = all_configurations(peaucellier(0.0), np.array([0.5]))
    assert (found.level, len(found)) == (4, 4)
    assert [g.nodes for g in found.groups if g.free] == [("Q",)]
    assert found.missing == 4


@pytest.mark.few(1)
@pytest.mark.parametrize(("leg", "level", "number"), [(2.0, 2, 2), (1.7, 2, 2), (1.5, 4, 1)])
def test_equilateral_platform_has_roots_at_infinity(leg, level, number):
    """Two finite roots, proved complete for the reals by intervals; at leg 1.5 they coincide."""
    corners = [cmath.exp(1j * (math.pi / 2 + 2 * math.pi * k / 3)) for k in range(3)]
    mechanism = loaded(platform([3 * c for c in corners], [1.5 * c for c in corners], [leg] * 3))
    found = all_configurations(mechanism, mechanism.start_inputs)
    assert (found.level, len(found)) == (level, number)
    assert found.groups[0].infinite == 4


@pytest.mark.parametrize("opposite", [False, True])
def test_plate_on_two_parallel_rails_and_a_link(opposite):
    """Two solutions for its angle from the distance of the rails, each with two intersections of line and circle."""
    rails = {"first": {"node": "P", "guide": ["G", "H"]}, "second": {"node": "Q", "guide": ["J", "K"]}}
    if opposite:
        rails["second"]["guide"].reverse()
    spec = {
        "nodes": {"G": [0, 0], "H": [4, 0], "J": [0, 1], "K": [4, 1], "A": [2, -1], "P": [1, 0], "Q": [2.5, 1],
                  "R": [2, 0.3]},
        "ground": ["G", "H", "J", "K", "A"],
        "links": {"link": {"nodes": ["A", "R"], "length": 2.5}},
        "elements": {"plate": {"nodes": ["P", "Q", "R"], "shape": {"P": [0, 0], "Q": [2, 0], "R": [1.2, -0.5]}}},
        "prismatic": rails,
    }  # fmt: skip
    found = all_configurations(loaded(spec), NO_INPUTS)
    expected = []
    for angle in (math.pi / 6, 5 * math.pi / 6):  # 2 sin = 1
        r = (1.2 - 0.5j) * cmath.exp(1j * angle)
        for side in (1, -1):
            expected.append(2 + side * math.sqrt(6.25 - (r.imag + 1) ** 2) - r.real)
    names = found.mechanism.nodes
    x = found.mechanism.to_file(found.z)[:, names.index("P")].real
    assert (found.complete, found.unfit) == (True, 0)
    np.testing.assert_allclose(np.sort(x), np.sort(expected), atol=1e-12)


def test_slides_on_parallel_rotating_rails_are_not_proved_complete(tmp_path):
    """The count of 8 is only an upper bound; four roots exist, and an independent search finds no other."""
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(Growth(134, ["prp", "triad", "rrp", "true_pair"], "elsewhere").model()))
    mechanism = load(path)
    inputs = mechanism.drawn_inputs
    found = all_configurations(mechanism, inputs)
    assert [g.family.rails_shared for g in ConfigurationFinder(mechanism).groups if g.family.loops] == [True]
    assert (found.complete, len(found), sum(g.roots for g in found.groups)) == (False, 2, 4)
    assert found.missing == 0
    others = oracles.configurations_by_starts(mechanism, inputs, starts=100)
    fits = [z for z in others if residual(mechanism, z[:, None], inputs[:, None]).total[0] < 1e-9]
    assert 0 < len(fits) < len(others)  # a block reversed on its rail is not the same assembly
    assert not oracles.unmatched(np.array(fits), found.z)


@pytest.mark.parametrize("bars", [60, pytest.param(120, marks=pytest.mark.soak)])
def test_the_rank_of_a_long_chain_is_exact(bars):
    """A chain of driven bars: the rank is computed without a tolerance."""
    spec = {"nodes": {"O": [0, 0]}, "ground": ["O"], "links": {}, "actuators": {}}
    for k in range(bars):
        before = "O" if k == 0 else f"n{k - 1}"
        spec["nodes"][f"n{k}"] = [k + 1, (k + 1) % 2]
        spec["links"][f"b{k}"] = [before, f"n{k}"]
        drive = {"type": "rotary", "pivot": before, "arm": f"n{k}"}
        spec["actuators"][f"m{k}"] = drive if k == 0 else {**drive, "reference": "O" if k == 1 else f"n{k - 2}"}
    mechanism = loaded(spec)
    found = all_configurations(mechanism, mechanism.drawn_inputs)
    assert (found.complete, len(found)) == (True, 1)
    np.testing.assert_allclose(found.z[0], mechanism.drawn, atol=1e-11)


# ------------------------------------------------------------------ redundant constraints, undriven nodes


def test_third_parallel_crank_leaves_one_configuration():
    """The antiparallelogram violates the constraints of the third crank."""
    mechanism = model_of("parallelogram_third_crank")
    found = all_configurations(mechanism, np.array([0.5]))
    assert len(found.surplus) == 1
    assert (found.complete, found.bound, len(found)) == (True, 2, 1)
    a, b, o, d = (found.z[0, mechanism.nodes.index(n)] for n in ("B", "C", "A", "D"))
    assert abs(abs(a - o) - abs(b - d)) < 1e-12
    assert abs(((a - o) / (b - d)).imag) < 1e-12


def test_a_redundant_slide_is_left_out_and_checked():
    """A trammel driven by its crank: the second slide is satisfied by only one of the two configurations."""
    spec = {
        "nodes": {"O": [0, 0], "G": [5, 0], "H": [0, 5], "C": [0.6, 0.8], "A": [1.2, 0], "B": [0, 1.6]},
        "ground": ["O", "G", "H"],
        "links": {"crank": ["O", "C"]},
        "elements": {"bar": ["A", "C", "B"]},
        "prismatic": {"sx": {"node": "A", "guide": ["O", "G"]}, "sy": {"node": "B", "guide": ["O", "H"]}},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "C"}},
    }
    mechanism = loaded(spec)
    found = all_configurations(mechanism, mechanism.drawn_inputs)
    assert found.surplus == ("sy",)
    assert (found.complete, len(found)) == (True, 1)
    np.testing.assert_allclose(found.z[0], mechanism.drawn, atol=1e-12)


def test_a_redundant_pin_is_replaced_by_a_slide_and_checked():
    """A coupler of two triangles that share two pins: the second pin is redundant; the mirror image violates it."""
    spec = {
        "nodes": {"O": [0, 0], "G": [4, 0], "A": [0, 1], "B": [3.5, 2], "X": [1.5, 2], "Y": [2, 1]},
        "ground": ["O", "G"],
        "links": {"crank": ["O", "A"], "rocker": ["G", "B"]},
        "elements": {"p": ["A", "X", "Y"], "q": ["X", "Y", "B"]},
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
    }
    mechanism = loaded(spec)
    found = all_configurations(mechanism, mechanism.drawn_inputs)
    assert len(found.surplus) == 1
    assert len(found) == 2  # a four-bar
    assert np.max(found.residual) < 1e-12


def test_a_slide_that_is_necessary_for_a_node_is_not_left_out():
    """A pin on the line y = 0.5 and on the rail of a brace, which is a redundant constraint of the crank."""
    spec = {
        "nodes": {"O": [0, 0], "X": [5, 0], "A": [1.2, 1.6], "B": [-0.8, 0.6], "P": [-1, 0.5]},
        "ground": ["O", "X"],
        "links": {"brace": ["A", "B"]},
        "elements": {"crank": ["O", "A", "B"]},
        "prismatic": {
            "rail": {"node": "P", "guide": ["O", "X"], "offset": 0.5},
            "slot": {"node": "P", "guide": ["A", "B"]},
        },
        "actuators": {"motor": {"type": "rotary", "pivot": "O", "arm": "A"}},
    }
    mechanism = loaded(spec)
    turn = cmath.rect(1.0, 0.7) / cmath.rect(1.0, cmath.phase(1.2 + 1.6j))
    found = all_configurations(mechanism, np.array([0.7]))
    assert len(found) == 1
    a, b = turn * (1.2 + 1.6j), turn * (-0.8 + 0.6j)
    pin = mechanism.to_file(found.z[0])[mechanism.nodes.index("P")]
    assert abs(pin - (b + (a - b) * (0.5 - b.imag) / (a - b).imag)) < 1e-12


def test_undriven_nodes_are_named():
    spec = four_bar(1, 3, 2, 3)
    del spec["actuators"]
    with pytest.raises(StructureError):
        all_configurations(loaded(spec), NO_INPUTS)


@pytest.mark.parametrize("seed", [1001, 1158])
def test_a_driven_angle_between_blocks_on_parallel_rails_is_redundant(seed, tmp_path):
    """The rails determine the angle; with rails that are not parallel it would be an input."""
    path = tmp_path / "model.yaml"
    path.write_text(yaml.safe_dump(Growth(seed, 5, "elsewhere").model()))
    mechanism = load(path)
    assert mobility(mechanism, assembled(mechanism)).overdriven == ("motor",)
    with pytest.raises(StructureError):
        all_configurations(mechanism, mechanism.drawn_inputs)


def test_an_angle_driven_twice_is_rejected():
    spec = four_bar(1, 3, 2, 3)
    spec["actuators"]["again"] = {"type": "rotary", "pivot": "O", "arm": "A", "reference": "C"}
    with pytest.raises(StructureError):
        all_configurations(loaded(spec), np.zeros(2))


# ------------------------------------------------------------------ over many inputs


@pytest.mark.few(2)
@pytest.mark.parametrize("name", ["double_butterfly", "stephenson_3_far", "gim_fig11", "jansen"])
def test_rows_agree_with_the_solution_at_each_input(name):
    mechanism = model_of(name)
    inputs = np.repeat(mechanism.start_inputs[:, None], 73, axis=1)
    inputs[0] += np.linspace(0.0, 2.0 * np.pi, 73) if name != "gim_fig11" else np.linspace(0.0, 0.7, 73)
    rows = configurations_over(mechanism, inputs)
    assert len(rows) == 73
    for k in range(0, 73, 8):
        alone = all_configurations(mechanism, inputs[:, k])
        assert rows[k].complete
        assert len(rows[k]) == len(alone)
        assert not oracles.unmatched(alone.z, rows[k].z, 1e-9)
    assert {len(a) % 2 for a in rows} == {len(rows[0]) % 2}


def test_rows_are_followed_through_inputs_at_which_roots_coincide():
    """4 to 8 roots are real over a turn; only the first row is solved from a generic linkage."""
    from gimcli.assemblies.configuration_sweep import RootFollower

    follower = RootFollower(ConfigurationFinder(model_of("double_butterfly")))
    numbers = {len(follower.row(np.array([angle]))) for angle in np.linspace(0.0, 2.0 * np.pi, 73)}
    assert numbers == {4, 6, 8}
    assert follower.fresh == 1


@pytest.mark.parametrize("fault", ["two the same", "not a number", "moved off"])
def test_a_row_that_loses_a_root_is_solved_again(fault, monkeypatch):
    from gimcli.assemblies import configuration_sweep

    follower = configuration_sweep.RootFollower(ConfigurationFinder(model_of("double_butterfly")))
    follower.row(np.array([2.0]))
    original = configuration_sweep.track

    def altered(*arguments):
        done = original(*arguments)
        done.w[0] = {"two the same": done.w[1], "not a number": np.nan, "moved off": 3.0 + done.w[0]}[fault]
        return done

    monkeypatch.setattr(configuration_sweep, "track", altered)
    now = follower.row(np.array([2.01]))
    assert follower.fresh == 2
    assert now.complete
    assert not oracles.unmatched(all_configurations(now.mechanism, now.inputs).z, now.z)


def test_a_root_keeps_its_number_while_roots_are_distinct():
    mechanism = model_of("double_butterfly")
    inputs = np.repeat(mechanism.start_inputs[:, None], 60, axis=1) - np.linspace(0.0, 0.06, 60)
    rows = configurations_over(mechanism, inputs)
    assert {len(r) for r in rows} == {6}
    for before, after in pairwise(rows):
        numbers = [after.branches.index(b) for b in before.branches]
        assert np.max(np.abs(after.z[numbers] - before.z)) < 0.02
