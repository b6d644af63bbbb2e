"""All configurations over many inputs: every complex root of a coupled group is followed from row to row.

The paths from one row to the next pass through a complex linkage between them, since roots coincide at some real
inputs; so no root is lost, and a root keeps its number between two such inputs.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from gimcli.assemblies.assemblies import ConfigurationFinder, Configurations
from gimcli.assemblies.assur_loops import LoopGroup
from gimcli.assemblies.certificate import distances, prove
from gimcli.assemblies.constants import SEARCH
from gimcli.assemblies.root_paths import corrected, random_member, track
from gimcli.assemblies.roots import AGREED, REACHED, Roots
from gimcli.mechanism import ComplexArray, FloatArray

SEED = 360

Place = tuple[int, tuple[int, ...]]
"""The number of a group, and the branches of the partial configuration on which it is solved."""


@dataclass
class RootFollower:
    """Follows the roots of every coupled group from row to row, for each partial configuration."""

    assembler: ConfigurationFinder
    before: dict[Place, tuple[ComplexArray, Roots]] = field(default_factory=dict)
    now: dict[Place, tuple[ComplexArray, Roots]] = field(default_factory=dict)
    fresh: int = 0  # number of groups that were solved from a generic linkage

    def __post_init__(self) -> None:
        self.generator = np.random.default_rng(SEED)

    def row(self, inputs: FloatArray) -> Configurations:
        """Return the configurations at the next inputs (actuators,)."""
        self.before, self.now = self.now, {}
        return self.assembler.at(inputs, self._roots)

    def _roots(self, number: int, branch: tuple[int, ...], group: LoopGroup, H: ComplexArray) -> Roots:
        roots = None
        known = self.before.get((number, branch))
        if known is not None and known[1].level in (REACHED, AGREED) and not known[1].infinite:
            roots = self._followed(group, *known, H)
        if roots is None:
            self.fresh += 1
            roots = self.assembler.afresh(number, branch, group, H, known[1] if known else None)
        self.now[number, branch] = H, roots
        return roots

    def _followed(self, group: LoopGroup, before: ComplexArray, roots: Roots, H: ComplexArray) -> Roots | None:
        """Return all roots followed to new coefficients; None if one is lost."""
        family = group.family
        change = float(np.max(np.abs(H - before)))
        if change == 0.0:
            return roots
        aside = random_member(family, self.generator)
        between = 0.5 * (before + H) + SEARCH.aside * change * aside
        tracking = replace(SEARCH.tracking, first=SEARCH.along)
        done = track(family, before, between, roots.proven.w, tracking)
        done = track(family, between, H, done.w, tracking)
        w = done.w
        if not np.isfinite(w).all():
            return None
        proven = prove(family, H, corrected(family, H, w, 1))
        gap = distances(family, proven.w, proven.w)
        np.fill_diagonal(gap, np.inf)
        apart = bool((gap > proven.small[:, None] + proven.small[None, :]).all())
        if not (apart and proven.sure.all() and (proven.real | proven.complex).all()):
            return None
        return replace(roots, proven=proven)
