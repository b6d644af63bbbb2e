"""Run kernels with numbers that count operations: additions, multiplications, divisions, roots and functions."""

import math
from types import FunctionType, SimpleNamespace

import numpy as np

from gimcli.kernels import jit

COUNT = {"operations": 0}


def tick(value):
    COUNT["operations"] += 1
    return Counted(value)


class Counted(float):
    """A float that counts its operations; signs, comparisons and absolute values do not count."""

    def __neg__(self):
        return Counted(-float(self))

    def __abs__(self):
        return Counted(abs(float(self)))


def counting(name):
    plain = getattr(float, name)
    return lambda self, other: tick(plain(float(self), float(other)))


for operation in ("add", "radd", "sub", "rsub", "mul", "rmul", "truediv", "rtruediv"):
    setattr(Counted, f"__{operation}__", counting(f"__{operation}__"))

MATH = SimpleNamespace(**{name: getattr(math, name) for name in ("inf", "isfinite", "floor")})


def counting_function(function):
    return lambda x: tick(function(float(x)))


for function in ("sqrt", "cos", "sin"):
    setattr(MATH, function, counting_function(getattr(math, function)))
Counted.sqrt = MATH.sqrt  # numpy calls this method for objects


class Store(np.ndarray):
    """An array that converts floats written into it to counting numbers."""

    def __setitem__(self, at, value):
        super().__setitem__(at, Counted(value) if isinstance(value, float) else value)


def counted_array(a):
    """Return an array of counting numbers."""
    a = np.asarray(a, dtype=float)
    return np.array([Counted(v) for v in a.ravel()] or [], dtype=object).reshape(a.shape).view(Store)


def zeros(shape, dtype=float):
    return counted_array(np.zeros(shape)) if dtype is float else np.zeros(shape, dtype)


def each(function):
    """Return a function of arrays of counting numbers."""
    return lambda a: np.array([function(v) for v in a.ravel()], dtype=object).reshape(a.shape)


NUMPY = SimpleNamespace(zeros=zeros, int64=np.int64, cos=each(MATH.cos), sin=each(MATH.sin))


def counted(kernel):
    """Return a kernel in which roots and functions also count, and so in the kernels that it calls."""
    names = dict(kernel.__globals__)
    for name in kernel.__code__.co_names:
        if names.get(name) in jit._KERNELS:
            names[name] = counted(names[name])
    names.update({"math": MATH, "np": NUMPY})
    return FunctionType(kernel.__code__, names, kernel.__name__, kernel.__defaults__)


def counting_form(a):
    """Return an argument of a kernel, or a tuple of them, with counting numbers."""
    if isinstance(a, tuple):
        return type(a)(*map(counting_form, a))
    if isinstance(a, np.ndarray) and a.dtype.kind == "f":
        return counted_array(a)
    return Counted(a) if isinstance(a, float) else a


def operations(kernel, *arguments):
    """Return the number of operations of a kernel; operations with float arrays and floats count."""
    given = [counting_form(a) for a in arguments]
    COUNT["operations"] = 0
    counted(kernel)(*given)
    return COUNT["operations"]
