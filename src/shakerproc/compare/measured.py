"""What a model is held against: the input and every sensor of one test, as arrays in SI."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

from shakerproc.compare.quiet import Quiet, quiet_of
from shakerproc.data import Channel, FloatArray, Recording, UnusedChannel
from shakerproc.errors import DiagnosisError, ModelError, SpectrumError
from shakerproc.models import Model, Sensor
from shakerproc.runs import find_crop, open_test
from shakerproc.runs.remarks import unused_lines
from shakerproc.testlog import Test, TestLog

UNIT_OF: Final = {
    "acceleration": "m/s^2",
    "displacement": "m",
    "velocity": "m/s",
    "relative displacement": "m",
    "relative velocity": "m/s",
}
"""Unit of the channel that a sensor of each kind needs."""

REACH: Final = 3.0
"""How far above the excited band the response is compared, for its harmonics [-]."""

NO_SENSOR: Final = "neither drives the model nor is a sensor of it"

_DEFAULT_LOW_HZ: Final = 5.0
_HIGHEST: Final = 0.45  # of the sample rate: above it the recorder's filter rules
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
        Noise of every channel, where the recording begins or ends at rest.
    notes : tuple of str
        What had to be decided, a sentence each.
    read : tuple of str
        What the reader of the recording had to decide.
    unused : tuple of UnusedChannel
        Channels of the file that neither drive the model nor are a sensor of it.
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
    notes: tuple[str, ...]
    read: tuple[str, ...] = ()
    unused: tuple[UnusedChannel, ...] = ()

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines for people: what the reader decided, and which channels are not used."""
        return (*self.read, *unused_lines(self.unused))

    @property
    def name(self) -> str:
        """Number of the test, as text."""
        return str(self.test.id)

    @property
    def input(self) -> FloatArray:
        """What drives the model, (n,) array: the mean of the controls, or the force."""
        mean: FloatArray = self.controls.mean(axis=0)
        return mean


def measured_tests(log: TestLog, model: Model) -> tuple[Measured, ...]:
    """Return every test of a log that has a recording and is not discarded.

    Raises
    ------
    DiagnosisError
        If the log has no such test, or a recording and the model do not fit together.
    ShakerprocError
        If a recording cannot be used.
    """
    tests = [t for t in log.tests if t.recording is not None and not t.discarded]
    if not tests:
        raise DiagnosisError(
            f"{log.path.name}: no test has a recording that may be used, so there is nothing "
            f"to hold the model against. Give a test its recording, or take back discarded."
        )
    return tuple(measure(log, test, model) for test in tests)


def measure(log: TestLog, test: Test, model: Model) -> Measured:
    """Return one test as the model needs it.

    Raises
    ------
    DiagnosisError
        If channels and sensors do not fit together.
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
        samples = recording.samples()
        found = _measured(recording, test, samples[inputs], samples[rows], tuple(model.sensors))
        return replace(found, read=recording.notes, unused=_unused(recording, {*inputs, *rows}))


def _unused(recording: Recording, used: Collection[int]) -> tuple[UnusedChannel, ...]:
    """Return the channels that the model does not need, and those that nobody uses."""
    spare = (c.name for i, c in enumerate(recording.channels) if i not in used)
    return (*(UnusedChannel(name, NO_SENSOR) for name in spare), *recording.unused)


def _measured(
    recording: Recording,
    test: Test,
    controls: FloatArray,
    responses: FloatArray,
    sensors: tuple[str, ...],
) -> Measured:
    rate = recording.sample_rate
    start, stop, notes = _part(recording, test)
    if stop - start < _SHORTEST:
        raise DiagnosisError(
            f"{recording.run}: {stop - start} samples are too few to judge a model; "
            f"{_SHORTEST} are the least. Correct crop in the log."
        )
    controls = controls - controls[:, start:stop].mean(axis=1, keepdims=True)
    responses = responses - responses[:, start:stop].mean(axis=1, keepdims=True)
    quiet = quiet_of(controls, responses, rate)
    excited = _excited(test, rate)
    low, high = excited
    band = (0.7 * low, min(max(REACH * high, 4.0 * low), _HIGHEST * rate))
    return Measured(
        test=test, run=recording.run, sample_rate=rate, controls=controls, sensors=sensors,
        responses=responses, excited=excited, band=band, start=start, stop=stop, quiet=quiet,
        notes=notes,
    )  # fmt: skip


def _part(recording: Recording, test: Test) -> tuple[int, int, tuple[str, ...]]:
    """Return the samples to be judged; where the crop finds nothing, all of them."""
    try:
        crop = find_crop(recording, test)
    except SpectrumError:
        note = f"{recording.run}: the crop of the log finds no run, so all of it is compared."
        return 0, recording.n_samples, (note,)
    return crop.start, crop.stop, ()


def _excited(test: Test, rate: float) -> tuple[float, float]:
    low, high = test.processing.band or test.band or (_DEFAULT_LOW_HZ, _HIGHEST * rate)
    if test.frequency_hz is not None and test.band is None:
        low, high = 0.8 * test.frequency_hz, 1.25 * test.frequency_hz
    return max(low, 0.2), min(high, _HIGHEST * rate)


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


def input_rows(recording: Recording, model: Model) -> list[int]:
    """Return the rows of the channels that drive the model.

    Raises
    ------
    DiagnosisError
        If there is none, or its unit is another.
    """
    on = model.excitation.on
    role, unit = ("control", "m/s^2") if on is None else ("force", "N")
    rows = [i for i, c in enumerate(recording.channels) if c.role == role]
    if on is not None and any(recording.channels[i].at == on for i in rows):
        rows = [i for i in rows if recording.channels[i].at == on]
    if not rows:
        what = "the base is driven" if on is None else f"a force acts on {on}"
        raise DiagnosisError(
            f"{recording.run}: in the model {what}, but no channel has the role {role}. Give "
            f"the channel that measures it this role in the log; the recording has "
            f"{_names(recording.channels)}."
        )
    for i in rows:
        _check_unit(recording, recording.channels[i], unit, f"role {role}")
    return rows


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
