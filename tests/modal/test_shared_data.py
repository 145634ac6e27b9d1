"""Published measurements: modes that others have found there, and two ways to the same."""

import numpy as np
import pytest

from shakerproc.modal import Settings, identify_functions, identify_samples
from shakerproc.modal.output_only import identify_output_only
from shakerproc.recordings import open_recording

pytestmark = [pytest.mark.shared, pytest.mark.slow]


def test_f16_has_its_modes_although_the_band_is_far_wider_than_the_input(shared):
    """Bending at 5.2 Hz and the wing's torsion near 7.3 Hz: Noel and Schoukens, 2017."""
    path = shared / "data" / "f16_level1" / "F16Data_FullMSine_Level1.csv"
    table = np.genfromtxt(path, delimiter=",", skip_header=1, usecols=(0, 2, 3, 4)).T
    found = identify_samples(table[:1], table[1:], 400.0, Settings((2.0, 60.0), order=50))
    for published in (5.2, 7.3):
        assert np.min(np.abs(found.frequency - published)) < 0.05
    assert np.max(found.model.unexplained) < 0.12


def test_cued_functions_of_the_authors_and_their_samples_have_one_main_mode(shared):
    folder = shared / "data" / "cued_gc4"
    samples = np.load(folder / "time_data.npz")["y"].T
    stored = np.load(folder / "tf_data.npz")
    settings = Settings((40.0, 150.0), order=40)
    ours = identify_samples(samples[:1], samples[1:], 1000.0, settings)
    theirs = identify_functions(stored["f"], stored["y"].T[:, np.newaxis], settings)
    for found in (ours, theirs):
        main = np.argmin(np.abs(found.frequency - 78.0))
        assert found.frequency[main] == pytest.approx(78.0, rel=2e-3)
        assert found.damping[main] == pytest.approx(0.007, rel=0.1)


def test_tower_output_only(shared):
    """0.806 Hz stands out of the densities of all eight sensors (SOURCES.md)."""
    with open_recording(shared / "data" / "tdms_owilab" / "good_tdms_1.tdms") as recording:
        samples = recording.samples()
    found = identify_output_only(samples, recording.sample_rate, Settings((0.2, 5.0), order=40))
    assert np.min(np.abs(found.frequency - 0.806)) < 0.02
