r"""The rows that channels have in common: their own, or samples at even times between.

Even samples are summed with a sinc in a Kaiser window. Through uneven ones goes a cubic spline,
of which an even grid of step h shows a sine of frequency f with the gain

.. math:: H(fh) = \frac{3\,\mathrm{sinc}^4(fh)}{2 + \cos(2 \pi f h)}

References
----------
.. [1] M. Unser, "Splines: a perfect fit for signal and image processing", IEEE Signal
   Processing Magazine 16(6), 22-38, 1999.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray, SampleSource
from shakerproc.errors import RecordingError
from shakerproc.interpolation import TAPS, interpolated
from shakerproc.recordings.choosing import Chosen
from shakerproc.recordings.guard import shown

SPLINE_BAND: Final = 0.22
"""Share of the sample rate up to which the gain of a spline is 1 within 1 % [-]."""

SINC_BAND: Final = 0.45
"""Share of the lower rate up to which that of the windowed sinc is [-]."""

NEIGHBOURS: Final = 32
"""Samples on either side of a time that a spline is drawn through: what lies beyond changes it
by less than 0.27 to that power [-]."""


ENDS: Final = 4
"""Samples at either end that are left out: there a spline is off by more than elsewhere, by a
share that falls by 0.27 from sample to sample [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """When the samples of a channel were taken: a step and a start, or times.

    Attributes
    ----------
    n_samples : int
        How many there are.
    rate : float
        Samples per second, the mean where they are uneven [Hz].
    start : float
        Of the first [s].
    times : (n,) array, optional
        Of each, where they are uneven; behind `start` [s].
    """

    n_samples: int
    rate: float
    start: float
    times: FloatArray | None = None

    @property
    def end(self) -> float:
        """Time of the last sample [s]."""
        if self.times is not None:
            return self.start + float(self.times[-1])
        return self.start + (self.n_samples - 1) / self.rate

    @property
    def longest(self) -> float:
        """Longest step that is none of a gap [s]."""
        if self.times is None:
            return 1.0 / self.rate
        steps = np.diff(self.times)
        return float(steps[steps <= 2.0 * np.median(steps)].max())

    @property
    def jitter(self) -> float:
        """How far steps that are none of gaps vary, rms over their mean [-]."""
        if self.times is None:
            return 0.0
        steps = np.diff(self.times)
        usual = steps[steps <= 2.0 * np.median(steps)]
        return float(np.std(usual) / np.mean(usual))

    @property
    def gaps(self) -> FloatArray:
        """Steps that are longer than two others, so that a sample is missing [s]."""
        if self.times is None:
            return np.empty(0)
        steps = np.diff(self.times)
        long: FloatArray = steps[steps > 2.0 * np.median(steps)]
        return long

    def finer(self, rate: float) -> int:
        """Return how many times finer than a rate [Hz] samples are interpolated first.

        Once where what lies above half of the rate folds to above the band of the spline.
        """
        if self.times is None or rate >= (0.5 + SPLINE_BAND) * self.rate:
            return 1
        return int(np.ceil(self.rate / rate))

    def edge(self, rate: float) -> float:
        """Return the time at either end where neighbours are missing [s], at a rate [Hz]."""
        if self.times is None:
            return TAPS / min(self.rate, rate)
        ends = ENDS * self.longest
        return ends + TAPS / rate if self.finer(rate) > 1 else ends

    def band(self, rate: float) -> float:
        """Return the frequency up to which the interpolation is good to 1 % [Hz]."""
        if self.times is None:
            return SINC_BAND * min(self.rate, rate)
        good = SPLINE_BAND / self.longest
        return min(good, SINC_BAND * rate) if self.finer(rate) > 1 else min(good, 0.5 * rate)


@final
@dataclass(frozen=True, slots=True, eq=False)
class ResampledSource(SampleSource):
    """Samples of another source at even times that all of its rows cover.

    Attributes
    ----------
    source : SampleSource
        Where they come from.
    lines : dict
        When those of each row were taken, by row.
    rate : float
        Of the even times [Hz].
    start : float
        The first of them [s].
    """

    source: SampleSource
    lines: dict[int, Line]
    rate: float
    start: float

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        times = self.start + np.arange(start, max(start, stop)) / self.rate
        out = np.empty((len(rows), times.size))
        groups: dict[int, list[int]] = {}
        for at, row in enumerate(rows):
            groups.setdefault(id(self.lines[row]), []).append(at)
        for places in groups.values():
            chosen = [rows[at] for at in places]
            out[places] = self._of(chosen, self.lines[chosen[0]], times)
        return out

    def _of(self, rows: Sequence[int], line: Line, times: FloatArray) -> FloatArray:
        """Return the values of rows that share their times at others [s]."""
        if line.times is None:
            return interpolated(
                lambda first, last: self.source.read(rows, first, last),
                line.n_samples, line.rate, times - line.start, self.rate,
            )  # fmt: skip
        finer = line.finer(self.rate)
        if finer == 1:
            return self._spline(rows, line, line.times, times - line.start)
        rate = finer * self.rate
        ends = ENDS * line.longest
        count = int(np.floor((line.end - line.start - 2.0 * ends) * rate)) + 1
        whole = line.times

        def read(first: int, last: int) -> FloatArray:
            return self._spline(rows, line, whole, ends + np.arange(first, last) / rate)

        return interpolated(read, count, rate, times - line.start - ends, self.rate)

    def _spline(
        self, rows: Sequence[int], line: Line, taken: FloatArray, times: FloatArray
    ) -> FloatArray:
        """Return the values of splines through samples at other times [s].

        A time beside a sample that is no number has none.
        """
        from scipy.interpolate import CubicSpline

        if not times.size:
            return np.empty((len(rows), 0))
        first = int(np.searchsorted(taken, times[0], side="right")) - 1 - NEIGHBOURS
        last = int(np.searchsorted(taken, times[-1])) + 1 + NEIGHBOURS
        first, last = max(first, 0), min(last, line.n_samples)
        samples, at = self.source.read(rows, first, last), taken[first:last]
        good = np.isfinite(samples)
        values = CubicSpline(at, np.where(good, samples, 0.0), axis=1)(times)
        for row in np.flatnonzero(~good.all(axis=1)):
            values[row] = _over_holes(at, samples[row], times)
        resampled: FloatArray = values
        return resampled

    def close(self) -> None:
        """Close the other source."""
        self.source.close()


def _over_holes(at: FloatArray, samples: FloatArray, times: FloatArray) -> FloatArray:
    """Return a spline [units of the samples] through those that are numbers, at times [s]."""
    from scipy.interpolate import CubicSpline

    good = np.isfinite(samples)
    if good.sum() < 2:
        return np.full(times.size, np.nan)
    values: FloatArray = CubicSpline(at[good], samples[good])(times)
    after = np.clip(np.searchsorted(at, times), 0, at.size - 1)
    values[~(good[after] & good[np.maximum(after - 1, 0)])] = np.nan
    return values


def common_length(
    chosen: Sequence[Chosen], begins: Sequence[int], run: str
) -> tuple[int, int | None, str]:
    """Return how many complete rows there are, how many there should be if more, and a note.

    A row is complete where every channel holds its sample: a program that is stopped between
    two writes leaves some channels longer than others.

    `begins` is the sample of each channel that is the first of them.

    Raises
    ------
    RecordingError
        If there is no complete row.
    """
    each = list(zip(chosen, begins, strict=True))
    n_samples = min(channel.n_samples - begin for (channel, _), begin in each)
    if n_samples <= 0 and any(begins):
        late = max(range(len(chosen)), key=lambda at: -begins[at])
        raise RecordingError(
            f"{run}: channel {shown(chosen[late][0].name)} starts after others have ended. Use "
            "only channels that were measured at one time."
        )
    if not n_samples:
        none = next(channel for channel, _ in chosen if not channel.n_samples)
        raise RecordingError(
            f"{run}: there is not one complete row of samples: channel {shown(none.name)} "
            f"holds none of its {none.promised}. Copy the file again, or leave the channel out "
            "of the log."
        )
    long = max((channel for channel, _ in chosen), key=lambda channel: channel.promised)
    short = min((channel for channel, _ in chosen), key=lambda channel: channel.promised)
    there = [channel.promised - begin for (channel, _), begin in each]
    if long.promised == short.promised:  # what only starts late is not cut short
        return n_samples, min(there) if min(there) > n_samples else None, ""
    note = (
        f"Channel {shown(long.name)} holds {long.n_samples} samples, {shown(short.name)} "
        f"{short.n_samples}: the {n_samples} rows that all channels have are used."
    )
    return n_samples, max(there) if max(there) > n_samples else None, note


def resampled_length(
    chosen: Sequence[Chosen], lines: Sequence[Line], start: float, rate: float
) -> tuple[int, int | None]:
    """Return how many interpolated rows there are, and how many there should be if more.

    Parameters
    ----------
    chosen : sequence of (RawChannel, ChannelUse)
        The channels.
    lines : sequence of Line
        When their samples were taken.
    start : float
        First of the interpolated times [s].
    rate : float
        Of them [Hz].
    """
    last = min(line.end - line.edge(rate) for line in lines)
    n_samples = int((last - start) * rate + 1e-6) + 1
    missing = max(
        (channel.promised - channel.n_samples) / line.rate
        for (channel, _), line in zip(chosen, lines, strict=True)
    )
    return n_samples, n_samples + math.ceil(missing * rate) if missing > 0.0 else None
