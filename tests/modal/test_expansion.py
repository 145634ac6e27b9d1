"""MAC and SEREP: closed forms, and two other programs (pyserep, sdypy-EMA)."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import eigh
from scipy.sparse import csc_matrix

from shakerproc.modal import mac
from shakerproc.modal.shapes import expanded

SENSORS = [0, 3, 5, 8, 11]


def chain(n=12):
    """Mass, stiffness and mass-normalised shapes, a column for each mode, of unequal masses."""
    mass = np.diag(1.0 + 0.3 * np.arange(n))
    stiffness = 1e5 * (2.0 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
    squares, shapes = eigh(stiffness, mass)
    return mass, stiffness, shapes, np.sqrt(squares) / (2.0 * np.pi)


def of(measured, shapes, far):
    """Expand shapes at the sensors, a row for each, by the modes of a model."""
    return expanded(
        np.array(measured, complex), shapes[SENSORS].T.astype(complex),
        shapes.T.astype(complex), np.array(far),
    )  # fmt: skip


def test_a_shape_in_the_span_of_the_nearest_modes_is_expanded_exactly():
    _, _, shapes, _ = chain()
    true = shapes[:, :3] @ np.array([1.0, -0.4 + 0.2j, 0.15])
    found = of([true[SENSORS]], shapes, [np.arange(12.0)])
    assert_allclose(found.shapes[0], true, rtol=0.0, atol=1e-12)
    assert found.n_used[0] == 3
    assert found.missed[0] < 1e-12
    assert found.left_out[0] < 1e-12


def test_expanded_modes_of_the_model_are_orthogonal_in_its_mass():
    mass, _, shapes, _ = chain()
    far = [np.abs(np.arange(12.0) - i) for i in range(4)]
    found = of(shapes[SENSORS, :4].T, shapes, far).shapes.real
    assert_allclose(found @ mass @ found.T, np.eye(4), atol=1e-10)


def test_what_the_sensors_measure_beside_the_modes_is_missed_and_not_expanded():
    """A part at right angles to all modes used leaves the expansion as it is: Pythagoras."""
    _, _, shapes, _ = chain()
    one = shapes[SENSORS, 0]
    beside = np.linalg.svd(shapes[SENSORS, :4])[0][:, 4]
    measured = one / np.linalg.norm(one) + 0.1 * beside
    found = of([measured], shapes[:, :4], [np.arange(4.0)])
    assert_allclose(found.shapes[0], shapes[:, 0] / np.linalg.norm(one), atol=1e-10)
    assert found.missed[0] == pytest.approx(0.1 / np.sqrt(1.01))


def test_the_error_of_a_sensor_left_out_is_that_of_a_fit_to_the_others():
    _, _, shapes, _ = chain()
    rng = np.random.default_rng(3)
    measured = shapes[SENSORS, 0] + 0.01 * rng.standard_normal(5)
    errors = []
    for n in range(1, 5):
        left = []
        for i in range(5):
            rest = [k for k in range(5) if k != i]
            at = shapes[SENSORS][:, :n]
            amplitudes = np.linalg.lstsq(at[rest], measured[rest], rcond=None)[0]
            left.append(measured[i] - at[i] @ amplitudes)
        errors.append(np.linalg.norm(left) / np.linalg.norm(measured))
    found = of([measured], shapes, [np.arange(12.0)])
    assert found.left_out[0] == pytest.approx(min(errors), rel=1e-9)
    assert found.n_used[0] == 1 + int(np.argmin(errors))


def test_a_single_sensor_is_not_expanded():
    assert expanded(np.ones((1, 1), complex), np.ones((3, 1), complex),
                    np.ones((3, 4), complex), np.zeros((1, 3))) is None  # fmt: skip


@pytest.mark.parametrize("rounding", [0.0, 3e-10])
def test_nothing_of_a_mode_that_one_sensor_alone_tells_is_predicted_from_the_others(rounding):
    at_sensors = np.array([[1.0, rounding, 0.0]], complex)
    found = expanded(np.array([[1.0, 0.2, 0.1]], complex), at_sensors, at_sensors,
                     np.zeros((1, 1)))  # fmt: skip
    assert found.left_out[0] == pytest.approx(1.0)


def test_the_expansion_is_that_of_pyserep():
    rom = pytest.importorskip("pyserep.core.rom_builder", reason="needs pyserep")
    mass, stiffness, shapes, _ = chain()
    measured = np.random.default_rng(4).standard_normal(5)
    for n in (2, 3, 4):
        there, _, _ = rom.build_serep_rom(
            csc_matrix(stiffness), csc_matrix(mass), shapes, np.arange(n), np.array(SENSORS),
            verbose=False,
        )  # fmt: skip
        found = of([measured], shapes[:, :n], [np.arange(float(n))])
        if found.n_used[0] == n:
            assert_allclose(found.shapes[0], there @ measured, rtol=1e-9)
            return
    pytest.fail("no number of modes is that of the expansion")


@pytest.mark.filterwarnings("ignore::numpy.exceptions.ComplexWarning")
def test_the_mac_is_that_of_two_other_programs():
    tools = pytest.importorskip("sdypy.EMA.tools", reason="needs sdypy-EMA")
    checks = pytest.importorskip("pyserep.analysis.validation", reason="needs pyserep")
    rng = np.random.default_rng(6)
    first, second = rng.standard_normal((2, 7, 4))
    turned = second + 1j * rng.standard_normal((7, 4))
    ours = mac(first.T.astype(complex), second.T.astype(complex))
    assert_allclose(ours, checks.modal_assurance_criterion(first, second), rtol=1e-9)
    assert_allclose(mac(turned.T, first.T + 0j), tools.MAC(turned, first).real, rtol=1e-9)
