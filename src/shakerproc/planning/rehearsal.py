"""A test before it is run: the recording that a model and the log say it will give."""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from types import MappingProxyType
from typing import Final, Literal, final

import numpy as np
import scipy  # its parts load when they are first used

from shakerproc.comparison.own import Own, run
from shakerproc.data import (
    ROLE_UNITS,
    STANDARD_GRAVITY,
    Channel,
    ChannelUse,
    FloatArray,
    Recording,
    Role,
    recording_of_arrays,
)
from shakerproc.errors import LogError, SimulationError
from shakerproc.models import BASE, Model
from shakerproc.models.model import SENSOR_UNITS
from shakerproc.models.validation import check_sampled
from shakerproc.numerals import numeral
from shakerproc.planning.drive import (
    check_period,
    drive_of_test,
    length_of_run,
    sample_rate_of_test,
)
from shakerproc.runs import usual_roles
from shakerproc.simulation import (
    Input,
    InterpolationError,
    SimulatedResponse,
    is_smooth,
    prepare,
    simulate,
)
from shakerproc.simulation.inputs import MOST_SAMPLES
from shakerproc.simulation.pieces import finer as finer_samples
from shakerproc.simulation.pieces import interpolation_error
from shakerproc.testlog import Test
from shakerproc.testlog.excitation import FORCES, LEVELS
from shakerproc.units import any_quantity, from_si, is_unit_of, sensitivity

Holds = Literal["base", "force", "sensor", "mass", "condition", "nothing"]

_USUAL: Final = {"m/s^2": "g", "1": "m/m"}
"""Unit of a file for an SI unit, where the log says none; SI elsewhere."""


@final
@dataclass(frozen=True, slots=True)
class WrittenChannel:
    """A channel of a simulated recording.

    Attributes
    ----------
    channel : Channel
        As the file names it; its unit is the one that is stored.
    quantity : str
        SI unit of what is measured.
    volts_per_unit : float, optional
        Sensitivity, where the file is to hold volts [V per unit of `quantity`].
    holds : {"base", "force", "sensor", "mass", "condition", "nothing"}
        What the samples are.
    source : str
        Name of the sensor or mass, or the value of the condition.
    """

    channel: Channel
    quantity: str
    volts_per_unit: float | None
    holds: Holds
    source: str = ""


def written_channels(test: Test, model: Model) -> tuple[WrittenChannel, ...]:
    """Return the channels of the recording of a test, in the order of the file.

    Where the log names no channels: two controls (or a force) and the sensors of the model.

    Raises
    ------
    LogError
        If the model does not say what a channel measures.
    """
    uses = test.channels or _usual(model)
    return tuple(_written(test, model, key, use) for key, use in _places(uses))


def _usual(model: Model) -> tuple[ChannelUse, ...]:
    if model.excitation.role not in {"control", "force"}:
        raise LogError(
            f"{model.title}: a rehearsal needs a base or a force that drives the model, not "
            f"{model.excitation.kind}."
        )
    inputs = (
        (ChannelUse("control 1", "control"), ChannelUse("control 2", "control"))
        if model.excitation.on is None
        else (ChannelUse("force", "force"),)
    )
    roles: dict[str, Role] = {"m/s^2": "response", "m": "displacement", "m/s": "velocity"}
    sensors = (
        ChannelUse(name, roles[SENSOR_UNITS[sensor.measures]])
        for name, sensor in model.sensors.items()
    )
    return (*inputs, *sensors)


def _places(uses: Sequence[ChannelUse]) -> list[tuple[str, ChannelUse | None]]:
    """Return name and use of every channel of the file; numbers keep their places."""
    numbered = {use.key: use for use in uses if isinstance(use.key, int)}
    named = iter([use for use in uses if not isinstance(use.key, int)])
    count = max([len(uses), *(int(key) for key in numbered)])
    places: list[tuple[str, ChannelUse | None]] = []
    for number in range(1, count + 1):
        use = numbered.get(number) or next(named, None)
        name = f"channel {number}" if use is None or number in numbered else str(use.key)
        places.append((name, use))
    return places


def _written(test: Test, model: Model, name: str, use: ChannelUse | None) -> WrittenChannel:
    condition = None if use is None else _condition(test, use)
    if condition is not None:
        return condition
    if use is None or use.role in {"ignore", "tachometer"}:
        return WrittenChannel(Channel(name, "V", name, "V"), "V", None, "nothing")
    quantity = model.unit_of(ROLE_UNITS[use.role][0])
    usual = _USUAL.get(quantity, quantity)
    holds, source = _simulated_quantity(test, model, use, quantity)
    if use.sensitivity is not None:
        output, size = sensitivity(use.sensitivity, quantity)
        electrical = Channel(name, output, name, output)
        return WrittenChannel(electrical, quantity, size, holds, source)
    unit = use.unit or test.expect.unit or usual
    if not _converts(quantity, unit):
        unit = usual
    return WrittenChannel(Channel(name, quantity, name, unit), quantity, None, holds, source)


def _condition(test: Test, use: ChannelUse) -> WrittenChannel | None:
    """Return the channel of a condition that the test states; None of any other."""
    name = use.name or str(use.key)
    said = test.conditions.get(name)
    if said is None or use.key not in {one.key for one in test.measured_conditions}:
        return None
    value, unit = any_quantity(said)
    quantity = next((u for u in ROLE_UNITS["condition"] if is_unit_of(unit, u)), None)
    if quantity is None:
        return None
    channel = Channel(str(use.key), quantity, str(use.key), quantity)
    return WrittenChannel(channel, quantity, None, "condition", repr(value))


def _converts(quantity: str, unit: str) -> bool:
    try:
        from_si(1.0, quantity, unit)
    except ValueError:
        return False
    return True


def _simulated_quantity(
    test: Test, model: Model, use: ChannelUse, quantity: str
) -> tuple[Holds, str]:
    """Return the quantity of a channel.

    Raises
    ------
    LogError
        If the model does not say it.
    """
    name = use.name or str(use.key)
    on = model.excitation.on
    if use.role == "control":
        return ("base" if on is None else "nothing"), ""
    if use.role == "force" and on is not None:
        return ("force" if use.at in {None, on} else "nothing"), ""
    for known in (name, str(use.key)):
        if known in model.sensors and model.sensor_unit(model.sensors[known]) == quantity:
            return "sensor", known
    if use.role == "response" and use.at == BASE:
        return ("base" if on is None else "nothing"), ""
    if use.at in model.moving and use.role != "force":
        return "mass", str(use.at)
    wanted = f"sensors: {{{name}: {{at: {model.moving[0]}, measures: acceleration}}}}"
    raise LogError(
        f"{test.source}: test {test.id}: the model does not say what channel {name!r} (role "
        f"{use.role}{f', at {use.at}' if use.at else ''}) measures. Add it to the model, such "
        f"as {wanted}, or give the channel role: ignore"
    )


LAB_RATE: Final = 5688.9
"""Samples per second where nobody says otherwise [Hz]."""

LAB_DURATION: Final = 10.0
"""Length of a run where nobody says otherwise [s]."""

START: Final = datetime(2000, 1, 1, tzinfo=UTC)
"""When simulated recordings are made, so that the same seed gives the same bytes."""

USUAL_NOISE: Final[Mapping[str, float]] = MappingProxyType({
    "m/s^2": 0.005 * STANDARD_GRAVITY,
    "N": 0.01,
    "m": 1e-8,
    "m/s": 1e-5,
    "V": 1e-4,
})
"""Noise of a sensor, rms, by the unit of what it measures, where nobody says otherwise."""

_FINER: Final = 4  # steps of the simulation in a sample, so that the recorder can filter
_MOST_STEPS: Final = 4_000_000
_TOLERANCE: Final = 1e-10
_PASSES, _STOPS = 0.45, 0.49  # of the sample rate: the flank of the recorder's filter
_MARGIN: Final = 512  # samples by which what is filtered is led past either end
_NONE: Final[Mapping[str, float]] = MappingProxyType({})


@final
@dataclass(frozen=True, slots=True)
class Staging:
    """How recordings are simulated.

    Attributes
    ----------
    sample_rate, duration : float
        Of tests whose log does not say them [Hz], [s].
    lead_in, lead_out : float
        Rest before and after the run [s].
    noise : mapping of str to float
        Root mean square of each channel's own noise, by the SI unit of what it measures.
    offset : mapping of str to float
        Standard deviation of the offsets of the channels, likewise.
    seed : int
        Of noise, offsets and random excitation.
    growth : bool
        Whether to see how a disturbance grows, so that chaos is told.
    """

    sample_rate: float = LAB_RATE
    duration: float = LAB_DURATION
    lead_in: float = 0.5
    lead_out: float = 0.5
    noise: Mapping[str, float] = field(default_factory=lambda: USUAL_NOISE)
    offset: Mapping[str, float] = field(default_factory=lambda: _NONE)
    seed: int = 0
    growth: bool = True


@final
@dataclass(frozen=True, slots=True, eq=False)
class Rehearsed:
    """A simulated recording, and the motion behind it.

    Attributes
    ----------
    test : Test
        The line of the log.
    recording : Recording
        In memory.
    simulation : SimulatedResponse
        The motion, at a multiple of the recorder's rate.
    """

    test: Test
    recording: Recording
    simulation: SimulatedResponse

    @property
    def facts(self) -> dict[str, object]:
        """Facts of the rehearsal, units in the names."""
        shown = self.simulation
        rows = shown.displacement[: len(shown.masses)]
        return {
            "test": self.test.id,
            "duration_s": self.recording.duration,
            "sample_rate_hz": self.recording.sample_rate,
            "channels": [channel.name for channel in self.recording.channels],
            "largest_relative_displacement_m": {
                name: float(np.max(np.abs(row)))
                for name, row in zip(shown.masses, rows, strict=True)
            },
            "switchings": shown.switchings,
            "solver": shown.solver,
            "error": shown.error,
            "interpolation_error": shown.interpolation,
            "growth": shown.growth,
            "chaotic": shown.chaotic,
            "notes": list(shown.notes),
        }


def rehearse(model: Model, test: Test, staging: Staging) -> Rehearsed:
    """Return the recording that a test will give if the model is right.

    The excitation of the log shakes the model; what the sensors see passes the recorder's
    low-pass filter (0.45 of the sample rate) and gets noise and an offset of its own.

    Parameters
    ----------
    model : Model
        What is shaken.
    test : Test
        A line of the log.
    staging : Staging
        Noise, rest, seed.

    Raises
    ------
    LogError
        If the log does not say enough, or speaks of other channels than the model.
    SimulationError
        If the motion runs away.
    """
    check_drive(model, test)
    rate = sample_rate_of_test(test, staging.sample_rate) or staging.sample_rate
    check_sampled(model, rate)
    check_period(test, rate)
    excited, noisy = _generators(staging, test)
    quiet = staging.lead_in + staging.lead_out
    seconds = length_of_run(test, quiet, staging.duration)
    _check_length(test, seconds + quiet, rate)
    finer = _finer(round((seconds + quiet) * rate))
    steps = drive_of_test(test, seconds, rate * finer, excited)
    tail = max(staging.lead_out, (test.expect.duration or 0.0) - seconds - staging.lead_in)
    before, after = (round(rest * rate) * finer for rest in (staging.lead_in, tail))
    surplus = -(before + steps.size + after) % finer
    driven = _Driven(np.pad(steps, (before, after + surplus)), rate, finer)
    recording, response = _recorded(model, test, driven, staging, noisy)
    return Rehearsed(test, recording, response)


def with_usual_roles(recording: Recording) -> Recording:
    """Return a recording of which no log speaks, with the roles that its channels seem to have.

    Channels that have none are left out.
    """
    channels = recording.channels
    roles = usual_roles([c.source_name for c in channels], [c.source_unit for c in channels])
    given = replace(
        recording,
        channels=tuple(replace(c, role=role) for c, role in zip(channels, roles, strict=True)),
    )
    return given.select([i for i, role in enumerate(roles) if role != "ignore"])


def respond(model: Model, recording: Recording, staging: Staging) -> Rehearsed:
    """Return the response of a model to the measured input of a recording.

    Parameters
    ----------
    model : Model
        What is shaken.
    recording : Recording
        Its controls, or the force on the driven mass, shake it: the mean of them.
    staging : Staging
        Noise, offset and seed; the rest is the recording's own.

    Raises
    ------
    LogError
        If the recording has no channel that could drive the model.
    """
    on = model.excitation.on
    role, unit = "control" if on is None else "force", model.drive_unit
    rows = [i for i, c in enumerate(recording.channels) if c.role == role and c.unit == unit]
    if not rows:
        raise LogError(
            f"{recording.run}: no channel with the role {role} in {unit} to shake the model; "
            f"give a test log and let it say which channel that is"
        )
    check_sampled(model, recording.sample_rate)
    test = Test(id=recording.run)
    _, noisy = _generators(staging, test)
    samples = recording.select(rows).samples().mean(axis=0)
    samples = samples - samples.mean()
    finer = _finer(samples.size)
    (steps,) = finer_samples(samples, finer, 0, beyond=finer - 1)
    error = interpolation_error(samples)
    driven = _Driven(steps, recording.sample_rate, finer, error)
    made, response = _recorded(model, test, driven, staging, noisy)
    return Rehearsed(test, replace(made, run=f"{recording.run} simulated"), response)


@final
@dataclass(frozen=True, slots=True, eq=False)
class _Driven:
    """Input of the model in one test, at so many steps a sample."""

    samples: FloatArray
    sample_rate: float
    finer: int
    error: InterpolationError | None = None


def _recorded(
    model: Model, test: Test, driven: _Driven, staging: Staging, noisy: np.random.Generator
) -> tuple[Recording, SimulatedResponse]:
    channels = written_channels(test, model)
    given = _input(driven)
    try:
        response = simulate(model, given, tolerance=_TOLERANCE, growth=staging.growth)
    except SimulationError as error:
        raise SimulationError(f"test {test.id}: {error}") from error
    response = _filtered(model, given, response)
    rows = [
        _with_noise(
            one, low_passed(_sensed(one, response, driven), driven.finer), staging, noisy
        )
        for one in channels
    ]
    name = "Acceleration" if test.recording is None else test.recording.stem
    recording = recording_of_arrays(
        f"{name} simulated",
        [one.channel for one in channels],
        np.array(rows),
        driven.sample_rate,
    )
    return replace(recording, start_time=START), response


def _filtered(model: Model, given: Input, response: SimulatedResponse) -> SimulatedResponse:
    """Return a response whose accelerations are means over the steps, with their box undone.

    Where they jump, as those of dry friction do, values at the steps fold back.
    """
    if is_smooth(model):
        return response
    rows, failed = run(model, given, Own())
    return (
        response
        if failed
        else replace(response, outputs=dict(zip(model.sensors, rows, strict=True)))
    )


def _input(driven: _Driven) -> Input:
    """Return the input of the model, with the interpolation error of its finer steps."""
    given = prepare(driven.samples, driven.sample_rate * driven.finer)
    if driven.error is None or given.interpolation is None:
        return given
    error = InterpolationError(
        given.interpolation.first + driven.error.first,
        given.interpolation.middle + driven.error.middle,
    )
    return replace(given, missed=error.largest, interpolation=error)


def _check_length(test: Test, seconds: float, rate: float) -> None:
    """Pass a run of a size that can be simulated.

    Raises
    ------
    LogError
        If it has too many samples.
    """
    if not seconds * rate <= MOST_SAMPLES:
        raise LogError(
            f"{test.source or 'test'}: test {test.id}: {seconds:g} s at {rate:g} Hz are "
            f"{numeral(seconds * rate)} samples; at most {MOST_SAMPLES:.0e} are simulated. "
            "Shorten the run, or lower its sample rate."
        )


def check_drive(model: Model, test: Test) -> None:
    """Check that the level of a test drives the model: an acceleration, or a force.

    Raises
    ------
    LogError
        If the one is a force and the other an acceleration.
    """
    if test.level_unit is None:
        return
    by_force = LEVELS[test.level_unit][1] in FORCES
    if by_force != (model.excitation.on is not None):
        drives = "a force" if model.excitation.on is not None else "the base's acceleration"
        raise LogError(
            f"{test.source}: test {test.id}: its level is {test.level_text}, but {drives} "
            f"drives the model; correct the level, or excitation in the model"
        )


def _generators(staging: Staging, test: Test) -> tuple[np.random.Generator, ...]:
    """Return generators for excitation and noise, whatever other tests the log has."""
    mine = zlib.crc32(str(test.id).encode())
    return tuple(np.random.default_rng([staging.seed, mine, use]) for use in range(2))


def _finer(n_samples: int) -> int:
    """Return how many steps to take in a sample."""
    return max(1, min(_FINER, _MOST_STEPS // max(1, n_samples)))


def _with_noise(
    one: WrittenChannel, clean: FloatArray, staging: Staging, noisy: np.random.Generator
) -> FloatArray:
    """Return the stored samples of a channel, with noise, in the SI unit of their quantity."""
    drawn = noisy.standard_normal(clean.size + 1)
    seen = clean + staging.noise.get(one.quantity, 0.0) * drawn[1:]
    seen += staging.offset.get(one.quantity, 0.0) * drawn[0]
    return seen if one.volts_per_unit is None else one.volts_per_unit * seen


def _sensed(one: WrittenChannel, response: SimulatedResponse, driven: _Driven) -> FloatArray:
    """Return the measured quantity of a channel at every step, (n,) array."""
    if one.holds in {"condition", "nothing"}:
        return np.full_like(driven.samples, float(one.source or 0.0))
    if one.holds in {"base", "force"}:
        return driven.samples
    if one.holds == "sensor":
        return response.outputs[one.source]
    if one.quantity == "m":
        return response.relative_displacement(BASE, one.source)
    if one.quantity == "m/s":
        return response.relative_velocity(BASE, one.source)
    row: FloatArray = response.acceleration[response.masses.index(one.source)]
    return row


def low_passed(steps: FloatArray, finer: int) -> FloatArray:
    """Return a quantity [any unit] after the low pass of a recorder, known at every step."""
    n = steps.size // finer
    longer, line = _led_past_its_ends(steps[: n * finer], _MARGIN * finer)
    size = longer.size // finer
    spectrum = scipy.fft.rfft(longer)[: size // 2 + 1]
    share = np.arange(spectrum.size) / size
    fall = np.clip((share - _PASSES) / (_STOPS - _PASSES), 0.0, 1.0)
    kept: FloatArray = (
        scipy.fft.irfft(spectrum * (0.5 + 0.5 * np.cos(np.pi * fall)), size) / finer
    )
    inside: FloatArray = (kept + line[::finer])[_MARGIN : _MARGIN + n]
    return inside


def _led_past_its_ends(samples: FloatArray, margin: int) -> tuple[FloatArray, FloatArray]:
    """Return samples led past both ends, without the line that joins them, and that line.

    Turned round its ends a signal goes on in value and slope, and without the line its Fourier
    series has no jump.
    """
    longer = np.pad(samples, min(margin, samples.size - 1), "reflect", reflect_type="odd")
    longer = np.pad(longer, (longer.size - samples.size - 2 * margin) // -2, "edge")
    line = np.linspace(longer[0], longer[-1], longer.size)
    return longer - line, line
