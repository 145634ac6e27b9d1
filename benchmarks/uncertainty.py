"""Coverage of uncertainty budgets: how often value and expanded uncertainty hold the truth.

python -m benchmarks.uncertainty [--runs 400] [--segments 512 1024 2048]

White noise through a resonator of 200 Hz and 3 %, 16 s at 2048 Hz, on two channels with noise,
whose gains are drawn from what their calibration sheet allows.
"""

import argparse
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Final, TypedDict, Unpack

import numpy as np
import scipy

from shakerproc.data import STANDARD_GRAVITY, Channel, FloatArray, recording_of_arrays
from shakerproc.runs import process_recording
from shakerproc.runs.panels import Analysis, Cell
from shakerproc.testlog import Processing, Test
from shakerproc.testlog.excitation import Excitation
from shakerproc.testlog.processing import TimeCrop, Welch

RATE: Final = 2048.0
NATURAL: Final = 200.0
ZETA: Final = 0.03
NOISE: Final = 0.02
"""Standard deviation of the noise over that of the control [-]."""
QUIET: Final = 4096
"""Samples before and after the run."""
SHEET: Final = (0.03, 0.04)
"""Expanded uncertainties of control and response [-]."""


class Setup(TypedDict, total=False):
    """What a run may differ in from the usual one."""

    sheet: tuple[float | None, float | None]
    segment: int
    quiet: int
    excitation: Excitation


def resonator() -> FloatArray:
    """Return the coefficients of a discrete resonator whose pole is that of the mode."""
    pole = np.exp((-ZETA + 1j * np.sqrt(1.0 - ZETA**2)) * 2.0 * np.pi * NATURAL / RATE)
    return np.array([1.0, -2.0 * pole.real, abs(pole) ** 2])


@cache
def truth() -> dict[str, float]:
    """Return by name what white noise of unit variance and the resonator are exactly."""
    a = resonator()
    f, gain = scipy.signal.freqz([a.sum()], a, worN=2**18, fs=RATE)
    gain = np.abs(gain)
    k = gain.argmax()
    return {
        "control rms": 1.0,
        "control level (density)": 2.0 / RATE,
        "ch3 rms": float(np.sqrt(np.mean(gain**2))),
        "ch3 psd peak frequency": float(f[k]),
        "ch3 psd height": 2.0 * float(gain[k]) ** 2 / RATE,
        "ch3 h1 peak frequency": float(f[k]),
        "ch3 h1 height": float(gain[k]),
        "ch3 h1 natural frequency": NATURAL,
        "ch3 h1 damping ratio": 100.0 * ZETA,
    }


def budgets(seed: int, **how: Unpack[Setup]) -> Analysis:
    """Return the budgets of a simulated run, both gains off by what the sheet allows."""
    sheet, segment, quiet = (
        how.get("sheet", SHEET),
        how.get("segment", 1024),
        how.get("quiet", QUIET),
    )
    n, rng = 2**15, np.random.default_rng(seed)
    base = rng.standard_normal(n + 2 * quiet)
    base[:quiet] = base[n + quiet :] = 0.0
    a = resonator()
    rows = np.array([base, scipy.signal.lfilter([a.sum()], a, base)])
    rows[:, n + quiet :] = 0.0
    rows += NOISE * rng.standard_normal(rows.shape)
    spread = np.array([0.0 if u is None else 0.5 * u for u in sheet])
    rows *= (1.0 + spread * rng.standard_normal(2))[:, np.newaxis] * STANDARD_GRAVITY
    channels = (
        Channel("control", "m/s^2", "control", "g", "control", uncertainty=sheet[0]),
        Channel("ch3", "m/s^2", "ch3", "g", "response", uncertainty=sheet[1]),
    )
    processing = Processing(
        crop=TimeCrop(quiet / RATE, (quiet + n) / RATE),
        welch=Welch(segment, segment // 2, "periodic hann"),
        uncertainty=True,
    )
    excitation = how.get("excitation", "random")
    test = Test(1, excitation=excitation, from_hz=50.0, to_hz=900.0, processing=processing)
    recording = recording_of_arrays("run", channels, rows, RATE)
    result = process_recording(recording, test, pictured=False)
    (one,) = [one for one in result.analyses if one.kind == "uncertainty"]
    return one


def by_name(analysis: Analysis) -> dict[str, Mapping[str, Cell]]:
    """Return the first row of each number of the resonance, and of each level."""
    found: dict[str, Mapping[str, Cell]] = {}
    for row in analysis.summary:
        at = row["peak_hz"]
        if not isinstance(at, float) or abs(at - NATURAL) < 40.0:
            found.setdefault(f"{row['channel']} {row['quantity']}", row)
    return found


def coverage(runs: int, **how: Unpack[Setup]) -> dict[str, list[bool]]:
    """Return by name whether each interval that is given holds the truth."""
    held: dict[str, list[bool]] = {name: [] for name in truth()}
    for seed in range(runs):
        rows = by_name(budgets(seed, **how))
        for name, true in truth().items():
            row = rows.get(name, {})
            value, expanded = row.get("value"), row.get("expanded")
            if isinstance(value, float) and isinstance(expanded, float):
                held[name].append(abs(value - true) <= expanded)
    return held


def main(arguments: Sequence[str] | None = None) -> None:
    """Print for each segment how often the truth is held."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=400)
    parser.add_argument("--segments", type=int, nargs="+", default=[512, 1024, 2048])
    options = parser.parse_args(arguments)
    found = [coverage(options.runs, segment=segment) for segment in options.segments]
    print(f"| of {options.runs} runs | {' | '.join(map(str, options.segments))} |")
    print("|---" * (len(found) + 1) + "|")
    for name in found[0]:
        cells = [f"{np.mean(one[name] or [np.nan]):.1%} of {len(one[name])}" for one in found]
        print(f"| {name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
