"""`gim solve --all`: JSON report, printed table, CSV and picture."""

import json
import struct

import numpy as np
import pytest
from bundled import MODELS
from in_process import printed as gim, read_rows


def listed(name, *options):
    return json.loads(gim("solve", MODELS / f"{name}.yaml", "--all", "--json", *options))


def test_json_has_its_fields():
    report = listed("double_butterfly", "--at", "motor=112.62")
    assert report["complete"] is True
    assert report["bound"] == 18
    assert len(report["configurations"]) == 6
    for one in report["configurations"]:
        assert one["residual"] < 1e-12
        assert set(one["nodes"]) == set("QRPSTUVWXY")
        assert np.hypot(*np.subtract(one["nodes"]["Q"], one["nodes"]["U"])) == pytest.approx(11, rel=1e-13)
    assert sum(one["drawn"] for one in report["configurations"]) == 1
    assert (report["level"], report["unaccounted"]) == (1, 0)
    assert report["groups"][0]["complex"] == 18


def test_numbers_are_in_the_files_units():
    """The excavator is in cm: a linear actuator of 185 cm; 2^4 configurations."""
    report = listed("excavator")
    assert len(report["configurations"]) == 16
    boom = {round(float(np.hypot(*np.subtract(c["nodes"]["D"], c["nodes"]["E"]))), 9) for c in report["configurations"]}
    assert boom == {185.0}
    assert all("tip" in c["points"] for c in report["configurations"])


def test_same_order_every_time():
    assert listed("ten_bar") == listed("ten_bar")


def test_the_drawn_configuration_is_the_one_that_solve_finds():
    alone = json.loads(gim("solve", MODELS / "jansen.yaml", "--at", "motor=80", "--json"))
    drawn = [c for c in listed("jansen", "--at", "motor=80")["configurations"] if c["drawn"]]
    assert len(drawn) == 1
    for node, place in alone["nodes"].items():
        np.testing.assert_allclose(drawn[0]["nodes"][node], place, atol=1e-9)


def test_a_list_that_is_not_proved_complete_is_reported():
    report = listed("peaucellier")
    assert report["complete"] is False
    assert report["level"] == 4


def test_the_table_has_the_number_and_whether_it_is_complete():
    text = gim("solve", MODELS / "jansen.yaml", "--all")
    for signs in ("+++", "++-", "+-+", "+--", "-++", "-+-", "--+", "---"):
        assert f" {signs} " in text
    assert text.count(" * ") == 1


def test_an_empty_list_is_a_result_with_exit_status_5(tmp_path):
    model = tmp_path / "model.yaml"
    model.write_text(
        "nodes: {O: [0, 0], C: [10, 0], A: [1, 0], B: [9, 1]}\nground: [O, C]\n"
        "links: {a: [O, A], b: {nodes: [A, B], length: 2}, c: [C, B]}\n"
        "actuators: {motor: {type: rotary, pivot: O, arm: A}}\n"
    )
    report = json.loads(gim("solve", model, "--all", "--json", "--csv", tmp_path / "all.csv", code=5))
    assert "proved" in report["verdict"]
    assert (tmp_path / "all.csv").read_text().splitlines() == ["configuration,node,x,y,residual"]
    assert report["complete"] is True
    assert report["configurations"] == []


def test_csv_has_a_row_for_every_node_of_every_configuration(tmp_path):
    path = tmp_path / "all.csv"
    gim("solve", MODELS / "platform_3rpr.yaml", "--all", "--csv", path)
    rows = read_rows(path)
    assert list(rows[0]) == ["configuration", "node", "x", "y", "residual"]
    assert len(rows) == 6 * 7  # six nodes and a point
    plate = [complex(float(r["x"]), float(r["y"])) for r in rows if r["node"] in ("B1", "B2")]
    np.testing.assert_allclose(np.abs(np.diff(plate)[::2]), 17.04, rtol=1e-13)


@pytest.mark.parametrize(("name", "shape"), [("double_butterfly", (3, 2)), ("slider_crank", (2, 1))])
def test_the_picture_has_a_panel_for_each_configuration(name, shape, tmp_path):
    path = tmp_path / "all.png"
    gim("solve", MODELS / f"{name}.yaml", "--all", "--png", path)
    width, height = struct.unpack(">II", path.read_bytes()[16:24])
    assert path.read_bytes()[:4] == b"\x89PNG"
    assert width > 250 * shape[0]
    assert height > 100 * shape[1]


def test_panels_have_one_window_with_equal_axes(tmp_path):
    from gimcli import load
    from gimcli.assemblies import all_configurations
    from gimcli.output.gallery import gallery_picture

    mechanism = load(MODELS / "double_butterfly.yaml")
    found = all_configurations(mechanism, mechanism.start_inputs)
    z = mechanism.to_file(found.z)
    gallery = gallery_picture(mechanism, z, [str(k) for k in range(len(found))], "all")
    frames = {(p.frame.low, p.frame.high) for p in gallery.pictures}
    (low, high), frame = frames.pop(), gallery.pictures[0].frame
    assert not frames
    assert (high - low).real / frame.width == pytest.approx((high - low).imag / frame.height)
    inside = [low.real < z.real.min(), z.real.max() < high.real, low.imag < z.imag.min(), z.imag.max() < high.imag]
    assert all(inside)


@pytest.mark.usefixtures("unrendered")
def test_configurations_that_do_not_fit_the_picture_are_reported(tmp_path):
    """Six dyads between the crank and the ground: two sides each, 64 configurations."""
    model, letters = tmp_path / "dyads.yaml", "PQRSTU"
    nodes = [f"{n}: [{k}, 3], {n}0: [{k + 2}, -1]" for k, n in enumerate(letters)]
    links = [f"{n}1: [A, {n}], {n}2: [{n}, {n}0]" for n in letters]
    model.write_text(
        f"nodes: {{O: [0, 0], A: [0, 1], {', '.join(nodes)}}}\nground: [O, {', '.join(f'{n}0' for n in letters)}]\n"
        f"links: {{crank: [O, A], {', '.join(links)}}}\nactuators: {{motor: {{pivot: O, arm: A}}}}\n"
    )
    text = gim("solve", model, "--all", "--png", tmp_path / "all.png")
    assert "shows the first 36; 28 are not drawn" in text
    assert "64 configurations" in text


def test_the_tolerance_applies_to_redundant_constraints(tmp_path):
    """A third crank that is 1e-7 too long contradicts the others, but the error is below 1e-6."""
    text = (MODELS / "parallelogram_third_crank.yaml").read_text()
    model = tmp_path / "model.yaml"
    model.write_text(text.replace("right: {nodes: [D, C], length: 1}", "right: {nodes: [D, C], length: 1.0000001}"))
    assert model.read_text() != text
    gim("solve", model, "--all", code=5)
    assert len(json.loads(gim("solve", model, "--all", "--json", "--tolerance", 1e-6))["configurations"]) == 1


@pytest.mark.parametrize("option", [("--method", "gim"), ("--start", "random"), ("--method", "newton")])
def test_options_of_one_position_are_refused(option):
    gim("solve", MODELS / "jansen.yaml", "--all", *option, code=2)


def test_a_structure_that_is_not_driven_is_refused(tmp_path):
    model = tmp_path / "model.yaml"
    links = "links: {a: [O, A], b: [A, B], c: [C, B]}\n"
    model.write_text("nodes: {O: [0, 0], C: [4, 0], A: [0, 1], B: [4, 2]}\nground: [O, C]\n" + links)
    gim("solve", model, "--all", code=4)


def test_an_over_driven_mechanism_is_refused(tmp_path):
    model = tmp_path / "model.yaml"
    links = "links: {a: [O, A], b: [A, B], c: [C, B]}\n"
    drives = "actuators: {m: {type: rotary, pivot: O, arm: A}, k: {type: rotary, pivot: C, arm: B}}\n"
    model.write_text("nodes: {O: [0, 0], C: [4, 0], A: [0, 1], B: [4, 2]}\nground: [O, C]\n" + links + drives)
    gim("solve", model, "--all", code=4)


def test_an_unwritable_picture_is_refused_before_the_computation(tmp_path):
    (tmp_path / "file").write_text("")
    gim("solve", MODELS / "jansen.yaml", "--all", "--png", tmp_path / "file" / "all.png", code=6)
