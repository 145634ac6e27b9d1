"""Response functions over several forces that act at once: each as if it acted alone."""

import numpy as np
import pytest
from benchmarks.modal_signals import draw
from numpy.testing import assert_allclose

from shakerproc import spectra
from shakerproc.data import Channel, recording_of_arrays
from shakerproc.runs import process_recording
from shakerproc.testlog import Processing, Test, Welch

G = 9.80665


@pytest.fixture(scope="module")
def structure():
    return draw(np.random.default_rng(21), 3, n_inputs=2, noise_db=50.0, duration=120.0)


def processed(structure, forces, segment=5120):
    names = [f"f{i}" for i in range(1, len(forces) + 1)]
    channels = (
        *(Channel(name, "N", name, "N", "force") for name in names),
        *(Channel(f"a{i}", "m/s^2", f"a{i}", "g", "response") for i in range(1, 3)),
    )
    rows = np.concatenate([forces, structure.response[:2]])
    test = Test(
        1,
        excitation="random",
        from_hz=5.0,
        to_hz=205.0,
        processing=Processing(crop=None, welch=Welch(segment, segment // 2, window="hann")),
    )
    result = process_recording(
        recording_of_arrays("run", channels, rows, structure.sample_rate), test
    )
    return {one.kind: one for one in result.analyses}


def closed_form(structure, force, sensor, frequency):
    """Return the accelerance of a sum of modes [g/N]."""
    s = 2j * np.pi * frequency
    total = np.zeros(frequency.size, complex)
    for f, zeta, shape in zip(
        structure.frequency, structure.damping, structure.shapes, strict=True
    ):
        omega = 2.0 * np.pi * f
        gain = s**2 / (s**2 + 2.0 * zeta * omega * s + omega**2)
        total += shape[sensor] * shape[structure.driven[force]] * gain
    return total / G


@pytest.mark.parametrize("estimator", ["h1", "h2", "hv"])
def test_each_function_is_that_of_its_force_alone(structure, estimator):
    functions = processed(structure, structure.force)["response_functions"]
    assert [row["function"] for row in functions.summary] == [
        "a1 / f1", "a2 / f1", "a1 / f2", "a2 / f2",
    ]  # fmt: skip
    columns = functions.columns
    frequency = columns["frequency_hz"]
    away = np.abs(frequency[:, np.newaxis] / structure.frequency - 1.0).min(axis=1) > 0.05
    for k, j in ((0, 0), (1, 0), (0, 1), (1, 1)):
        name = f"a{k + 1}_over_f{j + 1}"
        truth = np.abs(closed_form(structure, j, k, frequency))
        strong = columns[f"excited_{name}"] & away & (truth > 0.1 * np.median(truth))
        found = columns[f"{estimator}_{name}_magnitude_g_per_N"]
        assert np.median(np.abs(found[strong] / truth[strong] - 1.0)) < 0.02
        assert columns[f"coherence_{name}"][strong].mean() > 0.95


def test_resonances_of_several_forces_are_those_of_the_structure(structure):
    rows = processed(structure, structure.force)["resonances"].summary
    known = [row["natural_frequency_hz"] for row in rows if row["natural_frequency_hz"]]
    for frequency in known:
        assert np.min(np.abs(structure.frequency / frequency - 1.0)) < 0.01
    assert {row["function"][-2:] for row in rows} == {"f1", "f2"}


def test_conditioned_h1_is_that_of_several_inputs_at_once():
    """Two ways to the same (Frisch and Waugh), with forces that are half alike."""
    rng = np.random.default_rng(4)
    x = rng.standard_normal((3, 20_000))
    x[1] += x[0]
    rows = np.vstack([x, x[0] - 2.0 * x[1] + 0.5 * rng.standard_normal(20_000)])
    cross = spectra.cross_spectra(rows, 1000.0, segment=256)
    together = spectra.h1_of_inputs(cross, [0, 1, 2], [3])[0]
    for k in range(3):
        left = spectra.conditioned(cross, [i for i in range(3) if i != k])
        assert_allclose(spectra.h1(left, [k], [3])[0], together[k], rtol=1e-9)
        assert left.effective_averages == pytest.approx(cross.effective_averages - 2.0)
    with pytest.raises(ValueError, match="averages do not tell 4 inputs apart"):
        spectra.conditioned(
            spectra.cross_spectra(rows[:, :600], 1000.0, segment=300), [0, 1, 2]
        )


def test_forces_that_move_as_one_are_told(structure):
    both = processed(structure, np.stack([structure.force[0], 2.0 * structure.force[0]]))
    functions = both["response_functions"]
    assert functions.summary == ()
    assert len(functions.sentences) == 2
    assert "No response function over f1: it moves as one with f2" in functions.sentences[0]
    assert "independent signals, or one at a time" in functions.sentences[0]


def test_too_few_averages_are_told(structure):
    functions = processed(structure, structure.force, segment=61_440)["response_functions"]
    assert functions.summary == ()
    assert "averages do not tell 2 forces apart; shorten the segment" in functions.sentences[0]
