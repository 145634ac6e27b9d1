"""Statements about the input of the shaker: chapter 5, appendix B."""

from collections.abc import Callable
from typing import Final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.simulation import closed_forms
from shakerproc.studies.checks import equals
from shakerproc.verification.base import ClaimFinding

_LAST_DIGIT: Final = 5e-6  # half of the last digit of 0.00155 mm


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
        f"eq. 5.1 with a linear omega(t) from 1 to 60 Hz ends at {end:.0f} Hz: it sweeps at "
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
    found = 0.06324 / (2.0 * np.sqrt(10.0 / 0.1))
    return ClaimFinding(
        f"c = 2 zeta sqrt(kappa m) takes the force kappa [N] for a stiffness; against kappa/a "
        f"at a = 0.1 m the 0.06324 N s/m are zeta = {found:.4f}",
        (equals("zeta [-]", found, 0.01, 0.01, relative=True),),
    )


CLAIMS: Final[tuple[tuple[str, str, Callable[[], ClaimFinding]], ...]] = (
    ("eq. 5.1", "a(t) = a0 cos(omega(t) t) sweeps from 1 to 60 Hz", _literal_sweep),
    ("app. B", "the sweep generator reaches f1 at the end", _listing_sweep),
    ("sec. 5.2.2, eq. 5.5", "1 g at 400 Hz is 0.00155 mm", _displacement),
    ("table 6.7, app. B", "zeta = 0.01 is c = 0.06324 N s/m", _critical_damping),
)
