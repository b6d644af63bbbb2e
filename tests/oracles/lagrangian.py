"""Driving effort of a mechanism with one input by Lagrange's equation, from its file and a closed form of its nodes.

No function of the package is used: the file is read with PyYAML, formulas are computed by Python, derivatives by the
input are differences of the eighth order.
"""

from __future__ import annotations

import csv
import math

import numpy as np
import yaml
from bundled import MODELS
from scipy.interpolate import PchipInterpolator

METRE = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "in": 0.0254, "ft": 0.3048}
KILOGRAM = {"kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237}
STENCIL = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
STEPS = np.arange(-4, 5)


def read(name):
    """Return the data of a shipped model with its formulas as numbers."""
    data = yaml.safe_load((MODELS / f"{name}.yaml").read_text())
    scope = {"deg": math.pi / 180, "sqrt": math.sqrt, "cos": math.cos, "sin": math.sin, "pi": math.pi}
    for key, value in data.get("parameters", {}).items():
        scope[key] = value if not isinstance(value, str) else eval(value, {}, scope)

    def numbers(part, numeric=False):
        if isinstance(part, dict):
            return {("on" if key is True else key): numbers(value, numeric) for key, value in part.items()}
        if isinstance(part, list):
            return [numbers(value, numeric) for value in part]
        if isinstance(part, str):
            try:
                return float(eval(part, {}, scope))
            except (NameError, SyntaxError, TypeError):
                return part
        return part

    for section in ("nodes", "links", "elements", "actuators", "masses", "loads", "springs", "dampers", "friction"):
        if section in data:
            data[section] = numbers(data[section])
    return data


def ray(angle):
    return np.exp(1j * angle)


def unit(z):
    return z / abs(z)


def meet(a, ra, b, rb, side):
    """Return the intersection of circles around a and b, to the left (side 1) or right (-1) of a -> b."""
    d = abs(b - a)
    x = (ra**2 - rb**2 + d**2) / (2 * d)
    return a + (b - a) / d * (x + 1j * side * np.sqrt(ra**2 - x**2))


class Machine:
    """A file with one input; `place(q)` returns the moving nodes [file's unit] for inputs q [rad or file's unit]."""

    def __init__(self, name, place):
        self.data, self.place = read(name), place
        units = {"length": "m", "angle": "deg", "mass": "kg", **self.data.get("units", {})}
        self.metre, self.kilogram = METRE[units["length"]], KILOGRAM[units["mass"]]
        self.degree = math.pi / 180 if units["angle"] == "deg" else 1.0
        self.members = {}
        for kind in ("links", "elements"):
            for key, value in self.data.get(kind, {}).items():
                self.members[key] = value["nodes"] if isinstance(value, dict) else value
        ground = self.data["ground"]
        self.ground = ground if isinstance(ground, list) else ground["nodes"]
        (self.actuator,) = self.data["actuators"].values()
        self.rotary = "pivot" in self.actuator
        self.file = self.degree if self.rotary else 1.0  # unit of the input
        for load in self.data.get("loads", {}).values():
            load.setdefault("on", load.get("member"))
        for name, mass in self.data["masses"].items():
            self.data["masses"][name] = mass if isinstance(mass, dict) else {"mass": mass}

    @property
    def seconds(self):
        """The time of the law [s]; a rate is in revolutions per minute."""
        law = self.actuator["law"]
        return 60 * law["turns"] / float(law["rate"].split()[0]) if "rate" in law else self.data["duration"]

    def nodes(self, q):
        """Return the nodes [m]."""
        fixed = {name: complex(*self.data["nodes"][name]) + 0 * q for name in self.ground}
        return {name: z * self.metre for name, z in {**fixed, **self.place(q)}.items()}

    def pose(self, z, member):
        if member == "ground":
            return 0j, 1.0 + 0j
        first, second = self.members[member][:2]
        return z[first], unit(z[second] - z[first])

    def point(self, z, part):
        """Return a point that is given by `local`, `at` or `centre`, or the mean of the member's nodes."""
        if part["on"] not in (*self.members, "ground"):
            return z[part["on"]]  # a force on a node
        origin, direction = self.pose(z, part["on"])
        if "at" in part:
            drawn = {name: complex(*xy) * self.metre for name, xy in self.data["nodes"].items()}
            start, along = self.pose(drawn, part["on"])
            return origin + direction * ((complex(*part["at"]) * self.metre - start) / along)
        return origin + direction * complex(*part["local"]) * self.metre

    def gauge(self, z, part):
        """Return the distance, travel [m] or angle [rad] that a spring or a damper acts on."""
        if "pivot" in part:
            zero = z[part["reference"]] - z[part["pivot"]] if "reference" in part else 1.0
            return np.angle((z[part["arm"]] - z[part["pivot"]]) / zero)
        if "nodes" in part:
            return abs(z[part["nodes"][1]] - z[part["nodes"][0]])
        first, second = (z[name] for name in part["guide"])
        return ((z[part["node"]] - first) * np.conj(unit(second - first))).real

    def by_q(self, q, function):
        """Return a quantity of the nodes and its derivative by the input [rad or m]."""
        step = 2e-3 if self.rotary else 1e-3 * np.ptp(q)
        values = [function(self.nodes(q + k * step)) for k in STEPS]
        if not np.iscomplexobj(values[0]):
            values = np.unwrap(np.unwrap(values, axis=0), axis=-1)  # of angles; lengths differ less from row to row
        slope = sum(weight * value for weight, value in zip(STENCIL, values, strict=True)) / step
        return values[4], slope if self.rotary else slope / self.metre

    def angle_rate(self, q, member):
        if member == "ground":
            return 0.0 * q
        along, rate = self.by_q(q, lambda z: self.pose(z, member)[1])
        return (rate / (1j * along)).real

    def inertia(self, q):
        """Return the reduced inertia."""
        total = 0.0 * q + self.rotor
        for name, mass in self.data["masses"].items():
            _, rate = self.by_q(q, lambda z, name=name, mass=mass: self.centre(z, name, mass))
            total = total + mass["mass"] * self.kilogram * abs(rate) ** 2
            if name in self.members:
                total = total + mass.get("inertia", 0.0) * self.angle_rate(q, name) ** 2
        return total

    @property
    def rotor(self):
        """The inertia of the motor's rotor on the input [kg m^2, or kg]."""
        rotor = self.actuator.get("rotor", {"inertia": 0.0, "ratio": 0.0})
        turns = rotor["ratio"] if "ratio" in rotor else 2 * math.pi / (rotor["lead"] * self.metre)
        return rotor["inertia"] * turns**2

    def centre(self, z, name, mass):
        if name not in self.members:
            return z[name]  # a point mass
        if "centre" in mass:
            return self.point(z, {"on": name, "local": mass["centre"]})
        drawn = self.members[name]
        return sum(z[node] for node in drawn) / len(drawn)

    def factor(self, load, q, time):
        if "table" not in load:
            return 1.0
        with (MODELS / load["table"]).open() as handle:
            rows = np.array([row for row in csv.reader(handle)][1:], dtype=float)
        over = time if load.get("over", "time") == "time" else q / self.file
        return PchipInterpolator(rows[:, 0], rows[:, 1])(np.clip(over, rows[0, 0], rows[-1, 0]))

    def applied(self, q, speed, time):
        """Return the generalised force of weights, loads, springs, dampers and friction."""
        gravity = complex(*self.data.get("gravity", (0, 0)))
        total = 0.0 * q
        for name, mass in self.data["masses"].items():
            _, rate = self.by_q(q, lambda z, name=name, mass=mass: self.centre(z, name, mass))
            total = total + mass["mass"] * self.kilogram * (np.conj(gravity) * rate).real
        for load in self.data.get("loads", {}).values():
            total = total + self.factor(load, q, time) * self.load(q, load)
        for spring in self.data.get("springs", {}).values():
            value, rate = self.by_q(q, lambda z, spring=spring: self.gauge(z, spring))
            free = spring["free"] * (self.degree if "pivot" in spring else self.metre)
            total = total - spring["stiffness"] * (value - free) * rate
        for damper in self.data.get("dampers", {}).values():
            _, rate = self.by_q(q, lambda z, damper=damper: self.gauge(z, damper))
            total = total - damper["damping"] * rate**2 * speed
        for pair, value in self.data.get("friction", {}).items():
            total = total - value * sum(rate**2 for rate in self.relative(q, pair)) * speed
        return total

    def load(self, q, load):
        if "torque" in load:
            return load["torque"] * self.angle_rate(q, load["on"])
        _, rate = self.by_q(q, lambda z: self.point(z, load))
        if "force" in load:
            return (np.conj(complex(*load["force"])) * rate).real
        direction = self.pose(self.nodes(q), load["on"])[1]
        return (np.conj(complex(*load["follower"]) * direction) * rate).real

    def relative(self, q, pair):
        """Yield the relative speeds in a pair, for a unit speed of the input."""
        if pair in self.data.get("prismatic", {}):
            slide = self.data["prismatic"][pair]
            node = slide.get("node") or slide["nodes"][0]
            yield self.by_q(q, lambda z: self.gauge(z, {"node": node, "guide": slide["guide"]}))[1]
            return
        at = ["ground"] if pair in self.ground else []
        at += [name for name, nodes in self.members.items() if pair in nodes]
        first = self.angle_rate(q, at[0])
        for other in at[1:]:
            yield self.angle_rate(q, other) - first

    def effort(self, q, speed, acceleration, time):
        """Return the driving effort; q in rad or the file's unit, speed and acceleration in SI units."""
        step = 2e-3 if self.rotary else 1e-3 * np.ptp(q)
        slope = sum(w * self.inertia(q + k * step) for w, k in zip(STENCIL, STEPS, strict=True) if w) / step
        slope = slope if self.rotary else slope / self.metre
        return self.inertia(q) * acceleration + slope * speed**2 / 2 - self.applied(q, speed, time)
