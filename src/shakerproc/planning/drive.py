"""A test before it is run: its length, rate and averages, and its excitation as samples."""

from dataclasses import dataclass
from math import log, log2
from typing import Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.data import FloatArray
from shakerproc.errors import LogError, SpectrumError
from shakerproc.simulation.excitations import (
    NoiseProfile,
    faded,
    flat_profile,
    harmonic,
    linear_sweep,
    logarithmic_sweep,
    multisine,
    random_noise,
    stepped_sine,
)
from shakerproc.simulation.pieces import Signal
from shakerproc.spectra import effective_averages, gain_random_error, window_samples
from shakerproc.spectra.multisines import samples_of_period
from shakerproc.spectra.profiles import profile_at
from shakerproc.testlog import PULSES, Multisine, Test, Welch, nominal_duration


@final
@dataclass(frozen=True, slots=True)
class Averaging:
    """Averages that Welch's segments give in a random test.

    Attributes
    ----------
    averages : float
        Independent averages that the overlapped segments are worth [-].
    density_error, gain_error : float
        Random errors of densities and of the gain at the assumed coherence, one standard
        deviation as a share [-].
    """

    averages: float
    density_error: float
    gain_error: float


def rate_at(test: Test, frequency: float) -> float | None:
    """Return how fast a sweep passes a frequency [Hz], in Hz/s; None for other tests."""
    if test.rate_oct_per_min is not None:
        return frequency * log(2.0) * test.rate_oct_per_min / 60.0
    return test.rate_hz_per_s


def duration_of_test(test: Test, otherwise: float | None = None) -> float | None:
    """Return how long a test runs [s]: by sweep or periods, as planned, expected or given."""
    needed = nominal_duration(test) or test.duration
    if needed is None and test.multisine is not None:
        needed = test.multisine.duration
    if needed is not None:
        return needed
    return test.expect.duration if test.expect.duration is not None else otherwise


def averaging(
    welch: Welch, duration: float, sample_rate: float, coherence: float = 0.9
) -> Averaging | None:
    """Return the averages of a random test; None where not two segments fit.

    Parameters
    ----------
    welch : Welch
        Segments, overlap and window.
    duration : float
        Length of the run [s].
    sample_rate : float
        Samples per second [Hz].
    coherence : float
        Assumed for the error of the gain [-].
    """
    step = welch.segment - welch.overlap
    segments = (round(duration * sample_rate) - welch.segment) // step + 1
    if segments < 2:
        return None
    window = window_samples(welch.window, welch.segment)
    averages = effective_averages(window, step, segments)
    if averages <= 1.0:
        return None
    return Averaging(
        averages,
        averages**-0.5,
        float(gain_random_error(np.array([coherence]), averages)[0]),
    )


def sample_rate_of_test(test: Test, otherwise: float | None = None) -> float | None:
    """Return the sample rate that the log says [Hz], or the given one."""
    return test.processing.sample_rate or test.expect.sample_rate or otherwise


GROUP: Final = 4
"""Odd lines in a row of which one is left out to detect odd distortion [-]."""

STEPS_PER_OCTAVE: Final = 24
"""Steps of a stepped sine, of which the log says nothing [-]."""

RAMP: Final = 0.1
"""Time over which the shaker is led up and down [s]; at most a tenth of the run."""


def check_period(test: Test, sample_rate: float) -> None:
    """Pass a test whose multisine, if it has one, fits a sample rate [Hz].

    Raises
    ------
    LogError
        If a period is no whole number of samples.
    """
    if test.multisine is None:
        return
    try:
        samples_of_period(test.multisine.period, sample_rate)
    except SpectrumError as error:
        raise LogError(f"{test.source}: test {test.id}: {error}") from error


def excited_lines(
    said: Multisine, n_lines: int, generator: np.random.Generator
) -> NDArray[np.bool_]:
    """Return which multiples of one over the period are excited, from the first.

    Parameters
    ----------
    said : Multisine
        Which the log wants.
    n_lines : int
        How many there are.
    generator : numpy.random.Generator
        Where the lines that are left out come from.
    """
    excited = np.ones(n_lines, dtype=bool)
    if said.lines == "all":
        return excited
    excited[1::2] = False
    if said.lines == "odd with detection":
        odd = np.flatnonzero(excited)
        groups = odd[: odd.size // GROUP * GROUP].reshape(-1, GROUP)
        excited[groups[np.arange(len(groups)), generator.integers(GROUP, size=len(groups))]] = (
            False
        )
    return excited


def played(
    test: Test,
    profile: NoiseProfile,
    sample_rate: float,
    ramp: float,
    generator: np.random.Generator,
) -> FloatArray:
    """Return all realisations, (n,) array [m/s² or N], each faded into the next.

    A realisation is led up within its first period, and goes on after its last one while it is
    led down: all other periods are whole.

    Parameters
    ----------
    test : Test
        The line of the log, which says how its multisine repeats.
    profile : NoiseProfile
        Density.
    sample_rate : float
        Samples per second [Hz].
    ramp : float
        Over which a realisation is led up and down [s]; a tenth of a period at most.
    generator : numpy.random.Generator
        Where lines and phases come from.

    Raises
    ------
    LogError
        If the log does not say the periods.
    """
    said = test.multisine
    if said is None or said.periods is None:
        raise LogError(
            f"{test.source}: test {test.id}: the log does not say how many periods; add "
            "multisine: {period: ..., periods: 9}"
        )
    n_period = round(said.period * sample_rate)
    length = said.periods * n_period
    step = length if said.every is None else round(said.every * sample_rate)
    n_ramp = min(round(ramp * sample_rate), n_period // 10)
    rise = 0.5 - 0.5 * np.cos(np.pi * (np.arange(n_ramp) + 0.5) / max(n_ramp, 1))
    window = np.concatenate([rise, np.ones(length - n_ramp), rise[::-1]])
    excited = excited_lines(said, n_period, generator)
    total = np.zeros((said.realisations - 1) * step + window.size)
    for m in range(said.realisations):
        one = multisine(
            profile, said.period, sample_rate, generator,
            periods=said.periods + 1, excited=excited,
        )  # fmt: skip
        total[m * step : m * step + window.size] += window * one[: window.size]
    return total


def length_of_run(test: Test, quiet: float, otherwise: float) -> float:
    """Return how long a test shakes [s]: by its sweep, as the log expects, or as given.

    Parameters
    ----------
    test : Test
        The line of the log.
    quiet : float
        Rest before and after, which the length that the log expects includes [s].
    otherwise : float
        Where the log says nothing [s].

    Raises
    ------
    LogError
        If the recording that the log expects is too short for the rest or the sweep.
    """
    swept, expected = nominal_duration(test), test.expect.duration
    if test.multisine is not None and test.multisine.duration is not None:
        return test.multisine.duration
    if expected is None:
        return duration_of_test(test, otherwise) or otherwise
    if swept is not None:
        if swept + quiet > expected * (1.0 + test.expect.duration_tolerance):
            raise LogError(
                f"{test.source}: test {test.id}: the log expects {expected:.5g} s, but the "
                f"sweep takes {swept:.5g} s and the rest before and after {quiet:.5g} s. "
                f"Correct expect or rate, or ask for less rest"
            )
        return swept
    if expected <= quiet:
        raise LogError(
            f"{test.source}: test {test.id}: the log expects {expected:.5g} s, but the rest "
            f"before and after takes {quiet:.5g} s. Correct expect, or ask for less rest"
        )
    return expected - quiet


def drive_of_test(
    test: Test, duration: float, sample_rate: float, generator: np.random.Generator
) -> FloatArray:
    """Return the motion or force that drives a test, from rest to rest, (n,) array [m/s² or N].

    Parameters
    ----------
    test : Test
        The line of the log.
    duration : float
        Length of the run [s].
    sample_rate : float
        Samples per second [Hz].
    generator : numpy.random.Generator
        Where the randomness comes from.

    Raises
    ------
    LogError
        If the log does not say what shakes the test, or how strongly.
    """
    known = test.excitation is not None and not not_playable(test)
    stated = test.level is not None and test.level_unit is not None
    if not (stated or test.profile is not None) or not known:
        raise LogError(f"{test.source}: test {test.id}: {_lacking(test)}")
    ramp = min(RAMP, 0.1 * duration)
    if test.excitation == "multisine":
        return played(test, noise_profile(test), sample_rate, ramp, generator)
    if test.excitation in {"random", "sine on random"}:
        samples = random_noise(noise_profile(test), duration, sample_rate, generator)
        samples += _tones(test, samples.size, sample_rate, generator)
    else:
        signal = _signal(test, duration)
        samples = signal(np.arange(round(duration * sample_rate)) / sample_rate)
    return faded(samples, sample_rate, ramp)


def tones_unknown(test: Test) -> bool:
    """Return whether tones are on the random vibration that its log does not say."""
    stated = bool(test.tones) and all(tone.level is not None for tone in test.tones)
    return test.excitation == "sine on random" and not stated


def _tones(
    test: Test, n_samples: int, sample_rate: float, generator: np.random.Generator
) -> FloatArray:
    """Return the tones of a sine on random, each with a phase of its own, (n,) array."""
    time = np.arange(n_samples) / sample_rate
    values = np.zeros(n_samples)
    for tone in test.tones:
        phase = generator.uniform(0.0, 2.0 * np.pi)
        values += (tone.level or 0.0) * np.sin(2.0 * np.pi * tone.frequency * time + phase)
    return values


def not_playable(test: Test) -> str:
    """Return why no log of such a test says all that shakes it; empty where it may."""
    if test.excitation == "measured":
        return "what shakes it stands in its recording alone"
    if test.excitation in PULSES:
        return f"a {test.excitation}: its width is no key of the log"
    if tones_unknown(test):
        return "the log does not say frequency and level of every tone of a sine on random"
    return ""


def _lacking(test: Test) -> str:
    if test.excitation is None:
        return "the log does not say what shakes it; add excitation, or leave this test out"
    why = not_playable(test)
    return f"{why}; leave this test out" if why else "the log does not say its level; add it"


def noise_profile(test: Test) -> NoiseProfile:
    """Return the density that a random test demands at every frequency."""
    level = test.level or 0.0
    if test.profile is not None:
        shape = NoiseProfile(test.profile.frequency_hz, test.profile.level)
        factor = (level / shape.rms) ** 2 if level else 1.0
        return NoiseProfile(shape.frequency, tuple(factor * one for one in shape.density))
    low, high = _band(test)
    rms = str(test.level_unit).endswith("rms")
    density = level**2 / (high - low) if rms else level
    return flat_profile(low, high, density)


def _signal(test: Test, duration: float) -> Signal:
    level = test.level or 1.0
    if test.excitation == "sine":
        if test.frequency_hz is None:
            raise LogError(f"{test.source}: test {test.id}: no frequency; add it")
        return harmonic(test.frequency_hz, level)
    low, high = _band(test)
    first, last = (test.from_hz or low), (test.to_hz or high)
    if test.excitation == "stepped sine":
        count = max(2, round(STEPS_PER_OCTAVE * log2(high / low)) + 1)
        steps = np.geomspace(first, last, count)
        cycles = max(1, round(duration / float(np.sum(1.0 / steps))))
        return stepped_sine([float(f) for f in steps], cycles, level)
    if test.rate_hz_per_s is not None:
        return _shaped(test, linear_sweep(first, last, duration, level), duration)
    rate = 60.0 * log2(high / low) / duration
    return _shaped(test, logarithmic_sweep(first, last, rate, level), duration)


def frequency_of_sweep(test: Test, share: FloatArray) -> FloatArray:
    """Return the frequency of a sweep when a share of its duration has passed [Hz].

    Parameters
    ----------
    test : Test
        The line of the log.
    share : (n,) array
        From 0 to 1 [-].
    """
    low, high = _band(test)
    first, last = (test.from_hz or low), (test.to_hz or high)
    if test.rate_hz_per_s is not None:
        return first + (last - first) * share
    return np.asarray(first * (last / first) ** share)


def _shaped(test: Test, swept: Signal, duration: float) -> Signal:
    """Return a sweep with the amplitude that the profile of its test has at each frequency.

    `duration` is that of the sweep [s].
    """
    profile = test.profile
    if profile is None:
        return swept
    corners = np.array(profile.frequency_hz), np.array(profile.level)

    def signal(time: FloatArray) -> FloatArray:
        now = frequency_of_sweep(test, np.clip(time / duration, 0.0, 1.0))
        inside = np.clip(now, corners[0][0], corners[0][-1])
        shaped: FloatArray = swept(time) * profile_at(inside, *corners)
        return shaped

    return signal


def _band(test: Test) -> tuple[float, float]:
    """Return the excited band, lower limit first [Hz].

    Raises
    ------
    LogError
        If the log does not say it.
    """
    band = test.band
    if band is None or not 0.0 < band[0] < band[1]:
        raise LogError(
            f"{test.source}: test {test.id}: from and to do not say a band; correct them"
        )
    return band
