"""How a recording is processed, and which further analyses it gets, as the log says it."""

from dataclasses import dataclass, field
from typing import Literal, TypeAlias, final

from shakerproc.data import STANDARD_GRAVITY, BadRows, Measurement
from shakerproc.testlog.excitation import Hammer

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


@final
@dataclass(frozen=True, slots=True)
class ThresholdCrop:
    """A run lasts while a control channel keeps reaching a threshold.

    Attributes
    ----------
    channel : str or int
        Name of the channel in tables, its key in the log, or ``control 2`` for the second of
        the control channels whatever its name.
    threshold : float
        Value that the run reaches and rest does not [m/s²], or [N] on a force channel.
    absolute : bool
        Compare the magnitude; otherwise, as in the thesis, the signed value.
    hold : float
        How long the threshold must be held, so that one spike does not start the run [s].
    skip : float
        Time at the start that is not looked at [s].
    remove_offset : bool
        Compare with the mean of the channel taken away.
    """

    channel: str | int = "control 2"
    threshold: float = 0.45 * STANDARD_GRAVITY
    absolute: bool = False
    hold: float = 0.0
    skip: float = 0.0
    remove_offset: bool = False


@final
@dataclass(frozen=True, slots=True)
class TimeCrop:
    """A run lasts from one time to another.

    Attributes
    ----------
    start : float
        From the first sample [s].
    stop : float, optional
        From the first sample [s]; by default the end of the recording.
    """

    start: float = 0.0
    stop: float | None = None


Crop: TypeAlias = ThresholdCrop | TimeCrop


@final
@dataclass(frozen=True, slots=True)
class Welch:
    """Segments of which the spectra are averages.

    Attributes
    ----------
    segment, overlap : int
        Lengths in samples.
    window : str
        Such as ``hamming`` (symmetric, as in the thesis) or ``periodic hann``.
    n_fft : int, optional
        Length that segments are padded to; by default the segment.
    """

    segment: int = 1024
    overlap: int = 512
    window: str = "hamming"
    n_fft: int | None = None


@final
@dataclass(frozen=True, slots=True)
class NotchFilter:
    """How the notch of a test is cut, at its `notch_hz`.

    Attributes
    ----------
    width : float
        Half-power width [Hz].
    harmonics : tuple of int
        Multiples of the frequency that are taken out.
    trim : float, optional
        What is cut off at both ends [s]; by default until the filter has settled.
    """

    width: float = 2.0
    harmonics: tuple[int, ...] = (1,)
    trim: float | None = None


@final
@dataclass(frozen=True, slots=True)
class Peaks:
    """Which peaks are listed, of those that chance does not make.

    Attributes
    ----------
    distance : float
        Within which only the tallest counts [Hz].
    count : int, optional
        How many for each channel; by default all.
    """

    distance: float = 0.0
    count: int | None = None


@final
@dataclass(frozen=True, slots=True)
class Tolerance:
    """How far the control spectrum may stray from the demanded level.

    Attributes
    ----------
    alarm, abort : float
        Either way [dB].
    """

    alarm: float = 3.0
    abort: float = 6.0


@final
@dataclass(frozen=True, slots=True)
class Processing:
    """How a recording is processed, the log's word overridden by the test's.

    Attributes
    ----------
    crop : ThresholdCrop, TimeCrop or None
        Where the run begins and ends; None takes the whole recording.
    sample_rate : float, optional
        Only where the recording does not say it, or `override_rate` [Hz].
    override_rate : bool
        Whether `sample_rate` counts although the recording states another.
    time_unit : str
        Unit of times in the recording that state none; empty where they do.
    resample : float, optional
        Rate of the even times that every channel is interpolated to [Hz].
    ignore_starts : bool
        Whether all channels start together, whatever the recording states.
    bad_rows : str
        ``refuse`` a text file with lines that are no rows of numbers, or ``skip`` them.
    group : str, optional
        Group of a recording of several.
    measurement : int or "all", optional
        Which of several measurements that follow each other in the same channels, from 1.
    welch : Welch
        Averaging of the spectra.
    detrend : str
        ``none``, ``mean`` (of the whole crop) or ``segment mean``.
    band : (float, float), optional
        Limits of tables and peaks [Hz]; by default those of the excitation.
    peaks : Peaks
        Which peaks are listed.
    notch : NotchFilter
        How a notch is cut.
    tolerance : Tolerance
        Of the control spectrum.
    stitch : bool
        Whether the sweeps of one direction are joined to one response.
    shock : Shock, optional
        Shock response spectra, where they are asked for.
    octaves : Octaves, optional
        Octave bands, likewise.
    distribution : Distribution, optional
        Probability density and exceedance of every channel.
    orders : Orders, optional
        Orders against the speed that a tachometer shows.
    dwell : Dwell, optional
        Gain, phase and frequency of a long sine over time.
    waterfall : Waterfall, optional
        Spectra one after the other.
    spectrogram : ShownSpectrogram, optional
        Spectrogram on the page of the report.
    splitting : Splitting, optional
        Shocks and stationary parts of a long record.
    integration : Integration, optional
        Velocity and displacement, likewise.
    fatigue : Fatigue, optional
        Vibration response and fatigue damage spectra, likewise.
    uncertainty : bool
        Whether every level, peak and damping gets its uncertainty budget.
    response_functions : tuple of ResponseFunction
        Between channels other than the controls and the responses.
    hammer : Hammer
        How the blows of a hammer test are cut out and windowed.
    inherited : frozenset of str
        Keys that the log says for every test and this test does not say itself: what it
        cannot have of these is left out.
    """

    crop: Crop | None = ThresholdCrop()
    sample_rate: float | None = None
    override_rate: bool = False
    time_unit: str = ""
    resample: float | None = None
    ignore_starts: bool = False
    bad_rows: BadRows = "refuse"
    group: str | None = None
    measurement: Measurement | None = None
    welch: Welch = Welch()
    detrend: Literal["none", "mean", "segment mean"] = "none"
    band: tuple[float, float] | None = None
    peaks: Peaks = Peaks()
    notch: NotchFilter = NotchFilter()
    tolerance: Tolerance = Tolerance()
    stitch: bool = False
    shock: Shock | None = None
    octaves: Octaves | None = None
    integration: Integration | None = None
    distribution: Distribution | None = None
    orders: Orders | None = None
    dwell: Dwell | None = None
    waterfall: Waterfall | None = None
    spectrogram: ShownSpectrogram | None = None
    splitting: Splitting | None = None
    fatigue: Fatigue | None = None
    uncertainty: bool = False
    response_functions: tuple[ResponseFunction, ...] = ()
    hammer: Hammer = field(default_factory=Hammer)
    inherited: frozenset[str] = field(default=frozenset(), compare=False)


@final
@dataclass(frozen=True, slots=True)
class Modal:
    """How modes are looked for, as far as the log says it.

    Attributes
    ----------
    band : (float, float), optional
        Where [Hz]; by default where the test excites.
    modes : int, optional
        How many; by default as many as the measurement needs.
    order : int
        Highest order of the stabilisation diagram.
    keep : tuple of float
        Frequencies near which a pole is kept [Hz].
    inputs : str, optional
        Which role is the input: ``control``, ``force`` or ``none`` (output only); by default
        the controls, else the forces, else none.
    together : bool
        Whether all tests are one fit.
    """

    band: tuple[float, float] | None = None
    modes: int | None = None
    order: int = 60
    keep: tuple[float, ...] = ()
    inputs: Literal["control", "force", "none"] | None = None
    together: bool = False
