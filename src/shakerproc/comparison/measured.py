"""Measured data that a model is compared with: input and sensors of one test, in SI."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.noise import NOT_REFUTED, Noise, Refuted, band_above, noise_of
from shakerproc.comparison.noise_sources import Channels, Quiet, end_of, offsets_of, quiet_of
from shakerproc.comparison.part import (
    AROUND,
    NotMeasuredError,
    Part,
    check_frequency,
    check_measured,
    check_sizes,
    few_periods,
    free_part,
    part_of,
)
from shakerproc.comparison.sensors import (
    input_rows,
    misplaced,
    sensor_row,
    sensors_of,
    unused_channels,
)
from shakerproc.data import (
    FloatArray,
    Recording,
    UnusedChannel,
)
from shakerproc.errors import DiagnosisError
from shakerproc.models import NO_CONDITIONS, Conditions, Model
from shakerproc.models.validation import check_sampled
from shakerproc.numerals import numeral
from shakerproc.recordings import MOST_LOST
from shakerproc.runs import open_test
from shakerproc.runs.opening import conditions_of
from shakerproc.runs.summary import unused_lines
from shakerproc.testlog import Test, TestLog

REACH: Final = 3.0
"""How far above the excited band the response is compared, for its harmonics [-]."""

MOST_OF_ALL: Final = 2**22
"""Samples that are looked at of all tests together: what is kept of them takes a gigabyte."""

MOST_OF_EACH: Final = 2**20
"""Samples that are looked at of one test."""

LEAST_OF_EACH: Final = 2**17
"""Samples that are looked at of each test, however many there are."""

MOST_WORK: Final = 2**30
"""Samples of all tests together, times the square of the number of masses: a minute or so
(1.7e9 took 108 s with 200 masses)."""

LEAST_OF_MANY: Final = 2**14
"""Samples that are looked at of each test where a model has many masses."""

MOST_MOTION: Final = 2**23
"""Samples of a test, times the number of masses: their motion takes half a gigabyte."""

UNCALIBRATED: Final = 0.01
"""Standard uncertainty of the gain of a channel of which no calibration sheet says it: the
tolerance of data sheets [-]."""

UNDRIVEN: Final = 0.005
"""Share of the power of a drive that lies below the band that it excites, and above it [-]."""

HIGHEST: Final = 0.45
"""Highest compared frequency over the sample rate: above it the recorder's filter rules [-]."""

LOWEST: Final = 0.2
"""Lowest compared frequency unless the log says a lower one: below it accelerometers drift
[Hz]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class Measured:
    """One test, as a model needs it.

    Attributes
    ----------
    test : Test
        What the log says of it.
    run : str
        Opens every error message.
    sample_rate : float
        Samples per second [Hz].
    controls : (n_controls, n) array
        Accelerations of the base [m/s^2] or the force on the mass [N], without their means.
    sensors : tuple of str
        Name of each response, in the order of the model's sensors.
    responses : (n_sensors, n) array
        What they measured, without their means, in the unit of the sensor.
    excited : (float, float)
        Band that the test excites [Hz].
    band : (float, float)
        Band that is compared: the excited one and the harmonics above it [Hz].
    start, stop : int
        Samples between which errors are taken; the model runs from sample 0.
    quiet : Quiet, optional
        Samples of every channel, where the recording begins at rest.
    noise : Noise
        Of the input and the responses, from the measurement alone.
    error_band : (float, float)
        Band of the free-run error: `from` to `to` of the test; where the log has none, where
        the responses exceed their noise [Hz].
    notes : tuple of str
        What had to be decided, and faults of the channels that are used, a sentence each.
    rate_doubt : float
        How far `sample_rate` may be off, relative [-].
    read : tuple of str
        What the reader of the recording had to decide.
    unused : tuple of UnusedChannel
        Channels of the file that neither drive the model nor are a sensor of it.
    places : tuple of str
        Where the log and the model disagree on the place of a channel, a sentence each.
    sha256 : str
        Of the bytes of the recording that these are from.
    gain_spread : (n_controls + n_sensors,) tuple of float
        Standard uncertainty of the gain of each channel, as `UNCALIBRATED` where no sheet says
        it; of a free decay, the control that is none has none [-].
    conditions : Conditions
        Under which the test was run: the model of the test is that under these.
    lowest : float
        Lowest frequency that can be compared [Hz].
    """

    test: Test
    run: str
    sample_rate: float
    controls: FloatArray
    sensors: tuple[str, ...]
    responses: FloatArray
    excited: tuple[float, float]
    band: tuple[float, float]
    start: int
    stop: int
    quiet: Quiet | None
    noise: Noise
    error_band: tuple[float, float]
    notes: tuple[str, ...]
    rate_doubt: float = 0.0
    read: tuple[str, ...] = ()
    unused: tuple[UnusedChannel, ...] = ()
    places: tuple[str, ...] = ()
    sha256: str = ""
    gain_spread: tuple[float, ...] = ()
    conditions: Conditions = NO_CONDITIONS
    lowest: float = LOWEST

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines for people: what the reader decided, places in doubt, channels not used."""
        mixed = self.test.excitation == "sine on random"
        tones = ("the tones drive the model too: errors are of tones and random vibration",)
        return (*self.read, *(tones * mixed), *self.places, *unused_lines(self.unused))

    @property
    def name(self) -> str:
        """Number of the test, as text."""
        return str(self.test.id)

    @property
    def channels(self) -> Channels:
        """Channels as they were measured, from which the noise is estimated."""
        return Channels(self.controls, self.responses, self.sample_rate, self.excited)

    @property
    def input(self) -> FloatArray:
        """Excitation of the model, (n,) array: the mean of the controls, or the force."""
        mean: FloatArray = self.controls.mean(axis=0)
        return mean


@final
@dataclass(frozen=True, slots=True, eq=False)
class Usable:
    """The tests of a log that a model can be compared with.

    Attributes
    ----------
    tests : tuple of Measured
        In the order of the log.
    left_out : tuple of str
        Which others take no part since a channel did not measure, a sentence each.
    """

    tests: tuple[Measured, ...]
    left_out: tuple[str, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks on the tests and faults of their channels, a sentence each."""
        return tuple(dict.fromkeys(note for test in self.tests for note in test.notes))

    def tell(self, warn: Callable[[str], None]) -> None:
        """Tell, before long work, which tests are left out and what is odd about the others."""
        for text in (*self.left_out, *self.notes):
            warn(text)

    def with_those_of(self, other: "Usable") -> "Usable":
        """Return only the tests that another model can be compared with as well."""
        there = {test.name for test in other.tests}
        return Usable(
            tuple(test for test in self.tests if test.name in there),
            tuple(dict.fromkeys((*self.left_out, *other.left_out))),
        )


def measured_tests(log: TestLog, model: Model) -> tuple[Measured, ...]:
    """Return the tests of `usable_tests` alone."""
    return usable_tests(log, model).tests


def usable_tests(log: TestLog, model: Model, *, most_clipped: float = MOST_LOST) -> Usable:
    """Return every test of a log that has a recording, is not discarded and was measured.

    A test of which the model needs a channel that did not measure takes no part.

    Parameters
    ----------
    log : TestLog
        The log.
    model : Model
        Its excitation and its sensors say which channels it needs.
    most_clipped : float
        Share of its samples at which a channel may stand at its limit [-].

    Raises
    ------
    LogError
        If no test has a recording that may be used.
    DiagnosisError
        If no test remains, or a recording and the model do not fit together.
    ShakerprocError
        If a recording cannot be used.
    """
    tests = log.recorded()
    share = longest(len(tests), model.n_coordinates)
    found, left_out = [], []
    for test in tests:
        try:
            found.append(measure(log, test, model, most_clipped=most_clipped, most=share))
        except NotMeasuredError as error:
            left_out.append(str(error))
    if not found:
        more = f" So is each of {len(tests) - 1} more." if len(tests) > 1 else ""
        raise DiagnosisError(
            f"{log.path.name}: no test is left to judge by. {left_out[0]}{more}"
        )
    return Usable(with_repeats(found), (*left_out, *log.left_out))


def with_repeats(
    tests: Sequence[Measured], refuted: Mapping[str, Refuted] = MappingProxyType({})
) -> tuple[Measured, ...]:
    """Return tests whose noise their repeats tell, where nothing better does.

    Parameters
    ----------
    tests : sequence of Measured
        The tests of a campaign.
    refuted : mapping of str to Refuted
        By the name of a test, the sources that tell too much noise of it.
    """
    every = [test.channels for test in tests]
    found = []
    for test, own in zip(tests, every, strict=True):
        noise = noise_of(own, every, refuted.get(test.name, NOT_REFUTED))
        band = _error_band(test.test, own, noise, test.lowest)
        found.append(replace(test, noise=noise, error_band=band))
    return tuple(found)


def longest(n_tests: int, n_coordinates: int) -> int:
    """Return how many samples of a test are looked at, so that time and memory suffice."""
    in_memory = min(MOST_OF_EACH, max(LEAST_OF_EACH, MOST_OF_ALL // n_tests))
    in_time = max(LEAST_OF_MANY, MOST_WORK // (n_coordinates**2 * n_tests))
    return min(in_memory, in_time, MOST_MOTION // n_coordinates)


def measure(
    log: TestLog, test: Test, model: Model, *,
    most_clipped: float = MOST_LOST, most: int = MOST_OF_EACH,
) -> Measured:  # fmt: skip
    """Return one test as the model needs it.

    Parameters
    ----------
    log : TestLog
        The log.
    test : Test
        One of its tests.
    model : Model
        What is compared with it.
    most_clipped : float
        Share of its samples at which a channel may stand at its limit [-].
    most : int
        Samples that are looked at, of a test that has more.

    Raises
    ------
    DiagnosisError
        If channels and sensors do not fit together.
    NotMeasuredError
        If a channel that the model needs did not measure.
    ShakerprocError
        If the recording cannot be used.
    """
    conditions, told = conditions_of(test)
    model = model.under(conditions)
    with open_test(log, test) as recording:
        check_sampled(model, recording.sample_rate)
        inputs = input_rows(recording, model)
        rows = [sensor_row(recording, name, model) for name in sensors_of(model)]
        overlap = set(inputs) & set(rows)
        if overlap:
            name = recording.channels[overlap.pop()].name
            raise DiagnosisError(
                f"{recording.run}: channel {name!r} both drives the model and is a sensor of "
                f"it. Give it the role response in the log, or take it out of the sensors."
            )
        part = part_of(recording, test, most)
        if model.excitation.role is None:
            part = free_part(recording, test, part, rows)
        samples = recording.samples(part.first, part.last)
        faults = check_measured(recording, samples, part, [*inputs, *rows], most_clipped)
        run = samples[:, part.start - part.first : part.stop - part.first]
        few = few_periods(recording.run, run[rows])
        check_sizes(recording, samples[:, part.start - part.first :], inputs, rows)
        check_frequency(recording, test, run, inputs)
        nothing = np.zeros((1, samples.shape[1]))
        if not model.excitation.imposed:  # where in its play a joint stands counts
            driven = model.excitation.role is not None
            samples = samples - offsets_of(run, driven=driven)
        chosen = (samples[inputs] if inputs else nothing, samples[rows])
        found = _measured(recording, test, chosen, model, part)
        return replace(
            found,
            notes=(*found.notes, *faults, *few),
            rate_doubt=recording.rate_doubt,
            read=(*recording.notes, *told),
            unused=unused_channels(recording, {*inputs, *rows}),
            places=misplaced(recording, model, inputs, rows),
            sha256=recording.sha256(),
            gain_spread=(
                *([gain_spread(recording, row) for row in inputs] or [0.0]),
                *(gain_spread(recording, row) for row in rows),
            ),
            conditions=conditions,
        )


def gain_spread(recording: Recording, row: int) -> float:
    """Return the standard uncertainty of the gain of a channel [-]."""
    expanded = recording.channels[row].uncertainty
    return UNCALIBRATED if expanded is None else 0.5 * expanded


def _measured(
    recording: Recording,
    test: Test,
    samples: tuple[FloatArray, FloatArray],
    model: Model,
    part: Part,
) -> Measured:
    controls, responses = samples
    rate = recording.sample_rate
    start = part.start - part.first
    last = part.stop - part.first
    stop = min(last, end_of(controls, responses, rate))
    rest_s = numeral((last - stop) / rate)
    told = f"{recording.run}: the last {rest_s} s are at rest; errors are of what is before."
    quiet = quiet_of(controls, responses, rate)
    units = {model.excitation.unit, *map(model.sensor_unit, model.sensors.values())}
    lowest = _lowest(test, rate / controls.shape[1], drifts="m/s^2" in units)
    excited = _excited(test, rate, lowest, controls)
    low, high = excited
    band = (0.7 * low, min(max(REACH * high, 4.0 * low), HIGHEST * rate))
    own = Channels(controls, responses, rate, excited)
    noise = noise_of(own)
    return Measured(
        test=test, run=recording.run, sample_rate=rate, controls=controls,
        sensors=tuple(model.sensors), responses=responses, excited=excited, band=band,
        start=start, stop=stop, quiet=quiet,
        noise=noise, error_band=_error_band(test, own, noise, lowest),
        notes=(*part.notes, *[told] * (stop < last)), lowest=lowest,
    )  # fmt: skip


def _stated(test: Test) -> list[tuple[float, float]]:
    """Return the bands that the log states, that which the test excites first [Hz]."""
    bands = [band for band in (test.processing.band, test.band) if band is not None]
    if test.frequency_hz is None or test.band is not None:
        return bands
    return [(AROUND[0] * test.frequency_hz, AROUND[1] * test.frequency_hz), *bands]


def _lowest(test: Test, once: float, *, drifts: bool) -> float:
    """Return the lowest compared frequency of a test [Hz].

    That of the log, but no lower than `once`, which passes once in the record [Hz]; where the
    log has none, `LOWEST` if a channel drifts.
    """
    said = min((low for low, _ in _stated(test)), default=LOWEST if drifts else once)
    return min(LOWEST, max(once, said))


def _error_band(test: Test, own: Channels, noise: Noise, lowest: float) -> tuple[float, float]:
    """Return the band of the free-run error, none of it below the lowest frequency [Hz]."""
    if test.band is not None:
        low, high = test.band
        return max(low, lowest), min(high, HIGHEST * own.sample_rate)
    heard = band_above(own, noise, (lowest, HIGHEST * own.sample_rate)) or own.excited
    if test.frequency_hz is None:
        return heard
    return min(heard[0], own.excited[0]), max(heard[1], own.excited[1])  # the sine is in it


def _excited(
    test: Test, rate: float, lowest: float, controls: FloatArray
) -> tuple[float, float]:
    """Return the band that a test excites [Hz]: that of the log, else that of its drive."""
    stated = _stated(test)
    driven = stated[0] if stated else _driven(controls.mean(axis=0), rate)
    low, high = driven or (lowest, HIGHEST * rate)
    return max(low, lowest), min(high, HIGHEST * rate)


def _driven(drive: FloatArray, rate: float) -> tuple[float, float] | None:
    """Return the band that holds the power of a drive [Hz]; None where nothing drives."""
    power = np.cumsum(np.abs(scipy.fft.rfft(drive)[1:]) ** 2)
    if not power.size or not power[-1] > 0.0:
        return None
    ends = np.searchsorted(power, (UNDRIVEN * power[-1], (1.0 - UNDRIVEN) * power[-1]))
    low, high = (ends + 1) * rate / drive.size
    return float(low), float(high)
