"""Statements about sweeps over a joint with free play: figures 4.2-4.5, 6.8-6.14."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.simulation.harmonic_balance import (
    difference_from_simulation,
    frequency_response,
)
from shakerproc.studies.results import below
from shakerproc.studies.study import StudyRun
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
    found = [gap_peak(a) for a in CLEARANCES]
    return ClaimFinding(
        f"F = k (|x| - a): a = 0, 0.5, 1, 2, 5, 10, 20, 50 mm give "
        f"{series(values_of(found))} Hz, F/(k a) from 10 down to 0.1",
        (peaks("omega_e [Hz]", "a", "falls", (CLEARANCES, found)),),
    )


def _printed_law_lowers() -> ClaimFinding:
    found = [peak(jump_gap(a) if a else gap(0.0), SWEEP) for a in PRINTED]
    values = values_of(found)
    return ClaimFinding(
        f"eq. 3.14 as printed, k(x) x, jumps by k a at the wall: a = 0, 0.5, 2, 5, 10, 20 mm "
        f"give {series(values, 2)} Hz, up to 5 mm at most "
        f"{100.0 * (1.0 - min(values[:4]) / values[0]):.1f} % lower",
        (peaks("omega_e [Hz]", "a", "falls", (PRINTED, found)),),
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
        f"at 5 mm {first.value:.3f} Hz with 5 N and {more.value:.3f} Hz with 20 N; 20 N with "
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
    told = {
        a: [one.value / by for one, by in zip(row, natural, strict=True)]
        for a, row in rows.items()
    }
    return ClaimFinding(
        "k = 250 ... 10000 N/m: "
        + ", ".join(f"{series(row)} of omega_n at {1e3 * a:g} mm" for a, row in told.items()),
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
        f"{100.0 * width / natural:.1f} % of omega_n; figure 4.2 changes by "
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
    found = frequency_response(gap(5e-3), 5.0, from_hz=2.5, to_hz=6.0)
    branch = found.branches[0]
    folds = series([branch.frequency[i] for i in branch.folds])
    unstable = int(np.sum(~branch.stable))
    apart = difference_from_simulation(found)
    return ClaimFinding(
        f"harmonic balance gives the whole curve with {branch.frequency.size} points, folds at "
        f"{folds} Hz and {unstable} unstable points between them; contact is lost at "
        f"{branch.frequency[-1]:.3f} Hz",
        (below("difference from the exact stepper over a period [-]", apart, 1e-3),),
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
)
