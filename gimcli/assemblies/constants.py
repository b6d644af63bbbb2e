"""Constants of the search for all configurations, with their reasons."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class TrackingConstants:
    """Constants of paths of roots from a generic linkage: predictor of fourth order, two corrections per step."""

    correction: float = 1e-4  # greatest first correction [rad]: with a tenth of it no path was left in any trial
    contraction: float = 1e-3  # greatest ratio of second to first correction: quadratic convergence of Newton-Raphson
    settled: float = 1e-9  # correction below which the ratio is not checked: rounding of ill-conditioned points
    first: float = 0.02  # first step in t
    shortest: float = 1e-10  # step at which a path ends
    most: int = 4000  # steps of a path
    aim: float = 0.2  # fraction of `correction` for which the next step is chosen
    safety: float = 0.85  # factor of the next step
    slowest: float = 0.5  # least and greatest change of the step
    fastest: float = 2.5
    far: float = 60.0  # |log theta| of a root at infinity: e^60 of the lengths


@dataclass(frozen=True)
class ConfigurationConstants:
    """Limits of the search, and tolerances of roots."""

    tracking: TrackingConstants = TrackingConstants()
    tighter: tuple[float, ...] = (0.1, 0.01)  # factors of `correction` for paths that coincided with another
    starts: int = 3  # most independent generic linkages
    pencil_loops: int = 4  # most loops for the pencil: with more it takes longer than paths (924 unknowns at 6 loops)
    pencil_unknowns: int = 400  # most monomials of the pencil
    idle: int = 12  # monodromy loops without a new root after which it ends if the count is unknown; about half of the
    # loops leave a block of roots
    monodromy: int = 60  # most monodromy loops
    count_loops: int = 6  # most loops for the exact count of revolute groups (less than 1 s)
    count_slides: int = 4  # most loops for the exact count of groups with slides
    polish: int = 8  # corrections of a candidate
    moved: float = 1.0  # greatest total correction of a candidate [rad]
    residual: float = 1e-9  # greatest residual of a candidate, relative to the coefficients
    near: float = 1e-5  # distance below which two endpoints are the same multiple root [rad]
    slope: float = 0.02  # |d log theta / d tau| at which a path that ends goes to infinity: rational, not small
    late: float = 0.999  # time t from which on a path that stops is not lost
    real: float = 1e-4  # distance from its mirror image up to which a multiple root may be real [rad]
    aside: float = 1.0  # imaginary part of the linkage between two rows, relative to their distance
    along: float = 0.5  # first step between two rows
    seconds: float = 10.0  # time for intervals if the count is not reached; a minute rarely gives more
    positions: int = 16_384  # most configurations: those of 14 dyads


SEARCH = ConfigurationConstants()

FITS = 1e-10
"""Residual of the constraints as written, that of `gim solve`."""
