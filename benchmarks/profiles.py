"""Verdicts of profiles: how often a right, a wrong and a just allowed density is kept.

python -m benchmarks.profiles [--runs 500] [--seed 0] [--segments 256 1024 4096]

White noise of 6 s at 5 kHz, judged from 80 to 1940 Hz as `process` judges it: "at the limit"
has the density of the limit itself, where 5 % of the lines are counted by chance at most.
"""

import argparse
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from shakerproc import spectra
from shakerproc.data import FloatArray
from shakerproc.spectra import CrossSpectra
from shakerproc.spectra.profiles import surely_beyond

RATE: Final = 5000.0
N_SAMPLES: Final = 30_000
BAND: Final = (80.0, 1940.0)
ALARM_DB: Final = 1.5
WRONG: Final = {"2.2 dB over a tenth": (2.2, (300.0, 500.0)), "2 dB everywhere": (2.0, BAND)}
"""Name, gain [dB] and band [Hz] of the runs that are beyond the alarm of 1.5 dB."""


def density(
    rng: np.random.Generator, segment: int, gain_db: float, band: tuple[float, float]
) -> tuple[FloatArray, CrossSpectra]:
    """Return the density of white noise of 1 that is raised in a band, in the band judged."""
    frequency = np.fft.rfftfreq(N_SAMPLES, 1.0 / RATE)
    raised = np.where((frequency > band[0]) & (frequency < band[1]), gain_db, 0.0)
    white = np.fft.rfft(rng.standard_normal(N_SAMPLES) * np.sqrt(RATE / 2.0))
    samples = np.fft.irfft(white * 10.0 ** (raised / 20.0), N_SAMPLES)
    cross = spectra.cross_spectra(
        [samples[np.newaxis]], RATE, segment=segment, overlap=segment // 2, window="hann"
    )
    inside = (cross.frequency > BAND[0]) & (cross.frequency < BAND[1])
    return spectra.psd(cross)[0, inside], cross


def shares(
    rng: np.random.Generator, segment: int, gain_db: float, band: tuple[float, float],
    limit_db: float, *, abort: bool,
) -> tuple[float, float]:  # fmt: skip
    """Return the shares of lines that are counted above an upper and below a lower limit."""
    values, cross = density(rng, segment, gain_db, band)
    factor = 10.0 ** (limit_db / 10.0)
    high = surely_beyond(values / factor, cross, above=True, anywhere=abort)
    low = surely_beyond(values * factor, cross, above=False, anywhere=abort)
    return float(high.mean()), float(low.mean())


def rows(segment: int, runs: int, seed: int) -> Iterator[tuple[str, float, float]]:
    """Return what was simulated, the share that was not kept, the mean share of lines [-]."""
    whole = (0.0, RATE)
    cases = {
        "right, alarm 1.5 dB": (0.0, whole, ALARM_DB, False),
        "right, abort 3 dB": (0.0, whole, 2.0 * ALARM_DB, True),
        **{f"{name}, alarm": (gain, band, ALARM_DB, False)
           for name, (gain, band) in WRONG.items()},
        "2.5 dB over a tenth, abort 1.5 dB": (2.5, (300.0, 500.0), ALARM_DB, True),
        "at the limit, alarm": (0.0, whole, 0.0, False),
        "at the limit, abort": (0.0, whole, 0.0, True),
    }  # fmt: skip
    for name, (gain, band, limit, abort) in cases.items():
        rng = np.random.default_rng(seed)
        each = np.array([
            shares(rng, segment, gain, band, limit, abort=abort) for _ in range(runs)
        ])  # fmt: skip
        allowed = 0.0 if abort else 0.05
        for side, found in zip(("high", "low"), each.T, strict=True):
            if side == "high" or gain == 0.0:
                yield f"{name} {side}", float(np.mean(found > allowed)), float(found.mean())


def main(arguments: Sequence[str] | None = None) -> None:
    """Print for each segment how often a limit is not kept, and how many lines are beyond."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--segments", type=int, nargs="+", default=[256, 1024, 4096])
    options = parser.parse_args(arguments)
    print(f"{options.runs} runs, seed {options.seed}")
    for segment in options.segments:
        for name, broken, share in rows(segment, options.runs, options.seed):
            print(f"{segment:5d} {name:40s} not kept {broken:7.1%}  lines beyond {share:6.2%}")


if __name__ == "__main__":
    main()
