"""All configurations where inputs follow the linkage itself, such as the angle of a gear that a rocker turns.

Such inputs are not known beforehand. The configurations at many values of them are the starts of Newton's method for
the equations that contain them as unknowns; each solution is then one of the configurations at its own inputs. Whether
the starts at every second value lead to the same solutions shows whether there were enough of them: this is no proof.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import compress, product
from operator import itemgetter

import numpy as np

from gimcli.assemblies.assemblies import SAME, ConfigurationFinder, Configurations
from gimcli.assemblies.configuration_sweep import RootFollower
from gimcli.assemblies.constants import FITS
from gimcli.assemblies.roots import AGREED, OPEN
from gimcli.continuation import gauss_newton
from gimcli.mechanism import ComplexArray, FloatArray, Mechanism
from gimcli.structure.carried import read_inputs
from gimcli.structure.residual import holds
from gimcli.structure.system import system_of

VALUES, FEWEST, MOST = 144, 4, 18
"""Number of values of all inputs that follow the linkage at which starts are found; the least and most of one."""


class LinkedFinder:
    """Finds the configurations at inputs of the drivers; angles that are read are within half a turn of the drawing."""

    def __init__(self, mechanism: Mechanism, tolerance: float) -> None:
        self.mechanism, self.system = mechanism, system_of(mechanism)
        own = tuple(coupling for coupling in mechanism.couplings if not coupling.reads)
        apart = replace(mechanism, couplings=own, complete=None)  # with any inputs
        self.roots, self.linked = RootFollower(ConfigurationFinder(apart, tolerance)), self.system.followers
        each = int(np.clip(round(VALUES ** (1.0 / len(self.linked))), FEWEST, MOST))
        self.values = np.array([*product(*(self._grid(k, each) for k in self.linked))])

    def _grid(self, follower: int, count: int) -> FloatArray:
        """Return values of an input: over a turn, or as far as members reach."""
        actuator = self.mechanism.actuators[follower]
        reach = np.pi if actuator.rotary else sum(member.extent for member in self.mechanism.members)
        return actuator.drawn + reach * (2.0 * (np.arange(count) + 0.5) / count - 1.0)

    def row(self, inputs: FloatArray) -> Configurations:
        """Return the configurations at inputs (actuators,), of which those that follow the linkage do not count."""
        found, seen = np.empty((0, len(self.mechanism.nodes)), dtype=complex), set[tuple[int, int]]()
        for half, z in self._solved(inputs):
            known = self._same(z, found)
            if not known:
                found = np.concatenate([found, z[None]])
            seen.add((half, known[0] if known else len(found) - 1))
        every = [(z, self.roots.row(read_inputs(self.mechanism, z, inputs))) for z in found]
        proved = [(one, k) for z, one in every for k in self._same(z, one.z)[:1]]
        agreed = len(proved) == len(found) and len(seen) == 2 * len(found)
        positions, residual, radius, branches = (
            [getattr(one, name)[k] for one, k in proved] for name in ("z", "residual", "radius", "branches")
        )
        return replace(
            proved[0][0] if proved else self.roots.row(inputs), mechanism=self.mechanism, inputs=inputs,
            z=np.array(positions).reshape(-1, len(self.mechanism.nodes)), residual=np.array(residual),
            radius=np.array(radius), branches=tuple(branches), searched=AGREED if agreed else OPEN,
        )  # fmt: skip

    def _solved(self, inputs: FloatArray) -> list[tuple[int, ComplexArray]]:
        """Return positions (nodes,) at which the constraints hold, and the half of the starts from which each comes."""
        at, starts = inputs.copy(), list[tuple[int, FloatArray]]()
        for number, values in enumerate(self.values):
            at[self.linked] = values
            near = self.roots.row(at).z
            starts += [(number % 2, self.system.coordinates(z, read_inputs(self.mechanism, z, at))) for z in near]
        starts.sort(key=itemgetter(0))
        x = np.array([x for _, x in starts]).reshape(-1, self.system.n)
        x, good = gauss_newton.settle(self.system.equations_at(inputs), x)
        z, halves = self.system.nodes(x[good].T), np.array([half for half, _ in starts], dtype=int)[good].tolist()
        own = np.reshape([read_inputs(self.mechanism, one, inputs) for one in z.T], (-1, len(inputs))).T
        return [*compress(zip(halves, z.T, strict=True), holds(self.mechanism, z, own, FITS))]

    def _same(self, z: ComplexArray, others: ComplexArray) -> list[int]:
        """Return which of others (rows, nodes) are the same as positions z (nodes,)."""
        apart = np.max(self.mechanism.apart(others.T, z[:, None]), axis=0, initial=0.0)
        return np.flatnonzero(apart <= SAME * self.mechanism.size).tolist()
