"""Mechanisms from link graphs (which links share a joint), with random coordinates, which are one configuration."""

import random
import tempfile
from itertools import combinations, permutations
from pathlib import Path

import yaml

from gimcli import load


def loaded(spec):
    """Return the mechanism of a model file's data."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.yaml"
        path.write_text(yaml.safe_dump({"units": {"length": "unit"}, **spec}, sort_keys=False))
        return load(path)


def truss(joints, seed=0, ground=0):
    """Return the model of a structure with random coordinates of its joints (sets of two or more links)."""
    place = random.Random(seed)
    nodes = {f"n{k}": [place.uniform(-1, 1), place.uniform(-1, 1)] for k in range(len(joints))}
    links = sorted({link for joint in joints for link in joint})
    at = {link: [f"n{k}" for k, joint in enumerate(joints) if link in joint] for link in links}
    moving = [link for link in links if link != ground]
    return {
        "nodes": nodes,
        "ground": at[ground],
        "links": {f"b{k}": at[k] for k in moving if len(at[k]) == 2},
        "elements": {f"b{k}": at[k] for k in moving if len(at[k]) > 2},
    }


def bars(edges, ground, lengths=None, seed=0):
    """Return the model of a framework of bars, one of them fixed; `lengths` by edge, by default random."""
    place = random.Random(seed)
    names = sorted({n for e in edges for n in e})
    nodes = {f"v{n}": [place.uniform(-1, 1), place.uniform(-1, 1)] for n in names}
    if lengths:
        nodes[f"v{ground[0]}"], nodes[f"v{ground[1]}"] = [0.0, 0.0], [lengths[ground], 0.0]
    links = {}
    for a, b in edges:
        if (a, b) != ground:
            links[f"e{a}{b}"] = {"nodes": [f"v{a}", f"v{b}"], **({"length": lengths[a, b]} if lengths else {})}
    return {"nodes": nodes, "ground": [f"v{n}" for n in ground], "links": links}


def baranov_trusses(loops):
    """Return the joints of all Baranov trusses with a number of loops, up to isomorphism.

    Links with three or more joints are the vertices of a multigraph with `loops` - 1 more edges than vertices; an edge
    is a joint, or a bar. Only the whole truss is rigid, no part of two or more links: k links have fewer than
    3 (k - 1) / 2 joints between them. With 5, 7 and 9 links there are 1, 3 and 28 trusses.
    """
    found = {}
    for vertices in range(2, 2 * loops - 1):
        edges, count = vertices + loops - 1, 2 * loops + 1 - vertices
        if count <= edges:
            for base in _multigraphs(vertices, edges):
                for chosen in combinations(range(edges), count):
                    marked = [(a, b, k in chosen) for k, (a, b) in enumerate(base)]
                    if len({e[:2] for e in marked if not e[2]}) == edges - count:
                        joints = _joints(marked, vertices)
                        if _irreducible(joints):
                            found.setdefault((vertices, _canonical(marked, vertices)), joints)
    return list(found.values())


def _multigraphs(vertices, edges):
    """Return multigraphs without loops and with at least three edges at every vertex, up to isomorphism."""
    pairs = list(combinations(range(vertices), 2))
    found = {}

    def grow(first, chosen):
        if len(chosen) == edges:
            degree = [sum(v in e for e in chosen) for v in range(vertices)]
            if min(degree) >= 3 and degree == sorted(degree):
                found.setdefault(_canonical([(*e, False) for e in chosen], vertices), tuple(chosen))
            return
        for k in range(first, len(pairs)):
            if all(_room(v, [*chosen, pairs[k]], vertices, edges) for v in pairs[k]):
                grow(k, [*chosen, pairs[k]])

    grow(0, [])
    return list(found.values())


def _room(vertex, chosen, vertices, edges):
    """Return whether the other vertices can still get three edges each."""
    return sum(vertex in e for e in chosen) <= 2 * edges - 3 * (vertices - 1)


def _canonical(marked, vertices):
    degree = [sum(v in e[:2] for e in marked) for v in range(vertices)]
    best = None
    for order in permutations(range(vertices)):
        if [degree[v] for v in sorted(range(vertices), key=order.__getitem__)] == sorted(degree):
            form = sorted((*sorted((order[a], order[b])), bar) for a, b, bar in marked)
            best = form if best is None or form < best else best
    return tuple(best)


def _joints(marked, vertices):
    joints, bar = [], vertices
    for a, b, between in marked:
        joints += [(a, bar), (bar, b)] if between else [(a, b)]
        bar += between
    return joints


def _irreducible(joints):
    links = 1 + max(v for joint in joints for v in joint)
    near = [0] * links
    for a, b in joints:
        near[a] |= 1 << b
        near[b] |= 1 << a
    for part in range(1, (1 << links) - 1):
        size = part.bit_count()
        inside = sum((near[v] & part).bit_count() for v in range(links) if part >> v & 1) // 2
        if size > 1 and 2 * inside >= 3 * (size - 1):
            return False
    return True


def watt_baranov(loops):
    """Return the joints of a central link, links around it, and bars between neighbours: 2 loops + 1 links."""
    ring = range(1, loops + 1)
    joints = [(0, k) for k in ring]
    for k in ring:
        joints += [(k, loops + k), (loops + k, k % loops + 1)]
    return joints
