"""Modes without a measured input: shapes without chance, and poles that the user wants kept."""

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.modal_signals import draw
from numpy.testing import assert_allclose
from scipy.signal import lfilter

from shakerproc.modal import Settings, identify_output_only, mac, phase_collinearity
from shakerproc.modal.shapes import scaled_to, without_chance

BAND = (3.0, 200.0)


@pytest.fixture(scope="module")
def structure():
    return draw(np.random.default_rng(3), 5, noise_db=40.0, duration=10.0)


def found_of(structure, **wishes):
    settings = Settings(BAND, order=40, **wishes)
    return identify_output_only(structure.response, structure.sample_rate, settings)


def driven(shapes, places, damping, *, seconds=60.0, rate=128.0):
    """Return responses of modes with shapes of any phase, each driven by noise of its own."""
    rng = np.random.default_rng(2)
    total = 0.0
    for shape, place in zip(shapes, places, strict=True):
        pole = 2.0 * np.pi * place * (-damping + 1j * np.sqrt(1.0 - damping**2))
        q = lfilter(
            [1.0], [1.0, -np.exp(pole / rate)], rng.standard_normal(int(seconds * rate))
        )
        total = total + np.real(np.outer(shape, q))
    return total + 1e-3 * np.std(total) * rng.standard_normal(total.shape)


def test_imaginary_parts_shrink_by_the_share_that_chance_has_in_them():
    shapes = np.array([[1.0 + 0.3j, -0.5 - 0.4j], [1.0 + 0.03j, 0.5 - 0.04j], [1.0, 2.0]])
    variance = np.array([[0.02, 0.03], [0.02, 0.03], [0.0, 0.0]])
    found = without_chance(shapes.astype(complex), variance)
    assert_allclose(found[0], [1.0 + 0.24j, -0.5 - 0.32j])  # 1 - 0.05 / 0.25 of them
    assert_allclose(found[1:].imag, 0.0)
    assert_allclose(found.real, shapes.real)


def test_shapes_are_compared_in_one_size_and_sign():
    shape = np.array([[1.0 + 0.1j, -0.6, 0.2j]])
    assert_allclose(scaled_to(-0.4 * shape, shape), shape)


def test_shapes_of_real_modes_are_real_and_those_of_complex_modes_are_not():
    places = (11.0, 23.0)
    real = np.array([[0.4, 0.8, 1.0, 0.7], [1.0, 0.6, -0.5, -0.9]])
    turned = real * np.exp(1j * np.array([[0.5, -0.4, 0.0, 0.4], [0.0, 0.5, -0.4, 0.3]]))
    for truth, complex_ in ((real + 0j, False), (turned, True)):
        found = identify_output_only(
            driven(truth, places, 0.01), 128.0, Settings((3.0, 50.0), order=20)
        )
        assert_allclose(found.frequency, places, rtol=5e-3)
        assert np.diag(mac(found.shapes, truth)).min() > 0.995
        assert_allclose(found.collinearity, phase_collinearity(truth), atol=0.06)
        assert (found.collinearity.max() < 0.95) == complex_
        if not complex_:
            assert found.collinearity.min() > 0.9999


def test_a_pole_that_the_user_wants_is_kept(structure):
    wanted = structure.frequency[0]
    alone = found_of(structure)
    assert np.min(np.abs(alone.frequency / wanted - 1.0)) > 0.05
    kept = found_of(structure, keep=(wanted,))
    assert kept.poles.size == alone.poles.size + 1
    assert kept.frequency[0] == pytest.approx(wanted, rel=5e-3)
    assert np.all(np.diff(kept.frequency) > 0.0)
    assert np.all(np.isfinite(kept.damping_error))
    fewer = found_of(structure, keep=(wanted,), modes=2)
    assert fewer.poles.size == 2
    assert fewer.frequency[0] == pytest.approx(wanted, rel=5e-3)


def test_what_is_wanted_and_not_there_is_told(structure):
    found = found_of(structure, keep=(60.0,), modes=40)
    assert "no pole within 2% of 60 Hz that could be kept" in found.notes
    assert any("40 modes were asked for, the measurement shows" in one for one in found.notes)


def test_a_record_without_modes_has_none():
    noise = np.random.default_rng(1).standard_normal((4, 8000))
    found = identify_output_only(noise, 512.0, replace(Settings(BAND), order=20))
    assert found.poles.size == 0
    assert found.shapes.shape == (0, 4)
