"""Noise of a measurement by itself: rest, repeats, controls, the band above, steps."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.data import FloatArray
from shakerproc.spectra import CrossSpectra, coherence, cross_spectra, psd, spectrogram

QUIET: Final = "quiet lead-in"
REPEATS: Final = "repeats"
DISAGREEMENT: Final = "disagreement of the controls"
ABOVE: Final = "band above the excitation"
QUARTER: Final = "quietest quarter of the spectrum"
RESOLUTION: Final = "resolution of the recorder"

SEGMENT: Final = 512
"""Samples of a Welch segment: noise is smooth in frequency, rest is short [-]."""

WINDOW: Final = "hann"
"""Its side lobes fall by 18 dB an octave; those of Hamming stay at -43 dB, so that far above it
what is excited would pass for noise."""

ABOVE_EXCITED: Final = 1.1
"""Where the band above begins, over the highest excited frequency: past the flank of a
drive's own filter [-]."""

BELOW_FILTER: Final = 0.4
"""Where the band above ends, over the sample rate: below the recorder's anti-alias filter,
whose flank begins at 0.4 to 0.5 of it [-]."""

MOST_POWER: Final = 0.9
"""Share of its power by which the bins of a motion are told [-]."""

MOVING: Final = 4.0
"""Density of a rest in the bins of the motion over that beside them, from which it moves: its
noise would be told twice too large [-]."""

FEWEST_BINS: Final = 16
"""Bins of the band above that tell a density to a quarter of it [-]."""

FEWEST_PIECES: Final = 16
"""Pieces of a record, a quarter of which is as quiet as its noise [-]."""

MOST_PIECES: Final = 512
"""Pieces of a record whose densities are looked at; neighbours of more are averaged [-]."""

SAME_DRIVE: Final = 0.999
"""Correlation above which two drives are one: noise of 3 % of both lowers it so far [-]."""

LONGEST_LAGS: Final = 2**18
"""Samples in which a period is sought [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Channels:
    """Channels of one test as they were measured.

    Attributes
    ----------
    controls : (n_controls, n) array
        Accelerations of the base [m/s^2], or one force [N].
    responses : (n_sensors, n) array
        Responses, in the unit of each sensor.
    sample_rate : float
        Samples per second [Hz].
    excited : (float, float)
        Band that the test excites [Hz].
    """

    controls: FloatArray
    responses: FloatArray
    sample_rate: float
    excited: tuple[float, float]


Source: TypeAlias = Callable[[Channels, Sequence[Channels]], FloatArray | None]


def frequencies(sample_rate: float) -> FloatArray:
    """Return the bins at which noise is told [Hz]."""
    return np.asarray(np.fft.rfftfreq(SEGMENT, 1.0 / sample_rate)[1:], float)


def density(rows: FloatArray, sample_rate: float) -> FloatArray:
    """Return smoothed densities at `frequencies`, (n_rows, n_frequencies) array [unit^2/Hz]."""
    return _density(smoothed(rows, sample_rate), sample_rate)


def smoothed(rows: FloatArray, sample_rate: float) -> CrossSpectra:
    """Return the cross-spectra of rows [unit], as smooth as noise is in frequency."""
    segment = min(SEGMENT, rows.shape[1])
    return cross_spectra(rows, sample_rate, segment=segment, window=WINDOW)


def _density(cross: CrossSpectra, sample_rate: float) -> FloatArray:
    # bins 0 and 1 hold what is left of the mean
    known = cross.frequency[2:]
    return np.array([np.interp(frequencies(sample_rate), known, row[2:]) for row in psd(cross)])


def resolution(test: Channels) -> FloatArray:
    r"""Return the noise of rounding to the smallest step, (n_controls + n_sensors,) array.

    .. math:: G = \frac{\Delta^2}{12} \Big/ \frac{f_s}{2}

    [unit^2/Hz]; 0 where a channel has no step of its own.

    References
    ----------
    .. [1] B. Widrow and I. Kollar, "Quantization Noise", Cambridge, 2008, ch. 5.
    """
    rows = [*test.controls, *test.responses]
    return np.array([_step(row) ** 2 / (6.0 * test.sample_rate) for row in rows])


_LEAST_EQUAL: Final = 8
"""Samples for each value that there is, at least, where values are those of a converter [-]."""


def _step(row: FloatArray) -> float:
    """Return the smallest difference of values of a row that takes few values, else 0."""
    values = np.unique(row)
    if values.size < 2 or values.size * _LEAST_EQUAL > row.size:
        return 0.0
    steps = np.diff(values)
    rounding = 1e-9 * float(np.abs(values).max())
    steps = steps[steps > rounding]
    return float(steps.min()) if steps.size else 0.0


def responses_at_rest(test: Channels, twins: Sequence[Channels]) -> FloatArray | None:
    """Return the responses before and after the run."""
    rest = _rest(test)
    if rest is None:
        return None
    others = (responses_of_repeats, responses_of_decay, responses_above)
    return _at_most(rest[len(test.controls) :], test.responses, test, twins, others)


def input_at_rest(test: Channels, twins: Sequence[Channels]) -> FloatArray | None:
    """Return the mean of the controls before and after the run, noises apart."""
    rest, n = _rest(test), len(test.controls)
    if rest is None:
        return None
    mean = np.asarray(rest[:n].sum(axis=0, keepdims=True) / n**2)
    run = test.controls.mean(axis=0, keepdims=True)
    return _at_most(mean, run, test, twins, (input_above,))


def _rest(test: Channels) -> FloatArray | None:
    """Return the densities at rest of all channels, before and after weighted by length."""
    found, lengths = [], []
    for way in (1, -1):
        quiet = quiet_of(test.controls[:, ::way], test.responses[:, ::way], test.sample_rate)
        if quiet is not None:
            rows = np.concatenate([quiet.controls, quiet.responses])
            found.append(density(rows, test.sample_rate))
            lengths.append(quiet.stop)
    return np.average(found, axis=0, weights=lengths) if found else None


def _at_most(
    rest: FloatArray,
    run: FloatArray,
    test: Channels,
    twins: Sequence[Channels],
    others: Sequence[Source],
) -> FloatArray:
    """Return the density of a rest, where it still moves no more than others say.

    The tail of a decay and the begin of a quake hold motion that no control tells.
    """
    moving = [
        stands_out(own, row) > MOVING
        for own, row in zip(rest, density(run, test.sample_rate), strict=True)
    ]
    known = (other(test, twins) for other in others) if any(moving) else iter(())
    least = next((one for one in known if one is not None), rest)
    return np.where(np.array(moving)[:, np.newaxis], np.minimum(rest, least), rest)


def stands_out(rest: FloatArray, run: FloatArray) -> float:
    """Return how much more a rest holds in the bins of a motion than beside them [-].

    The bins of a motion are the fewest that hold nine tenths of its power. White noise has 1.

    `rest` and `run` are (n_frequencies,) arrays of densities, in one unit.
    """
    order = np.argsort(run)[::-1]
    power = np.cumsum(run[order])
    count = 1 + int(np.searchsorted(power, MOST_POWER * power[-1]))
    beside = rest[order[count:]]
    if not beside.size or not beside.mean() > 0.0:
        return 1.0
    return float(rest[order[:count]].mean() / beside.mean())


def responses_of_repeats(test: Channels, twins: Sequence[Channels]) -> FloatArray | None:
    """Return half the density of what differs between repeats of a drive, or of its period."""
    shifted = _one_period_on(test)
    pairs = [shifted] if shifted is not None else []
    pairs += [(test.responses, twin.responses) for twin in twins if _repeats(test, twin)]
    if not pairs:
        return None
    halves = [0.5 * density(one - other, test.sample_rate) for one, other in pairs]
    return np.asarray(np.mean(halves, axis=0))


def _repeats(test: Channels, twin: Channels) -> bool:
    """Return whether another test has the same drive, sample by sample."""
    if twin.responses.shape != test.responses.shape:
        return False
    apart = np.ptp(twin.responses - test.responses, axis=1)
    if np.any(apart <= 1e-9 * np.ptp(test.responses, axis=1)):  # one recording, judged twice
        return False
    one, other = test.controls.mean(axis=0), twin.controls.mean(axis=0)
    size = float(np.sqrt(np.sum(one**2) * np.sum(other**2)))
    if not size > 0.0:
        return False
    same_level = abs(np.sum(one**2) / np.sum(other**2) - 1.0) < 4.0 * (1.0 - SAME_DRIVE)
    return same_level and float(np.sum(one * other)) > SAME_DRIVE * size


def _one_period_on(test: Channels) -> tuple[FloatArray, FloatArray] | None:
    lag = period_of(test.controls.mean(axis=0))
    if not lag:
        return None
    return test.responses[:, lag:], test.responses[:, :-lag]


def period_of(drive: FloatArray) -> int:
    """Return the samples after which a drive repeats, or 0 where it does not.

    Lags of a twentieth to a half of the drive are looked at: a sine has many periods in them,
    a slow sweep has none.

    `drive` is an (n,) array [m/s² or N].
    """
    part = drive[:LONGEST_LAGS]
    n = part.size
    length = scipy.fft.next_fast_len(2 * n, real=True)
    spectrum = scipy.fft.rfft(part, length)
    product = scipy.fft.irfft(np.abs(spectrum) ** 2, length)[:n]
    power = np.concatenate([[0.0], np.cumsum(part**2)])
    lags = np.arange(n // 20, n // 2)
    size = np.sqrt(power[n - lags] * (power[n] - power[lags]))
    if not lags.size or not np.all(size > 0.0):
        return 0
    likeness = product[lags] / size
    best = int(np.argmax(likeness))
    return int(lags[best]) if likeness[best] > SAME_DRIVE else 0


def disagreement(test: Channels, _: Sequence[Channels]) -> FloatArray | None:
    r"""Return the noise of the mean of the controls, from what each has for itself.

    What a control does in proportion to the mean of all (its gain, a rocking table) is not
    noise; of what is left of :math:`N` controls, :math:`\sum_i G_i / (N (N - 1))` is that of
    their mean.
    """
    n = len(test.controls)
    if n < 2:
        return None
    mean = test.controls.mean(axis=0)
    apart = test.controls - mean
    rows = np.array([mean, *apart])
    cross = cross_spectra(rows, test.sample_rate, segment=SEGMENT, window=WINDOW)
    both = psd(cross)
    coherent = np.abs(cross.matrix[0, 1:]) ** 2 / np.maximum(both[0], np.finfo(float).tiny)
    averages = max(2.0, cross.effective_averages)
    alone = np.maximum(0.0, both[1:] - coherent) * averages / (averages - 1.0)
    found = alone.sum(axis=0) / (n * (n - 1.0))
    mean_noise = np.interp(frequencies(test.sample_rate), cross.frequency[2:], found[2:])
    return np.asarray(mean_noise)[np.newaxis]


def responses_above(test: Channels, _: Sequence[Channels]) -> FloatArray | None:
    """Return the rest of the responses above the excited band, equal at all frequencies."""
    return _quartile(test.responses, test, ABOVE_EXCITED * test.excited[1])


def input_above(test: Channels, _: Sequence[Channels]) -> FloatArray | None:
    """Return the rest of the mean of the controls above the excited band."""
    mean = test.controls.mean(axis=0, keepdims=True)
    return _quartile(mean, test, ABOVE_EXCITED * test.excited[1])


def responses_of_decay(test: Channels, _: Sequence[Channels]) -> FloatArray | None:
    """Return the noise of a free decay beside its modes, the same everywhere."""
    return None if test.controls.any() else _quartile(test.responses, test, 0.0)


def _quartile(rows: FloatArray, test: Channels, low: float) -> FloatArray | None:
    r"""Return the noise above a frequency [Hz] by the lower quartile of densities there.

    Over frequency and time: lines and harmonics stand above it, and so does what a motion that
    jumps holds everywhere for a moment. A density of white noise by :math:`n` averages has a
    :math:`\chi^2` distribution, whose quartile is below its mean :math:`G` by

    .. math:: Q(\tfrac14; 2 n) / (2 n)
    """
    frequency = frequencies(test.sample_rate)
    high = BELOW_FILTER * test.sample_rate
    if np.count_nonzero((frequency > low) & (frequency < high)) < FEWEST_BINS:
        return None
    told = spectrogram(
        rows, test.sample_rate, segment=_segment(rows.shape[1], test.sample_rate, low),
        overlap=0, window=WINDOW, most_times=MOST_PIECES,
    )  # fmt: skip
    inside = (told.frequency > low) & (told.frequency < high)
    cells = told.density[:, inside].reshape(len(rows), -1)
    averages = max(1.0, rows.shape[1] * (told.frequency[1] / test.sample_rate) / told.time.size)
    low_by = scipy.stats.chi2.ppf(0.25, 2.0 * averages) / (2.0 * averages)
    least = np.quantile(cells, 0.25, axis=1) / low_by
    return np.repeat(least[:, np.newaxis], frequency.size, axis=1)


def _segment(n_samples: int, sample_rate: float, low: float) -> int:
    """Return the samples of a segment: few enough that a record holds `FEWEST_PIECES`.

    But so many that the band above `low` [Hz] has `FEWEST_BINS`, and that what is excited below
    it stays out of it: the lobe of a line is four bins wide.
    """
    longest = min(SEGMENT, n_samples)
    if not low > 0.0:
        return longest
    bins = FEWEST_BINS * sample_rate / (BELOW_FILTER * sample_rate - low)
    needed = max(bins, 4.0 * sample_rate / low, n_samples / FEWEST_PIECES)
    return int(min(longest, np.ceil(needed)))


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
_PRETRIGGER = 64  # samples that a recorder keeps before a blow, at least
_UNLIKE = 1.0  # mean square of successive differences over the variance: 2 for white noise
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
    responses that have nothing in common with the controls at most frequencies. A recorder
    that waits for a blow keeps less than 0.3 s before it: there blocks of 16 samples are
    followed, and none of their channels may hold anything smooth.

    `controls` and `responses` are in the units of their channels, `sample_rate` in [Hz].
    """
    slow = _lead_in(controls, responses, sample_rate, _blocks(sample_rate))
    if slow is not None:
        return slow
    found = _lead_in(controls, responses, sample_rate, (_PRETRIGGER // 4, _PRETRIGGER))
    if found is None or not _is_noise(np.concatenate([found.controls, found.responses])):
        return None
    return found


def _blocks(sample_rate: float) -> tuple[int, float]:
    """Return the samples of a block, and those that a rest takes at least."""
    return max(8, round(BLOCK_S * sample_rate)), SHORTEST_S * sample_rate


def _is_noise(rows: FloatArray) -> bool:
    """Return whether neighbouring samples of every row have next to nothing in common.

    References
    ----------
    .. [1] J. von Neumann, "Distribution of the ratio of the mean square successive difference
       to the variance", Annals of Mathematical Statistics 12, 367-395, 1941: 2 for white noise.
    """
    ratio = np.mean(np.diff(rows, axis=1) ** 2, axis=1)
    return bool(np.all(ratio >= _UNLIKE * np.var(rows, axis=1)))


def _lead_in(
    controls: FloatArray,
    responses: FloatArray,
    sample_rate: float,
    blocks: tuple[int, float],
) -> Quiet | None:
    """Return the lead-in that blocks of a size show, none shorter than so many samples."""
    size, shortest = blocks
    both = np.concatenate([controls, responses])
    n_blocks = both.shape[1] // size
    if n_blocks * size < 2 * shortest:
        return None
    level = both[:, : n_blocks * size].reshape(both.shape[0], n_blocks, size).std(axis=2)
    first = max(2, round(shortest / size))
    quietest = level[:, :first].min(axis=1, keepdims=True)
    loud = np.any(level > _LOUDER * quietest, axis=0)
    end = int(np.argmax(loud)) if loud.any() else 0
    stop = (end - 1) * size
    if stop < max(shortest, _SEGMENTS * _FEWEST):
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

    Arguments are those of `quiet_of`.
    """
    blocks = _blocks(sample_rate)
    rest = _lead_in(controls[:, ::-1], responses[:, ::-1], sample_rate, blocks)
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
