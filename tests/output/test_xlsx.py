"""Spreadsheets, read back with openpyxl."""

import math
from dataclasses import replace
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import openpyxl
import pytest
import yaml
from bundled import MODELS
from in_process import gim

import gimcli
from gimcli import OutputError
from gimcli.output import FORMATS, xlsx as module
from gimcli.output.xlsx import Workbook, kind_of, write_xlsx
from gimcli.table import Column, Table


def read(path):
    return openpyxl.load_workbook(path)


def columns(sheet):
    head, *rows = sheet.iter_rows(values_only=True)
    return {name: [row[k] for row in rows] for k, name in enumerate(head)}


@pytest.fixture
def traced():
    data = yaml.safe_load((MODELS / "crank_rocker.yaml").read_text(encoding="utf-8"))
    return gimcli.trace(gimcli.load(data | {"trace": ["P"]}), steps=24, derivatives=2, measure="transmission")


def test_one_sheet_for_each_kind_of_column(traced, tmp_path):
    traced.save(tmp_path / "t.xlsx")
    book = read(tmp_path / "t.xlsx")
    assert book.sheetnames == [
        "Report", "Positions", "Velocities", "Accelerations", "Angles", "Angular velocities", "Angular accelerations",
        "Measures", "Solution",
    ]  # fmt: skip
    lead = ["step", "time [s]", "motor [deg]", "status"]
    assert list(columns(book["Positions"])) == [*lead, "P.x [mm]", "P.y [mm]"]
    assert list(columns(book["Accelerations"])) == [*lead, "P.ax [mm/s^2]", "P.ay [mm/s^2]"]
    assert list(columns(book["Angles"]))[4:] == ["crank.angle [deg]", "coupler.angle [deg]", "rocker.angle [deg]"]
    written = [name for sheet in book.worksheets[1:] for name in list(columns(sheet))[4:]]
    assert len(written) + 4 == len(traced.table().names)
    assert {sheet.freeze_panes for sheet in book.worksheets[1:]} == {"A2"}
    crank = columns(book["Angles"])["crank.angle [deg]"]
    assert crank == pytest.approx([15.0 * k for k in range(25)], abs=1e-9)
    assert columns(book["Angular velocities"])["crank.omega [deg/s]"] == pytest.approx([360.0] * 25, abs=1e-6)


def test_all_digits_are_read_back(tmp_path):
    values = np.array([0.1, 1 / 3, -2.5e-300, 1e22, 0.1 + 0.2, 5e-324, 100.0])
    table = Table((Column("P.x", values, "mm"),))
    write_xlsx(Workbook("numbers", {"x": [0.1 + 0.2, None]}, table), tmp_path / "n.xlsx")
    book = read(tmp_path / "n.xlsx")
    assert columns(book["Positions"])["P.x [mm]"] == values.tolist()
    assert book["Report"]["B2"].value == 0.1 + 0.2
    assert all(cell.data_type == "n" for (cell,) in book["Positions"].iter_rows(min_row=2))


def test_cells_without_a_number_and_texts(tmp_path):
    table = Table((
        Column("P.x", np.array([math.nan, math.inf, 1.0])), Column("name", np.array(["=1+1", "a\x07<b&", "ä €"])),
        Column("branch", np.array([1, 2, 3])),
    ))  # fmt: skip
    write_xlsx(Workbook("=cmd", {}, table), tmp_path / "n.xlsx")
    sheet = read(tmp_path / "n.xlsx")["Positions"]
    assert columns(sheet) == {"name": ["=1+1", "a<b&", "ä €"], "branch": [1, 2, 3], "P.x": [None, "inf", 1.0]}
    assert sheet["A2"].data_type == "s"


def test_the_first_sheet_is_the_report(traced, tmp_path):
    traced.save(tmp_path / "t.xlsx")
    sheet = read(tmp_path / "t.xlsx")["Report"]
    rows = {row[0]: [value for value in row[1:] if value is not None] for row in sheet.iter_rows(values_only=True)}
    assert next(iter(rows)).startswith("Crank-rocker with a coupler point: 25 of 25 positions solved")
    assert rows["status"] == ["ok"]
    assert rows["steps"] == [24]
    assert rows["points.P.curve"] == ["closed"]
    assert len(rows["points.P.x"]) == 2


def test_long_lists_of_the_report_are_cut(tmp_path):
    write_xlsx(Workbook("", {"a": list(range(20_000))}, Table((Column("x", np.zeros(1)),))), tmp_path / "n.xlsx")
    row = [cell.value for cell in read(tmp_path / "n.xlsx")["Report"][2]]
    assert row == ["a", *range(1000), "..."]


def test_the_same_result_gives_the_same_bytes(traced, tmp_path):
    traced.save(tmp_path / "a.xlsx", tmp_path / "b.xlsx")
    assert (tmp_path / "a.xlsx").read_bytes() == (tmp_path / "b.xlsx").read_bytes()


def test_every_part_is_xml_and_is_declared(traced, tmp_path):
    """The views of sheets refer to the first view of the workbook; each part has its type, each relation its part."""
    traced.save(tmp_path / "t.xlsx")
    with ZipFile(tmp_path / "t.xlsx") as archive:
        parts = {name: ElementTree.fromstring(archive.read(name)) for name in archive.namelist()}
    types = {f"/{name}" for name in parts if not name.endswith(".rels") and name != "[Content_Types].xml"}
    assert types == {own.get("PartName") for own in parts["[Content_Types].xml"] if own.get("PartName")}
    targets = {own.get("Target") for own in parts["xl/_rels/workbook.xml.rels"]}
    assert {f"xl/{target}" for target in targets} == {name[1:] for name in types} - {"xl/workbook.xml"}
    main = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
    order = [own.tag.removeprefix(main) for own in parts["xl/workbook.xml"]]
    assert order == ["bookViews", "sheets"]
    sheet = [own.tag.removeprefix(main) for own in parts["xl/worksheets/sheet2.xml"]]
    assert sheet == ["sheetViews", "cols", "sheetData"]


def test_kinds_of_columns():
    assert [kind_of(name) for name in ("A.fx", "motor.effort", "shaking.fx", "power.drive", "energy.kinetic")] == [
        "Reactions", "Efforts", "Shaking", "Power", "Energy",
    ]  # fmt: skip
    assert [kind_of(name) for name in ("power.x", "shaking.vy", "shaking.moment", "A.moment")] == [
        "Positions", "Velocities", "Shaking", "Reactions",
    ]  # fmt: skip
    assert [kind_of(name) for name in ("curvature:P.radius", "P.x/crank.length", "residual", "span")] == [
        "Measures", "Derivatives", "Solution", "Values",
    ]  # fmt: skip


@pytest.mark.parametrize("command", ["mobility", "check", "groups", "sequence", "circuits", "singularities"])
def test_other_commands_write_a_spreadsheet(command, tmp_path):
    done = gim(command, MODELS / "crank_rocker.yaml", "-o", tmp_path / "m.xlsx", "-o", tmp_path / "m.csv")
    assert done.code == 0
    book = read(tmp_path / "m.xlsx")
    rows = (tmp_path / "m.csv").read_text(encoding="utf-8").count("\n")
    assert {sheet.max_row for sheet in book.worksheets[1:]} == {rows}


def test_more_rows_than_a_sheet_has_are_refused_before_the_motion(monkeypatch, tmp_path):
    monkeypatch.setitem(FORMATS, ".xlsx", replace(FORMATS[".xlsx"], most_rows=1000))
    done = gim("trace", MODELS / "crank_rocker.yaml", "--steps", 9_000_000, "-o", tmp_path / "m.xlsx")
    assert done.code == 2
    assert "9000001 rows, the format has at most 1000" in done.error
    assert list(tmp_path.iterdir()) == []


def test_more_rows_or_columns_than_a_sheet_has_are_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(module, "ROWS", 2)
    table = Table((Column("P.x", np.arange(3.0)),))
    with pytest.raises(OutputError, match="3 rows and 1 columns"):
        write_xlsx(Workbook("", {}, table), tmp_path / "n.xlsx")
    wide = Table(tuple(Column(f"{k}", np.zeros(1)) for k in range(16_385)))
    with pytest.raises(OutputError, match="16385 columns"):
        write_xlsx(Workbook("", {}, wide), tmp_path / "n.xlsx")
    assert list(tmp_path.iterdir()) == []
