"""What a model is held against: the input and every sensor of one test, as arrays in SI."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final, final

import numpy as np

from shakerproc.comparison.noise import NOT_REFUTED, Noise, Refuted, band_above, noise_of
from shakerproc.comparison.noise_sources import Channels
from shakerproc.comparison.quiet import Quiet, quiet_of
from shakerproc.data import (
    Channel,
    FloatArray,
    Recording,
    UnusedChannel,
    recording_of_arrays,
)
from shakerproc.errors import DiagnosisError, ModelError, SpectrumError
from shakerproc.models import BASE, Model, Sensor
from shakerproc.recordings import FAULTS, MOST_LOST, measuring, unusable
from shakerproc.runs import find_crop, open_test
from shakerproc.runs.remarks import unused_lines
from shakerproc.runs.roles import moving
from shakerproc.spectra.decays import free_start
from shakerproc.testlog import Test, TestLog
from shakerproc.testlog.log import PULSES
from shakerproc.units import near_miss, quoted

UNIT_OF: Final = {
    "acceleration": "m/s^2",
    "displacement": "m",
    "velocity": "m/s",
    "relative displacement": "m",
    "relative velocity": "m/s",
    "force": "N",
}
"""Unit of the channel that a sensor of each kind needs."""

REACH: Final = 3.0
"""How far above the excited band the response is compared, for its harmonics [-]."""

NO_SENSOR: Final = "neither drives the model nor is a sensor of it"

MOST_OF_ALL: Final = 2**22
"""Samples that are looked at of all tests together: what is kept of them takes a gigabyte."""

MOST_OF_EACH: Final = 2**20
"""Samples that are looked at of one test."""

LEAST_OF_EACH: Final = 2**17
"""Samples that are looked at of each test, however many there are."""

MOST_WORK: Final = 2**34
"""Samples of all tests together, times the square of the number of masses: a minute or so."""

LEAST_OF_MANY: Final = 2**14
"""Samples that are looked at of each test where a model has many masses."""

MOST_MOTION: Final = 2**23
"""Samples of a test, times the number of masses: their motion takes half a gigabyte."""

MOST_RATIO: Final = 1e8
"""Responses above so many times the drive, or below its inverse, have a wrong unit [-]."""

PASSING: Final = frozenset({"sine sweep", "stepped sine", "shock", "hammer"})
"""Excitations that do not do the same all the time."""

PARTS: Final = 16
"""Steps in which the loudest part is sought, over its length."""

RUN_IN: Final = 16
"""The model runs in for this share of the part that is judged: its inverse [-]."""

_DEFAULT_LOW_HZ: Final = 5.0
HIGHEST: Final = 0.45
"""Highest compared frequency over the sample rate: above it the recorder's filter rules [-]."""

LOWEST: Final = 0.2
"""Lowest compared frequency: below it accelerometers drift [Hz]."""

_SHORTEST: Final = 1024  # samples


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
        What had to be decided, a sentence each.
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

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines for people: what the reader decided, places in doubt, channels not used."""
        return (*self.read, *self.places, *unused_lines(self.unused))

    @property
    def name(self) -> str:
        """Number of the test, as text."""
        return str(self.test.id)

    @property
    def channels(self) -> Channels:
        """What was measured, as the noise is told from it."""
        return Channels(self.controls, self.responses, self.sample_rate, self.excited)

    @property
    def input(self) -> FloatArray:
        """What drives the model, (n,) array: the mean of the controls, or the force."""
        mean: FloatArray = self.controls.mean(axis=0)
        return mean


@final
@dataclass(frozen=True, slots=True, eq=False)
class Usable:
    """The tests of a log that a model can be held against.

    Attributes
    ----------
    tests : tuple of Measured
        In the order of the log.
    left_out : tuple of str
        Which others take no part since a channel did not measure, a sentence each.
    """

    tests: tuple[Measured, ...]
    left_out: tuple[str, ...]

    def with_those_of(self, other: "Usable") -> "Usable":
        """Return only the tests that another model can be held against as well."""
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
    share = longest(len(tests), len(model.masses))
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
    return Usable(with_repeats(found), tuple(left_out))


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
        found.append(replace(test, noise=noise, error_band=_error_band(test.test, own, noise)))
    return tuple(found)


def longest(n_tests: int, n_masses: int) -> int:
    """Return how many samples of a test are looked at, so that time and memory suffice."""
    in_memory = min(MOST_OF_EACH, max(LEAST_OF_EACH, MOST_OF_ALL // n_tests))
    in_time = max(LEAST_OF_MANY, MOST_WORK // (n_masses**2 * n_tests))
    return min(in_memory, in_time, MOST_MOTION // n_masses)


class NotMeasuredError(DiagnosisError):
    """A channel that a model needs did not measure in a test."""


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
        What is held against it.
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
    with open_test(log, test) as recording:
        inputs = input_rows(recording, model)
        rows = [sensor_row(recording, name, s) for name, s in sensors_of(model).items()]
        overlap = set(inputs) & set(rows)
        if overlap:
            name = recording.channels[overlap.pop()].name
            raise DiagnosisError(
                f"{recording.run}: channel {name!r} both drives the model and is a sensor of "
                f"it. Give it the role response in the log, or take it out of the sensors."
            )
        part = _part(recording, test, most)
        if model.excitation.role is None:
            part = _free_part(recording, test, part, rows)
        samples = recording.samples(part.first, part.last)
        _check_measured(recording, samples, part, [*inputs, *rows], most_clipped)
        _check_sizes(recording, samples[:, part.start - part.first :], inputs, rows)
        nothing = np.zeros((1, samples.shape[1]))
        chosen = (samples[inputs] if inputs else nothing, samples[rows])
        found = _measured(
            recording, test, chosen, tuple(model.sensors), part,
            centred=not model.excitation.imposed,  # where in its play a joint stands counts
        )  # fmt: skip
        return replace(
            found,
            rate_doubt=recording.rate_doubt,
            read=recording.notes,
            unused=_unused(recording, {*inputs, *rows}),
            places=_places(recording, model, inputs, rows),
            sha256=recording.sha256(),
        )


def _check_measured(
    recording: Recording, samples: FloatArray, part: "_Part", rows: list[int], clipped: float
) -> None:
    """Pass the samples of a test of which every channel that is needed was measured.

    Of several that were not, the first of `rows` is named: where the controls are dead, no
    response has anything in common with them. Not being numbers goes before all else.

    Raises
    ------
    NotMeasuredError
        If one was not.
    """
    judged = samples[:, part.start - part.first : part.stop - part.first]
    seen = recording_of_arrays(recording.run, recording.channels, judged, recording.sample_rate)
    needed = [recording.channels[row].name for row in rows]
    found = [
        f for f in measuring(replace(seen, driven=recording.driven)) if f.channel in needed
    ]
    for flag in sorted(
        found, key=lambda f: (f.kind != "not a number", needed.index(f.channel))
    ):
        most = {"clipping": clipped, "not a number": 0.0}.get(flag.kind, MOST_LOST)
        if unusable([flag], 0.0, seen.duration, most=most):
            start = part.start / recording.sample_rate
            since = ""
            if start and flag.start:
                since = f" (Times count from {start:.6g} s on, where the crop begins.)"
            raise NotMeasuredError(
                f"{recording.run} is left out: {flag.channel} "
                f"{FAULTS.get(flag.kind, flag.kind)}. {flag.message}{since}"
            )


def _check_sizes(
    recording: Recording, samples: FloatArray, inputs: list[int], rows: list[int]
) -> None:
    """Pass responses that are not out of all proportion to what drives them.

    Raises
    ------
    NotMeasuredError
        If one is, as no structure and no sensor makes it, but a wrong unit does.
    """
    if not inputs:
        return
    size = np.sqrt(np.mean(np.square(samples), axis=1))
    drive = float(size[inputs].max())
    for row in rows:
        channel = recording.channels[row]
        ratio = (
            float(size[row]) / drive
            if channel.unit == recording.channels[inputs[0]].unit
            else 1.0
        )
        if not 1.0 / MOST_RATIO <= ratio <= MOST_RATIO:
            raise NotMeasuredError(
                f"{recording.run} is left out: {channel.name} has {size[row]:.3g} "
                f"{channel.unit} rms, {ratio:.2g} times the drive. Check its unit and "
                "sensitivity in the log."
            )


def _unused(recording: Recording, used: Collection[int]) -> tuple[UnusedChannel, ...]:
    """Return the channels that the model does not need, and those that nobody uses."""
    spare = (c.name for i, c in enumerate(recording.channels) if i not in used)
    return (*(UnusedChannel(name, NO_SENSOR) for name in spare), *recording.unused)


def _places(
    recording: Recording, model: Model, inputs: Sequence[int], rows: Sequence[int]
) -> tuple[str, ...]:
    """Return where the log puts channels that the model has elsewhere, a sentence each."""
    wanted = dict.fromkeys(inputs, model.excitation.on or BASE)
    wanted |= {row: sensor.at for row, sensor in zip(rows, model.sensors.values(), strict=True)}
    return tuple(
        _elsewhere(recording.channels[row], place, model.places)
        for row, place in wanted.items()
        if recording.channels[row].at not in {None, "", place}
    )


def _elsewhere(channel: Channel, place: str, places: tuple[str, ...]) -> str:
    found = channel.at or ""
    meant = None if found in places else near_miss(found, places)
    question = f'; did you mean "{meant}"?' if meant else ""
    return (
        f"channel {channel.name}: the log says at: {quoted(found)}, the model {quoted(place)} "
        f"(its places: {', '.join(places)}){question}"
    )


def _measured(
    recording: Recording,
    test: Test,
    samples: tuple[FloatArray, FloatArray],
    sensors: tuple[str, ...],
    part: "_Part",
    *,
    centred: bool,
) -> Measured:
    controls, responses = samples
    rate = recording.sample_rate
    start, stop = part.start - part.first, part.stop - part.first
    if centred:
        controls = controls - controls[:, start:stop].mean(axis=1, keepdims=True)
        responses = responses - responses[:, start:stop].mean(axis=1, keepdims=True)
    quiet = quiet_of(controls, responses, rate)
    excited = _excited(test, rate)
    low, high = excited
    band = (0.7 * low, min(max(REACH * high, 4.0 * low), HIGHEST * rate))
    own = Channels(controls, responses, rate, excited)
    noise = noise_of(own)
    return Measured(
        test=test, run=recording.run, sample_rate=rate, controls=controls, sensors=sensors,
        responses=responses, excited=excited, band=band, start=start, stop=stop, quiet=quiet,
        noise=noise, error_band=_error_band(test, own, noise), notes=part.notes,
    )  # fmt: skip


def _error_band(test: Test, own: Channels, noise: Noise) -> tuple[float, float]:
    """Return the band of the free-run error [Hz]."""
    if test.band is not None:
        low, high = test.band
        return max(low, LOWEST), min(high, HIGHEST * own.sample_rate)
    return band_above(own, noise, (LOWEST, HIGHEST * own.sample_rate)) or own.excited


@final
@dataclass(frozen=True, slots=True)
class _Part:
    """What is looked at of a recording, `first` to `last`, and judged, `start` to `stop`."""

    first: int
    last: int
    start: int
    stop: int
    notes: tuple[str, ...] = ()


def _part(recording: Recording, test: Test, most: int) -> _Part:
    """Return the samples to be judged; where the crop finds nothing, all of them.

    The model begins at rest: where the part does not, it runs in before it is judged.

    Raises
    ------
    DiagnosisError
        If they are too few.
    """
    n, notes = recording.n_samples, []
    try:
        crop = find_crop(recording, test)
        start, stop = crop.start, crop.stop
    except SpectrumError:
        start, stop = 0, n
        notes.append(
            f"{recording.run}: the crop of the log finds no run, so all of it is compared."
        )
    if stop - start < _SHORTEST:
        raise DiagnosisError(
            f"{recording.run}: {stop - start} samples are too few to judge a model; "
            f"{_SHORTEST} are the least. Correct crop in the log."
        )
    if stop - start > most:
        whole = (stop - start) / recording.sample_rate
        start = _loudest(recording, test, start, stop, most)
        stop = start + most
        notes.append(
            f"{recording.run}: used {most / recording.sample_rate:.4g} s of {whole:.4g} s, "
            f"from {start / recording.sample_rate:.4g} s on."
        )
    if n <= 2 * most:
        return _Part(0, n, start, stop, tuple(notes))
    first = 0 if start <= most else start - most // RUN_IN
    return _Part(first, stop, start, stop, tuple(notes))


def _free_part(recording: Recording, test: Test, part: _Part, rows: list[int]) -> _Part:
    """Return the part in which the structure is left to itself; what is before tells nothing.

    Raises
    ------
    DiagnosisError
        If the test is driven all along, or has no free part.
    """
    if test.excitation not in (None, *PULSES):
        raise DiagnosisError(
            f"{recording.run}: its excitation is {test.excitation}, but nothing excites the "
            "model, which takes a free decay. Give what excites it in the model: "
            "{base: acceleration}, say."
        )
    samples = recording.samples(part.start, part.stop)
    driving = [i for i, c in enumerate(recording.channels) if c.role in {"control", "force"}]
    try:
        start = part.start + free_start(samples[rows], samples[driving])
    except SpectrumError as error:
        raise DiagnosisError(f"{recording.run}: {error}") from error
    if part.stop - start < _SHORTEST:
        raise DiagnosisError(
            f"{recording.run}: {part.stop - start} samples of free decay are too few; "
            f"{_SHORTEST} are the least."
        )
    return replace(part, first=start, start=start, last=part.stop)


def _loudest(recording: Recording, test: Test, start: int, stop: int, size: int) -> int:
    """Return where the most telling part of so many samples begins.

    Steady vibration is the same everywhere: its beginning, which shows the noise before it. A
    sweep tells most where it drives a resonance: the part with most power.
    """
    if test.excitation not in PASSING:
        return start
    step = max(1, size // PARTS)
    blocks = moving(recording).blocks(start, stop, step)
    power = np.array([float(np.sum(np.square(np.nan_to_num(block)))) for block in blocks])
    kept = max(1, min(PARTS, power.size - 1))
    return start + step * int(np.argmax(np.convolve(power[:-1], np.ones(kept), "valid")))


def _excited(test: Test, rate: float) -> tuple[float, float]:
    low, high = test.processing.band or test.band or (_DEFAULT_LOW_HZ, HIGHEST * rate)
    if test.frequency_hz is not None and test.band is None:
        low, high = 0.8 * test.frequency_hz, 1.25 * test.frequency_hz
    return max(low, LOWEST), min(high, HIGHEST * rate)


def sensors_of(model: Model) -> dict[str, Sensor]:
    """Return the sensors of a model that sit on its masses.

    Raises
    ------
    ModelError
        If it has none.
    """
    if not model.sensors:
        raise ModelError(
            f"{model.title}: no sensors, so no channel can be held against the model. Say what "
            f"each measures, such as sensors: {{ch3: {{at: {next(iter(model.masses))}, "
            f"measures: acceleration}}}}."
        )
    return dict(model.sensors)


def sensor_row(recording: Recording, name: str, sensor: Sensor) -> int:
    """Return the row of the channel that is a sensor of the model.

    Raises
    ------
    DiagnosisError
        If the recording has none of that name, or its unit is another.
    """
    for i, channel in enumerate(recording.channels):
        if name in {channel.name, channel.source_name}:
            _check_unit(recording, channel, UNIT_OF[sensor.measures], f"sensor {name!r}")
            return i
    raise DiagnosisError(
        f"{recording.run}: the model's sensor {name!r} is no channel of the recording, which "
        f"has {_names(recording.channels)}. Give the channel that name in the log "
        f"(name: {name}), or correct sensors in the model."
    )


def check_driven(model: Model) -> None:
    """Pass a model that an input drives, whose whole tests can be foretold.

    Raises
    ------
    DiagnosisError
        If nothing does.
    """
    if model.excitation.role is None:
        raise DiagnosisError(
            f"{model.title}: a free decay has no input, and where its motion begins only a fit "
            "tells, so that there is no free-run error: see compare_decays. Or give what "
            "excites it in the model: {base: acceleration}, say."
        )


def input_rows(recording: Recording, model: Model) -> list[int]:
    """Return the rows of the channels that drive the model; none of a free decay.

    Raises
    ------
    DiagnosisError
        If there is none, or its unit is another.
    """
    on, role, unit = model.excitation.on, model.excitation.role, model.excitation.unit
    if role is None:
        return []
    rows = [i for i, c in enumerate(recording.channels) if c.role == role]
    if on is not None and any(recording.channels[i].at == on for i in rows):
        rows = [i for i in rows if recording.channels[i].at == on]
    if not rows:
        what = _DRIVEN[role].format(on)
        raise DiagnosisError(
            f"{recording.run}: in the model {what}, but no channel has the role {role}. Give "
            f"the channel that measures it this role in the log; the recording has "
            f"{_names(recording.channels)}."
        )
    for i in rows:
        _check_unit(recording, recording.channels[i], unit, f"role {role}")
    return rows


_DRIVEN: Final = {
    "control": "the base is driven",
    "force": "a force acts on {}",
    "displacement": "the displacement of {} is imposed",
}


def _check_unit(recording: Recording, channel: Channel, wanted: str, why: str) -> None:
    if channel.unit != wanted:
        raise DiagnosisError(
            f"{recording.run}: channel {channel.name!r} is in {channel.unit or 'no unit'} "
            f"({channel.source_unit or 'the file says none'}), but {why} needs {wanted}. Give "
            f"unit or sensitivity of the channel in the log, or correct the model."
        )


def _names(channels: Sequence[Channel]) -> str:
    return ", ".join(
        f"{c.name} ({c.role or 'no role'}, {c.unit or 'no unit'})" for c in channels
    )
