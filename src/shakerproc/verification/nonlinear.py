"""Statements about joints: free play (figures 4.2-4.5, 6.8-6.14), a power law (4.6-4.19)."""

from collections.abc import Callable
from dataclasses import replace
from math import pi
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp

from shakerproc.data import FloatArray
from shakerproc.simulation import closed_forms
from shakerproc.simulation.harmonic_balance import (
    difference_from_simulation,
    frequency_response,
)
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
    STIFFNESS,
    SWEEP,
    WELCH,
    ClaimFinding,
    gap,
    gap_peak,
    jump_gap,
    peak,
    peaks,
    power_law,
    series,
    values_of,
)

CLEARANCES: Final = (0.0, 0.5e-3, 1e-3, 2e-3, 5e-3, 10e-3, 20e-3, 50e-3)
PRINTED: Final = (0.0, 0.5e-3, 2e-3, 5e-3, 10e-3, 20e-3)
WALLS: Final = (0.1, 0.25, 0.5, 1.0)


def _gap_lowers() -> ClaimFinding:
    run_peaks = [gap_peak(a) for a in CLEARANCES]
    return ClaimFinding(
        f"F = k (|x| - a): a = 0, 0.5, 1, 2, 5, 10, 20, 50 mm give "
        f"{series(values_of(run_peaks))} Hz, F/(k a) from 10 down to 0.1",
        (peaks("omega_e [Hz]", "a", "falls", (CLEARANCES, run_peaks)),),
    )


def _printed_law_lowers() -> ClaimFinding:
    run_peaks = [peak(jump_gap(a) if a else gap(0.0), SWEEP) for a in PRINTED]
    values = values_of(run_peaks)
    return ClaimFinding(
        f"eq. 3.14 as printed, k(x) x, jumps by k a at the wall. a = 0, 0.5, 2, 5, 10, 20 mm "
        f"give {series(values, 2)} Hz, up to 5 mm at most "
        f"{100.0 * (1.0 - min(values[:4]) / values[0]):.1f} % lower",
        (peaks("omega_e [Hz]", "a", "falls", (PRINTED, run_peaks)),),
    )


def _direction() -> ClaimFinding:
    up, down = (gap_peak(20e-3, down=way) for way in (False, True))
    return ClaimFinding(
        f"at a = 20 mm {up.value:.2f} Hz sweeping up, {down.value:.2f} Hz sweeping down: "
        f"without the direction omega_e says little",
        (below("difference up and down [Hz]", abs(up.value - down.value), up.bin_width),),
    )


def _only_severity() -> ClaimFinding:
    first, more = gap_peak(5e-3), gap_peak(5e-3, level=20.0)
    second = gap_peak(20e-3, level=20.0)
    return ClaimFinding(
        f"at 5 mm {first.value:.3f} Hz with 5 N and {more.value:.3f} Hz with 20 N. 20 N with "
        f"20 mm give {second.value:.3f} Hz again: only F/(k a) matters",
        (peaks("omega_e at 5 mm [Hz]", "F", "changes", ((5.0, 20.0), (first, more))),),
    )


def _damping_lowers() -> ClaimFinding:
    ratios = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2)
    rows = {a: [gap_peak(a, damping_ratio=z) for z in ratios] for a in (0.5e-3, 2e-3, 5e-3)}
    return ClaimFinding(
        "zeta = 0.005 ... 0.2: "
        + ", ".join(
            f"{series(values_of(row), 2)} Hz at {1e3 * a:g} mm" for a, row in rows.items()
        ),
        (peaks("omega_e [Hz]", "zeta", "falls", *((ratios, row) for row in rows.values())),),
    )


STIFFNESSES: Final = (250.0, 500.0, 1000.0, 2000.0, 5000.0, 10000.0)


def _stiffness_raises() -> ClaimFinding:
    rows = {a: [gap_peak(a, stiffness=k) for k in STIFFNESSES] for a in (0.5e-3, 5e-3)}
    return ClaimFinding(
        "k = 250 ... 10000 N/m: "
        + ", ".join(
            f"{series(values_of(row), 2)} Hz at {1e3 * a:g} mm" for a, row in rows.items()
        ),
        (peaks("omega_e [Hz]", "k", "rises", *((STIFFNESSES, row) for row in rows.values())),),
    )


def _stiffness_lowers_relative() -> ClaimFinding:
    rows = {a: [gap_peak(a, stiffness=k) for k in STIFFNESSES] for a in (0.5e-3, 5e-3)}
    natural = [float(np.sqrt(k) / (2.0 * np.pi)) for k in STIFFNESSES]
    ratios = {
        a: [one.value / by for one, by in zip(row, natural, strict=True)]
        for a, row in rows.items()
    }
    return ClaimFinding(
        "k = 250 ... 10000 N/m: "
        + ", ".join(f"{series(row)} of omega_n at {1e3 * a:g} mm" for a, row in ratios.items()),
        (
            peaks(
                "omega_e / omega_n [-]",
                "k",
                "falls",
                *((STIFFNESSES, row) for row in rows.values()),
                scales=natural,
            ),
        ),
    )


def _nastran_sweep() -> ClaimFinding:
    free = StudyRun("free", duration=30.0, initial_velocity=4.0)
    swept = [
        peak(power_law(3.0, a, 0.01), replace(SWEEP, initial_velocity=4.0), WELCH)
        for a in WALLS
    ]
    alone = [peak(power_law(3.0, a, 0.01), free, WELCH) for a in WALLS]
    return ClaimFinding(
        f"with the sweep {series(values_of(swept), 2)} Hz, from the initial velocity of 4 m/s "
        f"alone {series(values_of(alone), 2)} Hz (Welch, 2048 samples, bins 0.244 Hz): mostly "
        f"free motion",
        (peaks("omega_e [Hz]", "a", "falls", (WALLS, swept)),),
    )


def _welch_resolution() -> ClaimFinding:
    width = 500.0 / 2048.0
    natural = np.sqrt(STIFFNESS) / (2.0 * np.pi)
    values = values_of([gap_peak(a) for a in CLEARANCES])
    steps = np.abs(np.diff(values))
    return ClaimFinding(
        f"bins of Welch with 2048 samples are {width:.3f} Hz wide, "
        f"{100.0 * width / natural:.1f} % of omega_n. Figure 4.2 changes by "
        f"{abs(values[-1] - values[0]):.2f} Hz in all, from one a to the next by "
        f"{series(steps.tolist(), 2)} Hz",
        (
            below(
                "bin over the change in all and from each a to the next [-]",
                width / np.array([abs(values[-1] - values[0]), *steps]),
                1.0,
            ),
        ),
    )


def _frequency_domain() -> ClaimFinding:
    response = frequency_response(gap(5e-3), 5.0, from_hz=2.5, to_hz=6.0)
    branch = response.branches[0]
    folds = series([branch.frequency[i] for i in branch.folds])
    unstable = int(np.sum(~branch.stable))
    difference = difference_from_simulation(response)
    return ClaimFinding(
        f"harmonic balance gives the whole curve with {branch.frequency.size} points, folds at "
        f"{folds} Hz and {unstable} unstable points between them; contact is lost at "
        f"{branch.frequency[-1]:.3f} Hz",
        (below("difference from the exact stepper over a period [-]", difference, 1e-3),),
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
    run_peaks = [peak(power_law(n), _free(velocity)) for n in EXPONENTS]
    return ClaimFinding(
        f"n = 1, 3, 5 ... 21: {series(values_of(run_peaks), 2)} Hz",
        (peaks("omega_e [Hz]", "n", "rises", (EXPONENTS, run_peaks)),),
    )


def _splits_into_peaks() -> ClaimFinding:
    motion = simulated(power_law(3.0), _free(0.0), growth=False)
    lines = spectrum(motion.acceleration, motion.sample_rate, Measure())
    exact = float(closed_forms.power_law_frequency(np.array(1e-3), 1.0, 10.0, 1e-3, 3.0))
    third = (lines.frequency > 2.5 * exact) & (lines.frequency < 3.2 * exact)
    first = (lines.frequency > 0.5 * exact) & (lines.frequency < 1.1 * exact)
    share = float(np.sqrt(lines.density[third].sum() / lines.density[first].sum()))
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
    run_peaks = [peak(power_law(3.0, a), _free(0.0, a)) for a in walls]
    exact = [
        float(closed_forms.power_law_frequency(np.array(a), 1.0, 10.0, a, 3.0)) for a in walls
    ]
    return ClaimFinding(
        f"a = 0.01, 0.1, 1, 10 mm: {series(values_of(run_peaks), 2)} Hz (free motion of "
        f"amplitude a: exactly {series(exact, 2)}, as a^-1/2 because the stiffness is kappa/a)",
        (peaks("omega_e [Hz]", "a", "falls", (walls, run_peaks)),),
    )


def _peak_against_level(phase: float) -> ClaimFinding:
    levels, forcing = (5.0, 10.0, 15.0, 20.0, 25.0), 0.5 * NATURAL
    run_peaks = [peak(power_law(3.0), _sine(level, 0.5, phase)) for level in levels]
    return ClaimFinding(
        f"A = 5, 10, 15, 20, 25 N at 7.96 Hz: peaks at "
        f"{series([one.value / forcing for one in run_peaks], 2)} times the forcing",
        (
            peaks("omega_e [Hz]", "A", "changes", (levels, run_peaks)),
            _off_the_multiples(run_peaks, [forcing] * len(run_peaks)),
        ),
    )


def _off_the_multiples(run_peaks: list[PeakOfRun], forcing: list[float]) -> Checked:
    """Return whether peaks lie off every multiple of the forcing, as natural frequencies do."""
    distances = [
        abs(one.value - max(1.0, round(one.value / hertz)) * hertz) / one.resolution
        for one, hertz in zip(run_peaks, forcing, strict=True)
    ]
    return above("omega_e from a multiple of the forcing [resolutions]", distances, 1.0)


def _peak_against_ratio() -> ClaimFinding:
    ratios = (0.5, 1.0, 1.5)
    run_peaks = [peak(power_law(3.0), _sine(15.0, r)) for r in ratios]
    forcing = [r * NATURAL for r in ratios]
    orders = [one.value / hertz for one, hertz in zip(run_peaks, forcing, strict=True)]
    return ClaimFinding(
        f"r = 0.5, 1, 1.5: peaks at {series(orders, 2)} times the forcing",
        (
            peaks("omega_e [Hz]", "r", "changes", (ratios, run_peaks)),
            _off_the_multiples(run_peaks, forcing),
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
        f"{ratio:.0f} times the evaluations of the explicit DOP853. The problem is not "
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
    difference = float(np.max(np.abs(motions[0] - motions[1]))) / size
    return ClaimFinding(
        f"n = 3, 5 s of free motion from 1 mm, MATLAB's default tolerance of 1e-3. RK45 "
        f"(ode45) errs by {100.0 * errors[0]:.0f} % of the amplitude, BDF (like ode15s) by "
        f"{100.0 * errors[1]:.0f} %, Newmark's method at steps of 1 ms by "
        f"{100.0 * errors[2]:.0f} %. Both solvers are wrong, not one of them",
        (
            above(
                "RK45 against BDF, largest difference [% of the amplitude]",
                100.0 * difference,
                10.0,
            ),
        ),
    )


CLAIMS: Final[tuple[tuple[str, str, Callable[[], ClaimFinding]], ...]] = (
    ("fig. 4.2, 6.12", "a larger gap a lowers omega_e", _gap_lowers),
    ("eq. 3.14", "the same with k(x) as printed", _printed_law_lowers),
    ("ch. 4", "one sweep, its direction not told, gives omega_e", _direction),
    ("fig. 4.16, sec. 7.2", "the system depends on amplitude", _only_severity),
    ("fig. 4.3", "more damping lowers omega_e", _damping_lowers),
    ("fig. 4.4, 6.13", "more stiffness raises omega_e", _stiffness_raises),
    ("fig. 4.5, 6.14", "more stiffness lowers omega_e / omega_n", _stiffness_lowers_relative),
    ("fig. 6.10", "omega_e of the cubic joint falls with a", _nastran_sweep),
    ("ch. 6, app. A", "omega_e is read from the Welch density", _welch_resolution),
    (
        "sec. 6.3",
        "there may be a way to solve it in the frequency domain (not found)",
        _frequency_domain,
    ),
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
