"""Called kernels are translated once, whatever constants they are called with, and are part of their caller's code."""

import numpy as np
import pytest
from numba.core import event

from gimcli.kernels import jit
from gimcli.kernels.jit import kernel, stage


@kernel
def raised(value, power):
    result = 1.0
    for _ in range(power):
        result *= value
    return result


@stage
def add_power(to, value, power):
    to[0] += raised(value, power)


@kernel
def polynomial(to, value):
    add_power(to, value, 2)
    add_power(to, value, 3)
    add_power(to, value, 4)
    return raised(value, 5)


class Compilations(event.Listener):
    """The names of the functions that numba compiles."""

    def __init__(self):
        self.names = []

    def on_start(self, event):
        self.names.append(event.data["dispatcher"].py_func.__name__)

    def on_end(self, event):
        pass


@pytest.fixture
def compiled(tmp_path, monkeypatch):
    """The polynomial, compiled for numbers, with the names of what was compiled and the cache folder."""
    monkeypatch.setattr(jit, "cache_folder", lambda: tmp_path)
    seen = Compilations()
    function = jit._compiled.__wrapped__(polynomial, inner=False)
    with event.install_listener("numba:compile", seen):
        function(np.zeros(1), 2.0)
    return function, seen.names, tmp_path


def test_each_kernel_is_compiled_once_and_kept_in_the_file_of_its_caller(compiled):
    function, names, folder = compiled
    assert sorted(names) == ["add_power", "polynomial", "raised"]
    to = np.zeros(1)
    assert function(to, 3.0) == 243.0
    assert to[0] == 9.0 + 27.0 + 81.0
    assert [path.name.split("-")[0] for path in folder.iterdir()] == ["test_linking.polynomial"]


def test_a_called_kernel_has_no_code_of_its_own(compiled):
    function, _, _ = compiled
    called = function.py_func.__globals__["add_power"]
    (result,) = called.overloads.values()
    assert result.library.get_pointer_to_function(result.fndesc.llvm_func_name) == 0
