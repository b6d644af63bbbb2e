"""Mechanisms drawn where branches meet, with the freedoms and drives of every branch from closed forms.

Cranks on one line, all of one length a and drawn along this line: two neighbours with a coupler are equal cranks of a
parallelogram (equal angles), of an antiparallelogram, and, where the pivots are a apart (a rhombus), the first crank
may stand still while the other turns about its end. A kite whose crank lies on its frame has two branches: both pairs
of equal sides turn, or only the longer or shorter pair about the common end of crank and frame. Links in line between
fixed points, or between two points of one member, have an infinitesimal freedom only.
"""

import itertools
import random


class Drawing:
    """Nodes and links that are added, turned and moved at the end."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.nodes, self.ground, self.links, self.elements, self.motors = {}, [], {}, {}, {}

    def node(self, name, place, ground=False):
        self.nodes[name] = complex(place)
        self.ground += [name] * ground
        return name

    def link(self, *nodes):
        self.links["".join(nodes)] = list(nodes)

    def crank(self, k, pivot, end):
        self.node(f"A{k}", pivot, ground=True)
        self.node(f"B{k}", end)
        self.link(f"A{k}", f"B{k}")

    def motor(self, k=0):
        self.motors["motor"] = {"pivot": f"A{k}", "arm": f"B{k}"}

    def data(self):
        """Return the model (a dictionary) in a random frame, with nodes and links in random order."""
        turn = complex(self.random.gauss(0, 1), self.random.gauss(0, 1))
        shift = complex(self.random.uniform(-3, 3), self.random.uniform(-3, 3))
        z = {name: shift + turn * place for name, place in self.mixed(self.nodes).items()}
        return {
            "nodes": {name: [place.real, place.imag] for name, place in z.items()},
            "ground": self.ground,
            "links": self.mixed(self.links),
            **({"elements": self.elements} if self.elements else {}),
            **({"actuators": self.motors} if self.motors else {}),
        }

    def mixed(self, parts):
        names = list(parts)
        self.random.shuffle(names)
        return {name: parts[name] for name in names}


def verdict(mobility, undriven=(), overdriven=()):
    return mobility, frozenset(undriven), frozenset(overdriven)


def cranks(drawing, count, a, sense, gap):
    pivots = [0.0]
    for _ in range(count - 1):
        pivots.append(pivots[-1] + gap())
    for k, x in enumerate(pivots):
        drawing.crank(k, x, x + sense * a)
    return pivots


def chain_of_parallelograms(seed):
    """Pivots are more than a apart: every branch has mobility 1, and its cranks all turn."""
    d = Drawing(seed)
    count, a, sense = d.random.randint(2, 5), d.random.choice([0.9, 1.0, 1.3]), d.random.choice([1, -1])
    cranks(d, count, a, sense, lambda: a * d.random.uniform(1.2, 3.0))
    for k in range(count - 1):
        d.link(f"B{k}", f"B{k + 1}")
    if d.random.random() < 0.7:
        d.motor(d.random.randrange(count))
        return d, {verdict(1)}
    return d, {verdict(1, [f"B{k}" for k in range(count)])}


def chain_of_rhombi(seed):
    """Pivots are a apart: cranks 0 to k - 1 are still and the others turn together, for each k."""
    d = Drawing(seed)
    count, a = d.random.randint(2, 4), d.random.choice([0.9, 1.0, 1.3])
    cranks(d, count, a, 1, lambda: a)
    for k in range(count - 1):
        d.link(f"B{k}", f"B{k + 1}")
    driven = d.random.randrange(count)
    d.motor(driven)
    free = [[f"B{j}" for j in range(k, count)] for k in range(count)]
    return d, {verdict(1) if k <= driven else verdict(1, free[k], ["motor"]) for k in range(count)}


def cranks_with_one_coupler(seed):
    """Fraczek & Wojtyra, example 1.12: three or more equal cranks and one coupler, drawn in line."""
    d = Drawing(seed)
    count, a, sense = d.random.randint(3, 5), d.random.choice([0.9, 1.0, 1.3]), d.random.choice([1, -1])
    gaps = [1.0] * (count - 1) if d.random.random() < 0.5 else [d.random.uniform(0.5, 2.0) for _ in range(count - 1)]
    cranks(d, count, a, sense, iter(gaps).__next__)
    d.elements["coupler"] = [f"B{k}" for k in range(count)]
    if d.random.random() < 0.7:
        d.motor(d.random.randrange(count))
        return d, {verdict(1)}
    return d, {verdict(1, [f"B{k}" for k in range(count)])}


def folded_kite(seed):
    """Return a kite whose crank lies on the frame, both of length a; the sides b are drawn in line too."""
    d = Drawing(seed)
    a, b = 1.0, d.random.choice([0.6, 1.7])
    d.crank(0, 0.0, a)
    d.node("D", a, ground=True)
    d.node("C", a + d.random.choice([b, -b]))
    d.link("B0", "C")
    d.link("D", "C")
    return d


def kite(seed):
    """On the second branch the crank stands still, and nothing drives C."""
    d = folded_kite(seed)
    d.motor()
    return d, {verdict(1), verdict(1, ["C"], ["motor"])}


def kite_driven_at_the_still_side(seed):
    """With the motor on a side b both branches move it, and on the second one the crank rests."""
    d = folded_kite(seed)
    d.motors["motor"] = {"pivot": "D", "arm": "C"}
    return d, {verdict(1)}


def rocker_at_its_extreme(seed):
    """The crank of a flat parallelogram or kite is the rocker of a crank-rocker at its extreme: branches touch."""
    d = Drawing(seed)
    a, crank, coupler, folded = 1.0, d.random.uniform(0.2, 0.4), d.random.uniform(1.5, 2.5), d.random.random() < 0.5
    along = complex(d.random.uniform(-0.5, 0.5), d.random.choice([1.0, -1.0]))
    along /= abs(along)
    d.crank(0, 0.0, a)
    d.node("O", a + (coupler + crank) * along, ground=True)
    d.node("Q", a + coupler * along)
    d.link("O", "Q")
    d.link("Q", "B0")
    d.node("D", a if folded else 1.7, ground=True)
    d.node("C", a + 0.6 if folded else 2.7)
    d.link("B0", "C")
    d.link("D", "C")
    d.motors["motor"] = {"pivot": "O", "arm": "Q"}
    return d, {verdict(1), *([verdict(1, ["C"], ["motor"])] if folded else [])}


def stretched_chain(seed):
    """Links in line whose lengths add up to the distance of the pivots: a structure with an infinitesimal freedom."""
    d = Drawing(seed)
    count = d.random.randint(1, 3)
    places = [0.0]
    for _ in range(count + 1):
        places.append(places[-1] + d.random.uniform(0.5, 2.0))
    names = [d.node(f"P{k}", x, ground=k in (0, count + 1)) for k, x in enumerate(places)]
    for one, other in itertools.pairwise(names):
        d.link(one, other)
    return d, {verdict(0)}


def four_bar_with_a_node_in_line(seed):
    """A crank-rocker and, on its coupler, a node held by two links in line: mobility 1, two apparent freedoms."""
    d = Drawing(seed)
    d.crank(0, 0.0, 1j)
    d.node("D", 4.0, ground=True)
    d.node("C", 3 + 3j)
    d.link("D", "C")
    d.link("B0", "C")
    at = d.random.uniform(0.2, 0.8)
    d.node("P", (1 - at) * 1j + at * (3 + 3j))
    d.link("B0", "P")
    d.link("P", "C")
    d.motor()
    return d, {verdict(1)}


def platform_of_three_legs(seed):
    """3-RRR with equal legs, drawn in line with a flat platform: three freedoms, three motors on the legs."""
    d = Drawing(seed)
    leg, ends = d.random.choice([1.0, 1.5]), []
    for k, x in enumerate((0.0, d.random.uniform(1.0, 2.0), d.random.uniform(2.5, 4.0))):
        d.crank(k, x, x + leg)
        ends.append(d.node(f"C{k}", x + (2.0 if d.random.random() < 0.5 else 1.6) * leg))
        d.link(f"B{k}", f"C{k}")
        d.motors[f"m{k}"] = {"pivot": f"A{k}", "arm": f"B{k}"}
    d.elements["platform"] = ends
    return d, {verdict(3)}


def platform_of_struts(seed):
    """3-RPR: base and platform congruent, struts equal and parallel: three freedoms, three driven lengths."""
    d = Drawing(seed)
    flat = d.random.choice([0.0, 1.0])  # 0: all in line
    base = [complex(d.random.uniform(-2, 2), flat * d.random.uniform(-2, 2)) for _ in range(3)]
    strut = complex(d.random.uniform(1, 2), flat * d.random.uniform(-1, 1))
    for k, place in enumerate(base):
        d.node(f"A{k}", place, ground=True)
        d.node(f"C{k}", place + strut)
        d.motors[f"s{k}"] = {"type": "linear", "nodes": [f"A{k}", f"C{k}"]}
    d.elements["platform"] = ["C0", "C1", "C2"]
    return d, {verdict(3)}


KINDS = (
    chain_of_parallelograms, chain_of_rhombi, cranks_with_one_coupler, kite, kite_driven_at_the_still_side,
    rocker_at_its_extreme, stretched_chain, four_bar_with_a_node_in_line, platform_of_three_legs, platform_of_struts,
)  # fmt: skip


def symmetrical(seed):
    """Return name, model and the different verdicts (mobility, undriven nodes, surplus actuators) of its branches."""
    kind = KINDS[seed % len(KINDS)]
    drawing, branches = kind(seed)
    return kind.__name__, drawing.data(), branches
