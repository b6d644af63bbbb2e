"""Derivatives of positions by differences: the dimension in the model file is changed."""

import copy

import yaml

from gimcli import load
from gimcli.motion.motion import trace
from gimcli.positions.options import Options

STEP = 1e-4


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


def differences(model, path, steps, step=STEP):
    """Return the derivatives of positions (nodes, rows) by a dimension, of order 4 in the step, in the normal frame."""
    nominal = load(model)

    def z(h):
        mechanism = load(changed(model, path, h))
        motion = trace(mechanism, steps, Options(tolerance=1e-13))
        return motion.z + (mechanism.origin - nominal.origin) / nominal.scale

    return (8 * (z(step) - z(-step)) - (z(2 * step) - z(-2 * step))) / (12 * step)
