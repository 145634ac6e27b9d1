"""Noise of the channels while nothing shakes yet: the lead-in of a recording."""

from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.spectra import coherence, cross_spectra

BLOCK_S: Final = 0.05
"""Length of the blocks in which rest is looked for [s]."""

SHORTEST_S: Final = 0.3
"""Shortest rest that tells the noise [s]."""

PARTS: Final = 8
"""Parts of a recording whose means tell how well the whole one is known [-]."""

_LOUDER = 3.0  # times the quietest block: the shaker has begun
_REST = 0.3  # rest is quieter than this share of the whole recording
_DRIVEN = 0.5  # median coherence with the controls: noises of two sensors have none
_SEGMENTS = 8  # of the lead-in, for the coherence
_FEWEST = 8  # samples of each: bins beside those that hold the mean
_GROWS = 2.0  # from the first to the last third: a drive that is turned up is no rest


@final
@dataclass(frozen=True, slots=True, eq=False)
class Quiet:
    """The lead-in, and what the channels hold there.

    Attributes
    ----------
    stop : int
        First sample that no longer belongs to it.
    controls, responses : (n_channels, stop) array
        Samples at rest, without their means.
    """

    stop: int
    controls: FloatArray
    responses: FloatArray


def quiet_of(controls: FloatArray, responses: FloatArray, sample_rate: float) -> Quiet | None:
    """Return the lead-in of a recording at rest, or None where it begins in motion.

    The rms of blocks of 0.05 s is followed from the start; rest ends where a control or a
    response first exceeds three times its quietest block of the start, and must be below
    three tenths of the rms of the whole, have 64 samples, not grow while it lasts, and hold
    responses that have nothing in common with the controls at most frequencies.

    `controls` and `responses` are in the units of their channels, `sample_rate` in [Hz].
    """
    size = max(8, round(BLOCK_S * sample_rate))
    both = np.concatenate([controls, responses])
    n_blocks = both.shape[1] // size
    if n_blocks * size < 2 * SHORTEST_S * sample_rate:
        return None
    blocks = both[:, : n_blocks * size].reshape(both.shape[0], n_blocks, size)
    level = blocks.std(axis=2)
    first = max(2, round(SHORTEST_S * sample_rate / size))
    quietest = level[:, :first].min(axis=1, keepdims=True)
    loud = np.any(level > _LOUDER * quietest, axis=0)
    end = int(np.argmax(loud)) if loud.any() else 0
    stop = (end - 1) * size
    if stop < max(SHORTEST_S * sample_rate, _SEGMENTS * _FEWEST):
        return None
    lead = both[:, :stop]
    if np.any(lead.std(axis=1) > _REST * both.std(axis=1)):
        return None
    lead = lead - lead.mean(axis=1, keepdims=True)
    if _grows(level[:, : end - 1]) or _driven(
        lead[: len(controls)], lead[len(controls) :], sample_rate
    ):
        return None
    return Quiet(stop, lead[: len(controls)], lead[len(controls) :])


def offsets_of(rows: FloatArray, *, driven: bool) -> FloatArray:
    """Return the offset of every channel, (n_channels, 1) array, from (n_channels, n) samples.

    The mean; of what nothing drives one that a taper tells: a decay is cut within a period,
    whose mean is none.
    """
    if driven:
        return np.asarray(rows.mean(axis=1, keepdims=True))
    taper = np.hanning(rows.shape[1] + 2)[1:-1]
    return np.asarray(np.average(rows, axis=1, weights=taper)[:, np.newaxis])


def offset_errors(rows: FloatArray) -> FloatArray:
    """Return the standard deviations of means of (n_channels, n) samples, (n_channels,) array.

    As means of `PARTS` parts of them scatter: of white noise as of a motion whose last period
    is cut.
    """
    parts = np.array([part.mean(axis=1) for part in np.array_split(rows, PARTS, axis=1)])
    return np.asarray(parts.std(axis=0, ddof=1) / np.sqrt(PARTS))


def end_of(controls: FloatArray, responses: FloatArray, sample_rate: float) -> int:
    """Return the first sample of the rest in which a recording ends, its length without one.

    Nothing of a model shows in it: a decay that has died away is no motion to be predicted.

    Arguments are those of `quiet_of`, which looks for it from the end.
    """
    rest = quiet_of(controls[:, ::-1], responses[:, ::-1], sample_rate)
    return int(responses.shape[1]) - (0 if rest is None else rest.stop)


def _grows(level: FloatArray) -> bool:
    """Return whether a channel is louder in the last blocks of a lead-in than in the first."""
    third = max(1, level.shape[1] // 3)
    return bool(np.any(level[:, -third:].mean(axis=1) > _GROWS * level[:, :third].mean(axis=1)))


def _driven(controls: FloatArray, responses: FloatArray, sample_rate: float) -> bool:
    """Return whether a response follows the controls: a low level is no rest."""
    rows = np.concatenate([controls.mean(axis=0, keepdims=True), responses])
    if not np.all(rows.std(axis=1) > 0.0):
        return False
    segment = rows.shape[1] // _SEGMENTS
    cross = cross_spectra(rows, sample_rate, segment=segment)
    found = coherence(cross, [0], range(1, len(rows)))[:, 2:]
    return bool(np.any(np.nanmedian(found, axis=1) > _DRIVEN))
