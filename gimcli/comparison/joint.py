"""Joint coordinates: a spanning tree of bodies, a variable for each freedom of its joints, cut pairs as equations.

A tree grows from the frame by the joint with the fewest variables, nearest to the frame first. A joint
that an input drives costs no variable. A linear actuator can be a joint, too: its direction is the variable.
Source: Fraczek & Wojtyra, lecture notes on multibody methods; Garcia de Jalon & Bayo 1994, section 2.1.
"""

from __future__ import annotations

import cmath
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from gimcli.comparison.absolute import follow_bodies
from gimcli.comparison.pairs import Bodies, BodyPair
from gimcli.comparison.stop import Stop
from gimcli.kernels import bodies as pairs
from gimcli.mechanism import FRAME, ComplexArray, FloatArray, Mechanism
from gimcli.positions.newton import Run
from gimcli.structure.steps import NONE

PARALLEL = 1e-12
"""A travel drives a sliding pair whose direction differs by less (sine)."""


@dataclass(frozen=True)
class JointFreedom:
    """One freedom of a joint: constant, plus a variable or what an input says."""

    constant: float = 0.0
    variable: bool = True
    actuator: int = NONE
    sense: int = 1


FIXED = JointFreedom(variable=False)


@dataclass(frozen=True)
class TreeJoint:
    """How a body hangs on its parent: angle and travel, with points and directions in both bodies."""

    kind: int
    parent: int
    child: int
    za: complex = 0.0j
    da: complex = 0.0j
    zb: complex = 0.0j
    db: complex = 0.0j
    angle: JointFreedom = FIXED
    travel: JointFreedom = FIXED
    met: tuple[int, ...] = ()  # numbers of the pairs that it stands for

    @property
    def variables(self) -> int:
        """Number of variables."""
        own = 2 if self.kind == pairs.FREE else int(self.travel.variable)
        return own + int(self.angle.variable)


class JointCoordinates:
    """A mechanism in joint coordinates."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism, self.bodies = mechanism, Bodies(mechanism)
        self.joints = self._tree()
        met = {number for joint in self.joints for number in joint.met}
        self.cut = [p for k, p in enumerate(self.bodies.pairs) if k not in met]
        self.unknowns = sum(j.variables for j in self.joints)
        self.equations = sum(p.rows for p in self.cut)

    # -- the tree ---------------------------------------------------------------------------

    def _tree(self) -> list[TreeJoint]:
        depth, joints = {FRAME: 0}, []
        while len(depth) < self.bodies.count:
            found = [j for j in self._joints() if j.parent in depth and j.child not in depth]
            if not found:
                loose = next(b for b in range(self.bodies.count) if b not in depth)
                angle = JointFreedom() if self.bodies.turns(loose) else FIXED
                found = [TreeJoint(pairs.FREE, FRAME, loose, angle=angle, travel=JointFreedom())]
            joint = min(found, key=lambda j: (j.variables, depth[j.parent]))
            depth[joint.child] = depth[joint.parent] + 1
            joints.append(joint)
        return joints

    def _joints(self) -> Iterator[TreeJoint]:
        """Yield every joint that a pair could be, in both senses."""
        for number, pair in enumerate(self.bodies.pairs):
            for parent, child in ((pair.a, pair.b), (pair.b, pair.a)):
                if pair.kind == pairs.COINCIDENT:
                    at = (pair.za, pair.zb) if parent == pair.a else (pair.zb, pair.za)
                    joint = TreeJoint(pairs.HINGE, parent, child, za=at[0], zb=at[1], met=(number,))
                    yield self._driven(joint)
                elif pair.slides:
                    yield self._sliding(number, pair, parent, child)
                elif pair.kind == pairs.DISTANCE:
                    at = (pair.za, pair.zb) if parent == pair.a else (pair.zb, pair.za)
                    ram = TreeJoint(pairs.RAM, parent, child, za=at[0], zb=at[1], met=(number,))
                    yield self._driven(replace(ram, travel=JointFreedom(actuator=pair.actuator)))

    def _driven(self, joint: TreeJoint) -> TreeJoint:
        """Let the joint's angle vary, if its bodies turn, or follow the input between them."""
        if not self.bodies.turns(joint.child):
            return joint
        for number, pair in enumerate(self.bodies.pairs):
            if pair.kind == pairs.ANGLE and {pair.a, pair.b} == {joint.parent, joint.child}:
                sense = 1 if pair.a == joint.child else -1
                angle = JointFreedom(sense * pair.constant, False, pair.actuator, sense)
                return replace(joint, angle=angle, met=(*joint.met, number))
        return replace(joint, angle=JointFreedom())

    def _sliding(self, number: int, pair: BodyPair, parent: int, child: int) -> TreeJoint:
        """Return a pin in a slot or, of two slides of one pair, a true prismatic pair."""
        along = pair.normal / 1j
        joint = TreeJoint(pairs.HINGE, parent, child, za=pair.za, zb=pair.zb, db=along, met=(number,))
        if parent == pair.b:
            joint = replace(joint, za=pair.zb, da=along, zb=pair.za, db=0.0j)
        second = self._partner(number, pair)
        if second is None:
            return self._travelling(self._driven(joint), pair)
        turn = self._prismatic_turn(pair, self.bodies.pairs[second])
        angle = JointFreedom(turn if child == pair.a else -turn, variable=False)
        return self._travelling(replace(joint, angle=angle, met=(number, second)), pair)

    def _partner(self, number: int, pair: BodyPair) -> int | None:
        """Return the other slide of a true prismatic pair."""
        for k, other in enumerate(self.bodies.pairs):
            same = other.slides and other.name == pair.name and (other.a, other.b) == (pair.a, pair.b)
            if k != number and same and other.za != pair.za:
                return k
        return None

    def _prismatic_turn(self, first: BodyPair, second: BodyPair) -> float:
        """Return the constant angle from the guide to the sliding body, in the sense drawn."""
        _, turns = self.bodies.poses(self.mechanism.drawn)
        run = second.za - first.za
        along = first.normal / 1j * turns[first.b]
        sense = 1.0 if (along.conjugate() * run * turns[first.a]).real >= 0.0 else -1.0
        return cmath.phase(sense * first.normal / 1j / run)

    def _travelling(self, joint: TreeJoint, pair: BodyPair) -> TreeJoint:
        """Let the travel vary, or follow the input that drives it."""
        along = pair.normal / 1j
        for number, other in enumerate(self.bodies.pairs):
            same = other.kind == pairs.ON_LINE and not other.slides and (other.a, other.b) == (pair.a, pair.b)
            if same and other.za == pair.za and abs((other.normal.conjugate() * along).imag) < PARALLEL:
                sense = 1 if (other.normal.conjugate() * along).real > 0.0 else -1
                offset = (other.normal.conjugate() * (pair.zb - other.zb)).real
                travel = JointFreedom(-sense * offset, False, other.actuator, sense)
                return replace(joint, travel=travel, met=(*joint.met, number))
        return replace(joint, travel=JointFreedom())

    # -- numbers ------------------------------------------------------------------------------

    def arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the joints as ji, jz and above of the kernel."""
        heads, parts, column = [], [], 0
        above = np.full(self.bodies.count, NONE, dtype=np.int64)
        for number, j in enumerate(self.joints):
            angle = column if j.angle.variable else NONE
            travel = column + int(j.angle.variable) if j.travel.variable else NONE
            column += j.variables
            above[j.child] = number
            heads.append(
                (j.parent, j.child, j.kind, angle, j.angle.actuator, j.angle.sense, travel, j.travel.actuator,
                 j.travel.sense)
            )  # fmt: skip
            points = [part for z in (j.za, j.da, j.zb, j.db) for part in (z.real, z.imag)]
            parts.append((*points, j.angle.constant, j.travel.constant))
        return np.array(heads, dtype=np.int64).reshape(-1, 9), np.array(parts).reshape(-1, 10), above

    def weights(self, length: float) -> FloatArray:
        """Return what a correction of each variable (unknowns,) is worth: lengths by `length`, angles by 1."""
        weights: list[float] = []
        for joint in self.joints:
            weights += [1.0] * joint.angle.variable
            shifts = joint.variables - joint.angle.variable
            weights += [1.0 if joint.kind == pairs.RAM else 1.0 / length] * shifts
        return np.array(weights, dtype=float)

    def start(self, z: ComplexArray) -> FloatArray:
        """Return the variables at a position z (nodes,)."""
        origins, turns = self.bodies.poses(z)
        q: list[float] = []
        for j in self.joints:
            if j.angle.variable:
                q.append(float(np.angle(turns[j.child] / turns[j.parent])))
            tip = (origins[j.child] + turns[j.child] * j.zb - origins[j.parent]) / turns[j.parent] - j.za
            if j.kind == pairs.FREE:
                q += [float(tip.real), float(tip.imag)]
            elif j.kind == pairs.RAM:
                q.append(float(np.angle(tip)))
            elif j.travel.variable:
                along = j.da if j.da != 0 else -j.db * turns[j.child] / turns[j.parent]
                q.append(float((np.conj(along) * tip).real))
        return np.array(q, dtype=float)

    def follow(
        self, inputs: FloatArray, start: ComplexArray, stop: Stop, run: Run
    ) -> tuple[ComplexArray, FloatArray, FloatArray]:
        """Follow inputs (actuators, rows) from a position (nodes,); return z, iterations and 1 where it settled."""
        layout = np.zeros((self.bodies.count, 2), dtype=np.int64)
        return follow_bodies(self, inputs, start, stop, run, layout, self.cut, self.arrays())
