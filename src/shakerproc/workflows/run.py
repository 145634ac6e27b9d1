"""A recording in a notebook, and one processed: `shakerproc process`."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Final, Unpack, final

from shakerproc import files, recordings
from shakerproc.campaign import tables
from shakerproc.campaign.jobs import SUMMARY, Products, input_of
from shakerproc.campaign.result_folder import (
    SINGLE,
    check_folder,
    check_result_folder,
    locked,
    put_in_place,
)
from shakerproc.data import Channel, Recording
from shakerproc.errors import ArgumentError
from shakerproc.numerals import numeral
from shakerproc.recordings.raw import AS_STATED
from shakerproc.runs import (
    RunResult,
    RunSummary,
    UnitOption,
    open_path,
    process_recording,
    summary_of,
    write_summary,
)
from shakerproc.runs.result import shown_unit
from shakerproc.runs.tables import spectra_columns, spelled
from shakerproc.testlog import Processing, Test, facts_of
from shakerproc.workflows.arguments import (
    AnyPath,
    argument_text,
    choice_of,
    file_of,
    list_of,
    number_of,
    path_of,
    switch_of,
    text_of,
)
from shakerproc.workflows.processing_options import Options, described, sampling_of, unit_of
from shakerproc.workflows.shown import Shown, frame, frame_of_rows, html
from shakerproc.workflows.worker import title_of, write_products

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class OpenedRecording(Shown):
    """Contents of a recording; its file is opened, and closed, whenever samples are read.

    Attributes
    ----------
    path : Path
        The file.
    channels : tuple of Channel
        Its channels, with their units in SI.
    sample_rate : float
        Samples per second [Hz].
    n_samples : int
        Samples of each channel.
    notes : tuple of str
        What the reader had to decide, a sentence each.
    group : str, optional
        Group of a file of several.
    said : Sampling
        What was said of its times.
    """

    path: Path
    channels: tuple[Channel, ...]
    sample_rate: float
    n_samples: int
    notes: tuple[str, ...] = ()
    group: str | None = None
    said: recordings.Sampling = AS_STATED

    @property
    def duration(self) -> float:
        """Length [s]."""
        return self.n_samples / self.sample_rate

    def to_pandas(self, start_s: float = 0.0, stop_s: float | None = None) -> "DataFrame":
        """Return the samples of every channel, accelerations in g, the others in SI units.

        Parameters
        ----------
        start_s, stop_s : float
            Part of the recording, to the nearest sample; by default all of it [s].

        Returns
        -------
        DataFrame
            A column ``time_s`` and one for each channel, which says its unit at its end.

        Raises
        ------
        ArgumentError
            If the part is empty.
        RecordingError
            If the file cannot be read any more.
        """
        start = round(number_of("start_s", start_s) * self.sample_rate)
        end = self.duration if stop_s is None else number_of("stop_s", stop_s)
        stop = min(round(end * self.sample_rate), self.n_samples)
        if not start < stop:
            raise ArgumentError(
                "start_s", f"nothing between {start_s:g} s and {min(end, self.duration):g} s"
            )
        with self._opened() as recording:
            samples = recording.samples(start, stop)
        import numpy as np

        columns = {"time_s": np.arange(start, stop) / self.sample_rate}
        for channel, row in zip(self.channels, samples, strict=True):
            unit, factor = shown_unit(channel.unit)
            columns[f"{channel.name}{spelled(unit)}"] = row * factor
        return frame(columns)

    def plot(self) -> "Figure":
        """Return every channel against time, as the extremes of each moment."""
        from shakerproc.report.runs.drawing import time_signals

        with self._opened() as recording:
            return time_signals(recording)

    def _opened(self) -> "Recording":
        return recordings.open_recording(
            self.path, part=recordings.FilePart(self.group), sample_rate=self.said
        )

    def _repr_html_(self) -> str:
        rows = [(c.name, c.unit, c.source_unit or "none") for c in self.channels]
        text = (
            f"{numeral(self.duration, 4)} s at {self.sample_rate:.6g} Hz, {self.n_samples} "
            "samples"
        )
        table = frame_of_rows(("channel", "unit", "unit in the file"), rows)
        return html(self.path.name, [text, *self.notes], table)


def open_recording(
    path: AnyPath,
    *,
    group: str | None = None,
    sample_rate_hz: float | None = None,
    override_rate: bool = False,
    time_unit: str | None = None,
    resample_hz: float | None = None,
    ignore_starts: bool = False,
) -> OpenedRecording:
    """Return the contents of a recording: channels, units, sample rate, length.

    Parameters
    ----------
    path : path
        The file, whose ending says the format: one that shakerproc reads, such as TDMS, CSV,
        MAT, UFF 58, WAV or HDF5, or what an installed reader knows.
    group : str, optional
        Group of a file of several.
    sample_rate_hz : float, optional
        Where the file does not say it, or `override_rate` [Hz].
    override_rate : bool
        Whether `sample_rate_hz` counts although the file states another.
    time_unit : str, optional
        Unit of times in the file that state none, such as ``ms``.
    resample_hz : float, optional
        Rate of the even times that every channel is interpolated to [Hz].
    ignore_starts : bool
        Whether all channels start together, whatever the file states.

    Raises
    ------
    ArgumentError
        If `path` is no path of a file.
    RecordingError
        If the file cannot be used.
    """
    given = file_of("path", path, "a recording")
    group = None if group is None else text_of("group", group, "the name of a group")
    said = sampling_of(
        sample_rate_hz,
        override_rate=switch_of("override_rate", override_rate),
        time_unit=None if time_unit is None else text_of("time_unit", time_unit, "a unit"),
        resample_hz=resample_hz,
        ignore_starts=switch_of("ignore_starts", ignore_starts),
    )
    with recordings.open_recording(
        given, part=recordings.FilePart(group), sample_rate=said
    ) as opened:
        return OpenedRecording(
            given,
            opened.channels,
            opened.sample_rate,
            opened.n_samples,
            opened.notes,
            group,
            said,
        )


_USUAL: Final = ("psd_and_response", "psd")
"""Figures of a run where none is asked for: the first that it has."""


@final
@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Run(Shown):
    """One recording processed.

    Attributes
    ----------
    result : RunResult
        Arrays in SI units: crop, spectra, response functions, coherence, peaks.
    summary : RunSummary
        Numbers in the units that tables show, flags and remarks.
    """

    result: RunResult
    summary: RunSummary

    def to_pandas(self) -> "DataFrame":
        """Return densities, response functions and coherences against frequency.

        Every column says its unit at its end; as spectra.csv of the command.
        """
        return frame(spectra_columns(self.result))

    @property
    def peaks(self) -> "DataFrame":
        """Peaks of every channel, with damping where it can be read; as peaks.csv."""
        return frame(tables.peak_columns([self.summary]))

    @property
    def statistics(self) -> "DataFrame":
        """Rms, extremes and crest factor of every channel; as statistics.csv."""
        return frame(tables.statistics_columns([self.summary]))

    @property
    def analyses(self) -> dict[str, "DataFrame"]:
        """Tables of the analyses that the log asks for, by their kinds."""
        return {
            kind: frame(tables.analysis_columns([self.summary], kind))
            for kind in tables.kinds_of_analysis([self.summary])
        }

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of the figures that `plot` may draw; those that a run lacks are told."""
        from shakerproc.report.runs.figures import IN_FILES

        return IN_FILES

    def plot(self, figure: str = "") -> "Figure":
        """Return a figure of the run.

        Parameters
        ----------
        figure : str
            One of `figures`; by default density and response function, or the density alone
            where nothing is set against a control.

        Raises
        ------
        ArgumentError
            If there is no such figure, or this run has not got it.
        """
        from shakerproc.report.runs.drawing import run_figure
        from shakerproc.report.runs.figures import IN_FILES

        asked = text_of("figure", figure, "the name of a figure")
        chosen = (choice_of("figure", asked, IN_FILES, "a figure"),) if asked else _USUAL
        title = title_of(self.result.test, self.result.recorded.run)
        for name in chosen:
            drawn = run_figure(self.result, name, title)
            if drawn is not None:
                return drawn
        raise ArgumentError("figure", f"this run has no {figure}: it lacks what is drawn there")

    def _repr_html_(self) -> str:
        summary = self.summary
        rate, length = summary.sample_rate_hz or 0.0, summary.duration_s or 0.0
        text = f"{summary.recording}: {numeral(length, 4)} s at {rate:.6g} Hz"
        flags = [f"{flag.kind}: {flag.message}" for flag in summary.flags]
        return html(f"Run {summary.test}", [text, *flags, *summary.remarks], self.statistics)


def process(
    recording: OpenedRecording | Test | AnyPath,
    *,
    controls: Sequence[str] | None = None,
    unit: str | None = None,
    override_unit: bool = False,
    out: AnyPath | None = None,
    figures: bool = True,
    **options: Unpack[Options],
) -> Run:
    """Return one recording processed: crop, spectra, responses, peaks, flags.

    Parameters
    ----------
    recording : OpenedRecording, Test or path
        What `open_recording` returned, a test of a log (``log.find(3)``), or a file. Without
        a log, channels take the roles that the command gives them.
    controls : sequence of str, optional
        Names or numbers of the control channels, all others being responses; an empty one for
        none. Not with a test, whose log says it.
    unit : str, optional
        Unit of channels that say none, such as ``g``.
    override_unit : bool
        Whether `unit` counts where the file says another.
    out : path, optional
        Folder to write tables and figures into; nothing is written without it.
    figures : bool
        Whether to write figures too, where `out` is given.
    **options
        See `Options`: excitation, level, band, crop, averaging.

    Returns
    -------
    Run
        Tables, figures and arrays.

    Raises
    ------
    ArgumentError
        If an argument cannot be used.
    ShakerprocError
        If the recording cannot be used, in the sentence that the command prints.
    """
    path, test = _what(recording)
    if controls is not None and test.recording is not None:
        raise ArgumentError("controls", "the log says which channels are controls")
    named = None if controls is None else list_of("controls", controls, "channels")
    return process_file(
        path,
        described(test, options),
        controls=None if named is None else tuple(map(str, named)),
        unit=unit_of(unit, override=switch_of("override_unit", override_unit)),
        out=None if out is None else path_of("out", out, "a folder"),
        products=Products(switch_of("figures", figures)),
    )


def _what(given: object) -> tuple[Path, Test]:
    """Return the file of a recording, and its metadata.

    Raises
    ------
    ArgumentError
        If it is no recording.
    """
    if isinstance(given, Test):
        return given.require_recording(), given
    if isinstance(given, OpenedRecording):
        said = given.said
        processing = Processing(
            group=given.group, sample_rate=said.rate, override_rate=said.override,
            time_unit=said.unit, resample=said.resample, ignore_starts=said.ignore_starts,
        )  # fmt: skip
        return given.path, Test(id=given.path.stem, processing=processing)
    if isinstance(given, Recording):
        raise ArgumentError(
            "recording", "expected what open_recording(path) returns, or its path"
        )
    if not isinstance(given, (str, PathLike)):
        raise ArgumentError(
            "recording",
            "expected what open_recording(path) returns, a test of a log, or the path of a "
            f"recording, got {argument_text(given)}",
        )
    path = file_of("recording", given, "a recording")
    return path, Test(id=path.stem)


def process_file(
    path: Path,
    test: Test,
    *,
    controls: tuple[str, ...] | None = None,
    unit: UnitOption | None = None,
    out: Path | None = None,
    products: Products | None = None,
    pictured: bool = True,
) -> Run:
    """Return one recording processed; where `out` is given, its results are put there.

    Parameters
    ----------
    path : Path
        The recording.
    test : Test
        What is known of it.
    controls : tuple of str, optional
        Its control channels; empty for none.
    unit : UnitOption, optional
        Unit of channels that say none.
    out : Path, optional
        Folder of its results: of this recording alone, all of one run.
    products : Products, optional
        What is written there.
    pictured : bool
        Whether figures are drawn, here or from the result.

    Raises
    ------
    ShakerprocError
        If the recording cannot be used, or the folder holds the results of another.
    """
    if out is not None:
        check_result_folder(out, SINGLE)
    with open_path(path, test, controls=controls, unit=unit) as opened:
        first = "" if opened.file is None else opened.file.first_sha256()
        if out is not None:
            check_folder(out, first)  # before the work, and once nobody else can write there
        result = process_recording(opened, test, pictured=pictured)
        if out is not None:
            return _put(out, result, opened, path, products or Products())
        return Run(result, _summary(result, path, opened.sha256()))


def _summary(result: RunResult, path: Path, digest: str) -> RunSummary:
    test = result.test
    return summary_of(result, str(test.id), facts_of(test), path.name, digest)


def _put(
    out: Path, result: RunResult, opened: Recording, path: Path, products: Products
) -> Run:
    """Write the results of a run into its folder, in place of those of an earlier one."""
    first = "" if opened.file is None else opened.file.first_sha256()
    with locked(out), files.staged(out) as staged:
        check_folder(out, first)
        write_products(result, opened, staged, products)
        digest = opened.sha256()
        summary = _summary(result, path, digest)
        files.write_csv(staged / "peaks.csv", tables.peak_columns([summary]))
        files.write_csv(staged / "statistics.csv", tables.statistics_columns([summary]))
        for kind in tables.kinds_of_analysis([summary]):
            columns = tables.analysis_columns([summary], kind)
            files.write_csv(staged / f"{kind}.csv", columns)
        write_summary(staged / SUMMARY, summary)
        put_in_place(out, staged, digest, [input_of(result.test), asdict(products)])
    return Run(result, summary)
