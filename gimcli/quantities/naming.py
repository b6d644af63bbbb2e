"""Names in a measure: their members, actuators and nodes, and messages with similar names."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from gimcli.errors import UsageError
from gimcli.mechanism import FRAME, Mechanism
from gimcli.nearest import guess

FRAME_NAMES = ("frame", "ground")


def refuse_count(spec: str, names: Sequence[str], counts: Sequence[int], form: str) -> None:
    """Raise UsageError if a measure has too many or too few names."""
    if len(names) not in counts or not all(names):
        raise UsageError(f"measure '{spec}': expected {form}")


def unknown(spec: str, what: str, name: str, known: Iterable[str]) -> UsageError:
    """Return the error for an unknown name."""
    return UsageError(f"measure '{spec}': no {what} '{name}'; {guess(name, known)}")


def member(mechanism: Mechanism, spec: str, name: str) -> int:
    """Return the index of a member; `frame` and `ground` are the fixed member."""
    names = [m.name for m in mechanism.members]
    if name in names[FRAME + 1 :]:
        return names.index(name, FRAME + 1)
    if name == names[FRAME] or name in FRAME_NAMES:
        return FRAME
    raise unknown(spec, "member", name, [*names[FRAME + 1 :], names[FRAME], FRAME_NAMES[0]])


def actuator(mechanism: Mechanism, spec: str, name: str) -> int:
    """Return the index of an actuator."""
    names = [a.name for a in mechanism.actuators]
    if name in names:
        return names.index(name)
    raise unknown(spec, "actuator", name, names)


def refuse_no_point(mechanism: Mechanism, spec: str, name: str) -> None:
    """Raise UsageError if no node or point has the name."""
    known = [*(p.name for p in mechanism.points), *mechanism.nodes]
    if name not in known:
        raise unknown(spec, "point or node", name, known)


def node(mechanism: Mechanism, spec: str, name: str) -> int:
    """Return the index of a node."""
    if name in mechanism.nodes:
        return mechanism.nodes.index(name)
    raise unknown(spec, "node", name, mechanism.nodes)
