"""Loop equations of linkages from links and joints, without code of the package."""

from __future__ import annotations

import numpy as np

FRAME = 0


def loops_of(links, revolute, prismatic=()):
    """Return C0, C, U, rail of a linkage.

    `links` is a list of {label: local point}, the frame first. `revolute` lists (link, label, link, label).
    `prismatic` lists (link a, label, direction in a, link b, label, angle of b from a): the point of b is on a line
    through the point of a, and b rotates with a. Angles are numbered by link; links of a prismatic pair have one angle.
    """
    owner, turn = list(range(len(links))), np.zeros(len(links))
    for a, _, _, b, _, angle in prismatic:  # b turns with a
        root = owner[b]
        base = turn[a] + angle - turn[b]
        for k in range(len(links)):
            if owner[k] == root:
                owner[k], turn[k] = owner[a], turn[k] + base
    if owner[FRAME] != FRAME:
        raise ValueError("name the frame first in a prismatic pair")
    classes = sorted(set(owner) - {FRAME})
    column = {c: i for i, c in enumerate(classes)}
    n, q = len(classes), len(prismatic)

    def vector(link, z):
        out = np.zeros(1 + n + q, dtype=complex)
        out[0 if owner[link] == FRAME else 1 + column[owner[link]]] = z * np.exp(1j * turn[link])
        return out

    edges = [(a, links[a][p], b, links[b][r], None) for a, p, b, r in revolute]
    edges += [(a, links[a][p], b, links[b][r], k) for k, (a, p, _, b, r, _) in enumerate(prismatic)]

    def step(edge):
        """Return the origin of b minus the origin of a."""
        a, za, b, zb, slide = edge
        out = vector(a, za) - vector(b, zb)
        if slide is not None:
            out[1 + n + slide] = prismatic[slide][2] * np.exp(1j * turn[a])
        return out

    place, rest, grown = {FRAME: np.zeros(1 + n + q, dtype=complex)}, list(edges), True
    while grown:
        grown = False
        for edge in list(rest):
            a, _, b, _, _ = edge
            if (a in place) != (b in place):
                if a in place:
                    place[b] = place[a] + step(edge)
                else:
                    place[a] = place[b] - step(edge)
                rest.remove(edge)
                grown = True
    rows = np.array([place[e[0]] + step(e) - place[e[2]] for e in rest])
    rail = np.array([-1 if owner[p[0]] == FRAME else column[owner[p[0]]] for p in prismatic], dtype=int)
    return rows[:, 0], rows[:, 1 : 1 + n], rows[:, 1 + n :], rail


def framework(edges):
    """Return C0, C, U, rail of bars {(vertex, vertex): length}; the first bar is the frame, along +x."""
    links = [{a: 0.0, b: length} for (a, b), length in edges.items()]
    first, joints = {}, []
    for k, link in enumerate(links):
        for vertex in link:
            if vertex in first:
                joints.append((first[vertex], vertex, k, vertex))
            first.setdefault(vertex, k)
    return loops_of(links, joints)


def random_loops(loops, slides, rng, reach=3.0):
    """Return C0, C, U, rail of random dense loops, and a solution with slides within `reach`."""
    n = 2 * loops - slides
    C = rng.normal(size=(loops, n)) + 1j * rng.normal(size=(loops, n))
    U = rng.normal(size=(loops, slides)) + 1j * rng.normal(size=(loops, slides))
    rail = rng.integers(-1, n, size=slides)
    angles, s = rng.uniform(-np.pi, np.pi, n), rng.uniform(-reach, reach, slides)
    theta = np.append(np.exp(1j * angles), 1.0)
    return -(C @ theta[:n] + U @ (s * theta[rail])), C, U, rail, np.concatenate([angles, s])
