"""Tests ready for the residual, and the noise that is drawn beside them."""

import gc
import weakref

import numpy as np
import pytest
from numpy.testing import assert_allclose
from tests.diagnosis.one_mass import data_of, one_mass


def test_inputs_with_noise_go_through_their_samples_in_as_many_parts():
    data = data_of(one_mass())
    for given, other, test in zip(
        data.inputs, data.shaken[0].inputs, data.shaken[0].tests, strict=True
    ):
        assert other.stride == given.stride
        assert_allclose(other.samples, test.input, atol=1e-9 * np.max(np.abs(test.input)))


@pytest.fixture
def no_garbage_collection():
    gc.disable()
    yield
    gc.enable()


@pytest.mark.usefixtures("no_garbage_collection")
def test_tests_are_freed_as_soon_as_nobody_needs_them():
    data = data_of(one_mass())
    assert data.shaken[0].inputs
    alive = weakref.ref(data.inputs[0])
    del data
    assert alive() is None
