"""Frequency and damping of a mode against its amplitude, and the law they follow."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.numerals import numeral
from shakerproc.spectra.decays.lines import (
    DecayEnvelope,
    DecayLine,
    envelope_of,
    filter_length,
    largest_rise,
    oscillation_of,
)
from shakerproc.spectra.decays.readings import (
    LEAST_INDEPENDENT,
    LEAST_SAMPLES,
    DecayReading,
    chart_of,
    read_chart,
    read_envelope,
)

FALL_OF_STRETCH: Final = 0.7
"""Amplitude at the end of a stretch over that at its start [-]: about seven stretches of their
own in a decade of amplitude."""

LEAST_STRETCHES: Final = 2
"""Stretches that a curve has at least [-]: a single reading has nothing that confirms it, and
two modes too close to tell apart give one that is wrong."""

MOST_NOISE: Final = 0.1
"""Rms of the noise over the amplitude from which on a stretch is not read, 20 dB [-]: below,
peaks are too high by half its square, 0.5 %, and less."""

LEAST_READINGS: Final = 5
"""Readings that a trend needs at least [-]: three beyond a constant and a power."""

SHARED_SCATTER: Final = 2.0
"""How much of the scatter is left out as each reading shares half its stretch with the one
before [-]: as if every other reading were."""

TREND_CONFIDENCE: Final = 0.99
"""Probability that chance shows no trend [-]: of a hundred decays of a linear structure one
does."""

EXPLAINED_SHARE: Final = 0.98
"""Share of the change of damping that a law explains at least to be named [-]."""

LEAST_FACTOR: Final = 1.3
"""Least factor between the smallest and the largest damping of which a law is named [-]: a gap
or a cubic spring changes the ratio by less with no damping of its own."""

LAW_ERROR: Final = 0.02
"""Error of a damping beside its interval when laws are compared, over its value [-]: laws of
smooth curves are known no better."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class DecayCurve:
    """Frequency and damping of a mode along its decay.

    Attributes
    ----------
    line : DecayLine
        The mode.
    fitted : tuple of DecayReading
        By least squares of a decaying sinusoid.
    charted : tuple of DecayReading
        By peaks and zero crossings, over the same stretches.
    problem : str
        Why there are none; empty where there are.
    reach : float
        How far the frequency may shift before the filters lower the amplitude [Hz].
    rises : float
        Largest amplitude after a smaller one, over that, as far as readings go; 1 of what only
        decays [-].
    """

    line: DecayLine
    fitted: tuple[DecayReading, ...]
    charted: tuple[DecayReading, ...]
    problem: str
    reach: float
    rises: float

    @property
    def disputed(self) -> list[int]:
        """Stretches of which the intervals of both methods do not meet."""
        return [
            i
            for i, (a, b) in enumerate(zip(self.fitted, self.charted, strict=True))
            if abs(a.frequency - b.frequency) > a.frequency_error + b.frequency_error
            or abs(a.damping - b.damping) > a.damping_error + b.damping_error
        ]


def decay_curve(samples: FloatArray, sample_rate: float, line: DecayLine) -> DecayCurve:
    """Return frequency and damping of a mode against its amplitude.

    Parameters
    ----------
    samples : (n_samples,) array
        The free decay of one channel, from its start [unit of the channel].
    sample_rate : float
        Samples per second [Hz].
    line : DecayLine
        The mode.
    """
    rest = samples - samples[-max(samples.size // 10, 1) :].mean()
    envelope = envelope_of(rest, sample_rate, line)
    motion = oscillation_of(rest, sample_rate, line)
    chart = chart_of(motion, line.frequency)
    least = max(LEAST_SAMPLES * envelope.step, LEAST_INDEPENDENT / motion.bandwidth)
    fitted, charted = [], []
    stretches = list(_stretches(envelope, least))
    for start, stop in stretches:
        one, other = read_envelope(envelope, start, stop), read_chart(chart, start, stop)
        if one is None or other is None or one.noise > MOST_NOISE:
            break
        fitted.append(one)
        charted.append(other)
    problem = ""
    if len(fitted) < LEAST_STRETCHES:
        fitted, charted = [], []
        needed = filter_length(line) + 0.5 * (LEAST_STRETCHES + 1) * least
        problem = _why_none(needed, samples.size / sample_rate, line)
    last = stretches[len(fitted) - 1][1] if fitted else 0.0
    rises = largest_rise(np.abs(envelope.values[envelope.time <= last]))
    return DecayCurve(line, tuple(fitted), tuple(charted), problem, envelope.reach, rises)


def _stretches(envelope: DecayEnvelope, least: float) -> Iterator[tuple[float, float]]:
    """Yield stretches over which the amplitude falls to a share, each half over the last.

    None is shorter than `least` [s]. An amplitude that comes back, as of two modes that beat,
    counts where it is passed first.
    """
    time, amplitude = envelope.time, np.abs(envelope.values)
    if not time.size:
        return
    fewest = int(np.ceil(least / envelope.step))
    start = int(np.argmax(amplitude))
    lowest = np.minimum.accumulate(amplitude[start:])
    while start + fewest < time.size:
        below = start + np.flatnonzero(
            lowest[start - time.size :] < FALL_OF_STRETCH * amplitude[start]
        )
        stop = max(int(below[0]) if below.size else time.size - 1, start + fewest)
        yield float(time[start]), float(time[stop])
        if not below.size:
            return
        start += max((stop - start) // 2, 1)


def _why_none(needed: float, duration: float, line: DecayLine) -> str:
    """Return why a decay tells nothing."""
    isolated = (
        f"to isolate {numeral(line.frequency, 4)} Hz from what lies {numeral(line.distance)} "
        "Hz away and to read it twice"
    )
    if duration < needed:
        return (
            f"the decay lasts {numeral(duration)} s, and {numeral(needed)} s are needed "
            f"{isolated}"
        )
    return (
        f"it ends, in noise or in another mode, within the {numeral(needed)} s that are needed "
        f"{isolated}"
    )


@final
@dataclass(frozen=True, slots=True)
class DecayTrend:
    """How a mode depends on its amplitude.

    Attributes
    ----------
    shift : float
        Frequency at the largest amplitude less that at the smallest, over that [-].
    shifts : bool
        Whether the frequency changes by more than its intervals allow.
    exponent : float
        Mean exponent p where the damping ratio goes as amplitude to the power p [-].
    damps : bool
        Whether the damping changes by more than its intervals allow.
    law : int
        Power n where the damping is a constant and amplitude to the power n: -1 or 1; 0 where
        neither explains it.
    """

    shift: float
    shifts: bool
    exponent: float
    damps: bool
    law: int


def trend_of(
    readings: Sequence[DecayReading], reference: Sequence[DecayReading] = ()
) -> DecayTrend | None:
    """Return how a mode depends on its amplitude; None where too few readings tell.

    Parameters
    ----------
    readings : sequence of DecayReading
        Of one method along the decay, each sharing half of its stretch with the one before.
    reference : sequence of DecayReading
        Those of a model: then the trend is that of frequency over the model's and of damping
        less the model's, at amplitudes that both have.
    """
    used = [one for one in readings if one.damping > 0.0]
    base = at_amplitudes(reference, [one.amplitude for one in used]) if reference else None
    if base is not None:
        used = [one for one, known in zip(used, base.known, strict=True) if known]
    if len(used) < LEAST_READINGS:
        return None
    amplitude, frequency, damping, frequency_error, damping_error = columns_of(used)
    floor = LAW_ERROR * damping
    exponent = float(np.polyfit(np.log(amplitude), np.log(damping), 1)[0])
    least = (LEAST_FACTOR - 1.0) * float(damping.min())
    if base is not None:
        frequency = frequency / base.frequency
        frequency_error = (frequency_error + base.frequency_error) / base.frequency
        damping, damping_error = damping - base.damping, damping_error + base.damping_error
    damps = _changes(damping, damping_error)
    errors = np.hypot(damping_error, floor)
    return DecayTrend(
        shift=float(frequency[0] / frequency[-1] - 1.0),
        shifts=_changes(frequency, frequency_error),
        exponent=exponent,
        damps=damps,
        law=_law(amplitude, damping, errors) if damps and np.ptp(damping) > least else 0,
    )


@final
@dataclass(frozen=True, slots=True, eq=False)
class AmplitudeReadings:
    """Readings at given amplitudes.

    Attributes
    ----------
    frequency, damping : (n_known,) array
        Between the readings, straight over the logarithm of amplitude [Hz], [-].
    frequency_error, damping_error : (n_known,) array
        Half the widths of their intervals [Hz], [-].
    known : (n,) array of bool
        Which of the amplitudes the readings reach.
    """

    frequency: FloatArray
    damping: FloatArray
    frequency_error: FloatArray
    damping_error: FloatArray
    known: NDArray[np.bool_]


def at_amplitudes(
    readings: Sequence[DecayReading], amplitudes: Sequence[float]
) -> AmplitudeReadings:
    """Return the readings at amplitudes between their smallest and their largest.

    `amplitudes` are in the unit of the readings.
    """
    amplitude, *others = columns_of(readings)
    rising = np.argsort(amplitude)
    wanted = np.asarray(amplitudes, float)
    known = (wanted >= amplitude.min()) & (wanted <= amplitude.max())
    place, along = np.log(amplitude[rising]), np.log(wanted[known])
    frequency, damping, *errors = (np.interp(along, place, row[rising]) for row in others)
    return AmplitudeReadings(frequency, damping, errors[0], errors[1], known)


def columns_of(readings: Sequence[DecayReading]) -> tuple[FloatArray, ...]:
    """Return amplitude, frequency, damping and the half widths of both intervals as arrays."""
    names = ("amplitude", "frequency", "damping", "frequency_error", "damping_error")
    return tuple(np.array([getattr(one, name) for one in readings]) for name in names)


def _changes(values: FloatArray, errors: FloatArray) -> bool:
    """Return whether values differ by more than half their 95 % intervals allow."""
    # of equal values the weighted scatter is chi-square with one less than their number
    weights = (1.96 / errors) ** 2
    mean = float(weights @ values / weights.sum())
    scatter = float(weights @ (values - mean) ** 2) / SHARED_SCATTER
    return scatter > float(scipy.special.chdtri(values.size - 1, 1.0 - TREND_CONFIDENCE))


def _law(amplitude: FloatArray, damping: FloatArray, errors: FloatArray) -> int:
    """Return the power n of the law a + b A^n, b above 0, that explains damping; 0 of none."""
    weights = 1.0 / errors**2
    mean = float(weights @ damping / weights.sum())
    whole = float(weights @ (damping - mean) ** 2)
    root = np.sqrt(weights)
    explained = {}
    for power in (-1, 1):
        design = np.stack([np.ones(amplitude.size), amplitude**power], axis=1)
        weights_of_law, *_ = np.linalg.lstsq(
            design * root[:, np.newaxis], damping * root, rcond=None
        )
        squares = float(weights @ (damping - design @ weights_of_law) ** 2)
        explained[power] = 1.0 - squares / whole if weights_of_law[1] > 0.0 else 0.0
    best = max(explained, key=lambda power: explained[power])
    return best if explained[best] >= EXPLAINED_SHARE else 0
