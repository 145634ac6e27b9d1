"""Summary of one run: every number that a table, a trend or the report shows."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from pydantic_core import to_json

from shakerproc import files
from shakerproc.data import UnusedChannel
from shakerproc.recordings import FAULTS
from shakerproc.runs.panels import Look, PanelScale

if TYPE_CHECKING:
    from pydantic import TypeAdapter


MOST_NAMES: Final = 40
"""Channels that are named in a line; summary.json names all."""

MOST_TESTS: Final = 12


def unused_lines(unused: Sequence[UnusedChannel]) -> tuple[str, ...]:
    """Return a line for each reason why channels are not used, which names them.

    Examples
    --------
    >>> unused_lines([UnusedChannel("T1", "it holds text"), UnusedChannel("T2", "no samples")])
    ('not used: T1 (it holds text)', 'not used: T2 (no samples)')
    """
    names: dict[str, list[str]] = {}
    for channel in unused:
        names.setdefault(channel.why, []).append(channel.name)
    return tuple(f"not used: {_listed(found)} ({why})" for why, found in names.items())


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return ", ".join(names[:MOST_NAMES]) + more


def by_tests(messages: Iterable[tuple[str, Sequence[str]]]) -> list[str]:
    """Return the messages on tests, each line once with the tests that it is true of.

    Parameters
    ----------
    messages : iterable of (str, sequence of str)
        Name of a test, and the lines about it.

    Examples
    --------
    >>> by_tests([("1", ["not used: T1 (it holds text)"]), ("2", []), ("3", ["a", "b"])])
    ['test 1: not used: T1 (it holds text)', 'test 3: a', 'test 3: b']
    >>> by_tests([("1", ["a"]), ("2", ["a"])])
    ['every test: a']
    """
    tests: dict[str, list[str]] = {}
    names = []
    for name, lines in messages:
        names.append(name)
        for line in lines:
            tests.setdefault(line, []).append(name)
    return [f"{_whose(found, names)}: {line}" for line, found in tests.items()]


def _whose(tests: Sequence[str], names: Sequence[str]) -> str:
    if len(tests) == len(names) > 1:
        return "every test"
    more = f" and {len(tests) - MOST_TESTS} more" if len(tests) > MOST_TESTS else ""
    plural = "s" if len(tests) > 1 else ""
    return f"test{plural} {', '.join(tests[:MOST_TESTS])}{more}"


Status: TypeAlias = Literal["done", "failed", "discarded"]
Value: TypeAlias = str | float | int | bool | None
CurveKind: TypeAlias = Literal[
    "time", "threshold", "psd", "gain", "gain_root", "phase", "coherence",
    "multiple_coherence", "psd_ratio", "sweep", "sweep_phase", "sweep_harmonic", "level",
    "harmonics", "notch", "notch_psd",
]  # fmt: skip


SURFACE_STEPS: Final = 32
"""Steps of the levels of a spectrogram, each a letter and a colour."""


@dataclass(frozen=True, slots=True)
class FlagSummary:
    """Something odd about a run.

    Attributes
    ----------
    kind : str
        What kind of thing, such as ``clipping`` or ``incomplete``.
    channel : str
        Channel it concerns; empty for the run.
    message : str
        A sentence: what was seen and what it may mean.
    unusable : bool
        Whether the channel did not measure, so that the run takes no part in trends.
    """

    kind: str
    channel: str
    message: str
    unusable: bool = False


@dataclass(frozen=True, slots=True)
class PeakSummary:
    """One peak of a spectrum.

    Attributes
    ----------
    frequency_hz : float
        Interpolated between bins [Hz].
    bin_hz : float
        Middle of the tallest bin [Hz].
    height : float
        Value in that bin.
    natural_frequency_hz : float or None
        Natural frequency of the mode that makes the peak [Hz].
    damping_ratio, damping_low, damping_high : float or None
        Damping ratio and its 95 % interval [-]; None where it is withheld.
    quality : float or None
        Quality factor [-].
    damping_bin_hz : float or None
        Bin width of the spectra that the damping was read from [Hz].
    why_not : str
        Why the damping is withheld.
    coherence : float or None
        Coherence with the control in that bin [-].
    fitted_height : float or None
        Height by the fit, the window's leakage taken away.
    resolved : bool
        Whether the bins resolve the peak; `height` is too low where they do not.
    shape : mapping
        How the responses of its quantity move there, by channel: real and imaginary part over
        the channel of the peak [-].
    """

    frequency_hz: float
    bin_hz: float
    height: float
    natural_frequency_hz: float | None
    damping_ratio: float | None
    damping_low: float | None
    damping_high: float | None
    quality: float | None
    damping_bin_hz: float | None
    why_not: str
    coherence: float | None
    fitted_height: float | None = None
    resolved: bool = True
    shape: Mapping[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class SweptPeak:
    """The tallest point of a swept response.

    Attributes
    ----------
    direction : str
        ``up`` or ``down``.
    frequency_hz, gain : float
        Where it is [Hz], and fundamental over control there, in shown units.
    natural_frequency_hz, damping_ratio : float or None
        Of the mode behind it [Hz] [-]; None where no linear mode fits.
    steady_hz, steady_gain : float or None
        Where a sweep slow enough would have its peak [Hz], and how tall.
    damping_low, damping_high : float or None
        95 % interval of the damping ratio [-].
    """

    direction: str
    frequency_hz: float
    gain: float
    natural_frequency_hz: float | None = None
    damping_ratio: float | None = None
    steady_hz: float | None = None
    steady_gain: float | None = None
    damping_low: float | None = None
    damping_high: float | None = None


@dataclass(frozen=True, slots=True)
class ChannelSummary:
    """One channel of a run.

    Attributes
    ----------
    name, role, unit, at : str
        What it is; the unit is that of tables and figures.
    mean, rms, minimum, maximum, crest_factor, kurtosis : float or None
        Statistics of the crop.
    band_rms : float or None
        Rms within the excited band, from the spectrum.
    coherence : float or None
        Mean coherence with the control within the excited band [-].
    psd_peaks, response_peaks : tuple of PeakSummary
        Tallest first: of the density, and of the response function.
    swept_peaks : tuple of SweptPeak
        Of a sweep, one for each way.
    """

    name: str
    role: str
    unit: str
    at: str
    mean: float | None
    rms: float | None
    minimum: float | None
    maximum: float | None
    crest_factor: float | None
    kurtosis: float | None
    band_rms: float | None
    coherence: float | None
    psd_peaks: tuple[PeakSummary, ...] = ()
    response_peaks: tuple[PeakSummary, ...] = ()
    swept_peaks: tuple[SweptPeak, ...] = ()


@dataclass(frozen=True, slots=True)
class CurveSummary:
    """A curve thinned for the screen, its extremes kept.

    Attributes
    ----------
    kind : CurveKind
        Which figure it belongs to.
    channel : str
        Whose it is.
    x, y : tuple of float
        Points; None breaks the line.
    low : tuple of float
        Lower edge, where the curve is an envelope and `y` its upper edge.
    part : str
        Which of several of one channel: ``up``, ``down``, ``before``, ``after``.
    """

    kind: CurveKind
    channel: str
    x: tuple[float, ...]
    y: tuple[float | None, ...]
    low: tuple[float | None, ...] = ()
    part: str = ""


@dataclass(frozen=True, slots=True)
class SurfaceSummary:
    """A spectrogram in fewer cells: of those that are one, the largest value.

    Attributes
    ----------
    channel, unit : str
        Whose it is, and the unit of the density.
    time_s, frequency_hz : (float, float)
        First and last [s] [Hz].
    low_db, high_db : float
        Levels of the first and the last step [dB re 1 unit].
    rows : tuple of str
        From the lowest frequency; of each time the step, a letter from A.
    """

    channel: str
    unit: str
    time_s: tuple[float, float]
    frequency_hz: tuple[float, float]
    low_db: float
    high_db: float
    rows: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class SpectrumSummary:
    """How the spectra of a run were made, and their random error.

    Attributes
    ----------
    segment, overlap, n_segments : int
        Samples of a segment, samples shared with the next, number of segments.
    window, detrend : str
        Window, and what mean was removed.
    bin_width_hz, resolution_hz : float
        Distance of the bins and their noise bandwidth [Hz].
    degrees_of_freedom : float
        Of each PSD value.
    low_factor, high_factor : float, optional
        The 95 % bounds of a PSD value, as multiples of it; None of blows.
    band_hz : tuple of float
        Excited band [Hz].
    """

    segment: int
    overlap: int
    n_segments: int
    window: str
    detrend: str
    bin_width_hz: float
    resolution_hz: float
    degrees_of_freedom: float
    low_factor: float | None
    high_factor: float | None
    band_hz: tuple[float, float]


@dataclass(frozen=True, slots=True)
class ControlSummary:
    """How well the mean control kept to its demand: a density, or a level along a sweep.

    Attributes
    ----------
    demanded : float
        Density or amplitude, in the shown unit.
    alarm_db, abort_db : float
        Limits of the log, either way [dB].
    beyond_alarm : float
        Share of the band or the sweep that lies beyond the alarm limit, chance allowed for [-].
    worst_db, worst_hz : float
        Largest departure [dB], and where it is [Hz].
    kept : bool
        Whether next to nothing is beyond the alarm limit and nothing beyond the abort limit.
    """

    demanded: float
    alarm_db: float
    abort_db: float
    beyond_alarm: float
    worst_db: float
    worst_hz: float
    kept: bool


@dataclass(frozen=True, slots=True)
class LineSummary:
    """A line of a figure of an analysis, thinned: see `shakerproc.runs.panels.Line`."""

    label: str
    x: tuple[float, ...]
    y: tuple[float | None, ...]
    channel: str
    look: Look
    style: int = 0


@dataclass(frozen=True, slots=True)
class PanelSummary:
    """A figure of an analysis: see `shakerproc.runs.panels.Panel`."""

    title: str
    caption: str
    x: PanelScale
    y: PanelScale
    lines: tuple[LineSummary, ...]
    equal: bool = False


@dataclass(frozen=True, slots=True)
class AnalysisSummary:
    """Summary of an analysis that the log asks for.

    Attributes
    ----------
    kind, title : str
        Key in the log, and name for people.
    rows : tuple of mapping
        The rows of its table in a batch, by header with units.
    told : tuple of str
        Sentences for people.
    panels : tuple of PanelSummary
        Figures.
    """

    kind: str
    title: str
    rows: tuple[Mapping[str, Value], ...]
    told: tuple[str, ...]
    panels: tuple[PanelSummary, ...]


@dataclass(frozen=True, slots=True)
class RunSummary:
    """One test of the log and its result.

    Attributes
    ----------
    test : str
        Its id in the log.
    status : Status
        Whether it was processed.
    facts : mapping
        What the log says of it, the columns of every table: joint, specimen, clearance_m, ...
    recording, sha256 : str
        The file, as the log names it, and its hash.
    error, detail : str
        Why it failed, and the traceback where there is one.
    sample_rate_hz, duration_s, promised_s : float or None
        Of the recording; `promised_s` only where it is incomplete.
    crop_s : tuple of float or None
        Start and stop of what was processed [s].
    measured_level : float or None
        What the control channels saw, in the unit of the demanded level.
    level_unit : str
        That unit.
    alarm : tuple of float or None
        Limits that the density of the control should keep, in that unit.
    control : ControlSummary or None
        How well the control kept its limits; None where none are demanded, or nothing is seen.
    notes : tuple of str
        What the reader had to decide, and what cannot be computed, a sentence each.
    unused : tuple of UnusedChannel
        Channels of the file that nothing is made of.
    analyses : tuple of AnalysisSummary
        What else the log asks for.
    events : tuple of (float, str)
        When something happened [s], and what.
    surface : SurfaceSummary or None
        Spectrogram, where the log asks for it on the page.
    """

    test: str
    status: Status
    facts: Mapping[str, Value] = field(default_factory=dict)
    recording: str = ""
    sha256: str = ""
    error: str = ""
    detail: str = ""
    sample_rate_hz: float | None = None
    duration_s: float | None = None
    promised_s: float | None = None
    start_time: str = ""
    crop_s: tuple[float, float] | None = None
    measured_level: float | None = None
    level_unit: str = ""
    alarm: tuple[float, float] | None = None
    control: ControlSummary | None = None
    spectrum: SpectrumSummary | None = None
    channels: tuple[ChannelSummary, ...] = ()
    flags: tuple[FlagSummary, ...] = ()
    curves: tuple[CurveSummary, ...] = ()
    notes: tuple[str, ...] = ()
    unused: tuple[UnusedChannel, ...] = ()
    analyses: tuple[AnalysisSummary, ...] = ()
    events: tuple[tuple[float, str], ...] = ()
    surface: SurfaceSummary | None = None

    @property
    def incomplete(self) -> bool:
        """Whether the recording was cut short."""
        return self.promised_s is not None

    @property
    def remarks(self) -> tuple[str, ...]:
        """Lines for people: the notes, and which channels are not used."""
        return (*self.notes, *unused_lines(self.unused))

    @property
    def unusable(self) -> tuple[FlagSummary, ...]:
        """Message on channels that did not measure."""
        return tuple(flag for flag in self.flags if flag.unusable)

    @property
    def left_out(self) -> str:
        """Why the test takes no part in trends, in a sentence; empty where it does."""
        why = dict.fromkeys(f"{f.channel} {FAULTS.get(f.kind, f.kind)}" for f in self.unusable)
        return f"test {self.test} takes no part in trends: {', '.join(why)}" if why else ""

    @property
    def status_text(self) -> str:
        """Status of the test, for people: how much of a recording that was cut short."""
        if self.promised_s is None or self.duration_s is None:
            return self.status
        return f"incomplete, {self.duration_s:.2f} of {self.promised_s:.2f} s"


def write_summary(path: Path, summary: RunSummary) -> None:
    """Write a summary as JSON, whole or not at all."""
    files.write_bytes(path, to_json(summary, inf_nan_mode="null"))


def read_summary(path: Path) -> RunSummary:
    """Return a summary that `write_summary` wrote."""
    return _form().validate_json(path.read_bytes())


@cache
def _form() -> "TypeAdapter[RunSummary]":
    from pydantic import TypeAdapter  # what only writes summaries needs none

    return TypeAdapter(RunSummary)
