"""Frequency and damping of a mode against its amplitude, by two methods."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import FloatArray
from shakerproc.numerals import numeral
from shakerproc.spectra.decays.crossings import LEAST_INDEPENDENT, chart_of, read_chart
from shakerproc.spectra.decays.isolation import (
    DecayEnvelope,
    envelope_of,
    filter_length,
    largest_rise,
    oscillation_of,
)
from shakerproc.spectra.decays.least_squares import LEAST, read_envelope
from shakerproc.spectra.decays.line import DecayLine
from shakerproc.spectra.decays.reading import Reading

FALL: Final = 0.7
"""Amplitude at the end of a stretch over that at its start [-]: about seven stretches of their
own in a decade of amplitude."""

LEAST_STRETCHES: Final = 2
"""Stretches that a curve has at least [-]: a single reading has nothing that confirms it, and
two modes too close to tell apart give one that is wrong."""

NOISY: Final = 0.1
"""Rms of the noise over the amplitude from which on a stretch is not read, 20 dB [-]: below,
peaks are too high by half its square, 0.5 %, and less."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class DecayCurve:
    """Frequency and damping of a mode along its decay.

    Attributes
    ----------
    line : DecayLine
        The mode.
    fitted : tuple of Reading
        By least squares of a decaying sinusoid.
    charted : tuple of Reading
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
    fitted: tuple[Reading, ...]
    charted: tuple[Reading, ...]
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
    least = max(LEAST * envelope.step, LEAST_INDEPENDENT / motion.bandwidth)
    fitted, charted = [], []
    stretches = list(_stretches(envelope, least))
    for start, stop in stretches:
        one, other = read_envelope(envelope, start, stop), read_chart(chart, start, stop)
        if one is None or other is None or one.noise > NOISY:
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
    """Yield stretches over which the amplitude falls to `FALL`, each half over the last.

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
        below = start + np.flatnonzero(lowest[start - time.size :] < FALL * amplitude[start])
        stop = max(int(below[0]) if below.size else time.size - 1, start + fewest)
        yield float(time[start]), float(time[stop])
        if not below.size:
            return
        start += max((stop - start) // 2, 1)


def _why_none(needed: float, duration: float, line: DecayLine) -> str:
    """Return why a decay tells nothing."""
    isolated = (
        f"to isolate {numeral(line.frequency, 4)} Hz from what lies {numeral(line.apart)} Hz "
        "away and to read it twice"
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
