"""Random assemblable mechanisms: built from a random position, so that the drawing fits exactly."""

import random


class Growth:
    """A mechanism that grows group by group from a crank."""

    def __init__(self, seed, groups):
        self.random = random.Random(seed)
        self.nodes, self.bodies, self.at, self.pairs = {}, {}, {}, {}
        self.ground = [self.node() for _ in range(5)]
        for name in self.ground:
            self.at[name] = {"ground"}
        crank = self.node()
        self.body([self.ground[0], crank, *self.maybe(1)])
        turn = self.random.choice([-1, 1]) * self.random.uniform(20, 200)
        self.actuators = {"motor": {"type": "rotary", "pivot": self.ground[0], "arm": crank, "law": {"by": turn}}}
        for _ in range(groups):
            self.random.choice([self.rrr, self.rrr, self.rrp, self.rpr, self.triad, self.true_pair])()
        if self.random.random() < 0.5:
            self.drive_elsewhere()

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

    def model(self):
        """Return the model file's data."""
        return {
            "units": {"length": "unit"},
            "nodes": self.nodes,
            "ground": self.ground,
            "links": {k: v for k, v in self.bodies.items() if len(v) == 2},
            "elements": {k: v for k, v in self.bodies.items() if len(v) > 2},
            "prismatic": self.pairs,
            "actuators": self.actuators,
        }
