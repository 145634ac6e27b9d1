"""What the log sheet says, in SI: the campaign, its tests, and how each is processed."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal, TypeAlias, final

from shakerproc.data import STANDARD_GRAVITY, BadRows, ChannelUse, Measurement
from shakerproc.documents import Document
from shakerproc.errors import LogError
from shakerproc.testlog.analyses import (
    Distribution,
    Fatigue,
    Integration,
    Octaves,
    Orders,
    ResponseFunction,
    Shock,
    Waterfall,
)
from shakerproc.testlog.hammer import Hammer
from shakerproc.testlog.header import Header
from shakerproc.testlog.multisine import Multisine
from shakerproc.testlog.parts import Beside, Event
from shakerproc.testlog.paths import is_inside
from shakerproc.units import near_miss

Excitation: TypeAlias = Literal[
    "sine sweep", "random", "sine", "multisine", "stepped sine", "shock", "hammer", "free decay"
]
PULSES: Final[tuple[Excitation, ...]] = ("shock", "hammer", "free decay")
"""Kinds of excitation that are over soon, and whose shape no key of the log says."""

BROADBAND: Final[tuple[Excitation, ...]] = ("random", "multisine")
"""Kinds of excitation whose level is a density or an rms value."""

LevelUnit: TypeAlias = Literal["m/s^2", "(m/s^2)^2/Hz", "m/s^2 rms", "N", "N^2/Hz", "N rms"]
Tag: TypeAlias = str | float
Fact: TypeAlias = str | float | bool | None


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
        Only where the recording does not say it [Hz].
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
    waterfall : Waterfall, optional
        Spectra one after the other.
    integration : Integration, optional
        Velocity and displacement, likewise.
    fatigue : Fatigue, optional
        Vibration response and fatigue damage spectra, likewise.
    response_functions : tuple of ResponseFunction
        Between channels other than the controls and the responses.
    hammer : Hammer
        How the blows of a hammer test are cut out and windowed.
    """

    crop: Crop | None = ThresholdCrop()
    sample_rate: float | None = None
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
    waterfall: Waterfall | None = None
    fatigue: Fatigue | None = None
    response_functions: tuple[ResponseFunction, ...] = ()
    hammer: Hammer = field(default_factory=Hammer)


@final
@dataclass(frozen=True, slots=True)
class Expectation:
    """What the log says a recording must be; None is not checked.

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
class Shaker:
    """What the shaker can do, zero to peak; None is not known.

    Attributes
    ----------
    stroke : float, optional
        Travel of the table from end to end [m].
    velocity : float, optional
        [m/s].
    acceleration : float, optional
        [m/s²].
    force : float, optional
        [N].
    moving_mass : float, optional
        Armature, fixture and specimen, which the force has to move [kg].
    """

    stroke: float | None = None
    velocity: float | None = None
    acceleration: float | None = None
    force: float | None = None
    moving_mass: float | None = None


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
    """

    band: tuple[float, float] | None = None
    modes: int | None = None
    order: int = 60
    keep: tuple[float, ...] = ()
    inputs: Literal["control", "force", "none"] | None = None


@final
@dataclass(frozen=True, slots=True)
class Specimen:
    """Measured dimensions of a coupon and the bushing it was tested with.

    Attributes
    ----------
    joint, name : str
        As the tests name it.
    nominal : float, optional
        Clearance on the drawing, hole less bushing [m].
    actual : float, optional
        Clearance as measured, hole less bushing [m]; play either way is half of it.
    actual_axial : float, optional
        Play out of plane as measured, bushing less coupon thickness [m].
    material, comment : str
        What else is known.
    """

    joint: str
    name: str
    nominal: float | None = None
    actual: float | None = None
    actual_axial: float | None = None
    material: str = ""
    comment: str = ""


@final
@dataclass(frozen=True, slots=True)
class ProfileNotch:
    """A part of a profile in which the plan allows the control to be lower.

    Attributes
    ----------
    low, high : float
        From where to where [Hz].
    depth : float
        By how much the lower alarm and abort lines go down [dB].
    """

    low: float
    high: float
    depth: float


@final
@dataclass(frozen=True, slots=True)
class Profile:
    """What a test demands at every frequency: breakpoints, straight lines on log axes.

    Attributes
    ----------
    name : str
        As the log has it.
    unit : LevelUnit
        Of the level: a density for random excitation, an amplitude for a sweep.
    frequency_hz, level : tuple of float
        Rising breakpoints [Hz], and the demand at each [unit].
    alarm_db, abort_db : tuple of float
        Tolerance either way from each breakpoint up to the next [dB].
    notches : tuple of ProfileNotch
        Where the plan allows less.
    """

    name: str
    unit: LevelUnit
    frequency_hz: tuple[float, ...]
    level: tuple[float, ...]
    alarm_db: tuple[float, ...]
    abort_db: tuple[float, ...]
    notches: tuple[ProfileNotch, ...] = ()


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
    processing: Processing = Processing()
    expect: Expectation = Expectation()
    source: str = ""
    folder: Path | None = None
    profile: Profile | None = None
    continued: tuple[str, ...] = ()
    beside: tuple[Beside, ...] = ()
    events: tuple[Event, ...] = ()
    multisine: Multisine | None = None

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
            raise LogError(
                f"{self.source}: test {self.id}: no recording {path}; "
                "put the file there, correct the path, or mark the test discarded: true"
            )
        if self.folder is not None and not is_inside(path, self.folder):
            raise LogError(
                f"{self.source}: test {self.id}: {path} is a link to outside "
                f"{self.folder}; put the file itself there"
            )
        return path


@final
@dataclass(frozen=True, slots=True, eq=False)
class TestLog:
    """The log sheet of a campaign.

    Attributes
    ----------
    path : Path
        The file.
    title : str
        As the log has it; by default the name of the file.
    folder : Path
        Below which every recording lies.
    tests : tuple of Test
        In the order of the log, discarded ones included.
    specimens : tuple of Specimen
        Measured dimensions, where the log gives them.
    document : Document
        For messages with line and column.
    shaker : Shaker
        What the shaker can do, where the log says it.
    modal : Modal
        How modes are looked for.
    header : Header, optional
        What stands at the top of the report, where the log says it.
    """

    __test__ = False  # not a test case, whatever pytest thinks of the name

    path: Path
    title: str
    folder: Path
    tests: tuple[Test, ...]
    specimens: tuple[Specimen, ...]
    document: Document[Any]
    shaker: Shaker = Shaker()
    modal: Modal = Modal()
    header: Header | None = None

    @property
    def active(self) -> tuple[Test, ...]:
        """Tests that are not discarded."""
        return tuple(test for test in self.tests if not test.discarded)

    def recorded(self) -> tuple[Test, ...]:
        """Return the tests that have a recording and are not discarded.

        Raises
        ------
        LogError
            If there is none.
        """
        found = tuple(test for test in self.active if test.recording is not None)
        if not found:
            raise LogError(
                f"{self.path.name}: no test has a recording that may be used. Give a test its "
                "recording, or take back discarded."
            )
        return found

    def find(self, identity: str | int) -> Test:
        """Return the test of this id; ``1`` and ``"1"`` are the same.

        Raises
        ------
        LogError
            If there is none.
        """
        by_id = {str(test.id): test for test in self.tests}
        if str(identity) in by_id:
            return by_id[str(identity)]
        meant = near_miss(str(identity), list(by_id))
        question = f'; did you mean "{meant}"?' if meant else ""
        ids = list(by_id)
        known = ", ".join(ids if len(ids) <= 12 else [*ids[:6], "...", *ids[-3:]])
        raise LogError(f'{self.path}: no test "{identity}"{question}; the log has {known}')

    def error(self, test: Test, message: str, *key: str | int) -> LogError:
        """Return the error to raise about a test, at one of its keys where one is given."""
        place = self.document.error(("tests", self.tests.index(test), *key), message)
        return LogError(str(place))
