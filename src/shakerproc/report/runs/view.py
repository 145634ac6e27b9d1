"""Runs as the report shows them: the front with the table of all, and one run by itself."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from markupsafe import Markup

from shakerproc.campaign import trends
from shakerproc.numerals import numeral
from shakerproc.report.figures import to_svg
from shakerproc.report.figures.figure import Axis
from shakerproc.report.figures.units import USUAL, ShownUnits
from shakerproc.report.page.sections import PageFigure, ReportTable, filled
from shakerproc.report.runs import analyses
from shakerproc.report.runs.drawing import marked, page_figures
from shakerproc.report.runs.in_units import words_of
from shakerproc.runs import tables
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

PEAK_COLUMNS: Final = tuple(name.replace("zeta", "ζ") for name in tables.COLUMNS)


def run_view(run: RunSummary, number: int, units: ShownUnits = USUAL) -> RunView:
    """Return a run, whose numbers are in these units, as the page shows it.

    `number` makes its anchor.
    """
    rows = tables.peak_rows(run)
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
        peaks_of=tables.quantity_of(run),
        peak_columns=PEAK_COLUMNS,
        peaks=[[_cell(value) for value in row.cells] for row in rows],
        withheld=tuple(filter(None, (tables.unresolved(run, rows), *tables.withheld(rows)))),
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
    facts = (trends.shown(name, run.facts.get(name)) for name in names)
    return ", ".join((f"Test {run.test}", *filter(None, facts)))


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
    sentences = [
        f"{row.channel.name} at {numeral(row.peak.frequency_hz, 4)} Hz from bins of "
        f"{numeral(row.peak.damping_bin_hz)} Hz"
        for row in tables.peak_rows(run)
        if row.peak.damping_ratio is not None
        and row.peak.damping_bin_hz is not None
        and run.spectrum is not None
        and row.peak.damping_bin_hz < 0.99 * run.spectrum.bin_width_hz
    ]
    return f" Damping of {', '.join(sentences)}." if sentences else ""


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


@dataclass(frozen=True, slots=True)
class Count:
    """How many runs are of one kind, and how the page colours the number."""

    number: int
    label: str
    kind: str


@dataclass(frozen=True, slots=True)
class Attention:
    """An observation, and the tests that it was made in, each with its anchor."""

    kind: str
    what: str
    where: str
    message: str
    tests: Sequence[tuple[str, str]] = ()


def tally(runs: Sequence[RunSummary]) -> str:
    """Return how many runs there are and how they went, in one sentence."""
    number = {c.label: c.number for c in counts(runs)}
    wanted = len(runs) - number.get("discarded", 0)
    parts = [f"{number['processed']} of {wanted} tests processed"]
    parts += [
        f"{number[name]} {name}"
        for name in ("failed", "incomplete", "flagged")
        if number.get(name)
    ]
    return ", ".join(parts) + "."


def counts(runs: Sequence[RunSummary]) -> list[Count]:
    """Return how many runs there are of each kind."""
    done = [run for run in runs if run.status == "done"]
    failed = sum(run.status == "failed" for run in runs)
    incomplete = sum(run.incomplete for run in done)
    flagged = sum(bool(run.flags) for run in done)
    discarded = sum(run.status == "discarded" for run in runs)
    return [
        Count(len(done), "processed", "done"),
        Count(failed, "failed", "failed" if failed else "none"),
        Count(incomplete, "incomplete", "odd" if incomplete else "none"),
        Count(flagged, "flagged", "odd" if flagged else "none"),
        Count(discarded, "discarded", "none"),
    ]


def attention(runs: Sequence[RunSummary], views: Sequence[RunView]) -> list[Attention]:
    """Return failed runs, then incomplete ones, then other flags; the same is told once."""
    columns: dict[Attention, list[tuple[str, str]]] = {}
    for run, view in zip(runs, views, strict=True):
        sentences = [Attention("flag", f.kind, f.channel, f.message) for f in run.flags]
        if run.status == "failed":
            sentences.insert(0, Attention("status-failed", "failed", "", run.error))
        for item in sentences:
            columns.setdefault(item, []).append((run.test, view.anchor))
    items = [replace(item, tests=tests) for item, tests in columns.items()]
    return sorted(items, key=lambda item: (item.what != "failed", item.what != "incomplete"))


@dataclass(frozen=True, slots=True)
class TableColumn:
    """A column of the table: its heading, and how it is sorted and filtered."""

    label: str
    numeric: bool
    choice: bool = False


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell: its text, its class, its sort key, its link."""

    shown: str | Markup
    css: str = ""
    order: str | float | None = None
    anchor: str = ""


COLUMNS: Final = (
    TableColumn("test", numeric=True),
    TableColumn("status", numeric=False, choice=True),
    TableColumn("joint", numeric=False, choice=True),
    TableColumn("specimen", numeric=False, choice=True),
    TableColumn("clearance", numeric=True),
    TableColumn("orientation", numeric=False, choice=True),
    TableColumn("excitation", numeric=False, choice=True),
    TableColumn("level", numeric=True),
    TableColumn("measured", numeric=True),
    TableColumn("peak frequency [Hz]", numeric=True),
    TableColumn("Q", numeric=True),
    TableColumn("coherence", numeric=True),
    TableColumn("PSD", numeric=False),
    TableColumn("flags", numeric=False, choice=True),
)


def table(
    runs: Sequence[RunSummary], views: Sequence[RunView], channel: str, units: ShownUnits
) -> tuple[Sequence[TableColumn], list[list[Cell]]]:
    """Return the columns that hold something, and a row of their cells for each run."""
    rows = [_row(run, view, channel, units) for run, view in zip(runs, views, strict=True)]
    kept = [i for i, _ in enumerate(COLUMNS) if not rows or any(row[i].shown for row in rows)]
    return [COLUMNS[i] for i in kept], [[row[i] for i in kept] for row in rows]


def _row(run: RunSummary, view: RunView, channel: str, units: ShownUnits) -> list[Cell]:
    peak = trends.main_peak(run, channel)
    measured = next((c for c in run.channels if c.name == channel), None)
    response = measured.response_peaks[0] if measured and measured.response_peaks else peak
    level = run.facts.get("level_g") or run.facts.get("level_g2_per_hz")
    clearance = run.facts.get("clearance_m")
    return [
        Cell(run.test, "n", anchor=view.anchor),
        Cell(run.status_text, "status-odd" if run.incomplete else f"status-{run.status}"),
        Cell(_shown_fact(run, "joint")),
        Cell(_shown_fact(run, "specimen")),
        Cell(units.text(trends.shown("clearance_m", clearance)), "n", _order(clearance)),
        Cell(_shown_fact(run, "orientation")),
        Cell(_shown_fact(run, "excitation")),
        Cell(_shown_fact(run, "level"), "n", _order(level)),
        Cell(f"{number(run.measured_level)} {run.level_unit}".strip(), "n", run.measured_level),
        _number_cell(peak.frequency_hz if peak else None, ".1f"),
        _number_cell(response.quality if response else None, ".3g"),
        _number_cell(measured.coherence if measured else None, ".3f"),
        Cell(_thumbnail(run, channel)),
        Cell(", ".join(dict.fromkeys(flag.kind for flag in run.flags)), "flag"),
    ]


def _shown_fact(run: RunSummary, name: str) -> str:
    return trends.shown(name, run.facts.get(name) or None)


def _order(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def _number_cell(value: float | None, form: str) -> Cell:
    return Cell(number(value, form), "n", value)


def _thumbnail(run: RunSummary, channel: str) -> Markup:
    curve = next((c for c in run.curves if c.kind == "psd" and c.channel == channel), None)
    if curve is None:
        return Markup("")
    x = np.array(curve.x)
    y = np.array([np.nan if v is None else v for v in curve.y])
    good = y[np.isfinite(y) & (y > 0.0)]
    if not good.size or x.size < 2:
        return Markup("")
    low, high = max(good.min(), 1e-6 * good.max()), good.max()
    return to_svg.sparkline(
        x,
        y,
        Axis("", x[0], x[-1]),
        Axis("", low, max(high, 1.01 * low), logarithmic=True),
    )


def table_note(runs: Sequence[RunSummary], channel: str) -> str:
    """Return the note below the table: whose numbers, which runs the log discards."""
    discarded = ", ".join(
        f"{run.test} ({comment})" if (comment := run.facts.get("comment")) else run.test
        for run in runs
        if run.status == "discarded"
    )
    left_out = f" Discarded in the log: {discarded}." if discarded else ""
    if not channel:
        return left_out.strip()
    return (
        f"Peak frequency, Q, coherence and the drawing are those of channel {channel}; "
        f"every channel is in peaks.csv.{left_out}"
    )


FACTS: Final = ("specimen", "joint", "clearance_m", "orientation", "excitation", "level")


def resonances(runs: Sequence[RunSummary], channel: str) -> ReportTable | None:
    """Return a row for each run: peaks of a channel by frequency, with Q where it was read.

    Of |H1|; of the density where there is no control; of the response functions of blows. None
    without any.
    """
    peaks_by_test = {
        run.test: list(_peaks(run, channel)) for run in runs if run.status == "done"
    }
    most = max(map(len, peaks_by_test.values()), default=0)
    if not most:
        return None
    rows = [
        [
            run.test,
            *(trends.shown(name, run.facts.get(name)) for name in FACTS),
            *(peaks_by_test[run.test] + [""] * most)[:most],
        ]
        for run in runs
        if run.test in peaks_by_test
    ]
    heads = ("test", *(name.removesuffix("_m") for name in FACTS))
    return filled(
        f"Peaks of {channel} [Hz] over its control or force, by frequency; Q in brackets where "
        "it was read. Every peak of every channel is in peaks.csv and resonances.csv.",
        (*heads, *(f"peak {i + 1}" for i in range(most))),
        rows,
    )


def _peaks(run: RunSummary, name: str) -> Iterator[str]:
    """Return the peaks of a channel in a run, by frequency, in words."""
    channel = next((c for c in run.channels if c.name == name), None)
    if channel is None:
        return
    peaks = sorted(_with_quality(run, channel))
    for frequency, quality in peaks:
        yield f"{frequency:.1f}" + (f" ({numeral(quality)})" if quality is not None else "")


def _with_quality(
    run: RunSummary, channel: ChannelSummary
) -> Iterator[tuple[float, float | None]]:
    for peak in channel.response_peaks or channel.psd_peaks:
        yield peak.frequency_hz, peak.quality
    for one in run.analyses:
        for row in one.rows if one.kind == "resonances" else ():
            frequency, damping = row.get("peak_hz"), row.get("damping_percent")
            if str(row.get("function", "")).startswith(f"{channel.name} / ") and isinstance(
                frequency, float
            ):
                yield frequency, 50.0 / damping if isinstance(damping, float) else None
