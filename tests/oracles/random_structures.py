"""Random structures, and their mobility and drives by instantaneous kinematics: each body has three velocities.

This uses definitions only: two bodies have the same velocity at a pin, a pin in a slot has no velocity across it, and a
linear actuator changes its length by the relative velocity along it. Positions are random, hence regular.
"""

import random
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import maximum_bipartite_matching

GROUND = "ground"
PARTS = ("crank", "dyad", "slider", "slotted", "block", "triad", "rigid", "loop", "parallel", "brace", "loose")


class Structure:
    """A structure to which parts are added; it has as many drives as freedoms, sometimes one less or more."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.place, self.bodies, self.slides, self.drives = {}, {GROUND: []}, {}, {}
        for _ in range(3):
            self.node([GROUND])
        self.crank()
        for _ in range(self.random.randint(1, 4)):
            getattr(self, self.random.choice(PARTS))()
        self.drive()

    # -- parts ---------------------------------------------------------------------------------

    def node(self, bodies=(), place=None):
        name = f"n{len(self.place)}"
        self.place[name] = complex(self.random.uniform(-2, 2), self.random.uniform(-2, 2)) if place is None else place
        for body in bodies:
            self.bodies[body].append(name)
        return name

    def body(self, *names):
        key = f"b{len(self.bodies)}"
        self.bodies[key] = list(names)
        if self.random.random() < 0.3:  # a node that only this member has
            self.node([key])
        return key

    def at(self, node):
        return [key for key, names in self.bodies.items() if node in names]

    def apart(self, count):
        """Return random nodes of different members; None if two belong to the same member."""
        chosen = self.random.sample(sorted(self.place), min(count, len(self.place)))
        shared = any(set(self.at(a)) & set(self.at(b)) for k, a in enumerate(chosen) for b in chosen[:k])
        return None if shared or len(chosen) < count else chosen

    def guide(self):
        key = self.random.choice([k for k, names in self.bodies.items() if len(names) > 1])
        return key, *self.random.sample(self.bodies[key], 2)

    def slide(self, nodes, key, u, v):
        self.slides[f"s{len(self.slides)}"] = (tuple(nodes), key, u, v)

    def crank(self):
        self.body(self.random.choice(self.bodies[GROUND]), self.node())

    def dyad(self):
        if ends := self.apart(2):
            new = self.node()
            for end in ends:
                self.body(end, new)

    def slider(self):
        key, u, v = self.guide()
        if (ends := self.apart(1)) and key not in self.at(ends[0]):
            new = self.node()
            self.body(ends[0], new)
            self.slide([new], key, u, v)

    def slotted(self):
        if ends := self.apart(2):
            new = self.node()
            self.slide([ends[1]], self.body(ends[0], new), ends[0], new)

    def block(self):
        """Add a member that slides with two pins on one guide."""
        key, u, v = self.guide()
        along, shift = self.place[v] - self.place[u], self.random.uniform(-0.5, 0.5)
        pins = [self.node(place=self.place[u] + along * (part + 1j * shift)) for part in (0.2, 0.9)]
        self.body(*pins)
        self.slide(pins, key, u, v)

    def triad(self):
        if ends := self.apart(3):
            new = [self.node() for _ in ends]
            self.body(*new)
            for a, b in zip(ends, new, strict=True):
                self.body(a, b)

    def rigid(self):
        """Connect two nodes to a member by five links, one of them redundant."""
        _, u, v = self.guide()
        new = [self.node(), self.node()]
        for end in (u, v):
            for other in new:
                self.body(end, other)
        self.body(*new)

    def loop(self):
        """Add a closed loop of four links at one node."""
        ring = [self.random.choice(sorted(self.place)), *(self.node() for _ in range(3))]
        for a, b in zip(ring, [*ring[1:], ring[0]], strict=True):
            self.body(a, b)

    def parallel(self):
        """Add a coupler on three to five parallel cranks: one to three constraints are redundant."""
        arm, count = complex(self.random.uniform(0.5, 1), self.random.uniform(0.5, 1)), self.random.randint(3, 5)
        feet = [self.node([GROUND]) for _ in range(count)]
        tips = [self.node(place=self.place[foot] + arm) for foot in feet]
        self.body(*tips)
        for foot, tip in zip(feet, tips, strict=True):
            self.body(foot, tip)

    def brace(self):
        if ends := self.apart(2):
            self.body(*ends)

    def loose(self):
        """Add a pin without a member in a slot."""
        self.slide([self.node()], *self.guide())

    # -- drives --------------------------------------------------------------------------------

    def drive(self):
        freedoms = self.columns[1] - rank(self.constraints())
        count = max(0, freedoms + self.random.choice([-1, 0, 0, 0, 0, 1]))
        table = self.constraints()
        for k in range(min(count, 6)):
            wanted = self.random.random() < 0.9  # drive a freedom that is not driven yet
            for _ in range(12 if wanted else 1):
                drive = self.some_drive()
                more = np.vstack([table, self.driven(*drive)])
                if not wanted or rank(more) > rank(table):
                    break
            self.drives[f"d{k}"], table = drive, more

    def some_drive(self):
        kind = self.random.choice(["turn", "turn", "ram", "travel"])
        single = [s for s in self.slides.values() if len(s[0]) == 1]
        if kind == "travel" and single:
            (node,), key, u, v = self.random.choice(single)
            return ("travel", node, key, u, v)
        pivots = [n for n in self.place if len(self.at(n)) > 1]
        if kind != "ram" or not (ends := next(filter(None, (self.apart(2) for _ in range(20))), None)):
            pivot = self.random.choice(pivots)
            reference, arm = sorted(self.random.sample(self.at(pivot), 2), key=lambda k: k != GROUND)
            return ("turn", pivot, *(next(n for n in self.bodies[key] if n != pivot) for key in (arm, reference)))
        return ("ram", *ends)

    # -- the oracle ----------------------------------------------------------------------------

    @cached_property
    def columns(self):
        """The first columns of the velocities of every member and of every pin without a member, and their number."""
        width, table = 0, {}
        for key in self.bodies:
            if key != GROUND:
                table[key], width = width, width + 3
        for node in self.place:
            if not self.at(node):
                table[node], width = width, width + 2
        return table, width

    def velocity(self, node, key=None):
        """Return rows (2, columns) of the velocity of a node, or of the point of the member `key` at this node."""
        table, width = self.columns
        key = key or (self.at(node) or [node])[0]
        rows = np.zeros((2, width))
        if key != GROUND:
            first = table[key]
            rows[:, first : first + 2] = np.eye(2)
            if key in self.bodies:
                rows[:, first + 2] = -self.place[node].imag, self.place[node].real
        return rows

    def turning(self, key):
        table, width = self.columns
        row = np.zeros(width)
        if key != GROUND:
            row[table[key] + 2] = 1.0
        return row

    def relative(self, node, key, along):
        rows = self.velocity(node) - self.velocity(node, key)
        return (along.real * rows[0] + along.imag * rows[1]) / abs(along)

    def constraints(self):
        rows = []
        for node in self.place:
            first, *others = self.at(node) or [node]
            for other in others:
                rows += list(self.velocity(node, first) - self.velocity(node, other))
        for nodes, key, u, v in self.slides.values():
            rows += [self.relative(n, key, 1j * (self.place[v] - self.place[u])) for n in nodes]
        return np.array(rows).reshape(len(rows), self.columns[1])

    def driven(self, kind, *nodes):
        if kind == "ram":
            a, b = nodes
            along, rows = self.place[b] - self.place[a], self.velocity(b) - self.velocity(a)
            return (along.real * rows[0] + along.imag * rows[1]) / abs(along)
        if kind == "travel":
            node, key, u, v = nodes
            return self.relative(node, key, self.place[v] - self.place[u])
        pivot, arm, reference = nodes
        shared = [next(k for k in self.at(pivot) if end in self.bodies[k]) for end in (arm, reference)]
        return self.turning(shared[0]) - self.turning(shared[1])

    def oracle(self):
        """Return mobility, redundant constraints, over-driving actuators and undriven nodes."""
        table, names = self.constraints(), list(self.drives)
        mobility, over = table.shape[1] - rank(table), []
        redundant = len(table) - rank(table)
        for name in names:
            more = np.vstack([table, self.driven(*self.drives[name])])
            if rank(more) == rank(table):
                over.append(name)
            table = more
        _, s, v = np.linalg.svd(table)
        null = v[int(np.sum(s > 1e-9)) :].T
        loose = [n for n in self.place if np.max(np.abs(self.velocity(n) @ null), initial=0.0) > 1e-7]
        matched = maximum_bipartite_matching(csr_array(np.abs(table) > 1e-12))
        return {
            "mobility": mobility, "redundant": redundant, "overdriven": over, "undriven": loose,
            "unmatched": table.shape[1] - int(np.sum(matched >= 0)),
        }  # fmt: skip

    # -- the model file ------------------------------------------------------------------------

    def data(self, noise=0.0):
        """Return the data of the model file; with `noise` the coordinates are disturbed and all dimensions written."""
        shake = random.Random(1)
        pairs = {k: [z.real, z.imag] for k, z in self.place.items()}
        moving = {k: names for k, names in self.bodies.items() if k != GROUND}
        links = {k: {"nodes": n, "length": abs(self.place[n[1]] - self.place[n[0]])} for k, n in moving.items()}
        drawn = {
            n: z if n in self.bodies[GROUND] else [v + noise * shake.uniform(-1, 1) for v in z]
            for n, z in pairs.items()
        }  # fmt: skip
        return {
            "units": {"length": "unit"}, "nodes": drawn, "ground": self.bodies[GROUND],
            "links": {k: link for k, link in links.items() if len(link["nodes"]) == 2},
            "elements": {
                k: {"nodes": n, "shape": {m: pairs[m] for m in n}} for k, n in moving.items() if len(n) > 2
            },
            "prismatic": {k: self.pair(*s) for k, s in self.slides.items()},
            "actuators": {k: self.actuator(*d) for k, d in self.drives.items()},
        }  # fmt: skip

    def pair(self, nodes, _key, u, v):
        along = (self.place[v] - self.place[u]) / abs(self.place[v] - self.place[u])
        offset = ((self.place[nodes[0]] - self.place[u]) * (1j * along).conjugate()).real
        return {
            **({"node": nodes[0]} if len(nodes) == 1 else {"nodes": list(nodes)}),
            "guide": [u, v],
            "offset": offset,
        }

    def actuator(self, kind, *nodes):
        if kind == "ram":
            return {"type": "linear", "nodes": list(nodes), "law": {"by": 0.001}}
        if kind == "travel":
            return {"type": "linear", "node": nodes[0], "guide": [nodes[2], nodes[3]], "law": {"by": 0.001}}
        return {"type": "rotary", "pivot": nodes[0], "arm": nodes[1], "reference": nodes[2], "law": {"by": 0.05}}


def rank(table):
    return int(np.sum(np.linalg.svd(table, compute_uv=False) > 1e-9)) if table.size else 0
