"""Tests as arrays in SI units: as a caller gives them, and as the estimation needs them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import ClassVar, Final, final

import numpy as np
from numpy.typing import NDArray

from shakerproc.comparison.measured import REACH, UNCALIBRATED
from shakerproc.comparison.noise import NOT_REFUTED, Noise, Refuted, noise_of
from shakerproc.comparison.noise_sources import (
    Channels,
    Quiet,
    end_of,
    offset_errors,
    offsets_of,
    quiet_of,
)
from shakerproc.data import FloatArray
from shakerproc.diagnosis.data.sensor_faults import clipped
from shakerproc.errors import DiagnosisError
from shakerproc.models import NO_CONDITIONS, Conditions

NYQUIST_SHARE: Final = 0.45
"""Highest compared frequency over the sample rate: above it the recorder's filter rules [-]."""

LOW_SHARE: Final = 0.7
"""Lowest compared frequency over the lowest excited one [-]."""

FLOOR_SHARE: Final = 2e-4
"""Least uncertainty of a response over its rms: what sensors are linear to [-]."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class TestArrays:
    """One test as arrays, in SI units.

    Attributes
    ----------
    name : str
        Name of the test.
    sample_rate : float
        Samples per second [Hz].
    controls : (n_controls, n) array
        Base accelerations [m/s^2], or one force [N].
    responses : (n_sensors, n) array
        Responses, in the order of the model's sensors.
    hold_out : bool
        Whether the test is kept out of every fit.
    excitation : str
        Kind of excitation, as the log says it.
    level, level_unit : float and str, optional
        Level of the excitation [SI] and its unit.
    band : (float, float)
        What is excited [Hz].
    error_band : (float, float), optional
        What the free-run error counts; what is excited where none is given [Hz].
    gain_spread : (n_controls + n_sensors,) tuple of float
        Standard uncertainty of the gain of each channel; `UNCALIBRATED` without any [-].
    conditions : Conditions
        Under which the test was run.
    """

    __test__: ClassVar[bool] = False  # not a test of pytest's

    name: str
    sample_rate: float
    controls: FloatArray
    responses: FloatArray
    hold_out: bool = False
    excitation: str = ""
    level: float | None = None
    level_unit: str = ""
    band: tuple[float, float] = (5.0, 1000.0)
    error_band: tuple[float, float] | None = None
    gain_spread: tuple[float, ...] = ()
    conditions: Conditions = NO_CONDITIONS

    @property
    def gain_spreads(self) -> tuple[float, FloatArray]:
        """Standard uncertainty of the gain of the input, and of each response [-].

        The input is the mean of the controls, which are calibrated one by one.
        """
        n = len(self.controls)
        each = np.array(self.gain_spread or np.full(n + len(self.responses), UNCALIBRATED))
        return float(np.sqrt(np.sum(each[:n] ** 2))) / n, each[n:]


@final
@dataclass(frozen=True, slots=True, eq=False)
class PreparedTest:
    """One test as the estimation needs it.

    Attributes
    ----------
    arrays : TestArrays
        As it was given.
    input : (n,) array
        What drives the model [m/s^2 or N].
    responses : (n_sensors, n) array
        Without their offsets.
    offset_error : (n_sensors,) array
        Standard deviation of what is told of these [unit of the sensor].
    band : (float, float)
        What is compared: the excited band and the harmonics above it [Hz].
    start, stop : int
        Samples between which the test is judged; the model runs from sample 0.
    quiet : Quiet, optional
        Noise of every channel, where the recording begins at rest.
    noise_density : Noise
        Of the input and the responses, from the measurement alone.
    noise : (n_sensors,) array
        Standard deviation of a sample of each response, never below what sensors are
        calibrated to [unit of the sensor].
    clipped : (n_sensors, n) array of bool
        Which samples stand at a limit of their channel.
    limits : (n_sensors,) array
        This limit; not a number where none is reached [unit of the sensor].
    """

    arrays: TestArrays
    input: FloatArray
    responses: FloatArray
    offset_error: FloatArray
    band: tuple[float, float]
    start: int
    stop: int
    quiet: Quiet | None
    noise_density: Noise
    noise: FloatArray
    clipped: NDArray[np.bool_]
    limits: FloatArray

    @property
    def name(self) -> str:
        """Name of the test."""
        return self.arrays.name

    @property
    def conditions(self) -> Conditions:
        """Conditions under which the test was run."""
        return self.arrays.conditions

    @property
    def sample_rate(self) -> float:
        """Samples per second [Hz]."""
        return self.arrays.sample_rate

    @property
    def error_band(self) -> tuple[float, float]:
        """Band in which the free-run error is counted [Hz]."""
        return self.arrays.error_band or self.arrays.band

    @property
    def n_samples(self) -> int:
        """Samples of the recording."""
        return self.input.size

    @property
    def at_rest(self) -> bool:
        """Whether the recording begins at rest, so that the start of the motion is known.

        What nothing drives does not come from rest.
        """
        return self.quiet is not None and bool(np.any(self.input))

    def shaken(self, generator: np.random.Generator) -> "PreparedTest":
        """Return the test with as much noise again on its input and its responses."""
        noise, size = self.noise_density, (self.n_samples, self.sample_rate)
        return replace(
            self,
            input=self.input + noise.drawn(*size, generator),
            responses=self.responses + noise.drawn_responses(*size, generator),
        )


def prepared(
    tests: Sequence[TestArrays],
    *,
    imposed: bool = False,
    refuted: Mapping[str, Refuted] = MappingProxyType({}),
) -> tuple[PreparedTest, ...]:
    """Return tests as the estimation needs them.

    Parameters
    ----------
    tests : sequence of TestArrays
        Tests of one campaign.
    imposed : bool
        Whether a displacement is imposed: where in its play a joint stands then counts, so that
        the mean of the input is kept.
    refuted : mapping of str to Refuted
        Sources of noise that are no floor, by the name of the test.
    """
    channels = [
        Channels(test.controls, test.responses, test.sample_rate, test.band) for test in tests
    ]
    found = []
    for test, own in zip(tests, channels, strict=True):
        twins = [other for other in channels if other is not own]
        noise = noise_of(own, twins, refuted.get(test.name, NOT_REFUTED))
        found.append(_prepared(test, noise, imposed=imposed))
    return tuple(found)


def _prepared(arrays: TestArrays, noise: Noise, *, imposed: bool) -> PreparedTest:
    controls = arrays.controls - arrays.controls.mean(axis=1, keepdims=True)
    driven = bool(np.any(controls))
    responses = arrays.responses - offsets_of(arrays.responses, driven=driven)
    errors = offset_errors(responses)
    rate = arrays.sample_rate
    quiet = quiet_of(controls, responses, rate)
    if quiet is not None:  # rest tells the offset of a channel better than the whole does
        rest = slice(0, quiet.stop)
        controls = controls - controls[:, rest].mean(axis=1, keepdims=True)
        responses = responses - responses[:, rest].mean(axis=1, keepdims=True)
        errors = offset_errors(responses[:, rest])
    low, high = arrays.band
    highest = min(max(REACH * high, 4.0 * low), NYQUIST_SHARE * rate)
    start = quiet.stop if quiet is not None else _run_in(controls.mean(axis=0), rate)
    rms = np.sqrt(np.mean(responses[:, start:] ** 2, axis=1))
    inside = noise.frequency <= highest
    own = np.sqrt(np.sum(noise.responses[:, inside], axis=1) * float(noise.frequency[0]))
    at_limit, limits = clipped(arrays.responses)
    return PreparedTest(
        arrays=arrays,
        input=(arrays.controls if imposed else controls).mean(axis=0),
        responses=responses,
        offset_error=errors,
        band=(LOW_SHARE * low, highest),
        start=start,
        stop=end_of(controls, responses, rate),
        quiet=quiet,
        noise_density=noise,
        noise=np.hypot(own, FLOOR_SHARE * rms),
        clipped=at_limit,
        limits=limits,
    )


def _run_in(drive: FloatArray, sample_rate: float) -> int:
    """Return the samples before which a test in motion is not judged.

    None of what nothing drives, and none where most of the drive lies before: a blow.
    """
    power = np.cumsum(drive**2)
    first = min(round(sample_rate), drive.size // 10)
    return first if first and power[-1] > 0.0 and power[first - 1] <= 0.5 * power[-1] else 0


def with_noise_of(
    tests: Sequence[PreparedTest], others: Sequence[PreparedTest]
) -> tuple[PreparedTest, ...]:
    """Return tests with the noise of others in its place."""
    pairs = zip(tests, others, strict=True)
    return tuple(
        replace(own, noise_density=new.noise_density, noise=new.noise) for own, new in pairs
    )


def check(test: TestArrays, n_sensors: int) -> None:
    """Pass a test that can be judged.

    Raises
    ------
    DiagnosisError
        If it does not fit the sensors, or lacks samples.
    """
    if test.responses.shape[0] != n_sensors:
        raise DiagnosisError(
            f"{test.name}: {test.responses.shape[0]} responses for {n_sensors} sensors."
        )
    if not (np.all(np.isfinite(test.responses)) and np.all(np.isfinite(test.controls))):
        raise DiagnosisError(f"{test.name}: samples are missing (NaN); crop the test.")
