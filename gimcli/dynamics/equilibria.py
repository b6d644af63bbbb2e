"""Positions of static equilibrium, and what it takes to leave them."""

from __future__ import annotations

from dataclasses import dataclass, field

from gimcli.mechanism import ComplexArray, FloatArray
from gimcli.status import Status

STABLE, UNSTABLE, UNDECIDED = "stable", "unstable", "undecided"
"""Stability; undecided: the second derivatives of the potential do not decide it, such as at a double root."""


@dataclass(frozen=True)
class Push:
    """The least effort of a released input that pushes the mechanism from a stable equilibrium over the next one."""

    sense: int  # 1 or -1: of the input at the start
    effort: float | None  # N m, or N; None where the input reaches a limit before
    inputs: FloatArray  # (actuators,) at the greatest effort; at the limit if there is one
    barrier: float  # J, difference of the potential
    target: int  # number of the other equilibrium in the list


@dataclass(frozen=True)
class Equilibrium:
    """A position in which all forces balance."""

    z: ComplexArray = field(repr=False)  # (nodes,)
    inputs: FloatArray  # (actuators,) rad, or length of the normal frame
    potential: float  # J
    stability: str
    negative: int  # number of directions in which the potential decreases
    multiplicity: int  # 1; 2: a double root; 0: one of a continuum
    stiffness: FloatArray | None  # (k, k) N m/rad, N or N/m, of the released inputs; None at a limit of an input
    residual: float  # force, relative to the sum of its contributions
    status: Status = Status.OK
    fraction: float = 0.0  # of the length of the circuit; below 0 and above 1 in further rounds
    pushes: tuple[Push, ...] = ()


@dataclass(frozen=True)
class BalanceHistory:
    """The forces along the circuit of one released input."""

    z: ComplexArray = field(repr=False)  # (nodes, rows)
    inputs: FloatArray  # (actuators, rows)
    fraction: FloatArray  # (rows,) of the length of the circuit
    potential: FloatArray  # (rows,) J
    effort: FloatArray  # (rows,) N m, or N, that holds the input; infinite at its limits


@dataclass(frozen=True)
class Equilibria:
    """All equilibria that were found."""

    found: tuple[Equilibrium, ...]
    released: tuple[int, ...]
    start: ComplexArray = field(repr=False)  # (nodes,) position from which they were searched
    start_inputs: FloatArray  # (actuators,)
    holding: FloatArray  # (k,) N m, or N, efforts of the released inputs that hold the mechanism there
    conservative: bool
    everywhere: bool  # all positions that were examined are in equilibrium
    size: float  # greatest sum of the magnitudes of all contributions to a force [J per rad or normal length]
    history: BalanceHistory | None = None  # of one released input
    closed: bool = False  # whether its circuit is closed
    ended: str = ""  # why it ends
    crossings: int = 0  # number of change points on it, where other branches leave
    gain: float = 0.0  # J, change of the potential in one round of a closed circuit
    winds: bool = False  # whether a torsion spring is wound in each round
    cut: bool = False  # whether further rounds were not examined
    starts: int = 0  # number of starts of the search with several released inputs
    limited: bool = False  # whether the search ended at its bound on work
    failed: int = 0  # number of starts from which it did not converge
