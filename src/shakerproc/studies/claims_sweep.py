"""Statements about sweeps over a joint with free play: figures 4.2-4.5, 6.8-6.14."""

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import numpy as np

from shakerproc.simulate.harmonic_balance import frequency_response
from shakerproc.studies.claims_base import (
    STIFFNESS,
    SWEEP,
    WELCH,
    Found,
    falls,
    gap,
    jump_gap,
    peak,
    power_law,
    series,
)
from shakerproc.studies.study import Run

CLEARANCES: Final = (0.0, 0.5e-3, 1e-3, 2e-3, 5e-3, 10e-3, 20e-3, 50e-3)


def _gap_lowers() -> Found:
    found = [peak(gap(a), SWEEP) for a in CLEARANCES]
    return Found(
        f"F = k (|x| - a): a = 0, 0.5, 1, 2, 5, 10, 20, 50 mm give {series(found)} Hz, "
        f"F/(k a) from 10 down to 0.1",
        "held" if falls(found) else "did not hold",
    )


def _printed_law_lowers() -> Found:
    found = [peak(jump_gap(a), SWEEP) for a in (0.5e-3, 2e-3, 5e-3)]
    lowest = min(found)
    return Found(
        f"eq. 3.14 as printed, k(x) x, jumps by k a at the wall: a = 0.5, 2, 5 mm give "
        f"{series(found, 2)} Hz, at most {100.0 * (1.0 - lowest / 5.033):.1f} % lower",
        "did not hold",
    )


def _direction() -> Found:
    up, down = (peak(gap(20e-3), replace(SWEEP, down=way)) for way in (False, True))
    return Found(
        f"at a = 20 mm {up:.2f} Hz sweeping up, {down:.2f} Hz sweeping down: without the "
        f"direction omega_e says little",
        "did not hold",
    )


def _only_severity() -> Found:
    first = peak(gap(5e-3), SWEEP)
    second = peak(gap(20e-3), replace(SWEEP, level=20.0))
    return Found(
        f"5 N with 5 mm and 20 N with 20 mm both give {first:.3f} and {second:.3f} Hz "
        f"(F/(k a) = 1): more force raises omega_e again",
        "held in part",
    )


def _damping_lowers() -> Found:
    ratios = (0.005, 0.01, 0.02, 0.05, 0.1, 0.2)
    rows = {a: [peak(gap(a, damping_ratio=z), SWEEP) for z in ratios] for a in (0.5e-3, 5e-3)}
    all_fall = all(falls(row) for row in rows.values())
    return Found(
        f"zeta = 0.005 ... 0.2: {series(rows[0.5e-3], 2)} Hz at 0.5 mm, "
        f"{series(rows[5e-3], 2)} Hz at 5 mm",
        "held" if all_fall else "held in part",
    )


def _stiffness_raises() -> Found:
    found = [peak(gap(5e-3, stiffness=k), SWEEP) for k in (250.0, 1000.0, 5000.0)]
    rises = falls([-value for value in found])
    return Found(
        f"k = 250, 1000, 5000 N/m at 5 mm: {series(found, 2)} Hz",
        "held" if rises else "did not hold",
    )


def _stiffness_lowers_relative() -> Found:
    stiffnesses = (250.0, 500.0, 1000.0, 2000.0, 5000.0, 10000.0)
    found = [
        peak(gap(5e-3, stiffness=k), SWEEP) / (np.sqrt(k) / (2.0 * np.pi)) for k in stiffnesses
    ]
    return Found(
        f"k = 250 ... 10000 N/m at 5 mm: {series(found)} of omega_n, as F/(k a) falls from 4 "
        f"to 0.1",
        "held" if falls(found, 0.01) else "held in part",
    )


def _nastran_sweep() -> Found:
    walls = (0.1, 0.25, 0.5, 1.0)
    free = Run("free", duration=30.0, initial_velocity=4.0)
    swept = [
        peak(power_law(3.0, a, 0.01), replace(SWEEP, initial_velocity=4.0), WELCH)
        for a in walls
    ]
    alone = [peak(power_law(3.0, a, 0.01), free, WELCH) for a in walls]
    return Found(
        f"with the sweep {series(swept, 2)} Hz, from the initial velocity of 4 m/s alone "
        f"{series(alone, 2)} Hz (Welch, 2048 samples, bins 0.244 Hz): mostly free motion",
        "held in part",
    )


def _welch_resolution() -> Found:
    width = 500.0 / 2048.0
    natural = np.sqrt(STIFFNESS) / (2.0 * np.pi)
    return Found(
        f"bins of Welch with 2048 samples are {width:.3f} Hz wide, "
        f"{100.0 * width / natural:.1f} % of omega_n: as much as the change that is to be seen",
        "held in part",
    )


def _frequency_domain() -> Found:
    found = frequency_response(gap(5e-3), 5.0, from_hz=2.5, to_hz=6.0)
    (branch,) = found.branches
    folds = series([branch.frequency[i] for i in branch.folds])
    unstable = int(np.sum(~branch.stable))
    return Found(
        f"harmonic balance gives the whole curve with {branch.frequency.size} points, folds at "
        f"{folds} Hz and {unstable} unstable points between them; contact is lost at "
        f"{branch.frequency[-1]:.3f} Hz",
        "held",
    )


CLAIMS: Final[tuple[tuple[str, str, Callable[[], Found]], ...]] = (
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
