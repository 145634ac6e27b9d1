"""Windows side by side: what is taken of them."""

import numpy as np
import pytest

from shakerproc.diagnosis.estimation.stacks import slope_in_time

RATE = 5000.0


@pytest.mark.parametrize(("frequency", "error"), [(100.0, 1e-5), (250.0, 4e-4)])
def test_the_slope_in_time_of_a_sine_is_its_cosine(frequency, error):
    time, omega = np.arange(400) / RATE, 2.0 * np.pi * frequency
    slope = slope_in_time(np.sin(omega * time)[None], RATE)[0]
    left = slope[2:-2] - omega * np.cos(omega * time[2:-2])
    assert np.max(np.abs(left)) < error * omega


def test_the_slope_of_few_samples_is_that_of_neighbours():
    assert slope_in_time(np.array([[0.0, 1.0, 4.0]]), 2.0).tolist() == [[2.0, 4.0, 6.0]]
