"""Registries: a measure, an integrator, a table format and a picture format that are added with one line each.

The commands use what is registered here, outside the package, like the parts of the package.
"""

from bundled import MODELS
from in_process import gim, read_rows

from gimcli.dynamics.integrators import INTEGRATORS, Integrator
from gimcli.output import FORMATS, Format
from gimcli.quantities.kinds import KINDS
from gimcli.quantities.quantity import Head, Kind, Quantity


class Height(Quantity):
    """The height of a node."""

    def __init__(self, mechanism, node):
        self.index, self.mechanism = mechanism.nodes.index(node), mechanism
        self.spec = f"height:{node}"
        self.heads = (Head(self.spec, mechanism.length_unit, "height"),)

    def values(self, state):
        return [self.mechanism.to_file(state.node(self.index)).imag]


class Heun:
    """Heun's method in equal steps, with the interface of scipy's solvers."""

    def __init__(self, slopes, start, y, end, *, step, **_):
        self.slopes, self.t, self.y, self.end, self.h = slopes, start, y.copy(), end, step
        self.status, self.nfev, self.t_old = "running", 0, start

    def step(self):
        h = min(self.h, self.end - self.t)
        self.before, first = self.y, self.slopes(self.t, self.y)
        self.y = self.y + 0.5 * h * (first + self.slopes(self.t + h, self.y + h * first))
        self.t_old, self.t, self.nfev = self.t, self.t + h, self.nfev + 2
        if self.end - self.t <= 1e-12 * h:
            self.t, self.status = self.end, "finished"

    def dense_output(self):
        rate = (self.y - self.before) / (self.t - self.t_old)
        return lambda time: self.before + (time - self.t_old) * rate


def test_measure(monkeypatch, tmp_path):
    def make(mechanism, spec, names):
        return [Height(mechanism, names[0])]

    kind = Kind("height", "NODE", "height of a node", (1,), make)
    monkeypatch.setitem(KINDS, "height", kind)
    model = MODELS / "crank_rocker.yaml"
    assert gim("trace", model, "--steps", 12, "-m", "height:B", "--no-png", "-o", tmp_path).code == 0
    rows = read_rows(tmp_path / "crank_rocker.csv")
    assert len(rows) == 13
    assert all(row["height:B"] for row in rows)


def test_integrator(monkeypatch, tmp_path):
    """The energy drift of Heun's method is proportional to the square of the step."""
    monkeypatch.setitem(INTEGRATORS, "heun", Integrator(Heun, lands=False, unit="s"))
    drifts = []
    for step in (2e-3, 1e-3):
        options = (
            "--integrator",
            "heun",
            "--step",
            step,
            "--time",
            0.5,
            "--dt",
            0.1,
            "--no-png",
            "--json",
            "-o",
            tmp_path,
        )
        done = gim("simulate", MODELS / "watt_durango.yaml", *options)
        assert done.code == 0
        drifts.append(done.json["energy_drift"])
    assert 3.0 < drifts[0] / drifts[1] < 9.0
    assert "heun" in gim("simulate", MODELS / "watt_durango.yaml", "--method", "hoin").error


def test_formats(monkeypatch, tmp_path):
    names = Format("table", lambda table, path: path.write_text("\n".join(table.names)))
    monkeypatch.setitem(FORMATS, ".names", names)
    monkeypatch.setitem(FORMATS, ".kind", Format("picture", lambda p, path: path.write_text(type(p).__name__)))
    table, picture = tmp_path / "position.names", tmp_path / "position.kind"
    assert gim("solve", MODELS / "crank_rocker.yaml", "-o", table, "-o", picture).code == 0
    assert table.read_text().split()[:3] == ["node", "x", "y"]
    assert picture.read_text() == "Picture"
