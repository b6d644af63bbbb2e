"""Random mechanisms of all kinds as model files, composed in an assembled position.

They have one to three inputs of all kinds and profiles, n-ary elements, slots, blocks, linear actuators and redundant
parts; some float; some have coordinates far from the known position.
"""

import cmath
import math

from random_mechanisms import Growth

PROFILES = ("uniform", "cubic", "quintic", "cycloidal", "harmonic")
"""Profiles by name."""

LAWS = ("by", "from", "named", "polynomial", "absolute", "table")
"""Forms of a law."""


class Grown(Growth):
    """A mechanism with the data of its file; `far` is whether its coordinates are far from the known position."""

    def __init__(self, seed):
        super().__init__(seed, 0, "crank")
        choose = self.random
        inputs = choose.choice([1, 1, 1, 1, 2, 2, 3])
        for k in range(1, inputs):
            self.actuators[f"m{k}"] = choose.choice([self.rotary_crank, self.ram, self.driven_slider])()
        kinds = [self.rrr, self.rrr, self.rrp, self.rpr, self.prp, self.triad, self.true_pair, self.nary]
        for _ in range(choose.choice([0, 1, 1, 2, 2, 3])):
            choose.choice(kinds)()
        if choose.random() < 0.2:
            choose.choice([self.braced, self.third_slide, self.third_crank])()
        self.elsewhere = inputs == 1 and choose.random() < 0.35
        if self.elsewhere:
            self.drive_elsewhere() if choose.random() < 0.6 else self.drive_linear(
                choose.choice(["distance", "travel"])
            )
        motor = self.actuators["motor"]
        if any(_driven(motor, nodes) for nodes in self.bodies.values() if "nodes" in motor):
            self.actuators["motor"] = {"type": "rotary", "pivot": self.ground[0], "arm": self.bodies["b0"][1]}
        self.floating = choose.random() < 0.2
        self.far = choose.random() < 0.25
        self.noise = choose.choice([1e-6, 1e-3, 0.1, 0.5])

    def rotary_crank(self):
        pivot = self.random.choice(self.ground[1:])
        arm = self.node()
        self.body([pivot, arm, *self.maybe(1)])
        return {"type": "rotary", "pivot": pivot, "arm": arm}

    def ram(self):
        """Add a linear actuator between the frame, or a moving node, and a new arm."""
        pivot = self.random.choice(self.ground[1:])
        arm = self.node()
        others = [n for n in self.nodes if n not in (pivot, arm)]
        self.body([pivot, arm])
        return {"type": "linear", "nodes": [self.random.choice(others), arm]}

    def driven_slider(self):
        u, v = self.random.sample(self.ground, 2)
        node = self.node()
        self.at[node] = set()
        self.slide([node], u, v)
        return {"type": "linear", "node": node, "guide": [u, v]}

    # -- redundant parts ------------------------------------------------------------------

    def braced(self):
        """Add a link between two nodes of an element."""
        wide = [nodes for nodes in self.bodies.values() if len(nodes) > 2]
        if wide:
            self.body(self.random.sample(self.random.choice(wide), 2))

    def third_slide(self):
        """Add a third node of a block on its guide."""
        blocks = [pair for pair in self.pairs.values() if "nodes" in pair]
        if blocks:
            pair = self.random.choice(blocks)
            u, v = pair["guide"]
            a, b = pair["nodes"]
            node = self.node(0.3 * self.place(a) + 0.7 * self.place(b))
            body = next(nodes for nodes in self.bodies.values() if a in nodes and b in nodes)
            body.append(node)
            self.at[node] = {name for name, nodes in self.bodies.items() if nodes is body}
            self.slide([node], u, v)

    def third_crank(self):
        """Add two links parallel to the crank and a common coupler: one constraint is redundant."""
        pivot, arm = self.ground[0], self.bodies["b0"][1]
        ends = [arm]
        for _ in range(2):
            shift = complex(self.random.uniform(-1, 1), self.random.uniform(-1, 1))
            own, end = self.node(self.place(pivot) + shift), self.node(self.place(arm) + shift)
            self.ground.append(own)
            self.at[own] = {"ground"}
            self.body([own, end])
            ends.append(end)
        self.body(ends)

    # -- laws -----------------------------------------------------------------------------

    def _by(self, motor):
        if "pivot" in motor:
            if len(self.actuators) == 1 and not self.elsewhere:
                return self.random.choice([-1, 1]) * self.random.choice([360.0, self.random.uniform(20, 200)])
            return self.random.choice([-1, 1]) * self.random.uniform(5, 60)
        return self.random.choice([-1, 1]) * self.random.uniform(0.02, 0.2)

    def _law(self, name, motor, tables):
        start, by = self.drawn_value_of(motor), self._by(motor)
        if "nodes" in motor and start + by < 0.02:
            by = -by  # a distance must be above 0
        kind = self.random.choice(LAWS)
        if self.far and kind in ("by", "named", "polynomial"):
            kind = "from"
        if kind == "by":
            return {"by": by}
        if kind == "from":
            return {"from": start, "to": start + by, "profile": self.random.choice(PROFILES)}
        if kind == "named":
            return {"by": by, "profile": self.random.choice(PROFILES)}
        bend = self.random.uniform(0.0, 0.9)
        if kind == "polynomial":
            return {"by": by, "profile": {"polynomial": [0.0, 1.0 - bend, bend]}}
        if kind == "absolute":
            return {"polynomial": [start, by * (1.0 + bend), -bend * by]}
        rows = [(k / 4.0, start + by * (k / 4.0) ** self.random.choice([1, 2])) for k in range(5)]
        tables[f"{name}.law.csv"] = "time,value\n" + "".join(f"{t!r},{v!r}\n" for t, v in rows)
        return {"table": f"{name}.law.csv"}

    # -- the file -------------------------------------------------------------------------

    def data(self):
        """Return the data of the file, and its tables by name."""
        tables = {}
        spec = self.model()
        motors = {}
        for name, motor in self.actuators.items():
            motor = {k: v for k, v in motor.items() if k != "law"}
            motors[name] = {**motor, "law": self._law(name, motor, tables)}
        spec["actuators"] = motors
        spec["nodes"] = {n: list(map(float, z)) for n, z in self.nodes.items()}
        if self.floating:
            self._float(spec)
        if self.far:
            self._misdraw(spec)
        spec["trace"] = [n for n in spec["nodes"] if n in self._used(spec)]
        return spec, tables

    def _float(self, spec):
        """Fix a member of the file, the frame or another one, instead of nodes; angles are relative to the frame."""
        spec["elements"]["frame"] = list(self.ground)
        names = ["frame"]
        if self.random.random() < 0.5:
            parts = {**spec["links"], **spec["elements"]}
            names = [
                name for name, nodes in parts.items() if not any(_driven(m, nodes) for m in spec["actuators"].values())
            ]
            for motor in spec["actuators"].values():
                if "pivot" in motor and "reference" not in motor and motor["pivot"] in self.ground:
                    self._refer(motor)
        spec["ground"] = {"member": self.random.choice(names)}

    def _refer(self, motor):
        """Measure an angle from a line of the frame, and adapt the law."""
        motor["reference"] = next(n for n in self.ground if n != motor["pivot"])
        turn = self.place(motor["reference"]) - self.place(motor["pivot"])
        law, shift = motor["law"], -math.degrees(cmath.phase(turn))
        if "from" in law:
            law["from"], law["to"] = law["from"] + shift, law["to"] + shift
        elif "by" not in law:
            motor["law"] = {"from": self.drawn_value_of(motor), "to": self.drawn_value_of(motor) + 30.0}

    def _misdraw(self, spec):
        """Write all dimensions, and disturb the coordinates of the moving nodes."""
        spec["links"] = {
            k: {"nodes": v, "length": abs(self.place(v[1]) - self.place(v[0]))} for k, v in spec["links"].items()
        }
        spec["elements"] = {
            k: {"nodes": v, "shape": {n: list(self.nodes[n]) for n in v}} for k, v in spec["elements"].items()
        }
        ground = spec["ground"]
        still = (
            self.ground if isinstance(ground, list)
            else {**spec["links"], **spec["elements"]}[ground["member"]]["nodes"]
        )  # fmt: skip
        shake = self.random.uniform
        for n, z in spec["nodes"].items():
            if n not in still:
                spec["nodes"][n] = [v + self.noise * shake(-1, 1) for v in z]

    @staticmethod
    def _used(spec):
        used = set(spec["ground"]) if isinstance(spec["ground"], list) else set()
        for part in (*spec["links"].values(), *spec["elements"].values()):
            used |= set(part["nodes"] if isinstance(part, dict) else part)
        for pair in spec["prismatic"].values():
            used |= {*pair["guide"], *(pair.get("nodes") or [pair["node"]])}
        for motor in spec["actuators"].values():
            used |= {*(motor.get("nodes") or []), *([motor["node"]] if "node" in motor else [])}
        return used


def _driven(motor, nodes):
    """Return whether all nodes of an input belong to a member."""
    ends = motor.get("nodes") or (
        [motor["pivot"], motor["arm"]] if "pivot" in motor else [motor["node"], *motor["guide"]]
    )
    return set(ends) <= set(nodes)
