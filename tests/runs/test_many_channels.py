"""Recordings of many channels: nothing is made that grows with the square of their number."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import signal

from shakerproc import spectra
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.recordings import health
from shakerproc.runs import averaging, process_recording
from shakerproc.runs.processing import find_crop
from shakerproc.testlog import ResponseFunction, Test, Welch

RATE, SEGMENT = 1000.0, 512
BINS = SEGMENT // 2 + 1


def moved_alike(count, n_samples):
    """Channels that share a motion, each with noise of its own."""
    generator = np.random.default_rng(5)
    own = generator.standard_normal((count, n_samples))
    return generator.standard_normal(n_samples) + 0.2 * own


def asked(*wanted):
    """A test whose log asks for response functions."""
    test = Test("many", excitation="random")
    wanted = tuple(ResponseFunction(*one) for one in wanted)
    welch = Welch(segment=SEGMENT, overlap=SEGMENT // 2)
    return replace(
        test,
        processing=replace(test.processing, welch=welch, response_functions=wanted, crop=None),
    )


def recording_of(samples, roles):
    channels = [
        Channel(f"a{i}", "m/s^2", f"a{i}", "m/s^2", role) for i, role in enumerate(roles)
    ]
    return recording_of_arrays("many", channels, samples, RATE)


@pytest.mark.parametrize("detrend", ["none", "mean", "segment mean"])
@pytest.mark.parametrize("inputs", [(), (2,), (3, 1), (0, 1, 2, 3)])
def test_spectra_of_some_inputs_are_those_of_scipy(inputs, detrend):
    samples = moved_alike(4, 5003) + np.arange(4)[:, None]
    found = spectra.cross_spectra(
        samples, RATE, segment=SEGMENT, detrend=detrend, inputs=inputs
    )
    given = samples - samples.mean(axis=1, keepdims=True) if detrend == "mean" else samples
    options = {
        "fs": RATE,
        "window": signal.get_window("hamming", SEGMENT, fftbins=False),
        "noverlap": SEGMENT // 2,
        "detrend": "constant" if detrend == "segment mean" else False,
    }
    density = signal.welch(given, **options)[1]
    assert_allclose(spectra.psd(found), density, rtol=1e-10, atol=1e-12 * density.max())
    assert found.matrix.shape == (len(inputs), 4, BINS)
    cross = [[signal.csd(given[i], other, **options)[1] for other in given] for i in inputs]
    if inputs:
        mine = found.between(inputs, range(4))
        assert_allclose(mine, cross, rtol=1e-10, atol=1e-12 * density.max())
    assert_allclose(
        found.lit_segments, spectra.cross_spectra(samples, RATE, segment=SEGMENT,
        detrend=detrend).lit_segments, rtol=1e-12)  # fmt: skip


def test_what_is_asked_of_a_channel_that_is_no_input_says_so():
    found = spectra.cross_spectra(moved_alike(3, 2000), RATE, segment=SEGMENT, inputs=[0])
    with pytest.raises(ValueError, match="row 1 is no input of these spectra"):
        spectra.h1(found, [1], [2])
    with pytest.raises(ValueError, match="inputs must be rows 0 to 2"):
        spectra.cross_spectra(moved_alike(3, 2000), RATE, segment=SEGMENT, inputs=[3])


def test_a_response_that_the_log_names_as_an_input_is_one(monkeypatch):
    monkeypatch.setattr(averaging, "ALL_PAIRS", 0.0)
    roles = ("control", "response", "response")
    result = process_recording(recording_of(moved_alike(3, 4000), roles), asked(("a2", "a1")))
    assert result.spectra.inputs == (0, 2)


def test_missing_shapes_are_told_and_nothing_else_changes(monkeypatch):
    recording = recording_of(moved_alike(3, 4000), ("control", "response", "response"))
    whole = process_recording(recording, asked())
    monkeypatch.setattr(averaging, "ALL_PAIRS", 0.0)
    few = process_recording(recording, asked())
    assert [note for note in few.notes if note.startswith("No shapes at the peaks")]
    assert not [note for note in whole.notes if note.startswith("No shapes")]
    assert_allclose(few.averages.against.h1, whole.averages.against.h1, rtol=1e-12)
    assert_allclose(few.averages.psd, whole.averages.psd, rtol=1e-12)


def test_of_two_hundred_responses_and_a_control_no_array_of_all_pairs_is_made():
    count = 201
    roles = ("control", *["response"] * (count - 1))
    recording = recording_of(moved_alike(count, 2048), roles)
    pairs, test = count * count * BINS * 16, asked()
    crop = find_crop(recording, test)
    tracemalloc.start()
    try:
        cross, _ = averaging.averaged(recording, crop, test)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert cross.matrix.shape == (1, count, BINS)
    assert peak < pairs / 4


def test_the_health_of_many_channels_takes_memory_in_proportion_to_them():
    def peak(count):
        recording = recording_of(moved_alike(count, 7000), ["response"] * count)
        tracemalloc.start()
        try:
            assert health(recording) == ()
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    assert peak(160) < 2.5 * peak(80)
