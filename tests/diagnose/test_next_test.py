"""The test that is proposed next: levels as a log says them, within the shaker's limits."""

import numpy as np
import pytest

from shakerproc.data import STANDARD_GRAVITY as G
from shakerproc.diagnose import TestArrays
from shakerproc.diagnose.next_test import _within, level_text, times_level
from shakerproc.testlog import Shaker
from shakerproc.testlog.levels import level_of

RATE = 1000.0


@pytest.mark.parametrize(
    ("level", "unit", "kind"),
    [
        (0.013 * G**2, "(m/s^2)^2/Hz", "random"),
        (1.5 * G, "m/s^2", "sine sweep"),
        (2.0 * G, "m/s^2 rms", "random"),
        (3.0, "N", "sine"),
    ],
)
def test_a_level_is_written_as_a_log_reads_it(level, unit, kind):
    read, its_unit = level_of(level_text(level, unit), kind)
    assert read == pytest.approx(level, rel=1e-2)
    assert its_unit == unit


def test_a_density_grows_with_the_square_of_the_amplitude():
    rows = np.ones((2, 100))
    test = TestArrays("t", RATE, rows, rows, False, "random", 0.01 * G**2, "(m/s^2)^2/Hz")
    assert times_level(test, 2.0, forced=False) == "0.04 g^2/Hz"
    unsaid = TestArrays("t", RATE, G * rows, rows)
    assert times_level(unsaid, 2.0, forced=False) == "2 g rms"


@pytest.mark.parametrize(
    ("shaker", "within"),
    [
        (Shaker(), True),
        (Shaker(acceleration=11.0), True),
        (Shaker(acceleration=9.0), False),
        (Shaker(velocity=1.1 * 10.0 / (40.0 * np.pi)), True),
        (Shaker(velocity=0.9 * 10.0 / (40.0 * np.pi)), False),
        (Shaker(stroke=2.2 * 10.0 / (40.0 * np.pi) ** 2), True),
        (Shaker(stroke=1.8 * 10.0 / (40.0 * np.pi) ** 2), False),
        (Shaker(force=50.0, moving_mass=4.0), True),
        (Shaker(force=50.0, moving_mass=6.0), False),
    ],
)
def test_a_sine_is_held_against_each_limit(shaker, within):
    """10 m/s² at 20 Hz: velocity over omega, displacement over its square."""
    t = np.arange(5000) / RATE
    assert _within(10.0 * np.sin(40.0 * np.pi * t), RATE, shaker) is within
