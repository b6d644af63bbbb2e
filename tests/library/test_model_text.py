"""`gim solve -o new.yaml`: the model file with the solved coordinates, the rest of its text as it was."""

import math
import re
import shutil

import numpy as np
import pytest
from bundled import EXPLICIT, MODELS
from in_process import gim, ran, refused

import gimcli
from gimcli import UsageError
from gimcli.model.source import read_source

NUMBER = re.compile(r"[-+]?\d+(\.\d*)?([eE][-+]?\d+)?")
OPEN = re.compile(r"^(  \w+:)(?: \{side: \w+\})?(?=\s+#)", re.MULTILINE)  # a node without coordinates, and a comment

FOUR_BAR = """\
nodes: {O: [0, 0], C: [4, 0], A: [0.7, 0.7], B: [3.5, 2.1]}  # rough
ground: [O, C]
links: {crank: {nodes: [O, A], length: 1}, rod: {nodes: [A, B], length: 3}, arm: {nodes: [C, B], length: 2.5}}
actuators: {motor: {type: rotary, pivot: O, arm: A, law: {from: 30, to: 390}}}
"""


def written(folder, text=FOUR_BAR, name="model.yaml"):
    path = folder / name
    path.write_bytes(text.encode())
    return path


def lengths(path):
    """Return the distances of all pairs of nodes of each member, by the definition of the file."""
    data = read_source(path).data
    at = {name: complex(*z) for name, z in data["nodes"].items() if isinstance(z, list)}
    found = {}
    for section in ("links", "elements"):
        for name, part in data.get(section, {}).items():
            part = {"nodes": part} if isinstance(part, list) else part
            own = {n: complex(*z) for n, z in part.get("shape", {}).items()} or at
            for k, a in enumerate(part["nodes"]):
                for b in part["nodes"][:k]:
                    found[name, a, b] = part["length"] if "length" in part else abs(own[a] - own[b])
    return found


@pytest.mark.few
@pytest.mark.parametrize("path", EXPLICIT, ids=lambda path: path.stem)
def test_the_new_file_has_the_same_dimensions_and_is_solved_at_once(path, tmp_path):
    """At 7 % of the laws; the file drawn there has all lengths, and the iteration starts at the solution."""
    m = gimcli.load(path)
    at = {a.name: float(m.value_to_file(k, a.law(np.array([0.07])))[0]) for k, a in enumerate(m.actuators)}
    at = {m.actuators[k].name: at[m.actuators[k].name] for k in m.drivers}
    p, new = gimcli.solve(m, at), tmp_path / path.name
    p.save(new)
    size = m.size * m.scale
    before, after = lengths(path), lengths(new)
    assert before.keys() == after.keys()
    assert max(abs(before[k] - after[k]) for k in before) <= 1e-12 * size
    n = gimcli.load(new)
    q = gimcli.solve(n, at)
    assert q.status == "ok"
    assert q.report()["sweeps"] <= 2 * (p.report()["sweeps"] > 0)  # Newton-Raphson always makes one step
    drawn = n.to_file(n.drawn)
    for name in m.nodes:
        np.testing.assert_allclose(q.xy[name], p.xy[name], atol=1e-11 * size)
        np.testing.assert_allclose(complex(*p.xy[name]), drawn[n.nodes.index(name)], atol=1e-11 * size)
    for point in m.points:
        np.testing.assert_allclose(q.xy[point.name], p.xy[point.name], atol=1e-11 * size)
    old = OPEN.sub(r"\1 [0, 0]", path.read_text())
    assert NUMBER.sub("#", new.read_text()) == NUMBER.sub("#", old)
    kept = [line for line in old.splitlines() if "[" not in line]
    assert kept == [line for line in new.read_text().splitlines() if "[" not in line]


def test_only_coordinates_that_change_are_written(tmp_path):
    """By hand: A is at 30 deg on a circle of radius 1; the frame and the rest of the text are unchanged."""
    path, new = written(tmp_path), tmp_path / "new.yaml"
    gim("solve", path, "-o", new)
    lines, old = new.read_text().splitlines(), FOUR_BAR.splitlines()
    assert lines[1:] == old[1:]
    head = re.fullmatch(
        r"nodes: {O: \[0, 0\], C: \[4, 0\], A: \[0\.86602540378, 0\.5\], B: \[(.*), (.*)\]}  # rough", lines[0]
    )
    b = complex(*map(float, head.groups()))
    assert abs(b - 4) == pytest.approx(2.5, abs=1e-10)
    assert abs(b - complex(math.sqrt(0.75), 0.5)) == pytest.approx(3, abs=1e-10)


def test_a_solved_drawing_stays_as_it_is(tmp_path):
    """A second pass changes nothing, also with Windows line ends and a byte order mark."""
    text = FOUR_BAR + "points: {P: {on: rod, at: [2.1, 3.3]}, Q: {on: arm, at: [3, 1]}}\n"
    path, new, again = (
        written(tmp_path, "\ufeff" + text.replace("\n", "\r\n")),
        tmp_path / "1.yaml",
        tmp_path / "2.yaml",
    )
    gim("solve", path, "-o", new)
    gim("solve", new, "-o", again)
    assert new.read_bytes().startswith(b"\xef\xbb\xbfnodes")
    assert new.read_bytes().count(b"\r\n") == 5
    assert again.read_bytes() == new.read_bytes()


def test_the_assembly_is_written(tmp_path):
    path, new = written(tmp_path), tmp_path / "new.yaml"
    for k in (1, 2):
        gim("solve", path, "--assembly", k, "--at", "motor=80", "-o", new)
        listed = gim("solve", new, "--all", "--at", "motor=80", "--json").json["configurations"]
        assert [one["drawn"] for one in listed] == [k == 1, k == 2]


def test_points_and_loads_move_with_their_members(tmp_path):
    more = "points: {P: {on: rod, at: [2, 3]}, Q: {on: ground, at: [1, 1]}, R: {on: rod, local: [1, 0]}}\n"
    more += "loads: {push: {on: arm, at: [3.9, 1], force: [1, 0]}}\nmasses: {rod: {mass: 1}}\n"
    path, new = written(tmp_path, FOUR_BAR + more), tmp_path / "new.yaml"
    p = gimcli.solve(gimcli.load(path), motor=100)
    p.save(new)
    data = read_source(new).data
    np.testing.assert_allclose(data["points"]["P"]["at"], p.xy["P"], atol=1e-11)
    assert data["points"]["Q"] == {"on": "ground", "at": [1, 1]}
    assert data["points"]["R"] == {"on": "rod", "local": [1, 0]}
    before, after = (gimcli.load(f).dynamics.loads[0] for f in (path, new))
    scales = [gimcli.load(f).scale for f in (path, new)]
    assert before.point * scales[0] == pytest.approx(after.point * scales[1], abs=1e-11)
    assert data["loads"]["push"]["at"] != [3.9, 1]


def test_a_law_without_from_begins_at_the_new_drawing(tmp_path):
    path, new = written(tmp_path, FOUR_BAR.replace("{from: 30, to: 390}", "{by: 90}")), tmp_path / "new.yaml"
    done = ran("solve", path, "--at", "motor=60", "-o", new)
    remark = "the law of motor begins at the initial position: now 60 to 150 deg, before 45 to 135"
    assert remark in " ".join(done.error.split())
    assert gim("trace", new, "--steps", "1", "--json", "-o", tmp_path / "1.csv").json["reachable"]["motor"] == [
        [pytest.approx(60, abs=1e-8), pytest.approx(150, abs=1e-8)]
    ]
    assert "the law" not in ran("solve", path, "-o", new).error


@pytest.mark.parametrize("free", ["", ", free: 2.0"])
def test_a_spring_whose_free_length_is_drawn_is_refused(free, tmp_path):
    text = FOUR_BAR + f"springs: {{coil: {{nodes: [O, B], stiffness: 5{free}}}}}\n"
    path, new = written(tmp_path, text), tmp_path / "new.yaml"
    done = ran("solve", path, "--at", "motor=100", "-o", new)
    if free:
        assert done.code == 0
        return
    assert done.code == 2
    assert not new.exists()


def test_a_torsion_spring_keeps_its_turn(tmp_path):
    """From 170 deg to 190 deg: a file drawn there would measure -170 deg."""
    text = FOUR_BAR.replace("[0.7, 0.7]", "[-0.985, 0.174]").replace("{from: 30, to: 390}", "{from: 170, to: 200}")
    text += "springs: {spiral: {pivot: O, arm: A, stiffness: 5, free: 0}}\n"
    path, new = written(tmp_path, text), tmp_path / "new.yaml"
    assert "spiral" in refused("solve", path, "--at", "motor=190", "-o", new)
    assert ran("solve", path, "--at", "motor=175", "-o", new).code == 0


def test_a_position_that_changes_lengths_is_refused(tmp_path):
    """Bars without `length` take it from the coordinates: a position solved to 1e-3 would change them."""
    new = tmp_path / "new.yaml"
    options = ("--at", "FD=120", "--at", "OA=119", "--method", "gim", "--tolerance", "1e-3", "-o", new)
    assert "would change member" in refused("solve", MODELS / "gim_fig11.yaml", *options)
    assert not new.exists()


def test_tables_must_be_found_from_the_new_file(tmp_path):
    (tmp_path / "law.csv").write_text("time,value\n0,30\n1,60\n2,90\n")
    path = written(tmp_path, FOUR_BAR.replace("{from: 30, to: 390}", "{table: law.csv}"))
    assert "law.csv" in refused("solve", path, "-o", tmp_path / "sub" / "new.yaml")
    assert ran("solve", path, "-o", tmp_path / "new.yaml").code == 0
    assert gim("trace", tmp_path / "new.yaml", "--steps", "2", "--json", "-o", tmp_path / "1.csv").code == 0


def test_the_model_file_itself_is_not_overwritten(tmp_path):
    path = written(tmp_path)
    assert str(path) in refused("solve", path, "-o", path)
    assert path.read_text() == FOUR_BAR
    copy = tmp_path / "copy.yml"
    shutil.copy(path, copy)
    assert ran("solve", path, "-o", copy).code == 0
    assert copy.read_text() != FOUR_BAR


def test_a_position_that_is_not_solved_writes_no_file(tmp_path):
    text = FOUR_BAR.replace("length: 3}", "length: 30}")
    path, new = written(tmp_path, text), tmp_path / "new.yaml"
    assert ran("solve", path, "-o", new).code == 5
    assert not new.exists()
    with pytest.raises(UsageError):
        gimcli.solve(gimcli.load(path)).save(new)
