"""Check that the results of commands agree with each other, with the file, and with the known position."""

import math
import time

import numpy as np
import yaml
from by_definition import Definition
from in_process import Ran, gim, position, read_rows
from random_models import Grown
from scipy.interpolate import PchipInterpolator

LONGEST = 60.0
"""Largest processor time of a command [s]."""

SAME = 1e-9
"""Largest difference of equal intervals, in rad or relative to the size."""

NEAR = 1e-6
"""Largest difference of equal positions, relative to the size."""

NAMED = {
    "uniform": lambda t: t,
    "cubic": lambda t: 3.0 * t**2 - 2.0 * t**3,
    "quintic": lambda t: 10.0 * t**3 - 15.0 * t**4 + 6.0 * t**5,
    "cycloidal": lambda t: t - math.sin(2.0 * math.pi * t) / (2.0 * math.pi),
    "harmonic": lambda t: 0.5 * (1.0 - math.cos(math.pi * t)),
}  # Norton, Cam Design and Manufacturing Handbook, 2002, chapter 2


class Subject:
    """A random mechanism, the commands that are run on it, and the errors found in their results."""

    def __init__(self, seed, folder, samples=4):
        self.seed, self.folder, self.samples = seed, folder, samples
        self.grown = Grown(seed)
        self.data, tables = self.grown.data()
        self.path = folder / "model.yaml"
        self.path.write_text(yaml.safe_dump(self.data, sort_keys=False))
        for name, text in tables.items():
            (folder / name).write_text(text)
        self.tables = tables
        self.definition = Definition(self.data)
        self.built = {n: complex(*z) for n, z in self.grown.nodes.items()}
        self.start = {n: self.value(n, 0.0) for n in self.definition.actuators}
        self.wrong, self.slow = [], {}

    # -- commands -------------------------------------------------------------------------

    def run(self, name, *options, path=None):
        """Run a command; record a traceback, an unexpected exit status, or a long processor time."""
        begun = time.process_time()
        try:
            done = gim(name.split()[0], path or self.path, *options, "--json")
        except Exception as error:
            done = Ran(1, "", f"{type(error).__name__}: {error}")
        spent = time.process_time() - begun
        command = " ".join([name, *(str(o) for o in options if str(self.folder) not in str(o))])
        self.slow[command] = spent
        self.expect(spent < LONGEST, f"{command} took {spent:.0f} s")
        self.expect(done.code in (0, 4, 5), f"{command} ended with {done.code}: {done.error[:300]}")
        return done

    def expect(self, holds, what):
        """Record an error if a condition does not hold."""
        if not holds:
            self.wrong.append(f"seed {self.seed}: {what}")
        return holds

    # -- laws of inputs -------------------------------------------------------------------

    def value(self, name, t):
        """Return the value of an input (file's unit) at a time 0..1, by its law."""
        motor = self.data["actuators"][name]
        law = motor["law"]
        if "table" in law:
            rows = [list(map(float, line.split(","))) for line in self.tables[law["table"]].split()[1:]]
            times, values = np.array(rows).T
            return float(PchipInterpolator(times / times[-1], values)(t))
        if "polynomial" in law:
            return sum(c * t**k for k, c in enumerate(law["polynomial"]))
        profile = law.get("profile", "uniform")
        part = (
            sum(c * t**k for k, c in enumerate(profile["polynomial"]))
            if isinstance(profile, dict)
            else NAMED[profile](t)
        )
        if "by" in law:
            begin = self.drawn_value(motor)
            return begin + law["by"] * part
        return law["from"] + (law["to"] - law["from"]) * part

    def drawn_value(self, motor):
        """Return the value of an input at the coordinates of the file."""
        drawn = self.definition.reading(motor, self.definition.nodes)
        return math.degrees(drawn) if "pivot" in motor else drawn

    def same_value(self, name, a, b, within=SAME):
        """Return whether two values of an input are the same; None is an infinite value."""
        if a is None or b is None:
            return a is b
        near = math.degrees(within) if "pivot" in self.definition.actuators[name] else within * self.definition.size
        return abs(a - b) <= near

    def same_interval(self, a, b):
        """Return whether two intervals of the inputs of a machine are the same."""
        pairs = ((n, x, y) for n in a for x, y in zip(a[n], b.get(n, a[n]), strict=True))
        return a.keys() == b.keys() and all(self.same_value(*one) for one in pairs)

    def apart(self, z, other):
        """Return the largest distance of nodes in two positions, relative to the size."""
        return max(abs(z[n] - other[n]) for n in self.data["trace"]) / self.definition.size

    # -- equalities -----------------------------------------------------------------------

    def check(self):
        """Compare the commands with each other; return the errors."""
        freedoms, left, driving = self.definition.freedoms(self.built)
        self.mobility(freedoms, left, driving)
        fit = left == 0 and driving == len(self.definition.actuators)
        ran = {name: self.run(name, *options) for name, options in self.commands().items()}
        if not fit:
            for name, done in ran.items():
                self.expect(done.code == 4, f"{name}: {done.code} where {left} freedoms are left, {driving} driven")
            return self.wrong
        assembled = ran["solve"].code == 0 and ran["solve"].json["status"] == "ok"
        if not self.grown.far:
            self.expect(assembled, f"solve: {ran['solve'].code} {ran['solve'].error[:200]} {ran['solve'].text[:200]}")
        for name, done in ran.items():
            self.expect(done.code in ((0, 5) if assembled else (0, 4, 5)), f"{name}: {done.code} {done.error[:200]}")
        if assembled and all(done.code in (0, 5) and done.text for done in ran.values()):
            reports = {name: done.json for name, done in ran.items()}
            begin = {n: complex(*z) for n, z in reports["solve"]["nodes"].items()}
            self.solved(begin)
            self.rows(begin, reports["trace"])
            self.listed(begin, reports["solve --all"])
            self.intervals(reports)
            self.extremes(reports["singularities"])
        return self.wrong

    def commands(self):
        """Return the commands by name, with their options."""
        steps = ("--steps", 12, "--no-png", "-o", self.folder / "out")
        (self.folder / "out").mkdir(exist_ok=True)
        return {
            "solve": (), "trace": steps, "solve --all": ("--all",), "singularities": (),
            "circuits": ("--samples", self.samples),
        }  # fmt: skip

    def mobility(self, freedoms, left, driving):
        """Check the mobility by an independent rank."""
        done = self.run("mobility")
        if done.code == 0 and done.text:
            report = done.json
            self.expect(report["mobility"] == freedoms, f"mobility {report['mobility']}, by rank {freedoms}")
            self.expect(bool(report["undriven"]) == (left > 0), f"undriven {report['undriven']}, by rank {left}")
            over = len(self.definition.actuators) - driving
            self.expect(len(report["overdriven"]) == over, f"overdriven {report['overdriven']}, by rank {over}")

    def solved(self, begin):
        """Check that the start is the known position."""
        if not self.grown.far:
            self.expect(
                self.apart(begin, self.built) < NEAR, f"solve is {self.apart(begin, self.built):.2g} off the drawing"
            )

    def rows(self, begin, report):
        """Check that rows that are ok have the inputs of the laws and satisfy every constraint."""
        for k, row in enumerate(read_rows(self.folder / "out" / "model.csv")):
            if row["status"] != "ok":
                continue
            z = position(row, self.data["trace"])
            inputs = {n: float(row[n]) for n in self.definition.actuators}
            for n, value in inputs.items():
                self.expect(self.same_value(n, value, self.value(n, k / 12.0), 1e-12), f"row {k}: {n} is {value}")
            worst, name = self.definition.worst(z, inputs)
            self.expect(worst <= self.definition.allowed, f"trace, row {k}: {name} off by {worst:.2g}")
            if k == 0:
                self.expect(self.apart(z, begin) < NEAR, "trace and solve begin differently")

    def listed(self, begin, report):
        """Check that all configurations satisfy every constraint, and that the drawn one is listed.

        Those of an independent machine have its own nodes; the others are where they begin.
        """
        found = [begin | {n: complex(*z) for n, z in one["nodes"].items()} for one in report["configurations"]]
        for z in found:
            worst, name = self.definition.worst(z, report["inputs"])
            self.expect(worst <= self.definition.allowed, f"solve --all: {name} off by {worst:.2g}")
        nearest = min((self.apart(z, begin) for z in found), default=math.inf)
        self.expect(nearest < NEAR, f"solve --all ({report['verdict']}) is {nearest:.2g} off the start")

    def intervals(self, reports):
        """Check that trace, singularities and circuits report the same intervals and curves."""
        curves = [c["interval"] for c in reports["singularities"]["circuits"]]
        for event in reports["trace"]["events"]:
            if event["kind"] == "limit":
                same = any(self.same_interval(event["interval"], c) for c in curves)
                self.expect(same, f"trace: interval {event['interval']}, singularities {curves}")
        joined = [c["interval"] for c in reports["circuits"]["curves"] if c["circuit"] == 1]
        alike = len(joined) == len(curves) and all(any(self.same_interval(a, b) for b in curves) for a in joined)
        self.expect(alike, f"circuits: {joined}, singularities {curves}")

    def extremes(self, report):
        """Check that a point has the same bounds along the whole circuit and on its path of the workspace."""
        if len(self.definition.actuators) > 1 or self.grown.far or not self._freed(report):
            return
        point = next(n for n in reversed(self.data["trace"]) if n not in self.definition.still)
        path, out = self.folder / "free.yaml", ("--no-png", "-o", self.folder / "out")
        found = self.run("workspace", "--point", point, *out, path=path)
        traced = self.run("trace", "--circuit", "--steps", 1500, *out)
        if found.code or traced.code:
            self.expect(
                found.code == traced.code == 0 or "does not move" in found.error,
                f"workspace of {point}: {found.code} {found.error[:200]}; trace --circuit: {traced.code}",
            )
            return
        z = np.array([position(row, [point])[point] for row in read_rows(self.folder / "out" / "model.csv")])
        near = 1e-4 * self.definition.size  # the maximum is between two rows
        own = [z.real.min(), z.real.max(), z.imag.min(), z.imag.max()]
        paths = [[*p["bounds"]["x"], *p["bounds"]["y"]] for p in found.json["paths"] if p["drawn"]]
        alike = len(paths) == 1 and np.allclose(paths[0], own, rtol=0.0, atol=near)
        self.expect(alike, f"workspace of {point}: {paths}, along the circuit {own}")

    def _freed(self, report):
        """Write the mechanism with an input range that covers the whole circuit, if that is one closed curve."""
        one = report["circuits"]
        if len(one) > 1 or not one[0]["closed"]:
            return False
        data = {**self.data, "actuators": {n: dict(a) for n, a in self.data["actuators"].items()}}
        ((name, motor),) = data["actuators"].items()
        del motor["law"]
        if "pivot" not in motor:
            low, high = one[0]["interval"][name]
            motor["law"] = {"from": low, "to": high}
        (self.folder / "free.yaml").write_text(yaml.safe_dump(data, sort_keys=False))
        return True
