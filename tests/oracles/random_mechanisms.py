"""Random mechanisms, composed in a random position, so that the coordinates satisfy all constraints."""

import cmath
import math
import random

KINDS = ("rrr", "rrp", "rpr", "prp", "triad", "true_pair", "nary")
"""Kinds of groups that are added to a mechanism."""

DRIVES = ("crank", "elsewhere", "distance", "travel")
"""Kinds of drives: the angle of the crank, a relative angle, a distance of two nodes, a travel along a guide."""


class Growth:
    """A mechanism to which groups are added, beginning with a crank; `groups` is their number or their kinds."""

    def __init__(self, seed, groups, drive=None):
        self.random = random.Random(seed)
        self.nodes, self.bodies, self.at, self.pairs = {}, {}, {}, {}
        self.ground = [self.node() for _ in range(5)]
        for name in self.ground:
            self.at[name] = {"ground"}
        crank = self.node()
        self.body([self.ground[0], crank, *self.maybe(1)])
        turn = self.random.choice([-1, 1]) * self.random.uniform(20, 200)
        self.actuators = {"motor": {"type": "rotary", "pivot": self.ground[0], "arm": crank, "law": {"by": turn}}}
        if not isinstance(groups, int):
            for kind in groups:
                getattr(self, kind)()
        else:
            for _ in range(groups):
                self.random.choice([self.rrr, self.rrr, self.rrp, self.rpr, self.triad, self.true_pair])()
        if drive == "elsewhere" or (drive is None and self.random.random() < 0.5):
            self.drive_elsewhere()
        elif drive in ("distance", "travel"):
            self.drive_linear(drive)

    def node(self, place=None):
        name = f"n{len(self.nodes)}"
        place = complex(self.random.uniform(-1, 1), self.random.uniform(-1, 1)) if place is None else place
        self.nodes[name] = [place.real, place.imag]
        return name

    def maybe(self, count):
        return [self.node() for _ in range(count) if self.random.random() < 0.5]

    def place(self, name):
        return complex(*self.nodes[name])

    def body(self, names):
        body = f"b{len(self.bodies)}"
        self.bodies[body] = list(names)
        for name in names:
            self.at.setdefault(name, set()).add(body)

    def pick(self, count=1):
        free = [n for n in self.nodes if n != self.ground[0]]
        chosen = self.random.sample(free, min(count, len(free)))
        apart = all(not self.at[a] & self.at[b] for i, a in enumerate(chosen) for b in chosen[:i])
        return chosen if apart and len(chosen) == count else None

    def guide(self):
        body = self.random.choice(["ground", *self.bodies])
        u, v = self.random.sample(self.ground if body == "ground" else self.bodies[body], 2)
        return body, u, v

    def slide(self, names, u, v):
        along = (self.place(v) - self.place(u)) / abs(self.place(v) - self.place(u))
        offset = ((self.place(names[0]) - self.place(u)) * (1j * along).conjugate()).real
        key = {"node": names[0]} if len(names) == 1 else {"nodes": names}
        self.pairs[f"s{len(self.pairs)}"] = {**key, "guide": [u, v], "offset": offset}

    def rrr(self):
        if ends := self.pick(2):
            new = self.node()
            for end in ends:
                self.body([end, new, *self.maybe(1)])

    def rrp(self):
        body, u, v = self.guide()
        if (ends := self.pick()) and body not in self.at[ends[0]]:
            new = self.node()
            self.body([ends[0], new])
            self.slide([new], u, v)

    def rpr(self):
        if ends := self.pick(2):
            new = self.node()
            self.body([ends[0], new, *self.maybe(1)])
            self.slide([ends[1]], ends[0], new)

    def prp(self):
        """Add a node on two lines of different members."""
        body, u, v = self.guide()
        other, p, q = self.guide()
        if body == other:
            return
        along, across = (self.place(b) - self.place(a) for a, b in ((u, v), (p, q)))
        if abs((along.conjugate() * across).imag) < 0.2 * abs(along) * abs(across):
            return
        new = self.node()
        self.at[new] = set()
        self.slide([new], u, v)
        self.slide([new], p, q)

    def nary(self):
        """Add a member of four or five nodes on three links."""
        if ends := self.pick(3):
            new = [self.node() for _ in range(self.random.choice([4, 5]))]
            self.body(new)
            for a, b in zip(ends, new, strict=False):
                self.body([a, b])

    def triad(self):
        if ends := self.pick(3):
            new = [self.node() for _ in ends]
            self.body(new)
            for a, b in zip(ends, new, strict=True):
                self.body([a, b])

    def true_pair(self):
        body, u, v = self.guide()
        if (ends := self.pick()) and body not in self.at[ends[0]]:
            along = (self.place(v) - self.place(u)) / abs(self.place(v) - self.place(u))
            height = 1j * along * self.random.uniform(-0.5, 0.5)
            a, b = (self.node(self.place(u) + along * t + height) for t in (0.1, 0.9))
            new = self.node()
            self.body([a, b, new])
            self.body([ends[0], new])
            self.slide([a, b], u, v)

    def drive_elsewhere(self):
        """Drive a relative angle at some pivot instead of the crank: the groups become coupled."""
        pivots = [n for n in self.nodes if len(self.at[n]) > 1 and n != self.ground[0]]
        if not pivots:
            return
        pivot = self.random.choice(pivots)
        second, first = sorted(self.random.sample(sorted(self.at[pivot]), 2), key=lambda b: b != "ground")
        arm = next(n for n in self.bodies[first] if n != pivot)
        others = self.ground if second == "ground" else self.bodies[second]
        reference = next(n for n in others if n != pivot)
        turn = self.random.choice([-1, 1]) * self.random.uniform(5, 60)
        self.actuators = {
            "motor": {"type": "rotary", "pivot": pivot, "arm": arm, "reference": reference, "law": {"by": turn}}
        }

    def drive_linear(self, drive):
        """Drive a length instead of the crank: the distance of two nodes, or the travel of a slider."""
        crank = self.actuators["motor"]["arm"]
        sliders = [p for p in self.pairs.values() if "node" in p]
        if drive == "travel" and sliders:  # an offset of the line does not change the travel
            slide = self.random.choice(sliders)
            self.actuators = {"motor": {"type": "linear", "node": slide["node"], "guide": slide["guide"]}}
        else:
            moving = [n for n in self.nodes if "ground" not in self.at[n]]
            end = self.random.choice(moving or [crank])
            self.actuators = {"motor": {"type": "linear", "nodes": [self.ground[2], end]}}
        reach = self.drawn_value() if "nodes" in self.actuators["motor"] else 1.0
        self.actuators["motor"]["law"] = {"by": self.random.choice([-1, 1]) * self.random.uniform(0.01, 0.1) * reach}

    def drawn_value(self):
        """Return the value of the only drive in the known position."""
        return self.drawn_value_of(self.actuators["motor"])

    def drawn_value_of(self, motor):
        """Return the value of a drive in the known position, in deg or as a length."""
        if "pivot" in motor:
            turn = self.place(motor["arm"]) - self.place(motor["pivot"])
            if "reference" in motor:
                turn /= self.place(motor["reference"]) - self.place(motor["pivot"])
            return math.degrees(cmath.phase(turn))
        if "nodes" in motor:
            a, b = motor["nodes"]
            return abs(self.place(b) - self.place(a))
        u, v = (self.place(n) for n in motor["guide"])
        return ((self.place(motor["node"]) - u) * (v - u).conjugate()).real / abs(v - u)

    def explicit(self, noise, seed=0):
        """Return the data of the model file with all dimensions, and coordinates disturbed by `noise`.

        `self.nodes` is the known position at the start of the law.
        """
        spec, shake = self.model(), random.Random(seed)
        spec["links"] = {
            k: {"nodes": v, "length": abs(self.place(v[1]) - self.place(v[0]))} for k, v in spec["links"].items()
        }
        spec["elements"] = {
            k: {"nodes": v, "shape": {n: list(self.nodes[n]) for n in v}} for k, v in spec["elements"].items()
        }
        start = self.drawn_value()
        motor = dict(self.actuators["motor"])
        motor["law"] = {"from": start, "to": start + motor["law"]["by"]}
        spec["actuators"] = {"motor": motor}
        spec["nodes"] = {
            n: z if n in self.ground else [v + noise * shake.uniform(-1, 1) for v in z] for n, z in self.nodes.items()
        }
        return spec

    def model(self):
        """Return the data of the model file."""
        return {
            "units": {"length": "unit"},
            "nodes": self.nodes,
            "ground": self.ground,
            "links": {k: v for k, v in self.bodies.items() if len(v) == 2},
            "elements": {k: v for k, v in self.bodies.items() if len(v) > 2},
            "prismatic": self.pairs,
            "actuators": self.actuators,
        }
