"""Fixtures: the bundled models, one after the other, and a motion of one."""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command line does; read when numpy is imported

import pytest
from bundled import FILES, run_model


@pytest.fixture
def trace_model():
    return run_model


@pytest.fixture(params=FILES, ids=lambda path: path.stem)
def model(request):
    return request.param
