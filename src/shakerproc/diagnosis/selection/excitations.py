"""Excitations that a next test may have, and what a shaker can do of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, final

import numpy as np

from shakerproc.data import STANDARD_GRAVITY, FloatArray
from shakerproc.diagnosis.data import PreparedTest
from shakerproc.simulation.excitations import (
    flat_profile,
    logarithmic_sweep,
    random_noise,
    sampled,
)
from shakerproc.testlog import Shaker

SECONDS: Final = 10.0
"""Length of what is simulated of a test that is proposed: a hundred periods of the slowest
joints, and as many averages of its spectrum as tell 10 % [s]."""

WIDER: Final = 2.0
"""Upper end of the wider band over that of the log: an octave [-]."""

HIGHEST_SHARE: Final = 0.4
"""Upper end of a proposed band over the sample rate: below a recorder's filter [-]."""

LOWEST_HZ: Final = 2.0
"""Below it the velocity and the stroke that a drive needs are not counted: the controller's
high-pass rules there [Hz]."""

_SHOWN: Final = (("(m/s^2)^2/Hz", "g^2/Hz", 2), ("m/s^2 rms", "g rms", 1), ("m/s^2", "g", 1))
"""Units in SI, as a log has them, and the power of g between them."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """An excitation that may be asked for, at the level of the loudest test.

    Attributes
    ----------
    excitation : str
        As a test log says it.
    level, unit : float and str
        Its level [SI].
    band : (float, float)
        What it excites [Hz].
    samples : (n,) array
        Its waveform [m/s^2 or N].
    like : str
        The test that lends everything but the level; empty where none is like it.
    """

    excitation: str
    level: float
    unit: str
    band: tuple[float, float]
    samples: FloatArray
    like: str = ""

    def words(self, times: float) -> str:
        """Return the level of the waveform times a factor [-], as a test log says it."""
        power = 2 if self.unit.endswith("/Hz") else 1
        return level_text(self.level * times**power, self.unit)


def level_text(level: float, unit: str) -> str:
    """Return a level [SI] as a test log says it, accelerations in g."""
    for si, shown, power in _SHOWN:
        if unit == si:
            return f"{level / STANDARD_GRAVITY**power:.3g} {shown}"
    return f"{level:.3g} {unit}"


def loudest(tests: Sequence[PreparedTest]) -> PreparedTest:
    """Return the test with the largest input."""
    return max(tests, key=_rms)


def trials_of(test: PreparedTest, unit: str, seed: int) -> list[Trial]:
    """Return excitations to choose from: a test as it was, random and a sweep, both wider.

    Parameters
    ----------
    test : PreparedTest
        The loudest one.
    unit : str
        Unit of the input, m/s^2 or N.
    seed : int
        Of the random waveforms.
    """
    low, high = test.arrays.band
    out = [as_it_was(test, unit)]
    generator = np.random.default_rng(seed)
    widest = min(WIDER * high, max(high, HIGHEST_SHARE * test.sample_rate))
    for top in dict.fromkeys((high, widest)):
        out.append(_random(test, (low, top), unit, generator))
        out.append(_sweep(test, (low, top), unit))
    return out


def as_it_was(test: PreparedTest, unit: str) -> Trial:
    """Return a test as it was; its rms says the level where no log does.

    Of a sweep the whole is simulated, of all else `SECONDS`.
    """
    own = test.arrays
    passing = own.excitation == "sine sweep"
    count = test.n_samples if passing else test.start + round(SECONDS * test.sample_rate)
    level, said = (
        (_rms(test), f"{unit} rms") if own.level is None else (own.level, own.level_unit)
    )
    kind = own.excitation or "random"
    return Trial(kind, level, said, own.band, test.input[:count], test.name)


def _random(
    test: PreparedTest, band: tuple[float, float], unit: str, generator: np.random.Generator
) -> Trial:
    """Return a flat random drive with the power of a test."""
    density = _rms(test) ** 2 / (band[1] - band[0])
    samples = random_noise(flat_profile(*band, density), SECONDS, test.sample_rate, generator)
    said = "N^2/Hz" if unit == "N" else f"({unit})^2/Hz"
    return Trial("random", density, said, band, samples)


def _sweep(test: PreparedTest, band: tuple[float, float], unit: str) -> Trial:
    """Return a sweep with the power of a test."""
    amplitude, octaves = _rms(test) * np.sqrt(2.0), float(np.log2(band[1] / band[0]))
    signal = logarithmic_sweep(*band, 60.0 * octaves / SECONDS, amplitude)
    samples = sampled(signal, SECONDS, test.sample_rate)
    return Trial("sine sweep", float(amplitude), unit, band, samples)


def _rms(test: PreparedTest) -> float:
    return float(np.sqrt(np.mean(test.input[test.start : test.stop] ** 2)))


def most_of(shaker: Shaker, samples: FloatArray, sample_rate: float) -> float:
    """Return by how much a motion of the table may be louder; infinite without limits [-].

    Parameters
    ----------
    shaker : Shaker
        Its limits.
    samples : (n,) array
        Acceleration of the table [m/s^2].
    sample_rate : float
        Samples per second [Hz].
    """
    mass = shaker.moving_mass or 0.0
    limits = (
        (shaker.acceleration, 0),
        (shaker.force / mass if shaker.force and mass else None, 0),
        (shaker.velocity, 1),
        (shaker.stroke / 2.0 if shaker.stroke else None, 2),
    )
    omega = 2.0 * np.pi * np.fft.rfftfreq(samples.size, 1.0 / sample_rate)
    kept = omega > 2.0 * np.pi * LOWEST_HZ
    spectrum = np.fft.rfft(samples) * kept
    most = np.inf
    for limit, order in limits:
        if limit is not None:
            moved = np.fft.irfft(spectrum / np.where(kept, omega, 1.0) ** order, samples.size)
            most = min(most, limit / max(float(np.max(np.abs(moved))), 1e-300))
    return most
