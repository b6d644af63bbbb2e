"""Constants of the search for all configurations, with their reasons."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class TrackingConstants:
    """A path of roots from a generic linkage: predictor of 4th order, two corrections a step."""

    correction: float = 1e-4  # largest first correction [rad]: a tenth of it left the neighbouring path in no trial
    contraction: float = 1e-3  # second over first correction: Newton-Raphson converges quadratically there
    settled: float = 1e-9  # a correction that need not shrink further: rounding of badly conditioned points
    first: float = 0.02  # first step in t
    shortest: float = 1e-10  # step at which a path counts as ending: t stays a number
    most: int = 4000  # steps of a path
    aim: float = 0.2  # share of `correction` that the next step aims at
    safety: float = 0.85
    slowest: float = 0.5  # change of step, least and most
    fastest: float = 2.5
    far: float = 60.0  # |log theta| of a root at infinity: e^60 of the lengths


@dataclass(frozen=True)
class ConfigurationConstants:
    """What the search may spend, and when a root counts."""

    tracking: TrackingConstants = TrackingConstants()
    tighter: tuple[float, ...] = (0.1, 0.01)  # of `correction`, for paths that met another
    starts: int = 3  # independent generic linkages before the search gives up
    pencil_loops: int = 4  # beyond it the pencil costs more than paths (924 unknowns at 6 loops)
    pencil_unknowns: int = 400  # monomials of the pencil
    idle: int = 12  # monodromy loops without a new root that end it, where the count is not known: blocks of roots
    # are left by half of the loops
    monodromy: int = 60  # loops at most
    count_loops: int = 6  # loops up to which the exact count of revolute groups is told (under a second)
    count_slides: int = 4  # and of groups with slides
    polish: int = 8  # corrections that a candidate is given
    moved: float = 1.0  # a candidate that corrections move farther was none [rad]
    residual: float = 1e-9  # of a candidate, relative to the coefficients
    near: float = 1e-5  # distance under which two endpoints are one multiple root [rad]
    slope: float = 0.02  # |d log theta / d tau| at which a path that ends goes to infinity: rational, not small
    late: float = 0.999  # time before which a path that stops was lost
    real: float = 1e-4  # distance from its mirror image at which a multiple root may be real [rad]
    aside: float = 1.0  # how far the linkage half-way between two rows is off the real ones, over their distance
    along: float = 0.5  # first step between two rows
    seconds: float = 10.0  # of intervals, where the count is not reached; a minute would rarely tell more
    positions: int = 16_384  # configurations that are listed: 14 dyads


SEARCH = ConfigurationConstants()

FITS = 1e-10
"""Residual of the constraints as written, that of `gim solve`."""
