"""A tone of the control is not a resonance of what it shakes, whatever the log says of it."""

import re

import numpy as np
import pytest
from tests.runs.test_peak_tables import mode, processed
from tests.small_campaign import RATE

from shakerproc.campaign.trends import main_peak
from shakerproc.spectra import cross_spectra, steady_lines

TIME = np.arange(round(60.0 * RATE)) / RATE


def test_a_sine_drive_that_the_log_does_not_name_is_no_main_peak(tmp_path, capfd):
    rng = np.random.default_rng(1)
    base = np.sin(2.0 * np.pi * 25.02 * TIME) + 1e-3 * rng.standard_normal(TIME.size)
    response = mode(base, 80.0, 0.02) + 1e-3 * rng.standard_normal(TIME.size)
    response += 0.05 * response**2  # the second and third multiples are no resonances either
    summary, rows = processed(tmp_path, response, base)
    found = [float(row["frequency_hz"]) for row in rows if row["channel"] == "ch3"]
    for k in range(1, 5):
        assert all(abs(hz - 25.02 * k) > 4.0 for hz in found)
    peak = main_peak(summary, "ch3")
    assert peak is None or abs(peak.frequency_hz - 80.0) < 4.0
    assert "steady tone at 25.02 Hz with 100% of its power" in capfd.readouterr().err
    assert any("excitation: sine" in remark for remark in summary.remarks)


def test_mains_hum_in_a_random_control_is_not_taken_for_the_tallest_peak(tmp_path):
    rng = np.random.default_rng(2)
    base = rng.standard_normal(TIME.size) + 3.0 * np.sin(2.0 * np.pi * 50.0 * TIME)
    response = mode(base, 240.0, 0.05) + 20.0 * np.sin(2.0 * np.pi * 50.0 * TIME)
    summary, _ = processed(tmp_path, response, base, "--excitation", "random")
    assert abs(main_peak(summary, "ch3").frequency_hz - 240.0) < 6.0
    (peak,) = summary.channels[1].response_peaks
    assert abs(peak.frequency_hz - 240.0) < 6.0
    assert any("a steady tone at 50" in remark for remark in summary.remarks)


@pytest.mark.parametrize("width", [None, 0.2, 5.0])
def test_random_vibration_has_no_tones(width):
    """White, and with a narrow-band part of 0.2 and of 5 Hz."""
    rng, found = np.random.default_rng(3), 0
    for _ in range(10):
        base = rng.standard_normal(TIME.size)
        if width is not None:
            base += mode(rng.standard_normal(TIME.size), 300.0, width / 600.0)
        cross = cross_spectra(base[np.newaxis], RATE, segment=1024)
        found += bool(steady_lines(cross, [0], (5.0, 900.0)))
    assert found <= 2


@pytest.mark.parametrize("hz", [5.02, 12.7])
def test_a_drive_of_a_few_bins_is_told_at_its_own_frequency(hz, tmp_path, capfd):
    """Below where peaks are looked for, its side lobes within are no tones and no main peak."""
    rng = np.random.default_rng(4)
    base = np.sin(2.0 * np.pi * hz * TIME) + 1e-3 * rng.standard_normal(TIME.size)
    summary, _ = processed(tmp_path, base + 1e-3 * rng.standard_normal(TIME.size), base)
    assert main_peak(summary, "ch3") is None
    (told,) = [line for line in capfd.readouterr().err.splitlines() if "steady tone" in line]
    shown = float(re.search(r"at ([\d.]+) Hz", told)[1])
    assert abs(shown - hz) < 0.3
