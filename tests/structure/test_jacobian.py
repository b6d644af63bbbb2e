"""The Jacobian of the constraints in three kinds of coordinates: closed forms, published ranks, dependent equations."""

import csv
import json

import numpy as np
import pytest
from in_process import gim

import gimcli
from gimcli.library.mobility import COORDINATES, JacobianMatrix, jacobian_matrix
from gimcli.structure.constraint_jacobian import full_pivoting

# Fraczek & Wojtyra, example 1.12: rank 3 of 4 equations in joint coordinates, 11 of 12 in absolute coordinates
RANKS = {"joint": (3, 4, 4), "absolute": (11, 12, 12), "natural": (5, 6, 6)}


@pytest.mark.parametrize("coordinates", COORDINATES)
def test_the_ranks_of_the_textbook_example(coordinates):
    found = gimcli.mobility(gimcli.load("parallelogram_third_crank"), coordinates=coordinates).jacobian
    assert (found.rank, *found.values.shape) == RANKS[coordinates]
    assert found.rank_by_singular_values == found.rank
    assert len(found.dependent) == 1


def four_bar(unit="m"):
    size = {"m": 1.0, "mm": 1000.0}[unit]
    places = {"A": 0, "B": 0.6 + 0.8j, "C": 2.6 + 2.3j, "D": 3}
    return places, gimcli.load(
        {
            "units": {"length": unit, "angle": "deg"},
            "nodes": {n: [size * complex(z).real, size * complex(z).imag] for n, z in places.items()},
            "ground": ["A", "D"],
            "links": {"crank": ["A", "B"], "coupler": ["B", "C"], "rocker": ["D", "C"]},
            "actuators": {"motor": {"pivot": "A", "arm": "B"}},
        }
    )


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_natural_coordinates_of_a_four_bar(unit):
    """Gradients of the lengths are unit vectors along the links."""
    z, mechanism = four_bar(unit)
    found = jacobian_matrix(mechanism, "natural")
    assert found.columns == tuple((f"{n}.{axis}", unit) for n in "BC" for axis in "xy")
    ray = {"crank": (z["B"] - z["A"], 0), "coupler": (z["B"] - z["C"], z["C"] - z["B"]), "rocker": (0, z["C"] - z["D"])}
    for name, row in zip(found.rows, found.values, strict=True):
        parts = [part / abs(part) if part else 0j for part in ray[name]]
        expected = [x for part in parts for x in (complex(part).real, complex(part).imag)]
        assert row == pytest.approx(expected, abs=1e-12) or row == pytest.approx([-x for x in expected], abs=1e-12)


@pytest.mark.parametrize("unit", ["m", "mm"])
def test_absolute_coordinates_of_a_four_bar(unit):
    """p - q = 0 at each pin: 1 and -1 by the origins, i e^(i phi) times the point by the angles."""
    z, mechanism = four_bar(unit)
    size = {"m": 1.0, "mm": 1000.0}[unit]
    found = jacobian_matrix(mechanism, "absolute")
    names = [name for name, _ in found.columns]
    assert [u for _, u in found.columns] == [unit, unit, "rad"] * 3
    origin = {"crank": "A", "coupler": "B", "rocker": "D"}  # the first node of each link
    for pin, first, second in (("A", "crank", "ground"), ("B", "coupler", "crank"), ("C", "rocker", "coupler")):
        expected = {"x": dict.fromkeys(names, 0.0), "y": dict.fromkeys(names, 0.0)}
        for sense, body in ((1.0, first), (-1.0, second)):
            if body == "ground":
                continue
            arm = 1j * size * (z[pin] - z[origin[body]])
            expected["x"] |= {f"{body}.x": sense, f"{body}.angle": sense * arm.real}
            expected["y"] |= {f"{body}.y": sense, f"{body}.angle": sense * arm.imag}
        for axis in "xy":
            row = found.values[found.rows.index(f"{pin} {first}-{second} {axis}")]
            assert dict(zip(names, row, strict=True)) == pytest.approx(expected[axis], abs=1e-9 * size)


@pytest.mark.parametrize("far", [6.0, 40.0, 100.0, 1e6])
def test_a_guide_node_far_away(far):
    """Slot: the distance of B from the line O-D, Im(conj(D) B) / |D|; D turns the line by 1 / |D|."""
    mechanism = gimcli.load(
        {
            "units": {"length": "mm", "angle": "deg"},
            "nodes": {"O": [0, 0], "C": [3, 2], "B": [3, 4], "D": [0.6 * far, 0.8 * far]},
            "ground": ["O", "C"],
            "links": {"crank": ["C", "B"], "arm": ["O", "D"]},
            "prismatic": {"slot": {"node": "B", "guide": ["O", "D"]}},
            "actuators": {"motor": {"pivot": "C", "arm": "B"}},
        }
    )
    found = jacobian_matrix(mechanism, "natural")
    assert [name for name, _ in found.columns] == ["B.x", "B.y", "D.x", "D.y"]
    slot = np.array([-0.8, 0.6, 4.0 / far, -3.0 / far])  # |OB| = 5
    row = found.values[found.rows.index("slot")]
    assert row * np.sign(row[1]) == pytest.approx(slot, rel=1e-9, abs=1e-15)
    assert found.rank == 3


@pytest.mark.parametrize("coordinates", COORDINATES)
@pytest.mark.parametrize("size", [1e-12, 1e-9, 1e-3, 1e3, 1e9, 1e12])
def test_the_rank_has_no_unit(coordinates, size):
    """The textbook example in other sizes has the same ranks."""
    high = 0.75**0.5
    places = {"A": (0, 0), "E": (1, 0), "D": (2, 0), "B": (0.5, high), "F": (1.5, high), "C": (2.5, high)}
    mechanism = gimcli.load(
        {
            "units": {"length": "mm", "angle": "deg"},
            "nodes": {name: [size * x, size * y] for name, (x, y) in places.items()},
            "ground": ["A", "E", "D"],
            "links": {"left": ["A", "B"], "middle": ["E", "F"], "right": ["D", "C"]},
            "elements": {"bar": ["B", "F", "C"]},
            "actuators": {"motor": {"pivot": "A", "arm": "B"}},
        }
    )
    found = jacobian_matrix(mechanism, coordinates)
    assert (found.rank, *found.values.shape) == RANKS[coordinates]
    assert found.rank_by_singular_values == found.rank
    assert len(found.dependent) == 1


def test_joint_coordinates_of_a_four_bar():
    """Loop closure at C along crank and coupler, minus the rocker: i times the vector from each joint to C."""
    z, mechanism = four_bar()
    found = jacobian_matrix(mechanism, "joint")
    column = {name: found.values[:, k] for k, (name, _) in enumerate(found.columns)}
    (x, y) = (found.rows.index(next(r for r in found.rows if r.endswith(part))) for part in (" x", " y"))
    vectors = {
        "crank at A.angle": z["C"] - z["A"],
        "coupler at B.angle": z["C"] - z["B"],
        "rocker at D.angle": z["D"] - z["C"],
    }
    signs = set()
    for name, vector in vectors.items():
        got = complex(column[name][x], column[name][y])
        ratio = got / (1j * vector)
        assert abs(ratio.imag) < 1e-12
        signs.add(round(ratio.real, 9))
    assert signs in ({1.0}, {-1.0})


@pytest.mark.few
def test_the_three_coordinates_have_the_same_apparent_mobility(model):
    mechanism = gimcli.load(model)
    apparent = gimcli.mobility(mechanism).report()["apparent"]
    for coordinates in COORDINATES:
        if mechanism.couplings and coordinates != "natural":
            with pytest.raises(gimcli.GimError):
                jacobian_matrix(mechanism, coordinates)
            continue
        found = jacobian_matrix(mechanism, coordinates)
        assert len(found.columns) - found.rank == apparent, coordinates
        assert found.rank_by_singular_values == found.rank
        assert len(set(found.rows)) == len(found.rows)
        assert len(set(found.columns)) == len(found.columns)
        assert len(found.dependent) == len(found.rows) - found.rank


@pytest.mark.few
def test_every_alternative_can_take_the_place_of_a_dependent_equation(model):
    """Without it, and with the dependent equation instead, the rank is the same; without any other one it is less."""
    found = jacobian_matrix(gimcli.load(model), "natural")
    table, rows = found.scaled, list(found.rows)
    independent = [k for k, name in enumerate(rows) if name not in found.dependent]
    for name, others in found.dependent.items():
        assert others
        for k in independent:
            kept = [rows.index(name), *(j for j in independent if j != k)]
            same = full_pivoting(table[kept], 1e-10)[0] == found.rank
            assert same == (rows[k] in others), (name, rows[k])


def test_rows_that_are_all_zero_or_none():
    empty = JacobianMatrix("natural", (), (), np.zeros((0, 0)))
    assert (empty.rank, empty.rank_by_singular_values, empty.dependent) == (0, 0, {})
    zero = JacobianMatrix("natural", ("a", "b"), (("x", "m"),), np.array([[0.0], [2.0]]))
    assert (zero.rank, zero.rank_by_singular_values, zero.dependent) == (1, 1, {"a": []})


@pytest.mark.parametrize("coordinates", COORDINATES)
def test_command_line(coordinates, tmp_path):
    done = gim(
        "mobility",
        "parallelogram_third_crank",
        "--jacobian",
        "--coordinates",
        coordinates,
        "--json",
        "-o",
        tmp_path / "j.csv",
    )
    report = done.json["jacobian"]
    rank, equations, unknowns = RANKS[coordinates]
    assert (report["rank"], report["rank_by_singular_values"]) == (rank, rank)
    assert (len(report["rows"]), len(report["columns"]), len(report["units"])) == (equations, unknowns, unknowns)
    with (tmp_path / "j.csv").open(encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    assert head[0] == "equation"
    assert [row[0] for row in rows] == report["rows"]
    assert [[float(x) for x in row[1:]] for row in rows] == report["values"]
    text = gim("mobility", "parallelogram_third_crank", "--jacobian", "--coordinates", coordinates).text
    assert f"{coordinates} coordinates" in text
    assert f"rank of {equations} equations in {unknowns} coordinates: {rank} by elimination" in text
    assert "one of several choices" in text


def test_without_the_option_nothing_is_computed(monkeypatch):
    monkeypatch.setattr("gimcli.library.mobility.jacobian_matrix", lambda *_: 1 / 0)
    done = gim("mobility", "parallelogram_third_crank", "--json")
    assert "jacobian" not in done.json
    (redundant,) = done.json["alternatives"]
    assert redundant == {"constraint": "bar B-F-C", "instead": ["left", "middle", "right", "bar B-F", "bar F-C"]}
    wrong = gim("mobility", "crank_rocker", "--coordinates", "polar")
    assert wrong.code == 2
    assert json.dumps(done.json)


def test_what_cannot_be_written_is_refused_before_anything_is_printed():
    refused = gim("mobility", "cardan_gear", "--coordinates", "joint")
    assert refused.code == 2
    assert refused.text == ""
