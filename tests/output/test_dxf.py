"""DXF files, read back with ezdxf; coordinates are compared with closed forms of the four-bar."""

import cmath
import math
import os
import subprocess
import sys

import ezdxf
import numpy as np
import pytest
from bundled import MODELS
from in_process import gim

import gimcli
from gimcli.output.dxf import layer_names, write_dxf
from gimcli.output.geometry import Geometry, Shape

CRANK, COUPLER, ROCKER, GROUND = 40.0, 120.0, 80.0, 100.0
POINT = 60 + 40j

FOUR_BAR = """
units: {length: mm, angle: deg}
nodes: {O2: [0, 0], O4: [100, 0], A: [30.64, 25.71], B: [143.19, 67.34]}
ground: [O2, O4]
links:
  crank: {nodes: [O2, A], length: 40}
  coupler: {nodes: [A, B], length: 120}
  rocker: {nodes: [O4, B], length: 80}
actuators:
  motor: {type: rotary, pivot: O2, arm: A, law: {from: 0, to: 360}}
points:
  P: {on: coupler, local: [60, 40]}
trace: [P]
"""


def closed_form(degrees):
    """Return A, B and P of the open four-bar from the law of cosines."""
    a = CRANK * cmath.exp(1j * math.radians(degrees))
    diagonal = GROUND - a
    d = abs(diagonal)
    at_a = math.acos((COUPLER**2 + d**2 - ROCKER**2) / (2 * COUPLER * d))
    along = cmath.exp(1j * (cmath.phase(diagonal) + at_a))
    return a, a + COUPLER * along, a + POINT * along


@pytest.fixture(scope="module")
def four_bar():
    return gimcli.loads(FOUR_BAR)


def read(path):
    drawing = ezdxf.readfile(path)
    assert not drawing.audit().errors
    return drawing


def on(drawing, layer):
    return list(drawing.modelspace().query(f'*[layer=="{layer}"]'))


def complexes(entity):
    if entity.dxftype() == "LINE":
        return [complex(end.x, end.y) for end in (entity.dxf.start, entity.dxf.end)]
    return [complex(x, y) for x, y in entity.get_points("xy")]


def test_a_position_in_true_size(four_bar, tmp_path):
    gimcli.solve(four_bar, motor=70).save(tmp_path / "p.dxf")
    drawing, (a, b, p) = read(tmp_path / "p.dxf"), closed_form(70)
    assert (drawing.header["$INSUNITS"], drawing.header["$MEASUREMENT"]) == (4, 1)
    for name, ends in {"crank": (0, a), "rocker": (GROUND, b)}.items():
        (line,) = on(drawing, f"member {name}")
        assert complexes(line) == pytest.approx(list(ends), abs=1e-10)
    (plate,) = on(drawing, "member coupler")
    assert plate.closed
    assert len(complexes(plate)) == 3
    for corner in (a, b, p):
        assert min(abs(corner - z) for z in complexes(plate)) < 1e-10
    pins = on(drawing, "pins")
    assert {e.dxftype() for e in pins} == {"CIRCLE"}
    centres = [complex(e.dxf.center.x, e.dxf.center.y) for e in pins]
    assert len(centres) == 4
    assert all(min(abs(z - centre) for centre in centres) < 1e-10 for z in (0, GROUND, a, b))
    (point,) = on(drawing, "points")
    assert abs(complex(point.dxf.location.x, point.dxf.location.y) - p) < 1e-10
    assert sorted(text.dxf.text for text in on(drawing, "names")) == ["A", "B", "O2", "O4", "P"]
    assert len(on(drawing, "frame")) == 2


def test_a_coupler_curve_has_every_row(four_bar, tmp_path):
    """5000 rows are more than a picture keeps."""
    gimcli.trace(four_bar, steps=5000).save(tmp_path / "t.dxf")
    (curve,) = on(read(tmp_path / "t.dxf"), "curve P")
    assert curve.closed
    found = np.array(complexes(curve))
    expected = np.array([closed_form(360 * k / 5000)[2] for k in range(5000)])
    assert np.max(np.abs(found - expected)) < 1e-9


def test_a_streamed_trace_writes_the_same_curve(four_bar, tmp_path):
    (tmp_path / "m.yaml").write_text(FOUR_BAR, encoding="utf-8")
    assert gim("trace", tmp_path / "m.yaml", "--steps", 4500, "-o", tmp_path / "a.dxf").code == 0
    (curve,) = on(read(tmp_path / "a.dxf"), "curve P")
    assert len(complexes(curve)) == 4500


def test_a_curve_ends_where_the_crank_reaches_its_limit(tmp_path):
    """A crank of 150 stops where its tip is 120 + 80 from the rocker's pivot, at arccos(-1/4) = 104.5 degrees."""
    model = FOUR_BAR.replace("length: 40", "length: 150").replace("from: 0, to: 360", "from: 40, to: 300")
    gimcli.trace(gimcli.loads(model), steps=260).save(tmp_path / "t.dxf")
    (curve,) = on(read(tmp_path / "t.dxf"), "curve P")
    assert not curve.closed
    assert len(complexes(curve)) == 1 + math.floor(math.degrees(math.acos(-0.25)) - 40)


def test_pieces_between_gaps():
    geometry, nan = Geometry("mm"), complex(math.nan, math.nan)
    geometry.add_curve("curve", np.array([0, 1, nan, nan, 2, 3 + 1j, 4, nan, 5]))
    first, second, third = geometry.layers["curve"]
    assert first.points.tolist() == [0, 1]
    assert second.points.tolist() == [2, 3 + 1j, 4]
    assert third.points.tolist() == [5]


def test_the_workspace_of_two_links_is_an_annulus(tmp_path):
    """Two links of 3 and 1 in series: the boundary has the radius 4, the hole 2 (closed form)."""
    mechanism = gimcli.loads("""
units: {length: in}
nodes: {O: [0, 0], A: [3, 0], B: [3, 1]}
ground: [O]
links: {upper: [O, A], lower: [A, B]}
actuators:
  shoulder: {type: rotary, pivot: O, arm: A, law: {from: 0, to: 360}}
  elbow: {type: rotary, pivot: A, arm: B, reference: O, law: {from: 0, to: 360}}
trace: [B]
""")
    gimcli.workspace(mechanism, "B").save(tmp_path / "w.dxf")
    drawing = read(tmp_path / "w.dxf")
    assert (drawing.header["$INSUNITS"], drawing.header["$MEASUREMENT"]) == (1, 0)
    for layer, radius in (("boundary", 4.0), ("hole", 2.0)):
        (loop,) = on(drawing, layer)
        assert loop.closed
        assert np.abs(complexes(loop)) == pytest.approx(radius, abs=1e-6)


def test_circuits_have_a_layer_for_each_curve(four_bar, tmp_path):
    """The mirrored circuit of the four-bar: the coupler point keeps its side of the coupler."""
    gimcli.circuits(four_bar).save(tmp_path / "c.dxf")
    drawing = read(tmp_path / "c.dxf")
    for circuit in (1, 2):
        (curve,) = on(drawing, f"curve P circuit {circuit}")
        for p in complexes(curve)[::60]:
            distance = {abs(abs(p - CRANK * cmath.exp(1j * t)) - abs(POINT)) < 1.0 for t in np.linspace(0, 6.3, 300)}
            assert True in distance


@pytest.mark.parametrize("model", ["crank_shaper", "excavator", "platform_3rrr", "floating_hexagon", "scotch_yoke"])
def test_models_with_other_pairs_are_written(model, tmp_path):
    done = gim("solve", MODELS / f"{model}.yaml", "-o", tmp_path / "m.dxf", "-o", tmp_path / "again.dxf")
    assert done.code == 0
    drawing = read(tmp_path / "m.dxf")
    mechanism = gimcli.load(MODELS / f"{model}.yaml")
    names = {layer.dxf.name for layer in drawing.layers}
    assert {f"member {m.name}" for m in mechanism.members[1:]} <= names
    blocks = {slide.pair for slide in mechanism.slides}
    assert len(on(drawing, "blocks")) == len(blocks)
    assert (tmp_path / "m.dxf").read_bytes() == (tmp_path / "again.dxf").read_bytes()


def test_names_of_layers_are_valid_and_distinct(tmp_path):
    names = ["member A", "member a", "member x/y", "member x:y", "member " + 300 * "n", 'curve <"|*?>']
    assert layer_names(names[:4]) == ["member A", "member a (2)", "member x_y", "member x_y (2)"]
    line = Shape(np.array([0, 1 + 1j]))
    write_dxf(Geometry("mm", {name: [line] for name in names}), tmp_path / "n.dxf")
    assert len(read(tmp_path / "n.dxf").modelspace()) == len(names)
    assert len(read(tmp_path / "n.dxf").layers) == len(names) + 2


def test_without_ezdxf_the_message_names_the_extra(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    done = gim("solve", MODELS / "crank_rocker.yaml", "-o", tmp_path / "m.dxf")
    assert done.code == 6
    assert "pip install 'gimcli[dxf]'" in done.error
    assert list(tmp_path.iterdir()) == []


def test_an_unsolved_position_has_no_drawing(tmp_path):
    model = tmp_path / "m.yaml"
    model.write_text(FOUR_BAR.replace("length: 40", "length: 150"), encoding="utf-8")
    done = gim("solve", model, "--at", "motor=180", "-o", tmp_path / "m.dxf")
    assert done.code == 5
    assert not (tmp_path / "m.dxf").exists()


def test_bytes_do_not_depend_on_the_order_of_sets(tmp_path):
    """ezdxf lists the kinds of entities in the order of a set, which the seed of hashes changes."""
    code = "import gimcli, sys; gimcli.solve('crank_rocker').save(sys.argv[1])"
    for seed in ("0", "4"):
        environment = {**os.environ, "PYTHONHASHSEED": seed}
        subprocess.run([sys.executable, "-c", code, str(tmp_path / f"{seed}.dxf")], env=environment, check=True)
    assert (tmp_path / "0.dxf").read_bytes() == (tmp_path / "4.dxf").read_bytes()
