"""What the plan says of a sweep whose specimen no model describes."""

import re

import pytest
from numpy.testing import assert_allclose
from tests.planning.test_plan import planned

from shakerproc.spectra.tones.passing import swept_peak


@pytest.mark.parametrize("rate", [1.0, 4.0])
def test_a_sweep_says_from_which_q_on_its_peaks_are_low(tmp_path, rate):
    row = f"excitation: sine sweep, level: 1 g, from: 20 Hz, to: 500 Hz, rate: {rate} oct/min"
    (told,) = [text for text in planned(tmp_path, row).warnings if "too low" in text]
    found = re.findall(r"([\d.e+]+) at ([\d.]+) Hz", told)
    assert [float(hz) for _, hz in found] == [20.0, 500.0]
    for q, hz in found:
        speed = float(hz) * 0.693147 * rate / 60.0
        assert_allclose(swept_peak(speed, float(hz), 0.5 / float(q)), 0.95, atol=0.01)
