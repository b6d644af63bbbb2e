"""Shipped models with masses, driven or free, and their forces."""

from __future__ import annotations

import numpy as np
from bundled import MODELS, changed

from gimcli.dynamics.forces import piece_forces
from gimcli.dynamics.gear_reactions import across
from gimcli.dynamics.kinematic_history import Courses
from gimcli.dynamics.statics import direction, statics
from gimcli.kernels.equilibrium import COUPLE
from gimcli.mechanism import FRAME
from gimcli.motion.motion import trace
from gimcli.positions.dispatch import plain
from gimcli.structure.steps import NONE


def released(stem, change=None):
    """Load a model with free inputs and gravity; each member has mass 1 and inertia 0.3."""

    def heavy(data):
        data["units"] = {**data.get("units", {}), "length": "m"}
        parts = {**data.get("links", {}), **data.get("elements", {})}
        data["masses"] = {name: {"mass": 1.0, "inertia": 0.3} for name in parts}
        data["gravity"] = [0.0, -9.81]
        for section in ("loads", "springs", "dampers", "friction"):
            data.pop(section, None)
        for actuator in data["actuators"].values():
            if "follows" not in actuator:
                actuator["free"] = True
            for key in ("start", "speed", "effort"):
                actuator.pop(key, None)
        if change:
            change(data)

    return changed(MODELS / f"{stem}.yaml", None, heavy)


def motion_forces(motion, run=plain):
    """Return the efforts and reactions of a motion along its laws."""
    return piece_forces(statics(motion.mechanism), Courses(motion.mechanism), motion, run)


def on(forces, node, member):
    """Return the force that a member receives at a node."""
    mechanism = forces.mechanism
    names = [m.name for m in mechanism.members]
    pin = next(p for p in forces.statics.pins if mechanism.nodes[p.node] == node)
    return forces.pin(pin, names.index(member))


def weighted(path, change=None):
    """Load a model with a mass for every member, centres of mass off its line, gravity and loads."""

    def weigh(data):
        data.setdefault("units", {})
        if data["units"].get("length") == "unit":
            data["units"]["length"] = "m"
        given = [xy for xy in data["nodes"].values() if isinstance(xy, list)]
        size = float(np.ptp(np.array(given, dtype=float), axis=0).max())
        metre = {"mm": 1e-3, "cm": 1e-2, "in": 0.0254}.get(data["units"].get("length", "m"), 1.0)
        data["units"]["mass"] = "kg"
        for section in ("springs", "dampers", "friction"):
            data.pop(section, None)
        for actuator in data["actuators"].values():
            if "rate" in (actuator.get("law") or {}):
                actuator["law"] = {"by": 360}
        names = [*data.get("links", {}), *data.get("elements", {})]
        data["masses"] = {
            name: {"mass": 1.0 + k / 7, "inertia": (0.1 * size * metre) ** 2, "centre": [0.1 * size, 0.03 * size * k]}
            for k, name in enumerate(names)
        }
        data["gravity"] = [1.5, -9.81]
        data["loads"] = {
            "push": {"on": names[-1], "local": [0.2 * size, 0.1 * size], "force": [30.0, -50.0]},
            "jet": {"on": names[0], "local": [0.2 * size, 0.0], "follower": [3.0, 20.0]},
            "twist": {"on": names[-1], "torque": 2.0 * size * metre},
        }
        if change is not None:
            change(data)

    return changed(path, None, weigh)


def moved(mechanism, steps=24):
    """Return the motion, its forces, and which rows have both."""
    motion = trace(mechanism, steps)
    forces = motion_forces(motion)
    good = motion.good & forces.good
    assert good.sum() > 0.6 * motion.good.sum()
    return motion, forces, good


def total_on_frame(forces):
    """Return force [N] and moment [N m] on the frame, the sums of the reactions."""
    z, metre = forces.course.nodes[0], forces.mechanism.dynamics.metre
    along = np.array([direction(one, z) for one in forces.statics.reactions])
    force, moment = np.zeros(z.shape[1], dtype=complex), np.zeros(z.shape[1])
    for k, reaction in enumerate(forces.statics.reactions):
        for side, sense, node in ((reaction.plus, 1, reaction.node), (reaction.minus, -1, reaction.other)):
            if side == NONE and reaction.kind == COUPLE:
                moment += sense * forces.unknowns[k] * metre
            elif side == NONE:
                push = sense * along[k] * forces.unknowns[k]
                force += push
                moment += (z[node].conj() * push).imag * metre
        moment += sum(factor for body, factor in reaction.couples if body == NONE) * forces.unknowns[k] * metre
    for gear, unknown in zip(forces.mechanism.gears, forces.statics.teeth, strict=True):
        if FRAME in gear.members:  # wheels on the frame are pressed at their pivots
            k = gear.members.index(FRAME)
            push = across(forces.statics, gear, z) * np.abs(forces.unknowns[unknown]) * (1.0 if k else -1.0)
            force += push
            moment += (z[gear.pivots[k]].conj() * push).imag * metre
    return force, moment
