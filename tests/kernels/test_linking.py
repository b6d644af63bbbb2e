"""Called kernels are translated once, whatever constants they are called with, and are part of their caller's code."""

import numba
import numpy as np
import pytest
from bundled import MODELS
from numba.core import event

from gimcli import load
from gimcli.kernels import jit, march
from gimcli.kernels.jit import kernel, stage, stub
from gimcli.motion.motion import kernel_names
from gimcli.positions.program import plan_program
from gimcli.structure.plan import make_plan


@kernel
def raised(value, power):
    result = 1.0
    for _ in range(power):
        result *= value
    return result


@stage
def add_power(to, value, power):
    to[0] += raised(value, power)


@stub(add_power, "short")
def add_nothing(to, value, power):
    pass


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


def test_a_variant_contains_stubs_and_has_a_file_of_its_own(compiled):
    _, _, folder = compiled
    assert jit.is_cached("polynomial")
    assert not jit.is_cached("polynomial_short")
    seen, short = Compilations(), jit._compiled.__wrapped__(polynomial, inner=False, variant="short")
    to = np.zeros(1)
    with event.install_listener("numba:compile", seen):
        assert short(to, 3.0) == 243.0
    assert to[0] == 0.0
    assert sorted(seen.names) == ["add_nothing", "polynomial", "raised"]
    assert jit.is_cached("polynomial", "polynomial_short")
    assert len(list(folder.iterdir())) == 2


@pytest.mark.parametrize("name", ["jansen", "stephenson_3_far"])
def test_the_kernel_of_a_motion_has_the_name_by_which_its_cache_is_found(name, tmp_path, monkeypatch):
    monkeypatch.setattr(jit, "cache_folder", lambda: tmp_path)
    program = plan_program(mechanism := load(MODELS / f"{name}.yaml"), make_plan(mechanism))
    names = kernel_names(make_plan(mechanism))
    own = jit._compiled.__wrapped__(march.march, False, program.variant)
    assert own._cache._stem.split("-")[0].split(".")[1] in names


def test_kernels_run_interpreted_if_numba_is_switched_off(monkeypatch):
    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    jit._compiled.cache_clear()
    to = np.zeros(1)
    assert jit.compiled(polynomial)(to, 3.0) == 243.0
    assert to[0] == 9.0 + 27.0 + 81.0
    jit._compiled.cache_clear()
