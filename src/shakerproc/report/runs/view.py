"""One run as the report shows it: a line of facts, flags, drawings, tables."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from shakerproc.campaign import trends
from shakerproc.numerals import numeral
from shakerproc.report.figures.units import USUAL, ShownUnits
from shakerproc.report.page.sections import PageFigure, filled
from shakerproc.report.runs import analyses
from shakerproc.report.runs.drawing import marked, page_figures
from shakerproc.report.runs.in_units import words_of
from shakerproc.runs import peak_rows
from shakerproc.runs.summary import (
    AnalysisSummary,
    ChannelSummary,
    FlagSummary,
    RunSummary,
)
from shakerproc.runs.tables import heading, shown_cell


@dataclass(frozen=True, slots=True)
class AnalysisView:
    """An analysis that the log asks for, as rows of text and sentences."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    told: Sequence[str]
    paper: bool


@dataclass(frozen=True, slots=True)
class RunView:
    """One run, ready for the page."""

    test: str
    anchor: str
    status: str
    title: str
    facts: str
    error: str
    detail: str
    flags: Sequence[FlagSummary]
    figures: Sequence[PageFigure]
    not_printed: str
    channel_columns: Sequence[str]
    channels: Sequence[Sequence[str]]
    peaks_of: str
    peak_columns: Sequence[str]
    peaks: Sequence[Sequence[str]]
    spectrum: str
    withheld: Sequence[str]
    remarks: Sequence[str]
    analyses: Sequence[AnalysisView]
    recording: str
    sha256: str


CHANNEL_COLUMNS: Final = (
    "channel", "role", "rms in band", "largest", "crest factor", "kurtosis", "coherence",
    "peak frequency [Hz]",
)  # fmt: skip

PEAK_COLUMNS: Final = tuple(name.replace("zeta", "ζ") for name in peak_rows.COLUMNS)


def run_view(run: RunSummary, number: int, units: ShownUnits = USUAL) -> RunView:
    """Return a run, whose numbers are in these units, as the page shows it.

    `number` makes its anchor.
    """
    rows = peak_rows.peak_rows(run)
    further = [marked(drawing, run) for drawing in analyses.page_figures(run)]
    channels = filled("", CHANNEL_COLUMNS, [_channel_row(c, run) for c in run.channels])
    return RunView(
        test=run.test,
        anchor=f"run-{number}",
        status=run.status,
        title=units.text(_title(run), words_of(run)),
        facts=units.text(_facts(run), words_of(run)),
        error=run.error,
        detail=run.detail,
        flags=run.flags,
        figures=[*page_figures(run), *further],
        not_printed=_not_printed(run),
        channel_columns=channels.columns,
        channels=channels.rows,
        spectrum=_spectrum_note(run),
        peaks_of=peak_rows.quantity_of(run),
        peak_columns=PEAK_COLUMNS,
        peaks=[[_cell(value) for value in row.cells] for row in rows],
        withheld=tuple(
            filter(None, (peak_rows.unresolved(run, rows), *peak_rows.withheld(rows)))
        ),
        remarks=run.remarks,
        analyses=[_analysis_view(one, run) for one in run.analyses],
        recording=run.recording,
        sha256=run.sha256,
    )


def _not_printed(run: RunSummary) -> str:
    """Return which tables and figures the printed page leaves out, in a sentence."""
    titles = ", ".join(
        one.title
        for one in run.analyses
        if (one.panels or one.rows) and not analyses.is_printed(one.kind, run)
    )
    return (
        f"Figures and tables in the folder of the run and on the page: {titles}."
        if titles
        else ""
    )


def _analysis_view(one: AnalysisSummary, run: RunSummary) -> AnalysisView:
    named = list(one.rows[0]) if one.rows else []
    names = [name for name in named if any(row.get(name) is not None for row in one.rows)]
    rows = [[_cell(shown_cell(name, row.get(name))) for name in names] for row in one.rows]
    columns, paper = (
        [heading(name) for name in names],
        analyses.is_printed(one.kind, run),
    )
    return AnalysisView(one.title, columns, rows, one.told, paper)


def _title(run: RunSummary) -> str:
    names = ("specimen", "joint", "clearance_m", "orientation", "excitation", "level")
    told = (trends.shown(name, run.facts.get(name)) for name in names)
    return ", ".join((f"Test {run.test}", *filter(None, told)))


def _facts(run: RunSummary) -> str:
    parts = []
    if run.duration_s is not None:
        length = f"{run.duration_s:.6g} s"
        if run.promised_s is not None:
            length = (
                f"INCOMPLETE: {numeral(run.duration_s, 4)} of {numeral(run.promised_s, 4)} s"
            )
        parts.append(f"{length} at {run.sample_rate_hz:.6g} Hz")
    if run.crop_s is not None:
        parts.append(f"processed {run.crop_s[0]:.3f} to {run.crop_s[1]:.3f} s")
    if run.measured_level is not None:
        parts.append(f"measured level {numeral(run.measured_level, 4)} {run.level_unit}")
    actual = run.facts.get("actual_clearance_m")
    if actual is not None:
        parts.append(f"actual clearance {trends.shown('actual_clearance_m', actual)}")
    if run.start_time:
        parts.append(f"started {run.start_time}")
    comment = run.facts.get("comment")
    return "; ".join((*parts, *([str(comment)] if comment else [])))


def _spectrum_note(run: RunSummary) -> str:
    s = run.spectrum
    if s is None:
        return ""
    bounds = (
        f": 95 % bounds of a PSD value × {s.low_factor:.2f} to × {s.high_factor:.2f}"
        if s.low_factor is not None and s.high_factor is not None
        else ""
    )
    return (
        f"Spectra: {s.segment} samples {s.window}, overlap {s.overlap}, {s.n_segments} "
        f"segments, bins {numeral(s.bin_width_hz, 4)} Hz apart (noise bandwidth "
        f"{numeral(s.resolution_hz, 4)} Hz), {s.degrees_of_freedom:.0f} degrees of "
        f"freedom{bounds}. Excited band {s.band_hz[0]:g} to {s.band_hz[1]:g} "
        f"Hz.{_finer_note(run)}"
    )


def _finer_note(run: RunSummary) -> str:
    """Return which dampings come from finer bins than the other numbers."""
    told = [
        f"{row.channel.name} at {numeral(row.peak.frequency_hz, 4)} Hz from bins of "
        f"{numeral(row.peak.damping_bin_hz)} Hz"
        for row in peak_rows.peak_rows(run)
        if row.peak.damping_ratio is not None
        and row.peak.damping_bin_hz is not None
        and run.spectrum is not None
        and row.peak.damping_bin_hz < 0.99 * run.spectrum.bin_width_hz
    ]
    return f" Damping of {', '.join(told)}." if told else ""


def number(value: float | None, form: str = ".4g") -> str:
    """Return a number for people, nothing for None. `value` may be in any unit."""
    return "" if value is None else format(value, form)


def _channel_row(channel: ChannelSummary, run: RunSummary) -> list[str]:
    is_control = channel.role == "control"
    peak = None if is_control else trends.main_peak(run, channel.name)
    largest = max(
        (abs(v) for v in (channel.minimum, channel.maximum) if v is not None), default=None
    )
    return [
        channel.name,
        channel.role,
        f"{number(channel.band_rms)} {channel.unit}",
        f"{number(largest)} {channel.unit}",
        number(channel.crest_factor, ".3g"),
        number(channel.kurtosis, ".3g"),
        number(channel.coherence, ".3f"),
        number(peak.frequency_hz, ".1f") if peak else "",
    ]


def _cell(value: object) -> str:
    return number(value) if isinstance(value, float) else str(value or "")
