"""Closed forms against quadrature, integration in time and limits."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq
from tests.closed_forms import oracles

from shakerproc.simulation import closed_forms


def quarter_period(force, amplitude, mass=1.0):
    """A quarter of the free period by energy, with x = A sin(angle) to take the root away."""

    def potential(x):
        return quad(force, x, amplitude, epsabs=0.0, epsrel=1e-13, limit=200)[0]

    def integrand(angle):
        x = amplitude * np.sin(angle)
        return amplitude * np.cos(angle) / np.sqrt(2.0 * potential(x) / mass)

    return quad(integrand, 0.0, np.pi / 2.0, epsrel=1e-11, limit=200)[0]


@pytest.mark.parametrize("overshoot", [1.001, 1.05, 2.0, 10.0, 1e3])
def test_gap_backbone_is_the_time_of_flight_and_half_sines(overshoot):
    """Energy gives the speed in the gap; the contact takes half a period of the spring."""
    mass, stiffness, clearance = 0.7, 1234.0, 3e-4
    amplitude = overshoot * clearance
    speed = np.sqrt(stiffness / mass) * (amplitude - clearance)
    flight = 4.0 * clearance / speed
    contact = 2.0 * np.pi * np.sqrt(mass / stiffness)
    ratio = oracles.gap_backbone(np.array(amplitude), clearance)
    assert_allclose(ratio, contact / (contact + flight), rtol=1e-12)


def test_gap_backbone_by_integration_in_time():
    """The instants at which the velocity vanishes, from a Runge-Kutta solution with events."""
    clearance, amplitude = 0.5, 1.3

    def motion(_, y):
        return [y[1], -np.sign(y[0]) * max(abs(y[0]) - clearance, 0.0)]

    def rest(_, y):
        return y[1]

    rest.direction = -1.0
    found = solve_ivp(
        motion, (0.0, 20.0), [amplitude, 0.0], rtol=1e-12, atol=1e-13, events=rest
    )
    period = found.t_events[0][-1] / np.count_nonzero(found.t_events[0] > 1.0)
    expected = oracles.gap_backbone(np.array(amplitude), clearance)
    assert_allclose(2.0 * np.pi / period, expected, rtol=1e-5)


@pytest.mark.parametrize("exponent", [1.0, 3.0, 5.0, 21.0])
def test_power_law_frequency_by_quadrature(exponent):
    mass, force, reference, amplitude = 1.3, 10.0, 1e-3, 1.4e-3
    quarter = quarter_period(lambda x: force * (x / reference) ** exponent, amplitude, mass)
    found = closed_forms.power_law_frequency(
        np.array(amplitude), mass, force, reference, exponent
    )
    assert_allclose(found, 0.25 / quarter, rtol=1e-8)


def test_duffing_free_frequency_by_quadrature():
    amplitude, natural, cubic = 1.5, 0.3, 2.0
    omega_n = 2.0 * np.pi * natural
    quarter = quarter_period(lambda x: omega_n**2 * x + cubic * x**3, amplitude)
    found = closed_forms.duffing_free_frequency(np.array(amplitude), natural, cubic)
    assert_allclose(found, 0.25 / quarter, rtol=1e-9)


@pytest.mark.parametrize(
    ("strength", "error"), [(0.1, 1e-4), (1.0, 3.9e-3), (10.0, 1.7e-2), (1e8, 2.22e-2)]
)
def test_eq_3_42_errs_as_measured_against_elliptic_functions(strength, error):
    amplitude = np.array(1.0)
    natural = 1.0 / (2.0 * np.pi)
    exact = closed_forms.duffing_free_frequency(amplitude, natural, strength)
    first = closed_forms.duffing_harmonic_free_frequency(amplitude, natural, strength)
    assert_allclose(first / exact - 1.0, error, rtol=0.1)


def test_duffing_free_motion_solves_its_equation():
    natural, cubic, amplitude = 1.0 / (2.0 * np.pi), 3.0, 0.8
    time = np.linspace(0.0, 10.0, 101)
    found = solve_ivp(
        lambda _, y: [y[1], -y[0] - cubic * y[0] ** 3],
        (0.0, 10.0),
        [amplitude, 0.0],
        t_eval=time,
        rtol=1e-12,
        atol=1e-13,
        method="DOP853",
    )
    motion = closed_forms.duffing_free_motion(time, amplitude, natural, cubic)
    assert_allclose(motion, found.y[0], atol=1e-10)


def test_eq_3_41_needs_its_missing_factor():
    """With the factor the error falls with the square of mu; as printed it does not fall."""
    natural, amplitude = 1.0 / (2.0 * np.pi), 1.0
    time = np.linspace(0.0, 6.0, 61)

    def error(cubic, factor):
        motion = closed_forms.duffing_free_motion(time, amplitude, natural, cubic)
        omega = 2 * np.pi * closed_forms.duffing_harmonic_free_frequency(1.0, natural, cubic)
        printed = np.cos(omega * time) + factor / (32 * omega**2) * (
            np.cos(3 * omega * time) - np.cos(omega * time)
        )
        return np.max(np.abs(printed - motion))

    def corrected(cubic):
        motion = closed_forms.duffing_free_motion(time, amplitude, natural, cubic)
        found = closed_forms.duffing_perturbation_motion(time, amplitude, natural, cubic)
        return np.max(np.abs(found - motion))

    assert corrected(0.01) < 0.02 * corrected(0.1)
    assert error(0.01, 1.0) > 0.04
    assert_allclose(corrected(0.1), error(0.1, 0.1), rtol=1e-12)


def test_damped_duffing_response_satisfies_the_balance():
    amplitude = np.array([0.5, 1.0, 2.0])
    lower, upper = closed_forms.duffing_response_frequencies(amplitude, 0.16, 0.1, 0.04, 1.0)
    for hertz in (lower[1:], upper):
        omega, a = 2 * np.pi * hertz, amplitude[-hertz.size :]
        cosine = (2 * np.pi * 0.16) ** 2 - omega**2 + 0.75 * 0.04 * a**2
        assert_allclose(np.hypot(cosine, 0.1 * omega) * a, 1.0, rtol=1e-12)
    assert np.isnan(lower[0])  # below resonance nothing is that small


def test_damped_frequency_refuses_critical_damping():
    assert_allclose(closed_forms.damped_frequency(10.0, 0.1), 9.95, rtol=1e-4)
    with pytest.raises(ValueError, match="must lie in 0 to below 1, not 1"):
        closed_forms.damped_frequency(10.0, 1.0)


def half_cycle(r, friction, amplitude, phase):
    """The end of one sliding half cycle, from the matrix exponential."""
    # states: displacement, velocity, cosine and sine of the force, 1; k = m = F0 = 1
    matrix = np.array([
        [0, 1, 0, 0, 0],
        [-1, 0, 1, 0, friction],
        [0, 0, 0, -r, 0],
        [0, 0, r, 0, 0],
        [0, 0, 0, 0, 0.0],
    ])
    start = np.array([amplitude, 0.0, np.cos(phase), np.sin(phase), 1.0])
    return expm(matrix * np.pi / r) @ start


@pytest.mark.parametrize(("r", "friction"), [(0.6, 0.2), (0.8, 0.5), (1.3, 0.6), (2.0, 0.3)])
def test_den_hartog_by_shooting(r, friction):
    amplitude = float(closed_forms.coulomb_amplitude(np.array(r), friction))
    guess = np.arcsin(np.clip(-friction * np.tan(np.pi / (2 * r)) / r * (1 - r**2), -1, 1))
    phase = guess if r < 1.0 else np.pi - guess
    phase = brentq(
        lambda p: half_cycle(r, friction, amplitude, p)[1], phase - 0.2, phase + 0.2, xtol=1e-14
    )
    end = half_cycle(r, friction, amplitude, phase)
    assert_allclose(end[:2], [-amplitude, 0.0], atol=1e-10)


def test_den_hartog_refuses_sticking():
    with pytest.raises(ValueError, match=r"the mass sticks at frequency ratio 0\.2"):
        closed_forms.coulomb_amplitude(np.array([0.9, 0.2]), 0.5)


def test_equivalent_damping_errs_by_percents():
    r = np.concatenate([np.linspace(0.5, 0.9, 41), np.linspace(1.1, 2.0, 91)])
    error = closed_forms.coulomb_harmonic_amplitude(r, 0.3) / closed_forms.coulomb_amplitude(
        r, 0.3
    )
    assert 0.9 < np.min(error) < 1.0
    assert 1.0 < np.max(error) < 1.1
    with pytest.raises(ValueError, match=r"below pi/4, not 0\.9"):
        closed_forms.coulomb_harmonic_amplitude(r, 0.9)


def test_displacement_of_the_table_at_400_hz_and_1_g():
    assert_allclose(closed_forms.displacement_amplitude(9.81, 400.0), 1.55e-6, rtol=2e-3)
