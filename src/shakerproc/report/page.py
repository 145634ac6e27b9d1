"""The report: one HTML file that opens offline, prints completely and runs nobody's text."""

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Final

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from shakerproc import __version__, files
from shakerproc.report import live, style, svg, trend_view
from shakerproc.report.drawing import Drawing
from shakerproc.report.methods import Methods, methods_of
from shakerproc.report.run_view import RunView, curves_of, number, run_view
from shakerproc.runs import telling, trends
from shakerproc.runs.summary import RunSummary
from shakerproc.runs.trends import Trend


@dataclass(frozen=True, slots=True)
class Table:
    """A table of a further section: cells are text already."""

    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, slots=True)
class Section:
    """A further section of the report, such as the evidence of a diagnosis.

    Attributes
    ----------
    title, anchor : str
        Its heading, and what the navigation calls it.
    paragraphs, tables, figures, parts : sequence
        What it holds, in this order; parts are sections of their own.
    """

    title: str
    anchor: str
    paragraphs: Sequence[str] = ()
    tables: Sequence[Table] = ()
    figures: Sequence[Drawing] = ()
    parts: "Sequence[Section]" = ()


@dataclass(frozen=True, slots=True)
class Report:
    """What a report is made of.

    Attributes
    ----------
    title : str
        Of the campaign.
    runs : sequence of RunSummary
        Every test of the log, in its order.
    trends : sequence of Trend
        What moves with what.
    channel : str
        Response channel that trends and the table of runs show.
    command : str
        How it was made.
    options : mapping
        Options that differ from the defaults.
    verdict : str
        Sentence to put before the trend's own.
    sections : sequence of Section
        What comes between the trends and the runs.
    without_points : sequence of str
        Titles of trends for which the log has not two values with a run.
    inputs : sequence of (str, str, str)
        Further files that went in: what they are, their names and their SHA-256.
    methods : Methods, optional
        What was done; by default what the runs tell.
    """

    title: str
    runs: Sequence[RunSummary]
    trends: Sequence[Trend] = ()
    channel: str = ""
    command: str = ""
    options: Mapping[str, str] = field(default_factory=dict)
    verdict: str = ""
    sections: Sequence[Section] = ()
    without_points: Sequence[str] = ()
    inputs: Sequence[tuple[str, str, str]] = ()
    methods: Methods | None = None


@dataclass(frozen=True, slots=True)
class _Count:
    number: int
    label: str
    kind: str


@dataclass(frozen=True, slots=True)
class _Attention:
    kind: str
    what: str
    where: str
    message: str
    tests: Sequence[tuple[str, str]] = ()


@dataclass(frozen=True, slots=True)
class _Column:
    label: str
    numeric: bool
    choice: bool = False


@dataclass(frozen=True, slots=True)
class _Cell:
    shown: str | Markup
    css: str = ""
    order: str | float | None = None
    anchor: str = ""


@dataclass(frozen=True, slots=True)
class _Page:
    title: str
    made: str
    verdict: str
    counts: Sequence[_Count]
    attention: Sequence[_Attention]
    columns: Sequence[_Column]
    rows: Sequence[Sequence[_Cell]]
    table_note: str
    trends: Sequence[Drawing]
    not_drawn: str
    sections: Sequence[Section]
    runs: Sequence[RunView]
    methods: Sequence[str]
    references: Sequence[str]
    provenance: Sequence[str]
    inputs: Sequence[tuple[str, str, str]]
    with_runs: bool
    channel: str


UPLOT: Final = "1.6.32"
"""Version of the script that draws on top of the figures (docs/decisions/0011)."""

LOOK: Final = {"colours": style.COLOURS, "dashes": style.DASHES, "markers": svg.MARKERS}

COLUMNS: Final = (
    _Column("test", numeric=True),
    _Column("status", numeric=False, choice=True),
    _Column("joint", numeric=False, choice=True),
    _Column("specimen", numeric=False, choice=True),
    _Column("clearance", numeric=True),
    _Column("orientation", numeric=False, choice=True),
    _Column("excitation", numeric=False, choice=True),
    _Column("level", numeric=True),
    _Column("measured", numeric=True),
    _Column("peak frequency [Hz]", numeric=True),
    _Column("Q", numeric=True),
    _Column("coherence", numeric=True),
    _Column("PSD", numeric=False),
    _Column("flags", numeric=False, choice=True),
)


def write_report(path: Path, report: Report) -> None:
    """Write a report, whole or not at all."""
    files.write_text(path, html(report))


def html(report: Report) -> str:
    """Return a report as one HTML document that needs no other file and no network."""
    environment = Environment(
        loader=PackageLoader("shakerproc.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    css = Markup(  # noqa: S704 - ours
        environment.get_template("page.css").render(
            uplot=_ours(environment, "vendor/uplot/uPlot.min.css"),
            colours=style.COLOURS,
            dashes=_dashes(),
            shades=style.SHADES,
        )
    )
    script = _script(environment)
    return environment.get_template("report.html.j2").render(
        page=_page(report),
        look=live.quoted(json.dumps(LOOK)),
        style=css,
        script=script,
        style_hash=_source_hash(css),
        script_hash=_source_hash(script),
    )


def _ours(environment: Environment, name: str) -> Markup:
    """Return a file of ours as it is."""
    loader = environment.loader
    assert loader is not None  # noqa: S101 - set where it is made
    return Markup(loader.get_source(environment, name)[0])  # noqa: S704 - ours


def _script(environment: Environment) -> Markup:
    """Return uPlot with its licence, and what this page does with it, as one script."""
    licence, drawing, page, shown = (
        _ours(environment, name)
        for name in (
            "vendor/uplot/LICENSE.txt", "vendor/uplot/uPlot.iife.min.js", "page.js", "live.js"
        )
    )  # fmt: skip
    drawing = drawing.partition("*/")[2].strip()  # its own heading; the licence says more
    heading = f"/*! uPlot {UPLOT}\n\n{licence.strip()}\n*/"
    return Markup("\n").join((Markup(heading), drawing, page, shown))  # noqa: S704 - ours


def _dashes() -> list[str]:
    """Return the dashes in steps of the drawings."""
    return [" ".join(str(int(n) * svg.UNIT) for n in dash.split()) for dash in style.DASHES]


def _source_hash(text: str) -> str:
    """Return what a content-security policy calls this style or script."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


def _page(report: Report) -> _Page:
    shown = [run for run in report.runs if run.status != "discarded"]
    views = [run_view(run, i) for i, run in enumerate(shown, 1)]
    methods = report.methods or methods_of(shown)
    with_runs = bool(report.runs) or not report.sections
    opening = _tally(report.runs) if with_runs else ""
    return _Page(
        title=report.title,
        made=f"shakerproc {__version__}, {files.now():%Y-%m-%d %H:%M} UTC",
        verdict=" ".join(filter(None, (opening, report.verdict or _told(report)))),
        counts=_counts(report.runs),
        attention=_attention(shown, views),
        columns=COLUMNS,
        rows=_rows(shown, views, report.channel),
        table_note=_table_note(report),
        trends=[trend_view.drawing(trend) for trend in report.trends],
        not_drawn=_not_drawn(report),
        sections=report.sections,
        runs=views,
        methods=methods.paragraphs,
        references=methods.references,
        provenance=_provenance(report, methods),
        inputs=[
            *report.inputs,
            *((f"test {v.test}", v.recording, v.sha256) for v in views if v.sha256),
        ],
        with_runs=with_runs,
        channel=report.channel,
    )


def _not_drawn(report: Report) -> str:
    titles = "; ".join(title.rstrip(".") for title in report.without_points)
    return f"Not drawn, as no two values have a run: {titles}." if titles else ""


def _told(report: Report) -> str:
    return telling.trend_sentence(report.runs, report.channel)


def _tally(runs: Sequence[RunSummary]) -> str:
    """Return how many runs there are and how they went, in one sentence."""
    counts = {c.label: c.number for c in _counts(runs)}
    wanted = len(runs) - counts.get("discarded", 0)
    parts = [f"{counts['processed']} of {wanted} tests processed"]
    parts += [
        f"{counts[name]} {name}"
        for name in ("failed", "incomplete", "flagged")
        if counts.get(name)
    ]
    return ", ".join(parts) + "."


def _counts(runs: Sequence[RunSummary]) -> list[_Count]:
    done = [run for run in runs if run.status == "done"]
    failed = sum(run.status == "failed" for run in runs)
    incomplete = sum(run.incomplete for run in done)
    flagged = sum(bool(run.flags) for run in done)
    discarded = sum(run.status == "discarded" for run in runs)
    return [
        _Count(len(done), "processed", "done"),
        _Count(failed, "failed", "failed" if failed else "none"),
        _Count(incomplete, "incomplete", "odd" if incomplete else "none"),
        _Count(flagged, "flagged", "odd" if flagged else "none"),
        _Count(discarded, "discarded", "none"),
    ]


def _attention(runs: Sequence[RunSummary], views: Sequence[RunView]) -> list[_Attention]:
    """Return failed runs, then incomplete ones, then other flags; the same is told once."""
    found: dict[_Attention, list[tuple[str, str]]] = {}
    for run, view in zip(runs, views, strict=True):
        told = [_Attention("flag", f.kind, f.channel, f.message) for f in run.flags]
        if run.status == "failed":
            told.insert(0, _Attention("status-failed", "failed", "", run.error))
        for item in told:
            found.setdefault(item, []).append((run.test, view.anchor))
    items = [replace(item, tests=tests) for item, tests in found.items()]
    return sorted(items, key=lambda item: (item.what != "failed", item.what != "incomplete"))


def _rows(
    runs: Sequence[RunSummary], views: Sequence[RunView], channel: str
) -> list[list[_Cell]]:
    return [_row(run, view, channel) for run, view in zip(runs, views, strict=True)]


def _row(run: RunSummary, view: RunView, channel: str) -> list[_Cell]:
    peak = trends.omega_e(run, channel)
    measured = next((c for c in run.channels if c.name == channel), None)
    response = measured.response_peaks[0] if measured and measured.response_peaks else peak
    level = run.facts.get("level_g") or run.facts.get("level_g2_per_hz")
    clearance = run.facts.get("clearance_m")
    return [
        _Cell(run.test, "n", anchor=view.anchor),
        _Cell(run.told_status, "status-odd" if run.incomplete else f"status-{run.status}"),
        _Cell(_told_or(run, "joint")),
        _Cell(_told_or(run, "specimen")),
        _Cell(trends.shown("clearance_m", clearance), "n", _order(clearance)),
        _Cell(_told_or(run, "orientation")),
        _Cell(_told_or(run, "excitation")),
        _Cell(_told_or(run, "level"), "n", _order(level)),
        _Cell(
            f"{number(run.measured_level)} {run.level_unit}".strip(), "n", run.measured_level
        ),
        _number_cell(peak.frequency_hz if peak else None, ".1f"),
        _number_cell(response.quality if response else None, ".3g"),
        _number_cell(measured.coherence if measured else None, ".3f"),
        _Cell(_thumbnail(run, channel)),
        _Cell(", ".join(dict.fromkeys(flag.kind for flag in run.flags)), "flag"),
    ]


def _told_or(run: RunSummary, name: str) -> str:
    return trends.shown(name, run.facts.get(name) or None)


def _order(value: object) -> float | None:
    return float(value) if isinstance(value, int | float) else None


def _number_cell(value: float | None, form: str) -> _Cell:
    return _Cell(number(value, form), "n", value)


def _thumbnail(run: RunSummary, channel: str) -> Markup:
    curve = next((c for c in curves_of(run, "psd") if c.channel == channel), None)
    if curve is None:
        return Markup("")
    x = np.array(curve.x)
    y = np.array([np.nan if v is None else v for v in curve.y])
    good = y[np.isfinite(y) & (y > 0.0)]
    if not good.size or x.size < 2:
        return Markup("")
    low, high = max(good.min(), 1e-6 * good.max()), good.max()
    return svg.sparkline(
        x,
        y,
        svg.Axis("", x[0], x[-1]),
        svg.Axis("", low, max(high, 1.01 * low), logarithmic=True),
    )


def _table_note(report: Report) -> str:
    discarded = ", ".join(
        f"{run.test} ({comment})" if (comment := run.facts.get("comment")) else run.test
        for run in report.runs
        if run.status == "discarded"
    )
    left_out = f" Discarded in the log: {discarded}." if discarded else ""
    if not report.channel:
        return f"Click a heading to sort.{left_out}"
    return (
        f"Peak frequency, Q, coherence and the drawing are those of channel {report.channel}; "
        f"every channel is in peaks.csv. Click a heading to sort.{left_out}"
    )


def _provenance(report: Report, methods: Methods) -> list[str]:
    options = ", ".join(f"{name} = {value}" for name, value in report.options.items())
    rest = "what the command says, the log says, and the defaults, in this order."
    return [
        f"shakerproc {__version__}; {methods.packages}.",
        f"Command: {report.command}" if report.command else "",
        f"Options: {options}" if options else f"Options: {rest}",
        "Every number of this page is in report.json and the tables beside it.",
    ]
