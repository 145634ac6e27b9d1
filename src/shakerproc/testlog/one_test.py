"""One line of the log sheet: a test, in SI, and the requirements on its recording."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias, final

from shakerproc.data import ChannelUse, Recording
from shakerproc.errors import LogError
from shakerproc.geometry import Wireframe
from shakerproc.testlog.excitation import (
    DemandedTone,
    Excitation,
    LevelUnit,
    Multisine,
    Profile,
)
from shakerproc.testlog.fields import is_inside
from shakerproc.testlog.header import Instrument
from shakerproc.testlog.processing import Processing
from shakerproc.units import is_same_unit, near_miss, quoted

Tag: TypeAlias = str | float

Fact: TypeAlias = str | float | bool | None

RATE_TOLERANCE = 1e-4
"""How far a sample rate may be off what the log expects, as a share [-]."""


@final
@dataclass(frozen=True, slots=True)
class FurtherRecording:
    """Channels of the same time from another recorder, or from another group of the file.

    Attributes
    ----------
    recording : str, optional
        File below the folder of the recordings; None for the recording of the test itself.
    group : str, optional
        Group of that file.
    sample_rate : float, optional
        Only where the file does not say it, or `override_rate` [Hz].
    override_rate : bool
        Whether that counts although the file states another.
    common : (str or int, str or int), optional
        A channel of the test's recording and the channel beside that measured the same motion;
        without it both have one clock.
    channels : tuple of ChannelUse
        What its channels are used as.
    """

    recording: str | None
    channels: tuple[ChannelUse, ...]
    group: str | None = None
    sample_rate: float | None = None
    override_rate: bool = False
    common: tuple[str | int, str | int] | None = None


@final
@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened during a test.

    Attributes
    ----------
    time : float
        From the start of the recording [s].
    note : str
        What happened.
    """

    time: float
    note: str


@final
@dataclass(frozen=True, slots=True)
class Expectation:
    """Expected properties of a recording; None is not checked.

    Attributes
    ----------
    duration : float, optional
        Length of the recording [s].
    duration_tolerance : float
        How far it may be off, as a share [-].
    sample_rate : float, optional
        Samples per second [Hz].
    channels : int, optional
        How many the recording holds: all that hold numbers, those with ``role: ignore`` and
        those that the log does not name included; in a file of several groups, of its group.
    unit : str, optional
        Unit of the used channels in the file, such as ``g``.
    sha256 : str, optional
        Hash of the file, 64 hexadecimal digits.
    """

    duration: float | None = None
    duration_tolerance: float = 0.02
    sample_rate: float | None = None
    channels: int | None = None
    unit: str | None = None
    sha256: str | None = None


@final
@dataclass(frozen=True, slots=True)
class Test:
    """One line of the log sheet.

    Attributes
    ----------
    id : int or str
        Unique in the log.
    recording : Path, optional
        Absolute, inside the log's folder; `require_recording` checks that it is there.
    joint, specimen, orientation, comment : str
        As the log has them; empty where it says nothing.
    clearance, actual_clearance, actual_axial_clearance : float, optional
        Nominal, measured in plane and measured out of plane, hole less bushing [m]; the test's
        own `actual_clearance` (a joint fixed with a washer has none) sets aside the specimen's.
    excitation : Excitation, optional
        Kind of excitation.
    level : float, optional
        In `level_unit`.
    level_unit : LevelUnit, optional
        Amplitude, density or rms.
    level_text : str
        As the log has it, the number in its shortest form: 1.0 g is ``1 g``.
    from_hz, to_hz : float, optional
        Excited band; a downward sweep has the higher one first [Hz].
    rate_oct_per_min : float, optional
        Of a logarithmic sweep [oct/min].
    rate_hz_per_s : float, optional
        Of a linear sweep [Hz/s].
    frequency_hz : float, optional
        Of a sine [Hz].
    notch_hz : float, optional
        What is filtered out for a second look [Hz].
    discarded : bool
        Never processed.
    hold_out : bool
        Never fitted to, only scored.
    tags : mapping
        Further columns.
    channels : tuple of ChannelUse
        Empty where the log names none: readers then take the usual five.
    processing : Processing
        How the recording is processed.
    expect : Expectation
        What the recording must be.
    source : str
        File and line of the test, for messages.
    folder : Path, optional
        Below which the recording must lie, links followed.
    profile : Profile, optional
        What the control is judged by.
    continued : tuple of str
        Files below `folder` that follow the recording, in their order.
    beside : tuple of Beside
        Channels of other recorders or of other groups.
    events : tuple of Event
        What happened during the test.
    multisine : Multisine, optional
        How a multisine repeats.
    tones : tuple of DemandedTone
        Of a sine on random; where it says none, they are found in the controls.
    instruments : tuple of Instrument
        Those of the report whose calibration ends on a day.
    planned : bool
        Whether it has not been run yet: it has no recording, and only forecasts read it.
    duration : float, optional
        How long a planned test is to shake, where no rate says it [s].
    geometry : Wireframe, optional
        Nodes, lines and surfaces of the structure.
    conditions : mapping of str to str
        Quantities that scale effects of a model, such as ``2 V``, by their names.
    measured_conditions : tuple of ChannelUse
        Channels that measure such quantities; among `channels` they are ignored.
    """

    __test__ = False  # not a test case, whatever pytest thinks of the name

    id: int | str
    recording: Path | None = None
    joint: str = ""
    specimen: str = ""
    clearance: float | None = None
    actual_clearance: float | None = None
    actual_axial_clearance: float | None = None
    orientation: str = ""
    excitation: Excitation | None = None
    level: float | None = None
    level_unit: LevelUnit | None = None
    level_text: str = ""
    from_hz: float | None = None
    to_hz: float | None = None
    rate_oct_per_min: float | None = None
    rate_hz_per_s: float | None = None
    frequency_hz: float | None = None
    notch_hz: float | None = None
    discarded: bool = False
    comment: str = ""
    hold_out: bool = False
    tags: Mapping[str, Tag] = field(default_factory=dict)
    channels: tuple[ChannelUse, ...] = ()
    processing: Processing = field(default_factory=Processing)
    expect: Expectation = Expectation()
    source: str = ""
    folder: Path | None = None
    profile: Profile | None = None
    continued: tuple[str, ...] = ()
    beside: tuple[FurtherRecording, ...] = ()
    events: tuple[Event, ...] = ()
    multisine: Multisine | None = None
    tones: tuple[DemandedTone, ...] = ()
    instruments: tuple[Instrument, ...] = ()
    planned: bool = False
    duration: float | None = None
    geometry: Wireframe | None = None
    conditions: Mapping[str, str] = field(default_factory=dict)
    measured_conditions: tuple[ChannelUse, ...] = ()

    @property
    def band(self) -> tuple[float, float] | None:
        """Excited band [Hz], lower limit first; None where the log does not say it."""
        if self.from_hz is None or self.to_hz is None:
            return None
        return min(self.from_hz, self.to_hz), max(self.from_hz, self.to_hz)

    @property
    def struck(self) -> bool:
        """Whether it is a hammer test, of which each segment of a spectrum is a blow."""
        return self.excitation == "hammer"

    @property
    def rings(self) -> bool:
        """Whether its motion dies away: no threshold crops it, no density has chance limits."""
        return self.excitation in {"hammer", "free decay"}

    @property
    def files(self) -> tuple[Path, ...]:
        """Paths of all files of the test, each once, the recording first; there or not."""
        if self.recording is None:
            return ()
        more = [*self.continued, *(one.recording for one in self.beside if one.recording)]
        below = self.folder or Path()
        return tuple(dict.fromkeys([self.recording, *(below / name for name in more)]))

    def require_recording(self) -> Path:
        """Return the path of the recording.

        Raises
        ------
        LogError
            If the log names none, or it is no file inside the log's folder (any more).
        """
        if self.recording is None:
            raise LogError(f"{self.source}: test {self.id} has no recording; add the key")
        return self._there(self.recording)

    def require_recordings(self) -> tuple[Path, ...]:
        """Return the paths of all files of the test, each once, the recording first.

        Raises
        ------
        LogError
            If one is no file inside the log's folder (any more).
        """
        return (self.require_recording(), *map(self._there, self.files[1:]))

    def require_file(self, name: str) -> Path:
        """Return the path of a further file of the test, named as below the log's folder.

        Raises
        ------
        LogError
            If it is no file there.
        """
        return self._there((self.folder or Path()) / name)

    def _there(self, path: Path) -> Path:
        """Return a path of a file that is there.

        Raises
        ------
        LogError
            If it is not, or a link to outside the log's folder.
        """
        if not path.is_file():
            neighbours = sorted(path.parent.iterdir()) if path.parent.is_dir() else []
            near = near_miss(path.name, [one.name for one in neighbours if one.is_file()])
            raise LogError(
                f"{self.source}: test {self.id}: no recording {path}"
                f"{f', did you mean {quoted(near)}?' if near else ''}; put the file there, "
                "correct the path, or mark the test discarded: true"
            )
        if self.folder is not None and not is_inside(path, self.folder):
            raise LogError(
                f"{self.source}: test {self.id}: {path} is a link to outside "
                f"{self.folder}; put the file itself there"
            )
        return path


def check_expectation(test: Test, recording: Recording) -> None:
    """Raise where a recording contradicts the log.

    Raises
    ------
    LogError
        If it is not; with everything that differs.
    """
    departures = list(_departures(test, recording))
    if departures:
        raise LogError(
            f"{test.source}: test {test.id}: {'; '.join(departures)}; correct the log, or look "
            "whether this is the recording of that test"
        )


def nominal_duration(test: Test) -> float | None:
    """Return how long the sweep of a test takes at its rate [s], None for other tests."""
    if test.from_hz is None or test.to_hz is None:
        return None
    if test.rate_oct_per_min is not None:
        return abs(math.log2(test.to_hz / test.from_hz)) / test.rate_oct_per_min * 60.0
    if test.rate_hz_per_s is not None:
        return abs(test.to_hz - test.from_hz) / test.rate_hz_per_s
    return None


def _departures(test: Test, recording: Recording) -> Iterator[str]:
    expect = test.expect
    if expect.duration is not None:
        yield from _difference(
            "s", expect.duration, recording.duration, expect.duration_tolerance
        )
    if expect.sample_rate is not None:
        yield from _difference("Hz", expect.sample_rate, recording.sample_rate, RATE_TOLERANCE)
    if expect.channels is not None:
        yield from _other_count(expect.channels, recording)
    if expect.unit is not None:
        yield from _other_units(expect.unit, recording)
    if expect.sha256 is not None and recording.file is not None:
        yield from _other_hash(expect.sha256, recording.file.first_sha256())


def _difference(unit: str, wanted: float, value: float, tolerance: float) -> Iterator[str]:
    if abs(value - wanted) > tolerance * wanted:
        yield f"the log expects {wanted:.7g} {unit}, the recording has {value:.7g} {unit}"


def _other_count(wanted: int, recording: Recording) -> Iterator[str]:
    used = len(recording.channels)
    n_channels = used if recording.in_file is None else recording.in_file
    if n_channels != wanted:
        counted = (
            f"all of them counted; {used} are used" if used != n_channels else "all are used"
        )
        yield f"the log expects {wanted} channels, the recording has {n_channels} ({counted})"


def _other_units(wanted: str, recording: Recording) -> Iterator[str]:
    for channel in recording.channels:
        if not is_same_unit(channel.source_unit, wanted):
            yield (
                f"the log expects channel {quoted(channel.name)} in {wanted}, "
                f"the recording has it in {quoted(channel.source_unit)}"
            )


def _other_hash(wanted: str, digest: str) -> Iterator[str]:
    if digest != wanted:
        yield f"the log expects SHA-256 {wanted[:12]}..., the file has {digest[:12]}..."
