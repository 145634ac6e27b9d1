"""Data that the rooms hand to each other: arrays, channels, recordings."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from shakerproc import checks

FloatArray: TypeAlias = NDArray[np.float64]
ComplexArray: TypeAlias = NDArray[np.complex128]

STANDARD_GRAVITY: Final = 9.80665
"""Standard acceleration of free fall [m/s²] (ISO 80000-3)."""

Role: TypeAlias = Literal[
    "control",
    "response",
    "force",
    "displacement",
    "velocity",
    "pressure",
    "strain",
    "voltage",
    "tachometer",
    "condition",
    "ignore",
]

ROLE_UNITS: Mapping[Role, tuple[str, ...]] = MappingProxyType({
    "control": ("m/s^2", "rad/s^2"),
    "response": ("m/s^2", "rad/s^2"),
    "force": ("N", "N m"),
    "displacement": ("m", "rad"),
    "velocity": ("m/s", "rad/s"),
    "pressure": ("Pa",),
    "strain": ("1",),
    "voltage": ("V",),
    "tachometer": ("V", "rad/s", "rad"),
    "condition": ("V", "N", "N m", "Pa", "m", "1"),
})
"""SI units that a channel of each role may have: of translation, then of rotation; of a
tachometer pulses, a speed or an angle."""

Measurement: TypeAlias = int | Literal["all"]
"""Which of the measurements that follow each other in a file, from 1, or all as one."""

BadRows: TypeAlias = Literal["refuse", "skip"]
"""What is done with lines of a text file that are no rows of numbers."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """Data of a sensor on its calibration sheet.

    Attributes
    ----------
    serial : str
        Its serial number.
    sensitivity : str
        Such as ``100.2 mV/g``.
    calibrated, valid_until : str
        Days, as 2026-03-31; empty where the sheet says none.
    uncertainty : float, optional
        Expanded uncertainty (k = 2) of the sensitivity, as a share of it [-].
    """

    serial: str
    sensitivity: str
    calibrated: str = ""
    valid_until: str = ""
    uncertainty: float | None = None

    @property
    def sentence(self) -> str:
        """A sentence part for people."""
        days = calibration_days(self.calibrated, self.valid_until)
        share = "" if self.uncertainty is None else f" +- {100.0 * self.uncertainty:.3g} %"
        return f"sensor {self.serial}, {self.sensitivity}{share}{days}"


def calibration_days(calibrated: str, valid_until: str) -> str:
    """Return the days of a calibration as the end of a sentence part; empty without any."""
    days = (("calibrated", calibrated), ("valid until", valid_until))
    return "".join(f", {how} {day}" for how, day in days if day)


@dataclass(frozen=True, slots=True)
class ChannelUse:
    """Use of one channel of a recording, as the test log states it.

    Attributes
    ----------
    key : str or int
        Name in the recording, or number among the group's channels, from 1.
    role : Role
        What the channel is used as.
    name : str, optional
        Name in tables, figures and model files; by default the name in the recording.
    at : str, optional
        Place or mass that the sensor sits on.
    unit : str, optional
        Unit of the numbers in the file, where the file does not say it.
    sensitivity : str, optional
        Sensor output per unit, such as ``100 mV/g``, where the file holds volts.
    override : bool
        Whether unit and sensitivity count where the file says another unit.
    position : tuple of float, optional
        Where the sensor sits, x, y, z [m].
    direction : tuple of float, optional
        Unit vector along which it measures, x, y, z [-].
    sensor : str, optional
        Serial number of the sensor.
    calibration : Calibration, optional
        What the calibration sheet says of it.
    default : bool
        Whether it is said for every test: a recording without such a channel goes without.
    """

    key: str | int
    role: Role
    name: str | None = None
    at: str | None = None
    unit: str | None = None
    sensitivity: str | None = None
    override: bool = False
    position: tuple[float, float, float] | None = None
    direction: tuple[float, float, float] | None = None
    sensor: str | None = None
    calibration: Calibration | None = None
    default: bool = field(default=False, compare=False)


@dataclass(frozen=True, slots=True)
class Channel:
    """One channel of a recording, as it is served: in SI.

    Attributes
    ----------
    name : str
        Name in tables, figures and model files.
    unit : str
        SI unit of the samples: ``m/s^2``, ``N``, ``m``, ``m/s``, ``V`` or ``1``.
    source_name : str
        Name in the file.
    source_unit : str
        Unit in the file, as it stands there (or in the log).
    role : Role, optional
        What the test log uses the channel as.
    at : str, optional
        Place or mass that the sensor sits on.
    own_rate : float, optional
        Samples per second that were taken of it, where the recording holds more [Hz].
    uncertainty : float, optional
        Expanded uncertainty (k = 2) of its calibration, where a sheet says it [-].
    """

    name: str
    unit: str
    source_name: str
    source_unit: str
    role: Role | None = None
    at: str | None = None
    own_rate: float | None = None
    uncertainty: float | None = None


@dataclass(frozen=True, slots=True)
class UnusedChannel:
    """A channel that a file holds and nothing is made of.

    Attributes
    ----------
    name : str
        Name in the file, with its group in front where that is another one.
    why : str
        Why it is not used, such as ``role: ignore in the log``.
    """

    name: str
    why: str


class SampleSource(ABC):
    """Where the samples of a recording come from."""

    @abstractmethod
    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        """Return samples start to stop of the channels in these rows, in SI units.

        Returns
        -------
        (len(rows), stop - start) array
            A new array; fewer samples than asked is an error, never a shorter array.
        """

    @abstractmethod
    def close(self) -> None:
        """Release the file."""


class SourceFile(ABC):
    """The file behind a recording, watched from before it is read."""

    @abstractmethod
    def first_sha256(self) -> str:
        """Return the SHA-256 of its bytes as it was opened."""

    @abstractmethod
    def sha256(self) -> str:
        """Return the SHA-256 of the bytes that were read: to be asked when all are.

        Raises
        ------
        RecordingError
            If the file has changed since it was opened.
        """

    @abstractmethod
    def check(self) -> None:
        """Pass a file that bears no sign of a change; quicker than a hash, and less sure.

        Raises
        ------
        RecordingError
            If the file has changed since it was opened.
        """

    @abstractmethod
    def close(self) -> None:
        """Release the file."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class ArraySource(SampleSource):
    """Samples that are in memory already, a (n_channels, n_samples) array in SI units."""

    samples: FloatArray

    def read(self, rows: Sequence[int], start: int, stop: int) -> FloatArray:
        return self.samples[list(rows), start:stop]

    def close(self) -> None:
        """Do nothing: there is no file."""


@final
@dataclass(frozen=True, slots=True)
class SkippedRows:
    """Lines of a text file that are no rows of numbers and were left out on request.

    Attributes
    ----------
    count : int
        Lines that were left out.
    bridged : int
        Samples that were missing there and are straight lines now.
    first, last : int
        Samples between which all of it lies.
    message : str
        What was left out, a sentence.
    """

    count: int
    bridged: int
    first: int
    last: int
    message: str


@final
@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """Samples of every channel during one run, read when they are asked for.

    Attributes
    ----------
    run : str
        Name of the run; opens every error message.
    channels : tuple of Channel
        What each row of the samples holds.
    sample_rate : float
        Samples per second [Hz].
    n_samples : int
        Complete rows in the file, the same for every channel.
    source : SampleSource
        Where the samples come from.
    rows : tuple of int
        Which rows of the source the channels are.
    path : Path, optional
        The file.
    start_time : datetime, optional
        When the first sample was taken, with its time zone.
    expected_samples : int, optional
        How many samples the file promised, where it holds fewer.
    notes : tuple of str
        What the reader had to decide or found odd, a sentence each.
    in_file : int, optional
        How many channels of numbers the file holds, those included that are not used.
    file : SourceFile, optional
        The file, watched; leaving the ``with`` statement is an error where it has changed.
    skipped : SkippedRows, optional
        What was left out of a text file, on request.
    unused : tuple of UnusedChannel
        Every channel of the file that is none of `channels`.
    rate_doubt : float
        How far `sample_rate` may be off, relative: what the digits of the file resolve [-].
    rate_doubtful : str
        What is to be known of `sample_rate`, where it is not simply the file's; sentences.
    driven : bool
        Whether the log says that the test was driven, so that nothing rests while it lasts.
    """

    run: str
    channels: tuple[Channel, ...]
    sample_rate: float
    n_samples: int
    source: SampleSource
    rows: tuple[int, ...]
    path: Path | None = None
    start_time: datetime | None = None
    expected_samples: int | None = None
    notes: tuple[str, ...] = ()
    in_file: int | None = None
    file: SourceFile | None = None
    skipped: SkippedRows | None = None
    unused: tuple[UnusedChannel, ...] = ()
    rate_doubt: float = 0.0
    rate_doubtful: str = ""
    driven: bool = False

    def __post_init__(self) -> None:
        checks.positive("sample_rate", self.sample_rate, "Hz")
        if len(self.rows) != len(self.channels):
            raise ValueError(f"{len(self.channels)} channels but {len(self.rows)} rows")

    @property
    def duration(self) -> float:
        """Length of the samples [s]."""
        return self.n_samples / self.sample_rate

    @property
    def incomplete(self) -> bool:
        """Whether the file promised more samples than it holds."""
        return self.expected_samples is not None and self.expected_samples > self.n_samples

    def samples(self, start: int = 0, stop: int | None = None) -> FloatArray:
        """Return the samples start to stop of every channel, (n_channels, n) array."""
        return self.source.read(self.rows, start, self.n_samples if stop is None else stop)

    def blocks(
        self, start: int = 0, stop: int | None = None, size: int = 2**18
    ) -> Iterator[FloatArray]:
        """Yield the samples start to stop in order, (n_channels, at most size) arrays."""
        end = self.n_samples if stop is None else stop
        for first in range(start, end, size):
            yield self.samples(first, min(first + size, end))

    def select(self, indices: Sequence[int]) -> "Recording":
        """Return the recording with only these of its channels, in this order."""
        return replace(
            self,
            channels=tuple(self.channels[i] for i in indices),
            rows=tuple(self.rows[i] for i in indices),
        )

    def __enter__(self) -> "Recording":
        return self

    def __exit__(self, problem: type[BaseException] | None, *_: object) -> None:
        try:
            if problem is None and self.file is not None:
                self.file.check()
        finally:
            self.source.close()

    def sha256(self) -> str:
        """Return the SHA-256 of the bytes that were read; none where there is no file.

        Raises
        ------
        RecordingError
            If the file has changed since it was opened.
        """
        return "" if self.file is None else self.file.sha256()


def recording_of_arrays(
    run: str, channels: Sequence[Channel], samples: FloatArray, sample_rate: float
) -> Recording:
    """Return a recording of samples in memory, a (n_channels, n_samples) array in SI units.

    Raises
    ------
    ValueError
        If the rows of `samples` are not one for each channel.
    """
    if samples.ndim != 2 or samples.shape[0] != len(channels):
        raise ValueError(f"samples must be ({len(channels)}, n_samples), not {samples.shape}")
    return Recording(
        run=run,
        channels=tuple(channels),
        sample_rate=sample_rate,
        n_samples=samples.shape[1],
        source=ArraySource(samples),
        rows=tuple(range(len(channels))),
    )
