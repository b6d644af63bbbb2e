"""Models with coupled inputs and gears, and closed forms of the geared five-bar."""

import numpy as np


def five_bar(ratio, phase, *, d=3.0, a=(1.0, 1.2), b=(3.5, 3.0), drawn=(1.77, 3.41), law=None):
    second = complex(np.exp(1j * np.radians(phase)) * a[1] + d)
    return {
        "units": {"length": "m", "angle": "deg"},
        "nodes": {"O": [0, 0], "Q": [d, 0], "A": [a[0], 0], "B": [second.real, second.imag], "P": list(drawn)},
        "ground": ["O", "Q"],
        "links": {
            "crank": {"nodes": ["O", "A"], "length": a[0]},
            "other": {"nodes": ["Q", "B"], "length": a[1]},
            "b1": {"nodes": ["A", "P"], "length": b[0]},
            "b2": {"nodes": ["B", "P"], "length": b[1]},
        },
        "actuators": {
            "motor": {"pivot": "O", "arm": "A", "law": law or {"from": 0, "to": 360}},
            "second": {"pivot": "Q", "arm": "B", "follows": "motor", "ratio": ratio, "phase": phase},
        },
        "trace": ["P"],
    }  # fmt: skip


def apex(turn, ratio, phase, d=3.0, a=(1.0, 1.2), b=(3.5, 3.0)):
    """Return P to the left of crank pin 1 -> crank pin 2."""
    one = a[0] * np.exp(1j * turn)
    two = d + a[1] * np.exp(1j * (ratio * turn + np.radians(phase)))
    apart = abs(two - one)
    along = (b[0] ** 2 - b[1] ** 2 + apart**2) / (2.0 * apart)
    return one + (two - one) / apart * (along + 1j * np.sqrt(b[0] ** 2 - along**2))


def with_gears(data, gears, **nodes):
    del data["actuators"]["second"]
    return {**data, "gears": gears, "nodes": {**data["nodes"], **nodes}}


PLANETARY = {
    "units": {"length": "mm", "angle": "deg"},
    "nodes": {"O": [0, 0], "S": [20, 0], "P": [35, 0], "T": [35, 12]},
    "ground": ["O"],
    "links": {"sun": ["O", "S"], "arm": ["O", "P"], "planet": ["P", "T"]},
    "actuators": {"motor": {"pivot": "O", "arm": "S", "law": {"from": 0, "to": 360}}},
    "gears": {
        "inner": {"members": ["sun", "planet"], "pivots": ["O", "P"], "carrier": "arm", "teeth": [40, 30]},
        "outer": {"type": "internal", "members": ["ground", "planet"], "pivots": ["O", "P"], "carrier": "arm",
                  "teeth": [100, 30]},
    },
    "trace": ["P", "T"],
}  # fmt: skip


def sun_and_planet(members=("rod", "sun"), pivots=("A", "O"), ratio=1.0):
    return {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [100, 0], "B": [100, 400], "C": [-200, 400], "S": [40, 0]},
        "ground": ["O", "C"],
        "links": {"crank": ["O", "A"], "rod": ["A", "B"], "beam": ["B", "C"], "sun": ["O", "S"]},
        "actuators": {"motor": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 720}}},
        "gears": {"mesh": {"members": list(members), "pivots": list(pivots), "carrier": "crank", "ratio": ratio}},
        "trace": ["S", "B"],
    }  # fmt: skip


def rack(radius=20.0):
    return {
        "units": {"length": "mm", "angle": "deg"},
        "nodes": {"O": [0, 0], "A": [30, 0], "B": [130, 0], "C": [160, 0], "G": [-200, 0], "H": [300, 0],
                  "Q": [150, radius], "T": [150, 2 * radius]},
        "ground": ["O", "G", "H", "Q"],
        "links": {"crank": ["O", "A"], "rod": ["A", "B"], "bar": ["B", "C"], "pinion": ["Q", "T"]},
        "prismatic": {"slide": {"nodes": ["B", "C"], "guide": ["G", "H"]}},
        "actuators": {"motor": {"pivot": "O", "arm": "A", "law": {"from": 0, "to": 720}}},
        "gears": {"mesh": {"type": "rack", "members": ["pinion", "bar"], "pivots": ["Q"], "radii": [radius]}},
        "trace": ["T"],
    }  # fmt: skip
