"""Modes of structures in closed form: modal superposition that shares no code with the fit."""

import numpy as np
import pytest
from benchmarks.modal_signals import draw
from numpy.testing import assert_allclose

from shakerproc.modal import (
    Settings,
    identify_functions,
    identify_samples,
    mac,
    normalised,
    phase_collinearity,
    response_functions,
)
from shakerproc.modal.gathering import twins_of
from shakerproc.modal.geometry import geometry_of
from shakerproc.modal.modal_model import ModeSet

BAND = (3.0, 200.0)


def closed_form_functions(structure, frequency):
    """Return accelerances, (n_sensors, n_inputs, n_frequencies)."""
    s = 2j * np.pi * frequency
    omega = 2.0 * np.pi * structure.frequency
    total = np.zeros(
        (structure.shapes.shape[1], len(structure.driven), frequency.size), complex
    )
    for w, zeta, shape in zip(omega, structure.damping, structure.shapes, strict=True):
        gain = s**2 / (s**2 + 2.0 * zeta * w * s + w**2)
        total += np.einsum("o,i,f->oif", shape, shape[list(structure.driven)], gain)
    return total


@pytest.fixture(scope="module")
def structure():
    return draw(np.random.default_rng(3), 5, n_inputs=2, noise_db=40.0, duration=12.0)


@pytest.fixture(scope="module")
def found(structure):
    return identify_samples(
        structure.force, structure.response, structure.sample_rate, Settings(BAND)
    )


def test_every_mode_is_found_and_no_other(structure, found):
    assert_allclose(found.frequency, structure.frequency, rtol=1e-3)
    assert_allclose(found.damping, structure.damping, rtol=0.05)
    assert np.diag(mac(found.shapes, structure.shapes.astype(complex))).min() > 0.99
    assert found.collinearity.min() > 0.999


def test_synthesis_is_the_closed_form(structure, found):
    frequency = np.linspace(5.0, 195.0, 2000)
    truth = closed_form_functions(structure, frequency)
    synthesis = response_functions(found.model, frequency)
    assert np.max(np.abs(synthesis - truth)) < 0.005 * np.max(np.abs(truth))


def test_response_functions_give_the_same_modes(structure):
    frequency = np.linspace(3.0, 200.0, 4000)
    rng = np.random.default_rng(1)
    truth = closed_form_functions(structure, frequency)
    noise = rng.standard_normal((2, *truth.shape)) * 0.003 * np.std(truth)
    found = identify_functions(frequency, truth + noise[0] + 1j * noise[1], Settings(BAND))
    assert_allclose(found.frequency, structure.frequency, rtol=1e-3)
    assert_allclose(found.damping, structure.damping, rtol=0.05)
    wanted = structure.shapes[:, list(structure.driven)]
    assert np.diag(mac(found.participation, wanted.astype(complex))).min() > 0.99


def test_as_many_modes_as_are_asked_for(structure):
    fewer = Settings((90.0, 115.0), modes=1)
    found = identify_samples(structure.force, structure.response, structure.sample_rate, fewer)
    assert found.poles.size == 1
    more = Settings((90.0, 115.0), modes=9)
    found = identify_samples(structure.force, structure.response, structure.sample_rate, more)
    assert any("9 modes were asked for" in note for note in found.notes)


def test_noise_alone_has_no_modes():
    rng = np.random.default_rng(5)
    inputs, responses = rng.standard_normal((1, 8000)), rng.standard_normal((4, 8000))
    assert identify_samples(inputs, responses, 512.0, Settings(BAND)).poles.size == 0


def test_an_order_too_high_for_the_lines_is_refused():
    rng = np.random.default_rng(6)
    with pytest.raises(ValueError, match="too high for 40 lines"):
        identify_samples(
            rng.standard_normal((1, 512)),
            rng.standard_normal((4, 512)),
            512.0,
            Settings((10.0, 49.0)),
        )


def test_mac_and_collinearity_by_hand():
    first = np.array([[1.0, 1.0, 0.0]], dtype=complex)
    second = np.array([[1.0, 1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 0.0, 0.0]], dtype=complex)
    assert_allclose(mac(first * 3j, second), [[1.0, 0.0, 0.5]], atol=1e-15)
    circling = np.array([[1.0, 1.0j], [2.0j, -4.0j]])
    assert_allclose(phase_collinearity(circling), [0.0, 1.0], atol=1e-15)
    assert_allclose(normalised(circling[1:] * np.exp(0.3j)), [[-0.5, 1.0]], atol=1e-15)


def test_sensors_on_a_line_are_seen_from_the_side_and_others_from_a_corner():
    line = [(x, 0.0, 0.0) for x in (0.0, 1.0, 3.0)]
    flat = geometry_of(line, [(0.0, 0.0, 1.0)] * 3)
    assert_allclose(flat.rest @ [3.0, 0.0], [-4.0 / 3.0, -1.0 / 3.0, 5.0 / 3.0], atol=1e-12)
    assert_allclose(flat.moved(np.array([1.0, 0.0, -1.0 + 0j]), 0.0)[:, 1] > 0.0, [1, 0, 0])
    assert flat.edges in {((0, 1), (1, 2)), ((1, 2), (0, 1))}
    tower = geometry_of([(0.0, 0.0, 1.0)] * 2 + [(0.0, 0.0, 9.0)] * 2,
                        [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)] * 2)  # fmt: skip
    assert tower.rest.shape == (2, 2)
    assert np.linalg.norm(tower.motion, axis=2).max(axis=1).min() > 0.05  # both are seen
    row = geometry_of([None, None], [None, None])
    assert not row.scaled


@pytest.mark.parametrize(
    ("second", "shape", "expected"),
    [(50.4, [1.0, 0.5], [(50.0, 50.4)]), (52.0, [1.0, 0.5], []), (50.4, [1.0, -0.5], [])],
)
def test_a_mode_within_the_width_of_another_of_the_same_shape_is_told(second, shape, expected):
    """The width of 50 Hz with 0.5 % is 0.5 Hz."""
    omega = 2.0 * np.pi * np.array([50.0, second])
    poles = omega * (-0.005 + 1j * np.sqrt(1.0 - 0.005**2))
    unknown = np.zeros(2)
    modes = ModeSet(
        method="response functions",
        poles=poles,
        frequency_error=unknown,
        damping_error=unknown,
        shapes=np.array([[1.0, 0.5], shape], dtype=complex),
        participation=np.ones((2, 1), dtype=complex),
        diagram=None,
        model=None,
        interval_from="",
    )
    assert twins_of(modes) == [pytest.approx(pair) for pair in expected]
