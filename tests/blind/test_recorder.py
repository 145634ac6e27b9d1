"""The recorder's filter against closed forms: a tone, and the sine integral of a jump."""

import numpy as np
import pytest
from blind.excitations import SAMPLE_RATE
from blind.nuisances import Nuisances
from blind.recorder import SUBSTEPS, responses
from blind.structures import Joint, Structure
from blind.truth import Motion
from numpy.testing import assert_allclose
from scipy.special import sici

N = 4096
STRUCTURE = Structure((1.0,), (Joint(-1, 0, 1.0, 1.0),))
MIDDLE = slice(400, -400)


def recorded(integral):
    """Return a response of which the integral over time is given, behind the filter."""
    fine = np.arange(N * SUBSTEPS + 1) / (SAMPLE_RATE * SUBSTEPS)
    means = np.diff(integral(fine)) * SAMPLE_RATE * SUBSTEPS
    none = np.empty((0, 1))
    motion = Motion(none, means[:, None], none, none, none, none, none)
    return responses(STRUCTURE, motion, Nuisances(), filtered=True)[0]


@pytest.mark.parametrize("share", [0.01, 0.2, 0.4])
def test_a_tone_below_its_corner_passes_as_it_is(share):
    turn = 2.0 * np.pi * share * SAMPLE_RATE
    t = np.arange(N) / SAMPLE_RATE
    out = recorded(lambda fine: np.sin(turn * fine + 0.3) / turn)
    assert_allclose(out[MIDDLE], np.cos(turn * t + 0.3)[MIDDLE], atol=1e-5)


@pytest.mark.parametrize("place", [0.0, 0.13, 0.7])
def test_a_jump_anywhere_between_samples_is_what_an_ideal_filter_makes_of_it(place):
    at = (N // 2 + place) / SAMPLE_RATE
    out = recorded(lambda fine: np.maximum(fine - at, 0.0))
    since = np.arange(N) / SAMPLE_RATE - at
    ideal = 0.5 + sici(2.0 * np.pi * 0.45 * SAMPLE_RATE * since)[0] / np.pi
    apart = np.fft.rfft((out - ideal)[MIDDLE] * np.hanning(N - 800))
    wanted = np.fft.rfft(ideal[MIDDLE] * np.hanning(N - 800))
    f = np.fft.rfftfreq(N - 800)
    band = (f > 0.02) & (f < 0.3)
    assert np.max(np.abs(apart[band]) / np.abs(wanted[band])) < 5e-3
