"""Statements about the power law: free motion (figures 4.6-4.12) and a sine (4.13-4.19)."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp

from shakerproc.data import FloatArray
from shakerproc.simulate import closed_forms
from shakerproc.studies.claims_base import Found, falls, peak, power_law, series
from shakerproc.studies.estimators import spectrum
from shakerproc.studies.simulated import signal_of, simulated, strobe
from shakerproc.studies.study import Measure, Run

NATURAL: Final = float(np.sqrt(10.0 / 1e-3) / (2.0 * np.pi))
"""The thesis' linear frequency of the power law, sqrt(kappa / (a m)) / 2 pi [Hz]."""

EXPONENTS: Final = (1.0, 3.0, 5.0, 9.0, 15.0, 21.0)


def _free(velocity: float, wall: float = 1e-3) -> Run:
    return Run(
        "free",
        duration=20.0,
        sample_rate=1000.0,
        initial_displacement=wall,
        initial_velocity=velocity,
    )


def _sine(level: float, ratio: float) -> Run:
    return Run(
        "sine",
        level=level,
        frequency=ratio * NATURAL,
        duration=20.0,
        sample_rate=1000.0,
        initial_velocity=0.1,
    )


def _exponent_raises() -> Found:
    text = [peak(power_law(n), _free(0.0)) for n in EXPONENTS]
    code = [peak(power_law(n), _free(0.1)) for n in EXPONENTS]
    held = falls([-value for value in text], 0.05), falls([-value for value in code], 0.05)
    return Found(
        f"n = 1, 3, 5, 9, 15, 21: from rest (the text) {series(text, 2)} Hz, with the "
        f"listing's 0.1 m/s {series(code, 2)} Hz: the initial energy decides",
        "held" if all(held) else ("held in part" if any(held) else "did not hold"),
    )


def _splits_into_peaks() -> Found:
    motion = simulated(power_law(3.0), _free(0.0), growth=False)
    found = spectrum(motion.acceleration, motion.sample_rate, Measure())
    exact = float(closed_forms.power_law_frequency(np.array(1e-3), 1.0, 10.0, 1e-3, 3.0))
    third = (found.frequency > 2.5 * exact) & (found.frequency < 3.2 * exact)
    first = (found.frequency > 0.5 * exact) & (found.frequency < 1.1 * exact)
    share = float(np.sqrt(found.density[third].sum() / found.density[first].sum()))
    return Found(
        f"one frequency that glides down with the amplitude from {exact:.2f} Hz, and its odd "
        f"harmonics (the third has {100.0 * share:.0f} % of the first): not several natural "
        f"frequencies, and no subharmonics",
        "did not hold",
    )


def _wall_lowers() -> Found:
    walls = (1e-5, 1e-4, 1e-3, 1e-2)
    found = [peak(power_law(3.0, a), _free(0.0, a)) for a in walls]
    exact = [
        float(closed_forms.power_law_frequency(np.array(a), 1.0, 10.0, a, 3.0)) for a in walls
    ]
    return Found(
        f"a = 0.01, 0.1, 1, 10 mm: {series(found, 2)} Hz (free motion of amplitude a: exactly "
        f"{series(exact, 2)}, as a^-1/2 because the stiffness is kappa/a)",
        "held" if falls(found) else "did not hold",
    )


def _peak_against_level() -> Found:
    levels = (5.0, 10.0, 15.0, 20.0, 25.0)
    found = [peak(power_law(3.0), _sine(level, 0.5)) for level in levels]
    orders = [value / (0.5 * NATURAL) for value in found]
    return Found(
        f"A = 5 ... 25 N at 7.96 Hz: peaks at {series(orders, 2)} times the forcing; from 10 N "
        f"on an odd harmonic of it, not a natural frequency",
        "held in part",
    )


def _peak_against_ratio() -> Found:
    ratios = (0.5, 1.0, 1.5)
    found = [peak(power_law(3.0), _sine(15.0, r)) / (r * NATURAL) for r in ratios]
    return Found(
        f"r = 0.5, 1, 1.5: peaks at {series(found, 2)} times the forcing (odd harmonics, and "
        f"the forcing itself)",
        "held in part",
    )


def _subharmonics() -> Found:
    counts = []
    for level in (5.0, 15.0, 25.0):
        run = _sine(level, 0.5)
        x, _ = strobe(power_law(3.0), run, periods=48, settle=4000, phases=1)
        counts.append(np.unique(np.round(x[0] / np.max(np.abs(x[0])), 3)).size)
    return Found(
        f"r = 0.5, A = 5, 15, 25 N: once settled (4000 periods) the motion repeats after "
        f"{', '.join(str(count) for count in counts)} periods; the thesis' 20 s are 159 of "
        f"them, and what its spectra show above the forcing are odd harmonics",
        "held in part" if max(counts) > 1 else "did not hold",
    )


def _stiff() -> Found:
    """Compare the work of an explicit and an implicit solver on the first two seconds."""
    run = Run("sine sweep", level=5.0, from_hz=0.0, to_hz=30.0, duration=30.0)
    force, damping = signal_of(run), 2.0 * np.sqrt(1000.0) * 0.01

    def motion(t: float, y: FloatArray) -> list[float]:
        beyond = max(abs(y[0]) - 5e-4, 0.0) * np.sign(y[0])
        return [y[1], float(force(np.array(t))) - 1000.0 * beyond - damping * y[1]]

    counts = [
        solve_ivp(motion, (0.0, 2.0), [0.0, 0.0], method=method, rtol=1e-8, atol=1e-10).nfev
        for method in ("DOP853", "Radau")
    ]
    return Found(
        f"on 2 s of the sweep over a = 0.5 mm at rtol 1e-8 the implicit Radau needs "
        f"{counts[1] / counts[0]:.0f} times the evaluations of the explicit DOP853: the "
        f"problem is not smooth, but not stiff",
        "did not hold",
    )


def _solvers_differ() -> Found:
    """Compare MATLAB's default kind of solver and Newmark's method with the exact motion."""
    run = Run("free", duration=5.0, sample_rate=1000.0, initial_displacement=1e-3)
    exact = simulated(power_law(3.0), run, growth=False).displacement
    size = float(np.max(np.abs(exact)))
    errors = [
        float(np.max(np.abs(simulated(power_law(3.0), other).displacement - exact))) / size
        for other in (
            replace(run, method="RK45"),
            replace(run, method="BDF"),
            replace(run, method="Newmark"),
        )
    ]
    return Found(
        f"n = 3, 5 s of free motion from 1 mm: at MATLAB's default tolerance of 1e-3 RK45 "
        f"(ode45) errs by {100.0 * errors[0]:.0f} % of the amplitude and BDF (like ode15s) by "
        f"{100.0 * errors[1]:.0f} %, Newmark's method at steps of 1 ms by "
        f"{100.0 * errors[2]:.0f} %: both solvers were wrong, not one of them",
        "held" if max(errors[:2]) > 0.05 else "did not hold",
    )


CLAIMS: Final[tuple[tuple[str, str, Callable[[], Found]], ...]] = (
    ("sec. 4.1", "contact makes the equation stiff: ode15s, ode23s", _stiff),
    ("sec. 4.2", "ode15s and ode45 give significantly different results", _solvers_differ),
    ("fig. 4.9", "omega_e rises with the exponent n", _exponent_raises),
    (
        "sec. 4.2",
        "nonlinearity gives rise to subharmonics or several natural frequencies",
        _splits_into_peaks,
    ),
    ("fig. 4.12", "omega_e falls with the gap a", _wall_lowers),
    ("fig. 4.16", "omega_e depends on the forcing amplitude A", _peak_against_level),
    ("fig. 4.19", "omega_e depends on the forcing frequency r", _peak_against_ratio),
    (
        "sec. 7.2, 8.1",
        "exciting at one frequency gives subharmonics and period doubling",
        _subharmonics,
    ),
)
