"""Settings of the further analyses that a log may ask for, in SI."""

from dataclasses import dataclass
from typing import Literal, TypeAlias, final

Baseline: TypeAlias = Literal["none", "mean", "line"]


@final
@dataclass(frozen=True, slots=True)
class Shock:
    """Shock response spectra.

    Attributes
    ----------
    damping : float
        Damping ratio of the oscillators [-]; 5 % is a quality factor of 10.
    low, high : float, optional
        Natural frequencies [Hz]; by default from one period in the run to a tenth of the
        sample rate.
    per_octave : int
        How many of them.
    """

    damping: float = 0.05
    low: float | None = None
    high: float | None = None
    per_octave: int = 12


@final
@dataclass(frozen=True, slots=True)
class Octaves:
    """Octave or fractional-octave bands.

    Attributes
    ----------
    fraction : int
        Bands to an octave.
    low, high : float, optional
        Middles of the lowest and the highest band [Hz]; by default those of the excited band.
    """

    fraction: int = 3
    low: float | None = None
    high: float | None = None


@final
@dataclass(frozen=True, slots=True)
class Integration:
    """Velocity and displacement of accelerations.

    Attributes
    ----------
    high_pass : float or "none", optional
        Corner of the high-pass [Hz]; by default half the low end of the excited band. Without
        one, integration starts from rest.
    baseline : Baseline, optional
        Asked to be taken from the acceleration of the run first.
    """

    high_pass: float | Literal["none"] | None = None
    baseline: Baseline | None = None

    @property
    def baseline_taken(self) -> Baseline:
        """Baseline that is taken out: by default the mean, which a high-pass removes anyway.

        Without a high-pass it is none: the mean of a shock is its velocity change over the
        length of the run, and no fault of the sensor.
        """
        by_default: Baseline = "none" if isinstance(self.high_pass, str) else "mean"
        return self.baseline or by_default


@final
@dataclass(frozen=True, slots=True)
class Distribution:
    """Probability density and exceedance of the samples.

    Attributes
    ----------
    bins : int
        Intervals of equal width between the least and the largest deviation from the mean.
    """

    bins: int = 100


@final
@dataclass(frozen=True, slots=True)
class Orders:
    """Orders of a rotating machine.

    Attributes
    ----------
    tachometer : str
        Name of the channel that holds its pulses.
    pulses_per_revolution : int
        Of the tachometer.
    track : tuple of float
        Orders, cycles in one revolution [-].
    revolutions : float
        Length of the stretches that they are fitted to [-].
    """

    tachometer: str = "tachometer"
    pulses_per_revolution: int = 1
    track: tuple[float, ...] = (1.0, 2.0)
    revolutions: float = 10.0


@final
@dataclass(frozen=True, slots=True)
class Dwell:
    """Gain, phase and frequency of a long sine over time.

    Attributes
    ----------
    every : float, optional
        Length of the stretches that they are read in [s]; by default 300 a run.
    """

    every: float | None = None


@final
@dataclass(frozen=True, slots=True)
class Waterfall:
    """Spectra one after the other.

    Attributes
    ----------
    spectra : int
        How many of them at most.
    """

    spectra: int = 30


@final
@dataclass(frozen=True, slots=True)
class ShownSpectrogram:
    """The spectrogram of a run on the page of the report.

    Attributes
    ----------
    channel : str
        Whose; the largest response where it is empty.
    """

    channel: str = ""


@final
@dataclass(frozen=True, slots=True)
class Splitting:
    """A long record in shocks and parts of vibration.

    Attributes
    ----------
    crest : float
        Peak of a shock at least, over the rms of the vibration around it [-].
    least : float
        Peak of a shock at least [m/s²].
    longest : float
        Duration of a shock at most [s].
    shortest : float
        Duration of a stationary part at least [s].
    step : float
        By how much the level of two parts differs at least [dB].
    """

    crest: float = 6.0
    least: float = 0.0
    longest: float = 1.0
    shortest: float = 5.0
    step: float = 3.0


@final
@dataclass(frozen=True, slots=True)
class Fatigue:
    """Vibration response and fatigue damage spectra.

    Attributes
    ----------
    damping : float
        Damping ratio of the oscillators [-].
    exponent : float
        Of the S-N curve [-].
    low, high : float, optional
        Natural frequencies [Hz]; by default those of the shock response spectra.
    per_octave : int
        How many of them.
    """

    damping: float = 0.05
    exponent: float = 4.0
    low: float | None = None
    high: float | None = None
    per_octave: int = 6


@final
@dataclass(frozen=True, slots=True)
class ResponseFunction:
    """A response function between two channels.

    Attributes
    ----------
    input, output : str
        Names of channels; ``controls`` is the mean of the controls.
    """

    input: str
    output: str
