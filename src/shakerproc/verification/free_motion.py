"""Statements about the power law: free motion (figures 4.6-4.12) and a sine (4.13-4.19)."""

from collections.abc import Callable
from dataclasses import replace
from math import pi
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp

from shakerproc.data import FloatArray
from shakerproc.simulation import closed_forms
from shakerproc.studies.kinds.grid import PeakOfRun
from shakerproc.studies.readings import (
    half_cycle_scatter,
    period_of,
    signal_of,
    simulated,
    spectrum,
    strobe,
)
from shakerproc.studies.results import Checked, above, below
from shakerproc.studies.study import Measure, StudyRun
from shakerproc.verification.base import (
    ClaimFinding,
    peak,
    peaks,
    power_law,
    series,
    values_of,
)

NATURAL: Final = float(np.sqrt(10.0 / 1e-3) / (2.0 * np.pi))
"""The thesis' linear frequency of the power law, sqrt(kappa / (a m)) / 2 pi [Hz]."""

EXPONENTS: Final = tuple(range(1, 22, 2))
COSINE: Final = 0.5 * pi


def _free(velocity: float, wall: float = 1e-3) -> StudyRun:
    return StudyRun(
        "free",
        duration=20.0,
        sample_rate=1000.0,
        initial_displacement=wall,
        initial_velocity=velocity,
    )


def _sine(level: float, ratio: float, phase: float = 0.0) -> StudyRun:
    return StudyRun(
        "sine",
        level=level,
        frequency=ratio * NATURAL,
        phase=phase,
        duration=20.0,
        sample_rate=1000.0,
        initial_velocity=0.1,
    )


def _exponent_raises(velocity: float) -> ClaimFinding:
    found = [peak(power_law(n), _free(velocity)) for n in EXPONENTS]
    return ClaimFinding(
        f"n = 1, 3, 5 ... 21: {series(values_of(found), 2)} Hz",
        (peaks("omega_e [Hz]", "n", "rises", (EXPONENTS, found)),),
    )


def _splits_into_peaks() -> ClaimFinding:
    motion = simulated(power_law(3.0), _free(0.0), growth=False)
    found = spectrum(motion.acceleration, motion.sample_rate, Measure())
    exact = float(closed_forms.power_law_frequency(np.array(1e-3), 1.0, 10.0, 1e-3, 3.0))
    third = (found.frequency > 2.5 * exact) & (found.frequency < 3.2 * exact)
    first = (found.frequency > 0.5 * exact) & (found.frequency < 1.1 * exact)
    share = float(np.sqrt(found.density[third].sum() / found.density[first].sum()))
    return ClaimFinding(
        f"one frequency that glides down with the amplitude from {exact:.2f} Hz, and its odd "
        f"harmonics (the third has {100.0 * share:.0f} % of the first)",
        (
            above(
                "largest change from one half cycle to the next, which several frequencies at "
                "once would make, over the half cycle [-]",
                half_cycle_scatter(motion),
                0.1,
            ),
        ),
    )


def _wall_lowers() -> ClaimFinding:
    walls = (1e-5, 1e-4, 1e-3, 1e-2)
    found = [peak(power_law(3.0, a), _free(0.0, a)) for a in walls]
    exact = [
        float(closed_forms.power_law_frequency(np.array(a), 1.0, 10.0, a, 3.0)) for a in walls
    ]
    return ClaimFinding(
        f"a = 0.01, 0.1, 1, 10 mm: {series(values_of(found), 2)} Hz (free motion of amplitude "
        f"a: exactly {series(exact, 2)}, as a^-1/2 because the stiffness is kappa/a)",
        (peaks("omega_e [Hz]", "a", "falls", (walls, found)),),
    )


def _peak_against_level(phase: float) -> ClaimFinding:
    levels, forcing = (5.0, 10.0, 15.0, 20.0, 25.0), 0.5 * NATURAL
    found = [peak(power_law(3.0), _sine(level, 0.5, phase)) for level in levels]
    return ClaimFinding(
        f"A = 5, 10, 15, 20, 25 N at 7.96 Hz: peaks at "
        f"{series([one.value / forcing for one in found], 2)} times the forcing",
        (
            peaks("omega_e [Hz]", "A", "changes", (levels, found)),
            _off_the_multiples(found, [forcing] * len(found)),
        ),
    )


def _off_the_multiples(found: list[PeakOfRun], forcing: list[float]) -> Checked:
    """Return whether peaks lie off every multiple of the forcing, as natural frequencies do."""
    apart = [
        abs(one.value - max(1.0, round(one.value / hertz)) * hertz) / one.resolution
        for one, hertz in zip(found, forcing, strict=True)
    ]
    return above("omega_e from a multiple of the forcing [resolutions]", apart, 1.0)


def _peak_against_ratio() -> ClaimFinding:
    ratios = (0.5, 1.0, 1.5)
    found = [peak(power_law(3.0), _sine(15.0, r)) for r in ratios]
    forcing = [r * NATURAL for r in ratios]
    orders = [one.value / hertz for one, hertz in zip(found, forcing, strict=True)]
    return ClaimFinding(
        f"r = 0.5, 1, 1.5: peaks at {series(orders, 2)} times the forcing",
        (
            peaks("omega_e [Hz]", "r", "changes", (ratios, found)),
            _off_the_multiples(found, forcing),
        ),
    )


def _subharmonics() -> ClaimFinding:
    periods = []
    for level in (5.0, 15.0, 25.0):
        run = _sine(level, 0.5)
        x, v, _ = strobe(power_law(3.0), run, periods=48, settle=4000, phases=1)
        periods.append(period_of(x[0], v[0]))
    return ClaimFinding(
        f"r = 0.5, A = 5, 15, 25 N: once settled (4000 periods) the motion repeats after "
        f"{', '.join(f'{period:g}' for period in periods)} periods; the thesis' 20 s are 159 "
        f"of them",
        (above("periods of the forcing after which the motion repeats", periods, 1.0),),
    )


def _stiff() -> ClaimFinding:
    """Compare the work of an explicit and an implicit solver on the first two seconds."""
    run = StudyRun("sine sweep", level=5.0, from_hz=0.0, to_hz=30.0, duration=30.0)
    force, damping = signal_of(run), 2.0 * np.sqrt(1000.0) * 0.01

    def motion(t: float, y: FloatArray) -> list[float]:
        beyond = max(abs(y[0]) - 5e-4, 0.0) * np.sign(y[0])
        return [y[1], float(force(np.array(t))) - 1000.0 * beyond - damping * y[1]]

    counts = [
        solve_ivp(motion, (0.0, 2.0), [0.0, 0.0], method=method, rtol=1e-8, atol=1e-10).nfev
        for method in ("DOP853", "Radau")
    ]
    ratio = counts[1] / counts[0]
    return ClaimFinding(
        f"on 2 s of the sweep over a = 0.5 mm at rtol 1e-8 the implicit Radau needs "
        f"{ratio:.0f} times the evaluations of the explicit DOP853: the problem is not "
        f"smooth, but not stiff",
        (below("evaluations of Radau over those of DOP853 [-]", ratio, 1.0),),
    )


def _solvers_differ() -> ClaimFinding:
    """Compare MATLAB's default kind of solver and Newmark's method with the exact motion."""
    run = StudyRun("free", duration=5.0, sample_rate=1000.0, initial_displacement=1e-3)
    exact = simulated(power_law(3.0), run, growth=False).displacement
    size = float(np.max(np.abs(exact)))
    motions = [
        simulated(power_law(3.0), other).displacement
        for other in (
            replace(run, method="RK45"),
            replace(run, method="BDF"),
            replace(run, method="Newmark"),
        )
    ]
    errors = [float(np.max(np.abs(motion - exact))) / size for motion in motions]
    apart = float(np.max(np.abs(motions[0] - motions[1]))) / size
    return ClaimFinding(
        f"n = 3, 5 s of free motion from 1 mm: at MATLAB's default tolerance of 1e-3 RK45 "
        f"(ode45) errs by {100.0 * errors[0]:.0f} % of the amplitude and BDF (like ode15s) by "
        f"{100.0 * errors[1]:.0f} %, Newmark's method at steps of 1 ms by "
        f"{100.0 * errors[2]:.0f} %: both solvers are wrong, not one of them",
        (
            above(
                "RK45 against BDF, largest difference [% of the amplitude]", 100.0 * apart, 10.0
            ),
        ),
    )


CLAIMS: Final[tuple[tuple[str, str, Callable[[], ClaimFinding]], ...]] = (
    ("sec. 4.1", "contact makes the equation stiff: ode15s, ode23s", _stiff),
    ("sec. 4.2", "ode15s and ode45 give significantly different results", _solvers_differ),
    (
        "fig. 4.9",
        "omega_e rises with the exponent n (from rest, as the text says)",
        lambda: _exponent_raises(0.0),
    ),
    (
        "fig. 4.9",
        "omega_e rises with the exponent n (with the listing's 0.1 m/s)",
        lambda: _exponent_raises(0.1),
    ),
    (
        "sec. 4.2",
        "nonlinearity gives rise to subharmonics or several natural frequencies",
        _splits_into_peaks,
    ),
    ("fig. 4.12", "omega_e falls with the gap a", _wall_lowers),
    (
        "fig. 4.16",
        "omega_e, a natural frequency, depends on A (a sine begun at 0, as eq. 4.5)",
        lambda: _peak_against_level(0.0),
    ),
    (
        "fig. 4.16",
        "omega_e, a natural frequency, depends on A (begun as a cosine)",
        lambda: _peak_against_level(COSINE),
    ),
    (
        "fig. 4.19",
        "omega_e, a natural frequency, depends on the forcing frequency r (begun at 0)",
        _peak_against_ratio,
    ),
    (
        "sec. 7.2, 8.1",
        "exciting at one frequency gives subharmonics and period doubling",
        _subharmonics,
    ),
)
