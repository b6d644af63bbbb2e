"""Models with gears: a five-bar with masses, also in body coordinates, and two wheels."""

import numpy as np
from geared_bodies import GearedBodies, ToothedPair

LENGTHS = {"crank": 1.0, "other": 1.2, "b1": 3.5, "b2": 3.0}
CENTRES = {"crank": 0.3 + 0.1j, "other": -0.2 + 0.05j, "b1": 1.6 - 0.1j, "b2": 1.4 + 0.2j}
MASSES = {"crank": (3.0, 0.4), "other": (4.0, 0.7), "b1": (1.5, 1.1), "b2": (1.2, 0.9)}


def five_bar(law=None, **gear):
    """Return a five-bar whose cranks are geared, with masses; the second crank is drawn at 60 deg."""
    second = complex(1.2 * np.exp(1j * np.pi / 3.0) + 3.0)
    return {
        "units": {"length": "m", "angle": "deg"},
        "nodes": {"O": [0, 0], "Q": [3, 0], "A": [1, 0], "B": [second.real, second.imag], "P": [1.77, 3.41]},
        "ground": ["O", "Q"],
        "links": {
            name: {"nodes": list(nodes), "length": LENGTHS[name]}
            for name, nodes in (("crank", "OA"), ("other", "QB"), ("b1", "AP"), ("b2", "BP"))
        },
        "actuators": {"motor": {"pivot": "O", "arm": "A", "law": law or {"from": 0, "to": 360}}},
        "gears": {"mesh": {"members": ["crank", "other"], "pivots": ["O", "Q"], **gear}},
        "masses": {
            n: {"mass": m, "inertia": j, "centre": [CENTRES[n].real, CENTRES[n].imag]} for n, (m, j) in MASSES.items()
        },
        "gravity": [0, -9.81],
        "trace": ["P"],
    }  # fmt: skip


def bodies(ratio, internal):
    """Return the same five-bar in body coordinates."""
    centre = [CENTRES[n] for n in LENGTHS]
    (c1, c2, c3, c4), (l1, l2, l3, l4) = centre, LENGTHS.values()
    pins = [
        (0, 0j, 1, -c1), (0, 3 + 0j, 2, -c2), (1, l1 - c1, 3, -c3), (2, l2 - c2, 4, -c4), (3, l3 - c3, 4, l4 - c4),
    ]  # fmt: skip
    radii = (3.0 * ratio / (1 + ratio), 3.0 / (1 + ratio)) if not internal else None
    if internal:
        second = 3.0 / abs(1.0 - ratio)
        radii = (ratio * second, second)
    gear = ToothedPair(1, 2, 0, 0j, 3 + 0j, radii, internal)
    return GearedBodies([MASSES[n] for n in LENGTHS], pins, [gear])


def state(found, t, row, speed):
    """Return coordinates of the bodies in a row, speeds and accelerations at a constant speed of the crank."""
    apex = complex(*t.xy["P"][row])
    turn = np.radians(t["motor"][row])
    ratio = found.gears[0].ratio
    one, two = np.exp(1j * turn), 3.0 + 1.2 * np.exp(1j * (ratio * turn + np.pi / 3.0))
    starts = {"crank": 0j, "other": 3 + 0j, "b1": one, "b2": two}
    ends = {"crank": one, "other": two, "b1": apex, "b2": apex}
    q = []
    for n in LENGTHS:
        angle = np.angle(ends[n] - starts[n])
        place = starts[n] + np.exp(1j * angle) * CENTRES[n]
        q += [place.real, place.imag, angle]
    q, drive = np.array(q), np.eye(12)[2]
    table, _ = found.rows(q, np.zeros(12))
    v = np.linalg.solve(np.vstack([table, drive]), [0.0] * len(table) + [speed])
    table, bias = found.rows(q, v)
    return q, v, np.linalg.solve(np.vstack([table, drive]), [*(-bias), 0.0])


def train(**gear):
    """Return two wheels about O and Q, 90 mm apart, with 3 N m on the second one."""
    return {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [20, 0], "Q": [90, 0], "B": [90, 30]},
        "ground": ["O", "Q"], "links": {"one": ["O", "A"], "two": ["Q", "B"]},
        "actuators": {"motor": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 360}}},
        "gears": {"mesh": {"members": ["one", "two"], "pivots": ["O", "Q"], **gear}},
        "loads": {"brake": {"on": "two", "torque": 3.0}}, "trace": ["A"],
    }  # fmt: skip
