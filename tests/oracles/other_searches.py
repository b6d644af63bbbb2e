"""Configurations of mechanisms by independent methods, for comparison with the lists of the package.

Three methods: the closure of a platform with three legs as one polynomial of degree six; Gauss-Newton in absolute
coordinates from many random starts (without a proof); and loops of a mechanism, written by the rules of the tests and
solved by interval branch and prune, which proves that the list is complete.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from gimcli.mechanism import SPAN

# ------------------------------------------------------------------ a platform with three legs


def platform_turns(base, plate, legs):
    """Return all solutions z = e^{iφ}, also complex φ, of a plate on three legs: six, fewer if degenerate.

    P' is the vector from the first base joint to the first joint of the plate, d_k = z c_k - g_k. |P'| = l_1 and
    |P' + d_k| = l_k give two linear equations for P', and |d_2 h_3 - d_3 h_2|² = (l_1 Im(d̄_2 d_3))², of degree 3 in
    z and 1/z.
    Source: Gosselin, Sefrioui & Richard, Solutions polynomiales au problème de la cinématique directe, 1992.
    """
    base, plate, legs = (np.asarray(v) for v in (base, plate, legs))
    c, g = plate[1:] - plate[0], base[1:] - base[0]
    z = np.exp(2j * np.pi * np.arange(8) / 8)
    d = c[:, None] * z - g[:, None]
    h = 0.5 * (legs[1:, None] ** 2 - legs[0] ** 2 - np.abs(d) ** 2)
    closure = np.abs(d[0] * h[1] - d[1] * h[0]) ** 2 - (legs[0] * (np.conj(d[0]) * d[1]).imag) ** 2
    laurent = np.fft.fft(closure) / 8  # coefficient of z^k at k mod 8
    return np.roots([laurent[k] for k in range(3, -4, -1)])


def platform_angles(base, plate, legs, tolerance=1e-7):
    """Return the angles of the plate [rad] in the real configurations, sorted."""
    z = platform_turns(base, plate, legs)
    return np.sort(np.angle(z[np.abs(np.abs(z) - 1) < tolerance]))


# ------------------------------------------------------------------ absolute coordinates


class Absolute:
    """Residuals in absolute coordinates: positions and angles of moving members, positions of nodes without member."""

    def __init__(self, mechanism, inputs):
        self.mechanism, self.inputs = mechanism, np.asarray(inputs, dtype=float)
        self.members = len(mechanism.members) - 1
        self.owner, shared = {}, defaultdict(list)
        for k, member in enumerate(mechanism.members):
            for node in member.nodes:
                (shared[node].append(k) if node in self.owner else self.owner.setdefault(node, k))
        self.shared = dict(shared)
        self.loose = [n for n in range(len(mechanism.nodes)) if n not in self.owner]
        self.unknowns = 3 * self.members + 2 * len(self.loose)

    def random(self, count, rng):
        """Return random starts (count, unknowns) in a square of three times the size."""
        x = rng.uniform(-1.5, 1.5, (count, self.unknowns)) * self.mechanism.size
        x[:, 2 : 3 * self.members : 3] = rng.uniform(-np.pi, np.pi, (count, self.members))
        return x

    def _poses(self, x):
        m = self.members
        origin = np.concatenate([np.zeros((len(x), 1)), x[:, 0 : 3 * m : 3] + 1j * x[:, 1 : 3 * m : 3]], axis=1)
        angle = np.concatenate([np.zeros((len(x), 1)), x[:, 2 : 3 * m : 3]], axis=1)
        return origin, angle

    def _in(self, poses, member, node):
        origin, angle = poses
        return origin[:, member] + np.exp(1j * angle[:, member]) * self.mechanism.members[member].local(node)

    def nodes(self, x):
        """Return positions (count, nodes)."""
        poses = self._poses(x)
        z = np.zeros((len(x), len(self.mechanism.nodes)), dtype=complex)
        for node, member in self.owner.items():
            z[:, node] = self._in(poses, member, node)
        for k, node in enumerate(self.loose):
            z[:, node] = x[:, 3 * self.members + 2 * k] + 1j * x[:, 3 * self.members + 2 * k + 1]
        return z

    def residuals(self, x):
        """Return residuals (count, equations), lengths and angles."""
        poses, z, rows = self._poses(x), self.nodes(x), []
        origin, angle = poses
        for node, members in self.shared.items():
            for member in members:
                gap = self._in(poses, member, node) - z[:, node]
                rows += [gap.real, gap.imag]
        for s in self.mechanism.slides:
            turn = np.exp(1j * angle[:, s.guide])
            rows.append((np.conj(s.along * turn) * (z[:, s.node] - origin[:, s.guide] - turn * s.point)).imag)
        for a, value in zip(self.mechanism.actuators, self.inputs, strict=True):
            turn = np.exp(1j * angle[:, a.guide])
            if a.rotary:
                offset = np.angle(a.arm) - np.angle(a.reference) - value
                turned = angle[:, a.members[0]] - angle[:, a.guide] + offset
                rows.append((turned + np.pi) % (2 * np.pi) - np.pi)
            elif a.kind == SPAN:
                rows.append(np.abs(z[:, a.node] - z[:, a.nodes[1]]) - value)
            else:
                along = np.conj(a.normal * turn) * (z[:, a.node] - origin[:, a.guide] - turn * a.point)
                rows.append(along.real - value)
        return np.array(rows).T

    def jacobians(self, x, step=1e-7):
        """Return Jacobians by differences (count, equations, unknowns)."""
        columns = []
        for k in range(self.unknowns):
            move = np.zeros(self.unknowns)
            move[k] = step
            columns.append((self.residuals(x + move) - self.residuals(x - move)) / (2 * step))
        return np.stack(columns, axis=2)


def configurations_by_starts(mechanism, inputs, starts=3000, seed=0, iterations=60):
    """Return the configurations (K, nodes) to which Gauss-Newton converges from random starts, in the normal frame."""
    system, rng = Absolute(mechanism, inputs), np.random.default_rng(seed)
    x = system.random(starts, rng)
    for _ in range(iterations):
        f, J = system.residuals(x), system.jacobians(x)
        damping = 1e-3 * np.minimum(1.0, (f * f).sum(axis=1))[:, None, None]
        normal = np.swapaxes(J, 1, 2) @ J + (damping + 1e-14) * np.eye(system.unknowns)
        step = np.linalg.solve(normal, np.swapaxes(J, 1, 2) @ f[:, :, None])[:, :, 0]
        largest = np.abs(step).max(axis=1, keepdims=True)
        x = x - step * np.minimum(1.0, 1.0 / np.maximum(largest, 1e-30))
    z = system.nodes(x[np.abs(system.residuals(x)).max(axis=1) < 1e-11])
    return distinct(z, 1e-6)


def distinct(z, tolerance):
    """Return rows without duplicates: they differ in at least one node."""
    kept = []
    for row in z:
        if all(np.abs(row - k).max() > tolerance for k in kept):
            kept.append(row)
    return np.array(kept).reshape(-1, z.shape[1])


def unmatched(found, listed, tolerance=1e-6):
    """Return the rows of `found` that are not among `listed`."""
    listed = np.asarray(listed).reshape(-1, found.shape[1])
    return [row for row in found if not (np.abs(listed - row).max(axis=1, initial=0.0) < tolerance).any()]


# ------------------------------------------------------------------ loops, and the proof


class Vectors:
    """Loops of a mechanism: positions of bodies and nodes are linear in 1, the e^{iφ} and the slides.

    A joint is a pin (body, node, point) or a slot (body, node, point, direction), which adds a slide. Driven angles
    couple the angles of two bodies.
    """

    def __init__(self, mechanism, inputs):
        self.mechanism, self.bodies = mechanism, len(mechanism.members)
        joints = [
            (b, n, z, None) for b, m in enumerate(mechanism.members) for n, z in zip(m.nodes, m.shape, strict=True)
        ]
        joints += [(s.guide, s.node, s.point, s.along) for s in mechanism.slides]
        root, phase = list(range(self.bodies)), [1.0 + 0.0j] * self.bodies
        for a, value in zip(mechanism.actuators, inputs, strict=True):
            if a.rotary:
                self._tie(root, phase, a, np.exp(1j * value))
            elif a.kind == SPAN:
                joints += [(len(root), a.node, 0.0, None), (len(root), a.nodes[1], value, None)]
                root.append(len(root))
                phase.append(1.0 + 0.0j)
            else:
                at = a.point + a.normal * value
                joints.append((a.guide, a.node, at, 1j * a.normal))
        count = defaultdict(int)
        for joint in joints:
            count[joint[1]] += 1
        self.joints = [j for j in joints if count[j[1]] > 1]  # a node of only one body moves with it
        self._prune()
        used = sorted({root[j[0]] for j in self.joints} - {root[0]})
        self.angle = {c: 1 + k for k, c in enumerate(used)}
        self.root, self.phase = root, phase
        self.slots = [k for k, j in enumerate(self.joints) if j[3] is not None]

    def _tie(self, root, phase, a, turn):
        """Couple the angle of the arm to that of the reference: arm e^{iφ} = reference e^{iφ} e^{i value}."""
        factor = a.reference * phase[a.guide] * turn / (a.arm * phase[a.members[0]])
        old, new = root[a.members[0]], root[a.guide]
        if new != 0 and old == 0:
            old, new, factor = new, old, 1 / factor
        for b, r in enumerate(root):
            if r == old:
                root[b], phase[b] = new, phase[b] * factor

    def _prune(self):
        """Remove bodies and nodes with only one joint."""
        while True:
            bodies, nodes = defaultdict(int), defaultdict(int)
            for body, node, _, _ in self.joints:
                bodies[body] += 1
                nodes[node] += 1
            kept = [j for j in self.joints if (bodies[j[0]] > 1 or j[0] == 0) and nodes[j[1]] > 1]
            if len(kept) == len(self.joints):
                return
            self.joints = kept

    def coefficients(self):
        """Return C0, C, U, rail, and positions {body or ("node", n): row over 1, angles, slides}."""
        width = 1 + len(self.angle) + len(self.slots)
        place, rest = {0: np.zeros(width, dtype=complex)}, list(enumerate(self.joints))
        grown = True
        while grown:
            grown = False
            for item in list(rest):
                k, (body, node, _, _) = item
                if (body in place) != (("node", node) in place):
                    step = self._step(k, width)
                    if body in place:
                        place["node", node] = place[body] + step
                    else:
                        place[body] = place["node", node] - step
                    rest.remove(item)
                    grown = True
        loops = np.array([place[j[0]] + self._step(k, width) - place["node", j[1]] for k, j in rest])
        loops = loops.reshape(len(rest), width)
        n = len(self.angle)
        rail = [self.angle.get(self.root[self.joints[k][0]], 0) - 1 for k in self.slots]
        return (loops[:, 0], loops[:, 1 : 1 + n], loops[:, 1 + n :], np.array(rail, dtype=int)), place

    def _step(self, k, width):
        body, _, point, direction = self.joints[k]
        row = np.zeros(width, dtype=complex)
        row[self.angle.get(self.root[body], 0)] += point * self.phase[body]
        if direction is not None:
            row[1 + len(self.angle) + self.slots.index(k)] = direction * self.phase[body]
        return row

    def nodes(self, place, rail, x):
        """Return positions (nodes,) at a solution; NaN for nodes that belong to no loop."""
        n = len(self.angle)
        theta = np.append(np.exp(1j * x[:n]), 1.0)
        value = np.concatenate([[1.0], theta[:n], x[n:] * theta[rail]])
        z = np.full(len(self.mechanism.nodes), np.nan + 0j)
        for body, member in enumerate(self.mechanism.members):
            if body in place and (self.root[body] == 0 or self.root[body] in self.angle):
                turn = self.phase[body] * (1.0 if self.root[body] == 0 else theta[self.angle[self.root[body]] - 1])
                for node, local in zip(member.nodes, member.shape, strict=True):
                    z[node] = place[body] @ value + turn * local
        for key, row in place.items():
            if isinstance(key, tuple):
                z[key[1]] = row @ value
        return z


def configurations_proved(mechanism, inputs, reach=np.inf):
    """Return the configurations (K, nodes), and whether the list is proved complete.

    Slides are searched up to `reach` times the size, or as far as the lengths allow.
    """
    from gimcli.assemblies.intervals import real_roots
    from gimcli.assemblies.loops import Coefficients

    vectors = Vectors(mechanism, inputs)
    (C0, C, U, rail), place = vectors.coefficients()
    if not len(C0):
        return np.array([vectors.nodes(place, rail, np.zeros(0))]), True
    result = real_roots(Coefficients(C0, C, U, rail), reach * mechanism.size)
    return np.array([vectors.nodes(place, rail, x) for x in result.roots]).reshape(
        -1, len(mechanism.nodes)
    ), result.complete


def not_turned_over(mechanism, z):
    """Return the rows (K, nodes) in which no true prismatic pair is reversed on its guide."""
    pairs = defaultdict(list)
    for s in mechanism.slides:
        pairs[s.pair].append(s)
    keep = np.ones(len(z), dtype=bool)
    for first, *others in pairs.values():
        if not others:
            continue
        a, b, rail = first.node, others[0].node, mechanism.members[first.guide]
        drawn = mechanism.drawn[b] - mechanism.drawn[a]
        u, v = rail.nodes[0], rail.nodes[1]
        along = (z[:, v] - z[:, u]) / (rail.shape[1] - rail.shape[0]) * first.direction
        along_drawn = (mechanism.drawn[v] - mechanism.drawn[u]) / (rail.shape[1] - rail.shape[0]) * first.direction
        sense = (np.conj(along) * (z[:, b] - z[:, a])).real * (np.conj(along_drawn) * drawn).real
        keep &= ~(sense < 0.0)
    return z[keep]
