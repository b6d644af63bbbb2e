"""All positions that commands report as ok satisfy all constraints of the file; one function checks them all: the gate.

The gate is `gimcli.structure.residual.holds`.
"""

import importlib
import pkgutil
import sys

import numpy as np
import pytest
from bundled import FEWEST, MODELS
from by_definition import Definition
from in_process import copied, gim, position, read_rows

import gimcli
from gimcli.library import workspace as workspace_report
from gimcli.structure import residual

LONG = {
    "circuits": (
        "dixon_k33", "double_butterfly", "double_butterfly_symmetric", "excavator", "floating_hexagon", "gim_fig11",
        "gim_fig13b", "gim_fig13c", "hart_a_frame", "innocenti_group", "jansen", "pantograph", "plantigrade",
        "scissor_lift", "ten_bar",
    ),
    "workspace": (
        "dixon_k33", "double_butterfly", "double_butterfly_symmetric", "excavator", "five_bar", "floating_hexagon",
        "gim_fig11", "gim_fig13c", "jansen", "pantograph", "peaucellier", "plantigrade",
        "platform_3rpr", "platform_3rrr", "scissor_lift", "stephenson_3_far", "ten_bar",
        "whitworth",
    ),
}  # fmt: skip
"""Models for which a command takes more than a second."""


class Checked:
    """A model, and checks of positions against the definitions of its constraints."""

    def __init__(self, model, folder, change=None):
        self.folder = folder
        self.path, data = copied(model, folder, change)
        self.definition = Definition(data)
        self.nodes, self.inputs = data["trace"], list(self.definition.actuators)
        self.seen = 0

    def run(self, command, *options):
        """Run a command with --json and return its report."""
        done = gim(command, self.path, *options, "--json")
        assert done.code in (0, 5), done.error or done.text
        return done.json

    def position(self, z, inputs, where):
        """Check a position."""
        worst, name = self.definition.worst(z, inputs)
        assert worst <= self.definition.allowed, f"{where}: {name} is off by {worst:.2g}"
        self.seen += 1

    def listed(self, nodes, inputs, where):
        """Check a position from a report."""
        self.position({n: complex(*nodes[n]) for n in self.nodes}, inputs, where)

    def rows(self, name, where, first="time"):
        """Check the rows of a file that are ok."""
        for k, row in enumerate(read_rows(self.folder / name)):
            if row["status"] == "ok":
                self.position(position(row, self.nodes), {n: float(row[n]) for n in self.inputs}, f"{where}, row {k}")


def traced(checked, variants=("", "--all-branches")):
    for options in variants:
        checked.run("trace", "--steps", 7, "--no-png", "-o", checked.folder, *options.split())
        checked.rows(f"{checked.path.stem}.csv", f"trace {options}")


def solved(checked):
    report = checked.run("solve")
    if report["status"] == "ok":
        checked.listed(report["nodes"], report["inputs"], "solve")
    report = checked.run("solve", "--all")
    for k, one in enumerate(report["configurations"]):
        checked.listed(one["nodes"], report["inputs"], f"solve --all, {k}")


def singular(checked):
    for one in checked.run("singularities")["singularities"]:
        checked.listed(one["nodes"], one["at"], f"singularities, {one['kind']}")


def joined(checked):
    report = checked.run("circuits", "--samples", 4)
    for one in report["configurations"]:
        checked.listed(one["nodes"], report["at"], "circuits")


def reached(checked, spy):
    """Check the positions that belong to the points in the file."""
    definition = checked.definition
    point = [n for n in checked.nodes if n not in definition.still][-1]
    checked.run("workspace", "--point", point, "--no-png", "-o", checked.folder)
    written = [complex(float(r["x"]), float(r["y"])) for r in read_rows(next(checked.folder.glob("*.workspace.csv")))]
    found = spy.pop()
    arcs = [arc for run in found.runs for arc in run.pieces] if hasattr(found, "runs") else [e.arc for e in found.edges]
    mechanism = found.task.mechanism
    z = mechanism.to_file(found.task.nodes(np.concatenate([arc.branch.x for arc in arcs])))
    own = z[mechanism.nodes.index(point)]
    assert all(min(abs(own - at)) <= 1e-12 * definition.size for at in written)
    aside = {}  # nodes of chains that do not move the point, as `solve` finds them
    if len(mechanism.nodes) < len(checked.nodes):
        aside = {n: complex(*at) for n, at in checked.run("solve")["nodes"].items()}
    for k in range(0, z.shape[1], 1 + z.shape[1] // 100):
        at = dict(zip(mechanism.nodes, z[:, k].tolist(), strict=True))
        checked.position({**aside, **at}, {}, f"workspace, {k}")


@pytest.fixture
def spy(monkeypatch):
    """Keep the results from which the tables of a workspace are written."""
    kept = []
    for name in ("reach_table", "region_table"):
        own = getattr(workspace_report, name)
        monkeypatch.setattr(workspace_report, name, lambda found, own=own: (kept.append(found), own(found))[1])
    return kept


@pytest.mark.few(*FEWEST)
def test_every_position_of_every_command_satisfies_the_file(model, tmp_path, spy):
    checked = Checked(model, tmp_path)
    for check in (traced, solved, singular):
        check(checked)
    if model.stem not in LONG["circuits"]:
        joined(checked)
    if model.stem not in LONG["workspace"]:
        reached(checked, spy)
    assert checked.seen >= 10


@pytest.mark.parametrize("name", ["gim_fig11", "scotch_yoke", "galloway_kite", "double_butterfly"])
def test_rows_around_limits_satisfy_the_file(name, tmp_path):
    checked = Checked(MODELS / f"{name}.yaml", tmp_path)
    traced(checked, ("--circuit", "--at-limit reverse", "--at-limit skip", "--method newton"))
    assert checked.seen >= 10


@pytest.mark.soak
@pytest.mark.parametrize("name", LONG["circuits"])
def test_positions_of_long_lists_of_circuits_satisfy_the_file(name, tmp_path):
    joined(Checked(MODELS / f"{name}.yaml", tmp_path))


@pytest.mark.soak
@pytest.mark.parametrize("name", LONG["workspace"])
def test_positions_of_long_workspaces_satisfy_the_file(name, tmp_path, spy):
    reached(Checked(MODELS / f"{name}.yaml", tmp_path), spy)


def weighed(data):
    """Give every link and element a mass."""
    moving = [n for kind in ("links", "elements") for n in data.get(kind) or {}]
    frame = data["ground"].get("member") if isinstance(data.get("ground"), dict) else None
    data["masses"] = {name: {"mass": 1.0, "inertia": 0.1} for name in moving if name != frame}
    data["gravity"] = [0.3, -9.81]
    data["units"] = {**(data.get("units") or {}), "length": "m"}


def swinging(data):
    """Add masses, and make the first input free."""
    weighed(data)
    next(iter(data["actuators"].values()))["free"] = True


@pytest.mark.few
def test_rows_with_forces_are_at_positions_that_satisfy_the_file(model, tmp_path):
    """A row of `forces` or `reduce` is ok only if the position at its inputs is ok."""
    checked = Checked(model, tmp_path, weighed)
    traced(checked, ("",))
    path, out = checked.path, ("--steps", 7, "--no-png", "-o", tmp_path)
    good = {key(row, checked.inputs): row for row in read_rows(tmp_path / f"{path.stem}.csv") if row["status"] == "ok"}
    done = gim("forces", path, *out, "--json")
    assert done.code in (0, 5), done.error or done.text
    pressed = [row for row in read_rows(tmp_path / f"{path.stem}.forces.csv") if row["status"] == "ok"]
    assert pressed or not good
    assert {key(row, checked.inputs) for row in pressed} <= good.keys()
    if len(checked.inputs) == 1:
        done = gim("reduce", path, *out, "--json")
        assert done.code in (0, 5), done.error or done.text
        reduced = [row for row in read_rows(tmp_path / f"{path.stem}.reduced.csv") if row["status"] == "ok"]
        assert {(row["q"],) for row in reduced} == {key(row, checked.inputs) for row in pressed}


def key(row, inputs):
    """Return the inputs of a row, as text."""
    return tuple(row[name] for name in inputs)


SWINGING = ("watt_durango", "slider_crank", "parallelogram_third_crank", "scotch_yoke", "double_butterfly", "five_bar")


def simulated(checked):
    checked.run("simulate", "--time", 0.4, "--dt", 0.02, "--no-png", "-o", checked.folder)
    checked.rows(f"{checked.path.stem}.simulation.csv", "simulate")


@pytest.mark.few(3)
@pytest.mark.parametrize("name", SWINGING)
def test_every_position_of_a_simulation_satisfies_the_file(name, tmp_path):
    checked = Checked(MODELS / f"{name}.yaml", tmp_path, swinging)
    simulated(checked)
    assert checked.seen >= 10


@pytest.mark.soak
def test_every_position_of_more_simulations_satisfies_the_file(model, tmp_path):
    if model.stem not in SWINGING:
        simulated(Checked(model, tmp_path, swinging))


# -- the gate -------------------------------------------------------------------------------


@pytest.fixture
def rejecting(monkeypatch):
    """Make the gate reject all positions, in every module that imports it."""
    for module in pkgutil.walk_packages(gimcli.__path__, "gimcli."):
        importlib.import_module(module.name)
    gate = residual.holds

    def never(mechanism, z, inputs, tolerance, swept=False, error=None):
        return np.zeros_like(gate(mechanism, z, inputs, tolerance, swept, error))

    for name, module in list(sys.modules.items()):
        if name.startswith("gimcli") and vars(module).get("holds") is gate:
            monkeypatch.setattr(module, "holds", never)


def solved_in(name, report):
    """Return the number of positions that a report states as solved."""
    if name in ("trace", "forces", "simulate", "reduce"):
        return report["solved"]
    if name == "sensitivity":
        return int(report["status"] == "ok")
    if name == "solve":
        return int(report.get("status") == "ok") + len(report.get("configurations", []))
    if name == "singularities":
        return len(report["singularities"]) + len(report["circuits"])
    if name == "circuits":
        return len(report["curves"]) + len(report["configurations"])
    if name == "workspace":
        return len(report.get("paths", report.get("curves"))) + report.get("grid", {}).get("solved", 0)
    if name == "tradeoff":
        return sum(entry["solved"] for entry in report["entries"]) + sum(bool(a["options"]) for a in report["advice"])
    raise AssertionError(name)


COMMANDS = (
    ("watt_1", "trace"), ("watt_1", "trace", "--circuit"), ("watt_1", "trace", "--all-branches"),
    ("watt_1", "trace", "--at-limit", "reverse"), ("gim_fig11", "trace", "--at-limit", "skip"),
    ("watt_1", "trace", "--method", "gim"), ("watt_1", "trace", "--method", "newton"),
    ("watt_1", "solve"), ("watt_1", "solve", "--method", "gim"), ("watt_1", "solve", "--start", "random"),
    ("watt_1", "solve", "--at", "motor=130"), ("watt_1", "solve", "--all"), ("watt_1", "circuits"),
    ("watt_1", "singularities"), ("watt_1", "workspace", "--point", "B"),
    pytest.param(("five_bar", "workspace"), marks=pytest.mark.soak, id="five_bar workspace"),
    ("five_bar", "workspace", "--grid", "10"), ("watt_1", "tradeoff", "--steps", "4", "--tolerances", "1e-3"),
    ("watt_1", "forces"), ("watt_durango", "simulate", "--time", "0.1"), ("watt_1", "reduce", "--steps", "4"),
    ("watt_1", "sensitivity", "--steps", "4"), ("watt_1", "sensitivity", "--at", "motor=130"),
)  # fmt: skip


@pytest.mark.few(8)
@pytest.mark.parametrize("case", COMMANDS, ids=" ".join)
def test_nothing_is_reported_as_solved_if_the_gate_rejects_it(case, rejecting, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name, command, *options = case
    done = gim(command, MODELS / f"{name}.yaml", *options, "--json")
    assert done.code in (4, 5), done
    if done.text:
        assert solved_in(command, done.json) == 0
    for path in tmp_path.glob("*.csv"):
        assert all(row.get("status", "") != "ok" for row in read_rows(path)), path.name
