"""The quiet of a recording before and after the run: what its channels show at rest."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, Recording
from shakerproc.numerals import numeral
from shakerproc.runs.averaging import welch
from shakerproc.runs.result import RunResult

MOST: Final = 64
"""Stretches that are looked at, evenly over what lies outside of the run [-]."""

KEPT: Final = 4
"""One of so many, the quietest, is rest: others may hold the beginning of the run [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class QuietPart:
    """What the channels show while nothing drives them.

    Attributes
    ----------
    density : (n_channels, n_frequencies) array
        Mean over the quietest stretches, in the bins of the run [unit²/Hz].
    rms : (n_channels,) array
        Of the same [unit].
    told : str
        Where it is from.
    """

    density: FloatArray
    rms: FloatArray
    told: str


def quiet_part(recording: Recording, result: RunResult) -> QuietPart | None:
    """Return the quiet part of a recording; None where less than a segment lies outside."""
    segment, crop = result.spectra.segment, result.crop
    starts = [
        *range(0, crop.start - segment + 1, segment),
        *range(crop.stop, result.n_samples - segment + 1, segment),
    ]
    if not starts:
        return None
    chosen = np.unique(np.linspace(0, len(starts) - 1, MOST).round().astype(int))
    power = np.array([_stretch(recording, starts[k], segment).var(axis=1) for k in chosen])
    over = np.where(result.statistics.rms > 0.0, result.statistics.rms, 1.0) ** 2
    order = np.argsort((power / over).sum(axis=1), kind="stable")
    quietest = order[: -(-len(order) // KEPT)]
    density = np.zeros(result.psd.shape)
    for k in chosen[quietest]:  # one after the other: segments may be long
        samples = _stretch(recording, starts[k], segment)
        density += welch([samples], result.sample_rate, result.test, ()).density
    told = (
        f"quietest {numeral(len(quietest) * segment / result.sample_rate, 3)} s before and "
        "after the run"
    )
    rms = np.sqrt(power[quietest].mean(axis=0))
    return QuietPart(density / len(quietest), rms, told)


def _stretch(recording: Recording, start: int, length: int) -> FloatArray:
    """Return samples less their means, (n_channels, length)."""
    samples = recording.samples(start, start + length)
    return np.asarray(samples - samples.mean(axis=1, keepdims=True))
