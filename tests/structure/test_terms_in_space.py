"""The terms, the rank and the continuation are those of space too: Bennett's linkage, four hinges that no plane holds.

Equal opposite links a, b with twists alpha, beta move if sin(alpha) / a = sin(beta) / b; then
tan(theta_1 / 2) tan(theta_2 / 2) = sin((beta + alpha) / 2) / sin((beta - alpha) / 2), theta_1 + theta_3 = 2 pi.
Source: Bennett, A new mechanism, Engineering 76 (1903) 777-778.
Three moving links and four hinges: w = 6 * 3 - 5 * 4 = -2, yet it moves.
"""

import itertools
import math

import numpy as np
import pytest

from gimcli.continuation.arclength import ArclengthConstants, place, walk
from gimcli.structure.constraint_jacobian import full_pivoting
from gimcli.structure.terms import COSINE, ONE, SINE, Term, TermArrays

LENGTHS, ALPHA = (1.0, 1.4), 0.6
BETA = math.asin(LENGTHS[1] * math.sin(ALPHA) / LENGTHS[0])
UNKNOWNS = 12
"""Coordinates of two points on each of the two moving hinges; the input is the variable after them."""


def link(turn, length, twist):
    """Return the frame after a hinge, turned about z, and a link along x with a twist about x."""
    c, s, ct, st = math.cos(turn), math.sin(turn), math.cos(twist), math.sin(twist)
    return np.array([
        [c, -s * ct, s * st, length * c], [s, c * ct, -c * st, length * s], [0.0, st, ct, 0.0], [0.0, 0.0, 0.0, 1.0]
    ])  # fmt: skip


def hinges(turn, beta):
    """Return two points (4, 2, 3) on each hinge at an input, in the frame of the first, by the closed form."""
    (a, b), ratio = LENGTHS, math.sin((BETA + ALPHA) / 2) / math.sin((BETA - ALPHA) / 2)
    second = 2.0 * math.atan2(ratio * math.cos(turn / 2), math.sin(turn / 2))
    frames = [np.eye(4), link(turn, a, ALPHA)]
    frames += [frames[1] @ link(second, b, beta), np.linalg.inv(link(0.0, b, beta))]
    return np.array([(f[:3, 3], f[:3, 3] + f[:3, 2]) for f in frames])


class Hinges:
    """Distances within the three moving links, and the turn of the first of them, as one curve (x, u)."""

    def __init__(self, beta):
        points = hinges(1.0, beta).reshape(8, 3)
        known = {k: p for k, p in enumerate(points) if k not in range(2, 6)}  # the first and the last hinge are fixed
        pairs = [(2, 3), (4, 5), *(p for k in (0, 2, 4) for p in itertools.product((k, k + 1), (k + 2, k + 3)))]
        rows = [self.distance(one, other, known, np.sum((points[one] - points[other]) ** 2)) for one, other in pairs]
        u, last = UNKNOWNS, UNKNOWNS + 1
        rows += [(Term(1.0, ONE, k, last), Term(-LENGTHS[0], kind, last, last)) for k, kind in ((0, COSINE), (1, SINE))]
        self.arrays = TermArrays(rows, u, range(last + 1))
        self.start = np.append(points[2:6].ravel(), 1.0)

    @staticmethod
    def distance(one, other, known, square):
        """Return the terms of |p - q|^2 - square, with the coordinates of fixed points as numbers."""
        last, found, constant = UNKNOWNS + 1, [], -square
        for axis in range(3):
            for p, q, sign in ((one, one, 1.0), (other, other, 1.0), (one, other, -2.0)):
                numbers = [known[k][axis] for k in (p, q) if k in known]
                places = [3 * (k - 2) + axis for k in (p, q) if k not in known]
                constant += sign * math.prod(numbers) if not places else 0.0
                found += [Term(sign * math.prod(numbers), ONE, *places, *[last] * len(numbers))] if places else []
        return (*found, Term(constant, ONE, last, last))

    def linearised(self, p):
        value, table = self.arrays.linearised(np.concatenate([p, np.ones((*p.shape[:-1], 1))], axis=-1))
        return value, table[..., :-1]

    def jacobian(self, p):
        return self.linearised(p)[1]


@pytest.mark.parametrize(("beta", "mobility"), [(BETA, 1), (BETA + 1e-3, 0)])
def test_the_rank_tells_which_twists_move(beta, mobility):
    loop = Hinges(beta)
    table = loop.jacobian(loop.start)
    assert 13 - full_pivoting(table)[0] == mobility


def test_the_linkage_is_followed_through_a_whole_turn():
    """Each point of the curve has the places of the closed form at its input."""
    loop = Hinges(BETA)
    assert np.abs(loop.linearised(loop.start)[0]).max() < 1e-14
    passed = [loop.start]
    start = place(loop, loop.start, np.eye(13)[-1])
    for point in walk(loop, start, ArclengthConstants(points=2000)):
        passed.append(point.p)
        if point.p[-1] > 1.0 + 2.0 * math.pi:
            break
    assert passed[-1][-1] > 1.0 + 2.0 * math.pi
    wanted = np.array([hinges(p[-1], BETA)[1:3].ravel() for p in passed])
    assert np.abs(np.array(passed)[:, :-1] - wanted).max() < 1e-11


def test_slopes_along_a_motion_are_differences():
    """The derivative of the rank's table, from which singular positions and accelerations follow."""
    loop, step = Hinges(BETA), 1e-5
    along = place(loop, loop.start, np.eye(13)[-1]).tangent
    ends = [loop.jacobian(loop.start + sign * step * along) for sign in (1.0, -1.0)]
    found = loop.arrays.slopes_along(np.append(loop.start, 1.0), np.append(along, 0.0))[:, :-1]
    assert np.abs(found - (ends[0] - ends[1]) / (2.0 * step)).max() < 1e-9
