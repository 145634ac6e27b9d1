"""Statements about the input of the shaker and the solver's cost: chapters 5, 6, appendix B."""

from collections.abc import Callable
from time import perf_counter
from typing import Final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY
from shakerproc.simulate import closed_forms
from shakerproc.studies.claims_base import SWEEP, Found, power_law
from shakerproc.studies.simulated import simulated


def _displacement() -> Found:
    metres = float(
        closed_forms.displacement_amplitude(np.array(STANDARD_GRAVITY), np.array(400.0))
    )
    return Found(
        f"{1e3 * metres:.5f} mm by eq. 5.5; the formula above it, with 4 pi for 4 pi², would "
        f"give {1e3 * metres * np.pi:.5f} mm",
        "held",
    )


def _literal_sweep() -> Found:
    """Return the frequency at the end: the derivative of the phase omega(t) t."""
    first, last, duration = 1.0, 60.0, 60.0
    end = first + 2.0 * (last - first) * duration / duration
    return Found(
        f"eq. 5.1 with a linear omega(t) from 1 to 60 Hz ends at {end:.0f} Hz: it sweeps at "
        f"twice the rate; the phase must be the integral",
        "did not hold",
    )


def _listing_sweep() -> Found:
    first, last, duration = 5.0, 100.0, 100.0
    end = first + (last - first) / (0.5 * duration) * duration
    return Found(
        f"t1 = tend/2 in the listing: 100 Hz at 50 s, {end:.0f} Hz at 100 s", "did not hold"
    )


def _critical_damping() -> Found:
    found = 0.06324 / (2.0 * np.sqrt(10.0 / 0.1))
    return Found(
        f"c = 2 zeta sqrt(kappa m) takes the force kappa [N] for a stiffness; against kappa/a "
        f"at a = 0.1 m the 0.06324 N s/m are zeta = {found:.4f}",
        "did not hold",
    )


def _cost() -> Found:
    run = SWEEP
    simulated(power_law(3.0, 0.5, 0.01), run, growth=False)
    start = perf_counter()
    simulated(power_law(3.0, 0.5, 0.01), run, growth=False)
    spent = perf_counter() - start
    fast = "less than a second" if spent < 1.0 else f"{spent:.0f} s"
    return Found(
        f"the same 30 s with 15 001 outputs take {fast} here, at an error below 1e-9",
        "did not hold" if spent < 10.0 else "held",
    )


CLAIMS: Final[tuple[tuple[str, str, Callable[[], Found]], ...]] = (
    ("eq. 5.1", "a(t) = a0 cos(omega(t) t) sweeps from 1 to 60 Hz", _literal_sweep),
    ("app. B", "the sweep generator reaches f1 at the end", _listing_sweep),
    ("sec. 5.2.2, eq. 5.5", "1 g at 400 Hz is 0.00155 mm", _displacement),
    ("table 6.7, app. B", "zeta = 0.01 is c = 0.06324 N s/m", _critical_damping),
    ("sec. 6.3, 7.2", "the model of one mass needs 600 s of computing", _cost),
)
