"""Statements of chapter 3 (linear theory, friction, Duffing) and on the shaker's input."""

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.simulation import closed_forms
from shakerproc.studies.results import above, below, equals
from shakerproc.verification.base import ClaimFinding

_LAST_DIGIT: Final = 5e-6  # half of the last digit of 0.00155 mm


def _damping_beyond_root_two() -> ClaimFinding:
    ratio = np.linspace(np.sqrt(2.0), 3.0, 101)[1:]
    gains = [closed_forms.magnification(ratio, zeta) for zeta in (0.1, 0.5)]
    low, high = (float(closed_forms.magnification(np.array(2.0), zeta)) for zeta in (0.1, 0.5))
    most = float(np.max(gains[1] - gains[0]))
    return ClaimFinding(
        f"at r = 2 eq. 3.10 falls from {low:.4f} (zeta 0.1) to {high:.4f} (0.5): damping "
        f"lowers it at every r; the sentence is true of motion of the base",
        (above("largest change of the gain from zeta 0.1 to 0.5, r 1.41 to 3 [-]", most, 0.0),),
    )


def _phase() -> ClaimFinding:
    lag = float(np.degrees(closed_forms.phase_lag(np.array(1.5), 0.1)))
    ratios = np.array([0.5, 1.5])
    both = np.degrees(np.arctan(2.0 * 0.1 * ratios / (1.0 - ratios**2)))
    printed = float(both[1])
    difference = np.abs(both - np.degrees(closed_forms.phase_lag(ratios, 0.1)))
    return ClaimFinding(
        f"at r = 1.5, zeta = 0.1 it prints {printed:.1f} deg, the lag is {lag:.1f} deg: the "
        f"arctangent needs its quadrant beyond resonance",
        (below("error at r = 0.5 and 1.5 [deg]", difference, 1e-9),),
    )


def _damped_frequency() -> ClaimFinding:
    ratio = closed_forms.damped_frequency(1.0, 0.1)
    return ClaimFinding(
        f"{ratio:.4f} at zeta = 0.1",
        (equals("omega_d over omega_n [-]", ratio, 0.995, 0.0005),),
    )


def _equivalent_damping() -> ClaimFinding:
    low, high = _errors_of_equivalent_damping((0.1, 0.2, 0.3))
    lowest, highest = _errors_of_equivalent_damping((0.4, 0.5, 0.6))
    return ClaimFinding(
        f"against Den Hartog's exact motion, r from 0.5 to 2 where the mass never sticks. "
        f"The error is {low:+.1f} to {high:+.1f} % up to F_c / F_0 = 0.3, {lowest:+.0f} to "
        f"{highest:+.0f} % up to 0.6",
        (
            below("largest error up to F_c / F_0 = 0.3 [%]", max(abs(low), abs(high)), 10.0),
            below("largest error up to 0.6 [%]", max(abs(lowest), abs(highest)), 10.0),
        ),
    )


def _errors_of_equivalent_damping(frictions: Sequence[float]) -> tuple[float, float]:
    """Return the smallest and largest error of eq. 3.24 [%]."""
    errors = []
    for friction in frictions:
        for ratio in np.concatenate([np.linspace(0.5, 0.95, 46), np.linspace(1.05, 2.0, 96)]):
            try:
                exact = closed_forms.coulomb_amplitude(np.array(ratio), friction)
            except ValueError:  # it sticks there
                continue
            first = closed_forms.coulomb_harmonic_amplitude(np.array(ratio), friction)
            errors.append(100.0 * float(first / exact - 1.0))
    return min(errors), max(errors)


def _amplitude_raises_frequency() -> ClaimFinding:
    natural = 0.5 / np.pi
    amplitude = np.array([np.sqrt(0.1), 1.0, np.sqrt(10.0), 1e4])
    exact = closed_forms.duffing_free_frequency(amplitude, natural, 1.0)
    first = closed_forms.duffing_harmonic_free_frequency(amplitude, natural, 1.0)
    errors = ", ".join(f"{100.0 * e:.2f}" for e in first / exact - 1.0)
    return ClaimFinding(
        f"eq. 3.42 and 3.49 are high by {errors} % at mu A²/omega_n² = 0.1, 1, 10 and without "
        f"end",
        (above("rise of the exact frequency from each to the next [Hz]", np.diff(exact), 0.0),),
    )


def _missing_mu() -> ClaimFinding:
    time = np.linspace(0.0, 2.0 * np.pi, 201)
    natural, cubic = 0.5 / np.pi, 0.01
    exact = closed_forms.duffing_free_motion(time, 1.0, natural, cubic)
    right = closed_forms.duffing_perturbation_motion(time, 1.0, natural, cubic)
    printed = np.cos(time) + (np.cos(3.0 * time) - np.cos(time)) / 32.0
    errors = [float(np.max(np.abs(motion - exact))) for motion in (printed, right)]
    return ClaimFinding(
        f"at mu = 0.01 the printed motion errs by {errors[0]:.3f} of the amplitude, with the "
        f"mu it lacks by {errors[1]:.0e}",
        (below("error of the printed motion, first order in mu [-]", errors[0], cubic**2),),
    )


CLAIMS: Final[tuple[tuple[str, str, Callable[[], ClaimFinding]], ...]] = (
    (
        "sec. 3.1, fig. 3.1",
        "more damping raises the response beyond r = sqrt(2)",
        _damping_beyond_root_two,
    ),
    ("eq. 3.9, 3.11", "the phase is the arctangent", _phase),
    ("eq. 3.27", "omega_d = 0.995 omega_n at zeta = 0.1", _damped_frequency),
    ("eq. 3.24", "friction can be replaced by equivalent viscous damping", _equivalent_damping),
    (
        "eq. 3.42, 3.49",
        "the frequency of the Duffing oscillator rises with amplitude",
        _amplitude_raises_frequency,
    ),
    ("eq. 3.41", "the first perturbation (printed without mu)", _missing_mu),
)


def _displacement() -> ClaimFinding:
    metres = float(
        closed_forms.displacement_amplitude(np.array(STANDARD_GRAVITY), np.array(400.0))
    )
    return ClaimFinding(
        f"{1e3 * metres:.5f} mm by eq. 5.5; the formula above it, with 4 pi for 4 pi², would "
        f"give {1e3 * metres * np.pi:.5f} mm",
        (equals("displacement [mm]", 1e3 * metres, 0.00155, _LAST_DIGIT),),
    )


def _literal_sweep() -> ClaimFinding:
    """Return the momentary frequency at the end: the derivative of the phase omega(t) t."""
    first, last, duration = 1.0, 60.0, 60.0

    def turns(time: FloatArray) -> FloatArray:
        return (first + (last - first) * time / duration) * time

    end = _frequency_at(turns, duration)
    return ClaimFinding(
        f"eq. 5.1 with a linear omega(t) from 1 to 60 Hz ends at {end:.0f} Hz. It sweeps at "
        f"twice the rate; the phase must be the integral",
        (equals("last frequency [Hz]", end, last, 0.01, relative=True),),
    )


def _listing_sweep() -> ClaimFinding:
    """Return the momentary frequency half-way and at the end of appendix B's generator."""
    first, last, duration = 5.0, 100.0, 100.0
    reached = 0.5 * duration  # t1 = tend/2 in the listing

    def turns(time: FloatArray) -> FloatArray:
        return first * time + 0.5 * (last - first) / reached * time**2

    half_way, end = _frequency_at(turns, reached), _frequency_at(turns, duration)
    return ClaimFinding(
        f"t1 = tend/2 in the listing: {half_way:.0f} Hz at 50 s, {end:.0f} Hz at 100 s",
        (equals("last frequency [Hz]", end, last, 0.01, relative=True),),
    )


def _frequency_at(turns: Callable[[FloatArray], FloatArray], time: float) -> float:
    """Return the momentary frequency of a phase in turns, by a central difference [Hz]."""
    step = 1e-4
    before, after = turns(np.array([time - step, time + step]))
    return float(after - before) / (2.0 * step)


def _critical_damping() -> ClaimFinding:
    ratio = 0.06324 / (2.0 * np.sqrt(10.0 / 0.1))
    return ClaimFinding(
        f"c = 2 zeta sqrt(kappa m) takes the force kappa [N] for a stiffness. Against kappa/a "
        f"at a = 0.1 m the 0.06324 N s/m are zeta = {ratio:.4f}",
        (equals("zeta [-]", ratio, 0.01, 0.01, relative=True),),
    )


INPUT_CLAIMS: Final[tuple[tuple[str, str, Callable[[], ClaimFinding]], ...]] = (
    ("eq. 5.1", "a(t) = a0 cos(omega(t) t) sweeps from 1 to 60 Hz", _literal_sweep),
    ("app. B", "the sweep generator reaches f1 at the end", _listing_sweep),
    ("sec. 5.2.2, eq. 5.5", "1 g at 400 Hz is 0.00155 mm", _displacement),
    ("table 6.7, app. B", "zeta = 0.01 is c = 0.06324 N s/m", _critical_damping),
)
