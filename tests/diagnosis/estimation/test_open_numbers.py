"""Numbers that few periods tell count as noise of what they were not fitted to."""

from dataclasses import replace

import numpy as np
import pytest
from tests.diagnosis.one_mass import arrays_of, one_mass

from shakerproc.diagnosis.data import prepared
from shakerproc.diagnosis.estimation.data_set import DataSet
from shakerproc.diagnosis.estimation.form import usable_forms
from shakerproc.diagnosis.estimation.least_squares import fit
from shakerproc.diagnosis.estimation.passed_noise import (
    prediction_of,
    with_open_numbers,
    with_passed_noise,
)
from shakerproc.diagnosis.hypotheses.hypothesis import hypothesis_of

NOISE, REPEATS = 0.1, 16


def _repeated(arrays, seed):
    """Return a test with noise of its own on the response, as another day would have."""
    noise = np.random.default_rng(seed).standard_normal(arrays.responses.shape)
    noisy = replace(arrays, responses=arrays.responses + NOISE * arrays.responses.std() * noise)
    return DataSet(one_mass(), prepared([noisy]))


def _fitted(data):
    none = hypothesis_of(one_mass())
    return fit(data, none, np.zeros(none.size), usable_forms(data)[-1].fitted, rounds=10)


def test_what_open_numbers_move_is_how_predictions_of_repeats_scatter():
    (arrays,) = arrays_of(one_mass(), levels=(2.0,), seconds=1.0)
    repeats = [_repeated(arrays, seed) for seed in range(REPEATS)]
    fits = [_fitted(data) for data in repeats]
    data, held_out = repeats[0], usable_forms(repeats[0])[-1].held_out
    runs = [prediction_of(data, replace(fits[0], x=one.x), held_out) for one in fits]
    scatter = np.std([run.outputs[0] for run in runs], axis=0, ddof=1)
    before = with_passed_noise(data, fits[0], held_out)
    told = with_open_numbers(data, fits[0], before)
    moved = np.sqrt(told.passed[0] ** 2 - before.passed[0] ** 2)
    sizes = [np.sqrt(np.mean(one[:, held_out.counted[0]] ** 2)) for one in (moved, scatter)]
    assert sizes[0] == pytest.approx(sizes[1], rel=0.4)


def test_a_law_that_does_not_explain_its_own_tests_has_no_such_scatter():
    (arrays,) = arrays_of(one_mass(), levels=(2.0,), seconds=1.0)
    data = _repeated(arrays, 0)
    found = _fitted(data)
    held_out = with_passed_noise(data, found, usable_forms(data)[-1].held_out)
    off = replace(found, rows=np.full_like(found.rows, 100.0))
    assert with_open_numbers(data, off, held_out) is held_out
