"""Extreme mechanisms: closed forms with 40 digits, and the accuracy that is possible.

`condition` is the displacement of nodes relative to the size, divided by the relative change of a length that causes
it. A rounding error u of the lengths moves nodes by condition * u: no method in double precision is more accurate.
Sweeps stop by eqs (1) and (2) of Petuya et al. 2004: their error is condition * tolerance, and near a double root at
most the square root of the tolerance.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from mpmath import mp, mpc, mpf
from specifications import four_bar, ray, read, run, size

from gimcli import load
from gimcli.motion.solve import solve
from gimcli.positions.options import Options

mp.dps = 40
U = 2.0**-53
TOLERANCE = 1e-10
METHODS = ("auto", "newton", "gim")

ROUNDINGS = 40.0
"""Rounding errors of a few lengths that add up at a node."""

SWEPT = 16.0
"""Restrictions of a loop whose errors, each equal to the tolerance, add up."""


def drawn(spec, **places):
    """Return a specification with the coordinates of nodes added or replaced."""
    spec = copy.deepcopy(spec)
    spec["nodes"] = {name: [complex(z).real, complex(z).imag] for name, z in (spec["nodes"] | places).items()}
    return {"links": {}, "elements": {}, "actuators": {}, **spec}


def rotary(start, end, **more):
    return {"motor": {"type": "rotary", "pivot": "O2", "arm": "A", "law": {"from": start, "to": end}} | more}


def link(a, b, length):
    return {"nodes": [a, b], "length": length}


def meet(a, ra, b, rb, side=1):
    """Return the intersection of circles around a, b, left (side 1) or right of a -> b, and its distance from a-b."""
    a, b = mpc(a), mpc(b)
    d = abs(b - a)
    x = (mpf(ra) ** 2 - mpf(rb) ** 2 + d**2) / (2 * d)
    h = mp.sqrt(mpf(ra) ** 2 - x**2)
    return a + (b - a) / d * (x + mpc(0, side) * h), h


def exact_ray(degrees):
    return mp.expjpi(mpf(float(degrees)) / 180)


def tried(spec, tmp_path, **options):
    """Solve a specification at the start of its laws."""
    path = tmp_path / "model.yaml"
    path.write_text(json.dumps(spec))
    mechanism = load(path)
    position = solve(mechanism, mechanism.start_inputs, Options(**options))
    return position, dict(zip(mechanism.nodes, mechanism.to_file(position.z), strict=True))


# --- mechanisms ------------------------------------------------------------------------------------------


def near_change_point(delta, side, start, end):
    """Return crank 1, coupler 3, rocker 2, frame 4 - delta: the dyad is nearly stretched at 180 deg."""
    frame = 4.0 - delta
    b, _ = meet(1j, 3, frame, 2, side)
    spec = drawn(four_bar(1, 3, 2, frame), A=1j, B=b)
    return spec | {"actuators": rotary(start, end)}, frame


def stretched(gap):
    links = {"left": link("O2", "C", 1), "right": link("D", "C", 1)}
    return drawn({"nodes": {"O2": 0, "D": 2 - gap, "C": 1 + 0.3j}, "ground": ["O2", "D"], "links": links})


def slider_crank(rod, start, end, direction=1.0, offset=0.0, at=0.5, reach=None):
    """Return a slider-crank 1 : rod along a guide, drawn at the crank angle `at` [rad] from the guide."""
    pin = np.exp(1j * at)
    slider = pin.real + np.sqrt(rod**2 - (pin.imag - offset) ** 2) + 1j * offset
    reach = reach or 2.0 * rod
    nodes = {"O2": 0, "H": reach + 0j, "A": pin, "B": slider}
    spec = {
        "nodes": {name: z * direction for name, z in nodes.items()}, "ground": ["O2", "H"],
        "links": {"crank": link("O2", "A", 1), "rod": link("A", "B", rod)},
        "prismatic": {"slide": {"node": "B", "guide": ["O2", "H"], "offset": offset}},
    }  # fmt: skip
    return drawn(spec) | {"actuators": rotary(start, end)}


def slider_place(angle, rod, offset=0.0):
    a = exact_ray(angle)
    return a.real + mp.sqrt(mpf(rod) ** 2 - (a.imag - mpf(offset)) ** 2)


def slider_driven(law):
    table = {"table": {"type": "linear", "node": "B", "guide": ["O2", "H"], "law": law}}
    return slider_crank(3, 0, 1, at=0.4) | {"actuators": table}


def crank_angle(x):
    x = mpf(x)
    return mp.acos((x**2 - 8) / (2 * x))


def scissor(n, width, law):
    height = np.sqrt(4 - width**2)
    nodes = {"L0": 0, "X": 2, "R0": width}
    elements, shape = {}, [[0, 0], [1, 0], [2, 0]]
    for k in range(1, n + 1):
        nodes |= {
            f"C{k}": width / 2 + 1j * (k - 0.5) * height,
            f"L{k}": 1j * k * height,
            f"R{k}": width + 1j * k * height,
        }
        for name, ends in ((f"a{k}", (f"L{k - 1}", f"C{k}", f"R{k}")), (f"b{k}", (f"R{k - 1}", f"C{k}", f"L{k}"))):
            elements[name] = {"nodes": list(ends), "shape": dict(zip(ends, shape, strict=True))}
    spec = drawn({"nodes": nodes, "ground": ["L0", "X"], "elements": elements})
    spec["prismatic"] = {"roller": {"node": "R0", "guide": ["L0", "X"]}}
    spec["actuators"] = {"ram": {"type": "linear", "node": "R0", "guide": ["L0", "X"], "law": law}}
    return spec


def windows(n, start, end):
    nodes = {f"O{k}": k for k in range(n + 1)} | {f"B{k}": k + ray(60.0) for k in range(n + 1)}
    links = {f"v{k}": link(f"O{k}", f"B{k}", 1) for k in range(n + 1)}
    links |= {f"h{k}": link(f"B{k}", f"B{k + 1}", 1) for k in range(n)}
    spec = drawn({"nodes": nodes, "ground": [f"O{k}" for k in range(n + 1)], "links": links})
    motor = {"type": "rotary", "pivot": "O0", "arm": "B0", "law": {"from": start, "to": end}}
    return spec | {"actuators": {"motor": motor}}


def third_crank(error):
    nodes = {"O2": 0, "E": 1.25, "D": 2.5} | {n: z + ray(60.0) for n, z in {"A": 0, "F": 1.25, "C": 2.5}.items()}
    links = {"left": link("O2", "A", 1), "middle": link("E", "F", 1 + error), "right": link("D", "C", 1)}
    spec = drawn({"nodes": nodes, "ground": ["O2", "E", "D"], "links": links})
    spec["elements"] = {"bar": {"nodes": ["A", "F", "C"], "shape": {"A": [0, 0], "F": [1.25, 0], "C": [2.5, 0]}}}
    return spec | {"actuators": rotary(20, 160)}


def walker(error):
    spec = copy.deepcopy(read("plantigrade"))
    spec["links"]["swinging_foot"]["length"] += error * 6
    return spec


# --- motions with a closed form --------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """A motion whose positions are known."""

    name: str
    spec: dict
    steps: int
    exact: Callable[[float], dict | list]  # nodes at a value of the first actuator, or a list of allowed positions
    condition: Callable[[float], float]  # at a value of the first actuator
    swept: float = 1.0  # least part of the rows that sweeps must solve
    unknown: Callable[[float], bool] = lambda value: False  # values where two branches cross: not compared

    def run(self, method, steps=None, **more):
        return run(self.spec, steps or self.steps, method=method, **more)

    def rounding(self, value):
        """Return the effect of a few rounding errors of the dimensions on a position."""
        return ROUNDINGS * U * self.condition(value) * size(self.spec)

    def limit(self, method, value):
        """Return the largest accepted error of a row that is ok."""
        big, tolerance = size(self.spec), TOLERANCE
        if method != "gim":
            return max(tolerance * big, self.rounding(value))
        swept = SWEPT * big * min(self.condition(value) * tolerance, tolerance**0.5)
        return max(tolerance * big, swept, self.rounding(value))

    def error(self, m, row):
        """Return the largest distance of a node from its exact position."""
        value = m.value[next(iter(m.value))][row]
        places = self.exact(value)
        places = places if isinstance(places, list) else [places]
        return float(min(max(abs(mpc(m.z[n][row]) - z) for n, z in place.items()) for place in places))

    def compared(self, m):
        """Return the rows that are ok, except those close to a crossing of two branches."""
        value = m.value[next(iter(m.value))]
        return [k for k, status in enumerate(m.status) if status == "ok" and not self.unknown(value[k])]

    def value(self, m, row):
        return m.value[next(iter(m.value))][row]


def over(h, scale=1.0):
    """Return the condition of a dyad whose apex has the distance h from the line of its centres."""
    return float(scale / max(abs(h), mpf(1e-300)))


def change_point(delta, side, ends=(90, 270), steps=36):
    spec, frame = near_change_point(delta, side, *ends)

    def dyad(angle, side=side):
        return meet(exact_ray(angle), 3, frame, 2, side)

    def places(angle):  # if rounding of the frame closes the gap, the other branch is also allowed
        merged = dyad(180)[1] ** 2 < ROUNDINGS * U
        return [{"B": dyad(angle, s)[0]} for s in ((side, -side) if merged else (side,))]

    far = 0.5 - 1.0 / steps if abs(ends[1] - ends[0]) > 90 else 0.0
    return Case(
        f"change point missed by {delta:g}", spec, steps, places, lambda a: over(dyad(a)[1], 1.2),
        swept=1.0 if delta > 1e-4 else far,
    )  # fmt: skip


def parallelogram(start, end, steps):
    spec = drawn(four_bar(1, 3, 1, 3), A=ray(50), B=3 + ray(50)) | {"actuators": rotary(start, end)}

    def slope(angle):
        return over(mp.sin(mp.radians(mpf(float(angle)))) if angle % 180 else 0)

    return Case(
        f"parallelogram, {start:g} to {end:g} deg", spec, steps, lambda a: {"B": 3 + exact_ray(a)}, slope, swept=0.1,
        unknown=lambda a: abs((a + 90) % 180 - 90) < 1e-3,
    )  # fmt: skip


def kite(start, end, steps):
    """Crank and frame 1, coupler and rocker 2: at 0 deg the crank pin is at the other pivot."""

    def place(angle):
        half = exact_ray(mpf(float(angle)) / 2)
        return half * (half.real + mp.sqrt(4 - half.imag**2))

    b = complex(place(60))
    spec = drawn(four_bar(1, 2, 2, 1), A=ray(60), B=b) | {"actuators": rotary(start, end)}

    def condition(angle):
        return over(mp.sin(mp.radians(mpf(float(angle)) / 2)), 4) if angle % 360 else 1e300

    return Case(
        f"kite, {start:g} to {end:g} deg", spec, steps, lambda a: {"B": place(a)}, condition, swept=0.4,
        unknown=lambda a: abs((a + 180) % 360 - 180) < 1e-3,
    )  # fmt: skip


def dead_centre(law, steps):
    spec = slider_driven(law)
    sides = (1, -1) if "profile" in law else (1,)  # after the dead centre both motions are allowed

    def place(x):
        angle = crank_angle(min(mpf(float(x)), mpf(4)))
        return [{"A": mp.expj(side * angle), "B": mpc(float(x))} for side in sides]

    def condition(x):
        return over(mp.sqrt(max(4 - mpf(float(x)), 0)), 2)

    return Case(f"slider driven to its dead centre, {law}", spec, steps, place, condition, swept=0.4)


def long_rod(ratio, steps=36):
    return Case(
        f"slider-crank 1 : {ratio:g}", slider_crank(ratio, 0, 360), steps,
        lambda a: {"A": exact_ray(a), "B": slider_place(a, ratio)}, lambda a: 1.0,
    )  # fmt: skip


def short_links(ratio, side=1):
    """Short crank and frame, long coupler and follower: a double crank."""
    a, c = 1 / ratio**0.5, ratio**0.5
    frame = 0.9 * a
    b, _ = meet(a * 1j, c, frame, c, side)
    spec = drawn(four_bar(a, c, c, frame), A=a * 1j, B=b) | {"actuators": rotary(90, 450)}

    def place(angle):
        return {"B": meet(mpf(a) * exact_ray(angle), c, frame, c, side)[0]}

    def condition(angle):  # the angle between both long links is about |A - O4| / c
        return over(abs(mpf(a) * exact_ray(angle) - frame), c)

    return Case(f"four-bar with lengths 1 : {ratio:g}", spec, 36, place, condition, swept=0.0)


def scaled(factor):
    lengths = [length * factor for length in (40, 120, 80, 100)]

    def place(angle):
        return {"B": meet(mpf(lengths[0]) * exact_ray(angle), lengths[1], lengths[3], lengths[2])[0]}

    spec = drawn(four_bar(*lengths), A=lengths[0] * 1j, B=complex(place(90)["B"])) | {"actuators": rotary(0, 360)}
    return Case(f"four-bar in units of {factor:g}", spec, 36, place, lambda a: 4.0)


def one_file(small, large):
    """Crank and rod of very different lengths in one file."""
    spec = slider_crank(large / small, 0, 360)
    for name, z in spec["nodes"].items():
        spec["nodes"][name] = [z[0] * small, z[1] * small]
    spec["links"] = {"crank": link("O2", "A", small), "rod": link("A", "B", large)}

    def place(angle):
        a = mpf(small) * exact_ray(angle)
        return {"A": a, "B": a.real + mp.sqrt(mpf(large) ** 2 - a.imag**2)}

    return Case(f"lengths {small:g} and {large:g} in one file", spec, 36, place, lambda a: 1.0)


def far_off(offset):
    def place(angle):
        b = meet(exact_ray(angle), 2.5, 2, 2.5)[0]
        return {"B": mpc(offset) + b}

    nodes = {"O2": offset, "O4": offset + 2, "A": offset + 1j, "B": offset + 2 + 2.5j}
    spec = drawn(four_bar(1, 2.5, 2.5, 2) | {"nodes": nodes}) | {"actuators": rotary(90, 450)}
    lost = abs(offset) / size(spec)  # factor by which the file's numbers lose accuracy
    return Case(f"four-bar {abs(offset):.2g} from the origin", spec, 36, place, lambda a: 4.0 + lost)


def sliver(height):
    """A very flat ternary coupler with P nearly on the line A-B; P drives another dyad."""
    frame = 2.0

    def coupler(angle):
        a = exact_ray(angle)
        b = meet(a, 2.5, frame, 2.5)[0]
        p = a + (b - a) / mpf(2.5) * mpc(1.25, height)
        return {"B": b, "P": p, "E": meet(p, 3, 4, 3)[0]}

    spec = four_bar(1, 2.5, 2.5, frame)
    del spec["links"]["coupler"]
    at = {n: complex(z) for n, z in coupler(90).items()}
    spec = drawn(spec | {"nodes": spec["nodes"] | {"F": 4}}, A=1j, **at)
    spec["ground"] = ["O2", "O4", "F"]
    shape = {"A": [0, 0], "B": [2.5, 0], "P": [1.25, height]}
    spec["elements"] = {"coupler": {"nodes": ["A", "B", "P"], "shape": shape}}
    spec["links"] |= {"e": link("P", "E", 3), "f": link("F", "E", 3)}
    return Case(
        f"ternary member {height:g} from flat", spec | {"actuators": rotary(90, 450)}, 36, coupler, lambda a: 10.0
    )


def steep_rod(delta):
    """The rod nearly perpendicular to its guide at -90 deg."""
    offset = 2.0 - delta
    spec = slider_crank(3, -60, -120, offset=offset, at=np.radians(-60.0))

    def lean(angle):
        return slider_place(angle, 3, offset) - exact_ray(angle).real

    return Case(
        f"rod {delta:g} from perpendicular to its guide", spec, 30,
        lambda a: {"B": mpc(slider_place(a, 3, offset), mpf(offset))}, lambda a: over(lean(a), 3), swept=0.4,
    )  # fmt: skip


def guides(angle):
    """A pin in two slots, one of them on a crank, that become nearly parallel."""
    reach = 1.0 / np.tan(np.radians(20.0))
    nodes = {"O2": 1j, "A": 1j - ray(20.0), "H": -2, "K": -1, "B": -reach}
    spec = drawn({"nodes": nodes, "ground": ["O2", "H", "K"], "links": {"crank": link("O2", "A", 1)}})
    spec["prismatic"] = {"slot": {"node": "B", "guide": ["O2", "A"]}, "rail": {"node": "B", "guide": ["H", "K"]}}

    def place(value):
        return {"B": -mp.cot(mp.radians(mpf(float(value)) - 180))}

    def condition(value):  # of the pin's position, which moves to infinity
        sine = mp.sin(mp.radians(mpf(float(value)) - 180))
        return float(1 / sine**2)

    return Case(
        f"slots {angle:g} deg from parallel",
        spec | {"actuators": rotary(200, 180 + angle)},
        20,
        place,
        condition,
        swept=0.8,
    )


def chain_of_windows(n):
    return Case(
        f"{n} windows", windows(n, 20, 160), 6,
        lambda a: {f"B{k}": k + exact_ray(a) for k in (1, n // 2, n)},
        lambda a: over(mp.sin(mp.radians(mpf(float(a)))), n),
    )  # fmt: skip


def chain_of_scissors(n):
    def place(w):
        height = mp.sqrt(4 - mpf(float(w)) ** 2)
        return {f"L{k}": mpc(0, k * height) for k in (1, n // 2, n)}

    swept = (
        1.0 if n < 40 else 0.0
    )  # the top moves by many lengths per step: sweeps may converge to other configurations
    return Case(f"{n} scissors", scissor(n, 1.2, {"from": 1.2, "to": 1.6}), 4, place, lambda w: 2.0 * n, swept=swept)


def redundant(error):
    return Case(
        f"third crank too long by {error:g}", third_crank(error), 8,
        lambda a: {"C": 2.5 + exact_ray(a), "F": 1.25 + exact_ray(a)},
        lambda a: over(mp.sin(mp.radians(mpf(float(a)))), 1 + abs(error) / U),
    )  # fmt: skip
