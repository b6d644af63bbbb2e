"""Derivatives of positions and of the numbers of plans by differences: the dimension in the model file is changed."""

import copy
from typing import NamedTuple

import numpy as np
import yaml

from gimcli import load, trace
from gimcli.positions.program import plan_program
from gimcli.structure.plan import make_plan

STEP = 1e-4


class PlanNumbers(NamedTuple):
    """The tables of `FloatTables` that positions depend on."""

    vz: np.ndarray
    lv: np.ndarray
    reach: np.ndarray
    gvz: np.ndarray
    gev: np.ndarray
    frame: np.ndarray


def numbers(mechanism, nominal):
    """Return the numbers of a mechanism's plan in the normal frame of another."""
    program, frame = plan_program(mechanism, make_plan(mechanism)), mechanism.members[0]
    assert mechanism.scale == nominal.scale
    q, g, places = program.arrays, program.group_arrays, np.zeros((len(mechanism.nodes), 2))
    shift = (mechanism.origin - nominal.origin) / mechanism.scale
    for node, z in zip(frame.nodes, frame.shape, strict=True):
        places[node] = (z + shift).real, (z + shift).imag
    return PlanNumbers(q.vz, q.lv, q.reach, g.vz, g.ev, places)


def read(path):
    """Return a model file as a dict."""
    return _keys(yaml.safe_load(path.read_text()))


def _keys(value):
    """Return a dict of YAML 1.1 with its keys `on` and `off` as texts."""
    if isinstance(value, dict):
        return {{True: "on", False: "off"}.get(key, key): _keys(one) for key, one in value.items()}
    return [_keys(one) for one in value] if isinstance(value, list) else value


def changed(model, path, change):
    """Return a copy of a model in which one number is changed."""
    model = found = copy.deepcopy(model)
    for key in path[:-1]:
        found = found[key]
    found[path[-1]] += change
    return model


def tangents(model, paths, step=STEP):
    """Return the numbers of a model and their derivatives by some dimensions, each with an axis of one design."""
    nominal = load(model)
    sides = [[numbers(load(changed(model, path, h)), nominal) for h in (step, -step)] for path in paths]
    slopes = [[(a - b) / (2 * step) for a, b in zip(*both, strict=True)] for both in sides]
    own = PlanNumbers(*(table[None] for table in numbers(nominal, nominal)))
    return own, PlanNumbers(*(np.array(some)[None] for some in zip(*slopes, strict=True)))


def differences(model, path, steps, step=STEP):
    """Return the derivatives of positions (nodes, rows) by a dimension, of order 4 in the step, in the normal frame."""
    nominal = load(model)

    def z(h):
        mechanism = load(changed(model, path, h))
        return trace(mechanism, steps, tolerance=1e-13).motion.z + (mechanism.origin - nominal.origin) / nominal.scale

    return (8 * (z(step) - z(-step)) - (z(2 * step) - z(-2 * step))) / (12 * step)
