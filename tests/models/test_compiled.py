"""Kernels compiled for other kernels alone; oracle: the same functions, run by Python."""

import importlib.util
import sys

import numpy as np
import pytest
from numpy.testing import assert_array_equal

SOURCE = """
from shakerproc.models.compiled import compiled, inlined, inner

@inlined
def cubed(x):
    return x * x * x

@inner
def march(rows, k):
    total = 0.0
    for i in range(rows.shape[1]):
        total += cubed(rows[k, i]) / (1.0 + abs(rows[k, i]))
        if total > 3.0:
            total -= 3.0
    return total

@compiled
def marched(rows, out):
    for k in range(rows.shape[0]):
        out[k] = march(rows, k)
"""


@pytest.fixture
def module(tmp_path, monkeypatch):
    path = tmp_path / "kernels_of_a_test.py"
    path.write_text(SOURCE)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    loaded = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, path.stem, loaded)
    spec.loader.exec_module(loaded)
    return loaded


def test_kernels_give_the_numbers_of_python_to_the_last_bit(module):
    rows = np.random.default_rng(1).standard_normal((7, 400))
    found, wanted = np.empty(7), np.empty(7)
    module.marched(rows, found)
    for k, row in enumerate(rows):
        total = 0.0
        for x in row.tolist():
            total += x * x * x / (1.0 + abs(x))
            total -= 3.0 if total > 3.0 else 0.0
        wanted[k] = total
    assert_array_equal(found, wanted)
