"""Every constraint of a model file, written from its definition without code of the package.

A position maps nodes to complex numbers in the file's unit. Errors are relative lengths and rad; those of sliding
pairs, travels and fixed nodes are relative to the mechanism's size, as the manual defines `residual`.
"""

import cmath
import math

import numpy as np

TOLERANCE = 1e-10
"""Largest error of a row that is ok, from the manual's page on accuracy."""

EPS = float(np.finfo(float).eps)


class Definition:
    """The constraints of a file's data."""

    def __init__(self, data):
        self.nodes = {str(n): complex(*z) for n, z in data["nodes"].items() if isinstance(z, list)}
        ground = data["ground"]
        self.held = ground.get("member") if isinstance(ground, dict) else None
        self.ground = [] if self.held else list(ground["nodes"] if isinstance(ground, dict) else ground)
        self.members = {**data.get("links", {}), **data.get("elements", {})}
        self.members = {k: v if isinstance(v, dict) else {"nodes": v} for k, v in self.members.items()}
        self.prismatic, self.actuators = data.get("prismatic") or {}, data.get("actuators") or {}
        self.degrees = (data.get("units") or {}).get("angle", "deg") == "deg"
        self.shapes = {k: self._shape(v) for k, v in self.members.items()}
        spans = [*([z for n, z in s.items()] for s in self.shapes.values()), list(self.nodes.values())]
        self.size = max(math.hypot(np.ptp(np.real(s)), np.ptp(np.imag(s))) for s in spans)
        first = [abs(z - next(iter(s.values()))) for s in self.shapes.values() for z in list(s.values())[1:]]
        self.shortest = min(first, default=self.size)
        far = max(map(abs, self.nodes.values()))
        rounding = 64.0 * EPS * max(self.size, far) / self.shortest
        self.allowed = max(TOLERANCE, rounding)

    def _shape(self, member):
        """Return the coordinates of a member's nodes in its own frame."""
        nodes = member["nodes"]
        if "length" in member:
            return {nodes[0]: 0j, nodes[1]: complex(member["length"])}
        if "shape" in member:
            return {n: complex(*member["shape"][n]) for n in nodes}
        return {n: self.nodes[n] for n in nodes}

    def errors(self, z, inputs):
        """Yield name and error of every constraint at a position, and of every given input (file's unit)."""
        yield from self._fixed(z)
        for name, shape in self.shapes.items():
            yield name, _rigid(shape, z)
        for name, pair in self.prismatic.items():
            yield from self._slides(name, pair, z)
        for name in inputs.keys() & self.actuators.keys():  # gears have inputs of their own
            yield name, self._drive(self.actuators[name], z, inputs[name])

    def worst(self, z, inputs):
        """Return the largest error and its constraint; NaN counts as infinite."""
        found = [(e if math.isfinite(e) else math.inf, name) for name, e in self.errors(z, inputs)]
        return max(found, default=(0.0, ""))

    def _fixed(self, z):
        for name in self.ground:
            yield f"ground {name}", abs(z[name] - self.nodes[name]) / self.size
        if self.held:
            first, second = self.members[self.held]["nodes"][:2]
            yield f"held {first}", abs(z[first] - self.nodes[first]) / self.size
            yield f"held {second}", abs(_turn(z[second] - z[first], self.nodes[second] - self.nodes[first]))

    def _slides(self, name, pair, z):
        u, v = pair["guide"]
        along = _unit(z[v] - z[u])
        names = pair.get("nodes") or [pair["node"]]
        for node in names:
            yield name, abs(((z[node] - z[u]) / along).imag - pair.get("offset", 0.0)) / self.size
        if len(names) == 2:  # a block keeps its orientation on the guide
            a, b = names
            drawn = ((self.nodes[b] - self.nodes[a]) / (self.nodes[v] - self.nodes[u])).real
            now = ((z[b] - z[a]) / along).real
            yield f"sense of {name}", 0.0 if drawn * now > 0.0 else math.inf

    def reading(self, actuator, z):
        """Return the value of an input, an angle in rad."""
        if "pivot" in actuator:
            arm = z[actuator["arm"]] - z[actuator["pivot"]]
            if actuator.get("reference") is not None:
                arm /= z[actuator["reference"]] - z[actuator["pivot"]]
            return cmath.phase(arm)
        if actuator.get("nodes"):
            a, b = actuator["nodes"]
            return abs(z[b] - z[a])
        u, v = actuator["guide"]
        return ((z[actuator["node"]] - z[u]) / _unit(z[v] - z[u])).real

    def _drive(self, actuator, z, value):
        now = self.reading(actuator, z)
        if "pivot" in actuator:
            value = math.radians(value) if self.degrees else value
            return abs(math.remainder(now - value, 2.0 * math.pi))
        return abs(now - value) / (value if actuator.get("nodes") else self.size)

    # -- freedoms -------------------------------------------------------------------------

    def freedoms(self, z):
        """Return the freedoms at a position, the freedoms with constant inputs, and the rank of the inputs."""
        nodes = [n for n in z if n in self.used]
        table = _gradients(lambda x: self._equations(_places(nodes, x)), _coordinates(nodes, z))
        drives = _gradients(lambda x: self._readings(_places(nodes, x)), _coordinates(nodes, z))
        rank, both = _rank(table), _rank(np.vstack([table, drives]))
        return 2 * len(nodes) - rank, 2 * len(nodes) - both, both - rank

    @property
    def still(self):
        """Nodes that never move."""
        return self.members[self.held]["nodes"] if self.held else self.ground

    @property
    def used(self):
        """Nodes of the ground, a member or a pair."""
        parts = [self.ground, *(m["nodes"] for m in self.members.values())]
        parts += [[*(p.get("nodes") or [p["node"]]), *p["guide"]] for p in self.prismatic.values()]
        return {n for part in parts for n in part}

    def _equations(self, z):
        yield from (z[n] for n in self.ground)
        for name, shape in self.shapes.items():
            first, second, *others = shape
            base = z[second] - z[first]
            yield z[first] if name == self.held else 0j
            yield base if name == self.held else complex(abs(base))
            for node in others:
                yield z[node] - z[first] - base * (shape[node] - shape[first]) / (shape[second] - shape[first])
        for pair in self.prismatic.values():
            u, v = pair["guide"]
            for node in pair.get("nodes") or [pair["node"]]:
                yield complex(((z[node] - z[u]) / _unit(z[v] - z[u])).imag)

    def _readings(self, z):
        for actuator in self.actuators.values():
            yield complex(self.reading(actuator, z))


def _coordinates(nodes, z):
    return np.array([part for n in nodes for part in (z[n].real, z[n].imag)])


def _places(nodes, x):
    return dict(zip(nodes, (x[::2] + 1j * x[1::2]).tolist(), strict=True))


def _gradients(function, x, step=1e-6):
    """Return central differences of complex values: rows for real and imaginary parts, scaled to length 1."""
    columns = []
    for k in range(len(x)):
        ends = [np.array(list(function(x + sense * step * np.eye(len(x))[k]))) for sense in (1.0, -1.0)]
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    table = np.array(columns).T
    rows = np.vstack([table.real, table.imag]) if table.size else np.zeros((0, len(x)))
    norm = np.linalg.norm(rows, axis=1)
    kept = norm > 1e-7
    return rows[kept] / norm[kept, None]


def _rank(table, tolerance=1e-7):
    return int(np.sum(np.linalg.svd(table, compute_uv=False) > tolerance)) if table.size else 0


def _unit(z):
    return z / abs(z) if z else complex(math.nan, 0.0)


def _turn(now, then):
    return cmath.phase(now / then)


def _rigid(shape, z):
    """Return the largest relative error of a member's lengths, or of its angles [rad]; a mirrored member has errors."""
    first, second, *others = shape
    base, own = z[second] - z[first], shape[second] - shape[first]
    error = abs(abs(base) / abs(own) - 1.0)
    for node in others:
        arm, drawn = z[node] - z[first], shape[node] - shape[first]
        error = max(error, abs(abs(arm) / abs(drawn) - 1.0), abs(_turn(arm / base, drawn / own)))
    return error
