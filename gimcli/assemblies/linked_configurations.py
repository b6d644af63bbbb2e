"""All configurations where inputs follow the linkage itself, such as the angle of a gear that a rocker turns.

Such inputs are not known beforehand. The configurations at many values of them are the starts of Newton's method for
the equations that contain them as unknowns; each solution is then one of the configurations at its own inputs. Whether
the starts at every second value lead to the same solutions shows whether there were enough of them: this is no proof.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

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
        starts = [self._starts(inputs, values) for values in self.values]
        halves = [self._solved(inputs, [x for own in starts[k::2] for x in own]) for k in (0, 1)]
        every = self._distinct([*halves[0], *halves[1]])
        found = [self._at(read_inputs(self.mechanism, z, inputs), z) for z in every]
        proved = [one for one in found if len(one)]
        agreed = len(proved) == len(every) and all(len(half) == len(every) for half in halves)
        return replace(
            proved[0] if proved else self.roots.row(inputs), mechanism=self.mechanism, inputs=inputs,
            z=np.array([one.z[0] for one in proved]).reshape(-1, len(self.mechanism.nodes)),
            residual=np.array([one.residual[0] for one in proved]), radius=np.array([one.radius[0] for one in proved]),
            branches=tuple(one.branches[0] for one in proved), searched=AGREED if agreed else OPEN,
        )  # fmt: skip

    def _starts(self, inputs: FloatArray, values: FloatArray) -> list[FloatArray]:
        """Return the unknowns (n,) at the configurations at some values (followers,) of the inputs that follow."""
        at = inputs.copy()
        at[self.linked] = values
        return [self.system.coordinates(z, read_inputs(self.mechanism, z, at)) for z in self.roots.row(at).z]

    def _solved(self, inputs: FloatArray, starts: list[FloatArray]) -> list[ComplexArray]:
        """Return the different positions (nodes,) near starts at which the constraints hold."""
        x = np.array(starts).reshape(-1, self.system.n)
        x, good = gauss_newton.settle(self.system.equations_at(inputs), x)
        every = [self.system.nodes(one) for one in x[good]]
        return self._distinct([z for z in every if self._holds(z, inputs)])

    def _holds(self, z: ComplexArray, inputs: FloatArray) -> bool:
        own = read_inputs(self.mechanism, z, inputs)
        return bool(holds(self.mechanism, z[:, None], own[:, None], FITS)[0])

    def _distinct(self, every: list[ComplexArray]) -> list[ComplexArray]:
        """Return different positions (nodes,), each once."""
        found: list[ComplexArray] = []
        for z in every:
            if all(self._apart(z, other) > SAME * self.mechanism.size for other in found):
                found.append(z)
        return found

    def _apart(self, z: ComplexArray, other: ComplexArray) -> float:
        return float(np.max(self.mechanism.apart(z, other), initial=0.0))

    def _at(self, inputs: FloatArray, z: ComplexArray) -> Configurations:
        """Return the configuration at all inputs (actuators,) that is near positions (nodes,), if there is one."""
        found = self.roots.row(inputs)
        near = [k for k, one in enumerate(found.z) if self._apart(one, z) <= SAME * self.mechanism.size][:1]
        return replace(
            found, z=found.z[near], residual=found.residual[near], radius=found.radius[near],
            branches=tuple(found.branches[k] for k in near),
        )  # fmt: skip
