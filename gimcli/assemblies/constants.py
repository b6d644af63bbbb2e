"""Constants of the search for all configurations, and the reasons for their values."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class TrackingConstants:
    """Constants of paths of roots from a generic linkage: predictor of fourth order, two corrections per step."""

    correction: float = 1e-4  # largest first correction [rad]; with a tenth of it no trial jumped to another path
    contraction: float = 1e-3  # largest ratio of second to first correction; Newton-Raphson converges quadratically
    settled: float = 1e-9  # correction below which the ratio is not checked: rounding of ill-conditioned points
    first: float = 0.02  # first step in t
    shortest: float = 1e-10  # step below which a path stops
    most: int = 4000  # largest number of steps of a path
    aim: float = 0.2  # first correction intended for the next step, relative to `correction`
    safety: float = 0.85  # factor of the next step
    slowest: float = 0.5  # smallest and largest factor between two steps
    fastest: float = 2.5
    far: float = 60.0  # |log theta| above which a root is at infinity


@dataclass(frozen=True)
class ConfigurationConstants:
    """Limits of the search, and tolerances of roots."""

    tracking: TrackingConstants = TrackingConstants()
    tighter: tuple[float, ...] = (0.1, 0.01)  # factors of `correction` for paths that coincided with another
    starts: int = 3  # largest number of independent generic linkages
    pencil_loops: int = 4  # with more loops the pencil takes longer than paths (924 unknowns at 6 loops)
    pencil_unknowns: int = 400  # largest number of monomials of the pencil
    idle: int = 12  # monodromy loops without a new root after which it ends if the count is unknown; about half of the
    # loops leave a block of roots
    monodromy: int = 60  # largest number of monodromy loops
    count_loops: int = 6  # largest number of loops for the exact count of revolute groups (less than 1 s)
    count_slides: int = 4  # the same for groups with slides
    polish: int = 8  # corrections of a candidate
    moved: float = 1.0  # largest total correction of a candidate [rad]
    residual: float = 1e-9  # largest residual of a candidate, relative to the coefficients
    near: float = 1e-5  # distance below which two endpoints are the same multiple root [rad]
    slope: float = 0.02  # |d log theta / d tau| above which a path goes to infinity; exact slopes are simple fractions
    late: float = 0.999  # a path that stops at a smaller t is lost
    real: float = 1e-4  # distance from its mirror image up to which a multiple root may be real [rad]
    aside: float = 1.0  # distance of the complex linkage between two rows from real ones, relative to that of the rows
    along: float = 0.5  # first step in t between two rows
    boxes: int = 800_000  # largest number of boxes of the interval search: about 10 s; more rarely decide more
    positions: int = 16_384  # largest number of configurations: that of 14 dyads


SEARCH = ConfigurationConstants()

FITS = 1e-10
"""Largest residual of the constraints as written, as in `gim solve`."""

PRIME = 2_147_483_647
"""Ranks are computed from random numbers modulo this prime; they are wrong with a probability of about 1e-8."""
