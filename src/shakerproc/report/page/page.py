"""The report: one HTML file that opens offline, prints completely and runs nobody's text."""

import base64
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final, final

from jinja2 import Environment
from markupsafe import Markup

from shakerproc import __version__, files
from shakerproc.campaign.trend import Trend
from shakerproc.campaign.trends import trend_sentence
from shakerproc.errors import PrintingError
from shakerproc.report.figures import axes, figure, style, to_svg
from shakerproc.report.figures.units import USUAL, ShownUnits
from shakerproc.report.page.methods import Methods, methods_of
from shakerproc.report.page.sections import (
    HeaderView,
    PageFigure,
    ReportSection,
    ReportTable,
    environment,
    header_view,
    rendered,
    with_expired,
)
from shakerproc.report.runs import view
from shakerproc.report.runs.in_units import run_in, trend_in
from shakerproc.report.runs.view import (
    Attention,
    Cell,
    Count,
    RunView,
    TableColumn,
    resonances,
    run_view,
)
from shakerproc.report.trends import page_figures
from shakerproc.runs.panels import PanelScale
from shakerproc.runs.summary import (
    AnalysisSummary,
    ChannelSummary,
    CurveSummary,
    FlagSummary,
    LineSummary,
    PanelSummary,
    PeakSummary,
    RunSummary,
)
from shakerproc.testlog import TestLog

_SHOWN: Final = 20
"""Tests that are named at most."""

_PEAK: Final = PeakSummary(100.0, 100.0, 10.0, 100.0, 0.02, 0.01, 0.03, 25.0, 1.0, "", 0.99)

_RESPONSE: Final = ChannelSummary(
    "response",
    "response",
    "g",
    "",
    0.0,
    1.0,
    -3.0,
    3.0,
    3.0,
    3.0,
    1.0,
    0.99,
    (_PEAK,),
    (_PEAK,),
)

_SHAPE: Final = ((10.0, 100.0, 200.0), (0.1, 1.0, 0.1))

_ANALYSIS: Final = AnalysisSummary(
    "example", "Example", ({"channel": "response", "largest_g": 3.0},), ("A sentence.",),
    (PanelSummary(
        "Example", "A figure.", PanelScale("frequency [Hz]"), PanelScale("amplitude [g]"),
        (LineSummary("response", *_SHAPE, "response", "curve"),),
    ),),
)  # fmt: skip

EXAMPLE: Final = RunSummary(
    "1", "done", {"joint": "radial", "level": "1 g"}, "example.tdms", "0" * 64,
    sample_rate_hz=1000.0, duration_s=10.0, crop_s=(1.0, 9.0), measured_level=1.0,
    level_unit="g", channels=(_RESPONSE,), flags=(FlagSummary("level", "", "A sentence."),),
    curves=(CurveSummary("psd", "response", *_SHAPE),), notes=("A sentence.",),
    analyses=(_ANALYSIS,),
)  # fmt: skip
"""A run with something in every place of the page."""


@final
@dataclass(frozen=True, slots=True)
class Watched:
    """State of the page while its folder is watched.

    Attributes
    ----------
    refresh : float
        Time after which a browser loads the page again [s].
    waiting : sequence of str
        Tests whose recordings have not come yet.
    """

    refresh: float
    waiting: Sequence[str] = ()

    @property
    def seconds(self) -> int:
        """Whole seconds, as HTML takes them."""
        return max(1, round(self.refresh))

    @property
    def sentence(self) -> str:
        """The state in a sentence."""
        text = f"Watched: this page reloads every {self.seconds} s"
        if not self.waiting:
            return f"{text}."
        more = len(self.waiting) - _SHOWN
        names = ", ".join([*self.waiting[:_SHOWN], *([f"{more} more"] if more > 0 else [])])
        return f"{text}. Waiting for the recordings of: {names}."


@dataclass(frozen=True, slots=True)
class Report:
    """Contents of a report.

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
    sections : sequence of ReportSection
        What comes between the trends and the runs.
    without_points : sequence of str
        Titles of trends for which the log has not two values with a run.
    inputs : sequence of (str, str, str)
        Further files that went in: what they are, their names and their SHA-256.
    methods : Methods, optional
        What was done; by default what the runs tell.
    watched : Watched, optional
        How the page follows a folder; by default it does not.
    header : HeaderView, optional
        What the log says for the customer.
    units : ShownUnits
        Units that a person chose; the usual ones where none is.
    """

    title: str
    runs: Sequence[RunSummary]
    trends: Sequence[Trend] = ()
    channel: str = ""
    command: str = ""
    options: Mapping[str, str] = field(default_factory=dict)
    verdict: str = ""
    sections: Sequence[ReportSection] = ()
    without_points: Sequence[str] = ()
    inputs: Sequence[tuple[str, str, str]] = ()
    methods: Methods | None = None
    watched: Watched | None = None
    header: HeaderView | None = None
    units: ShownUnits = USUAL


@dataclass(frozen=True, slots=True)
class _Page:
    title: str
    made: str
    verdict: str
    counts: Sequence[Count]
    attention: Sequence[Attention]
    columns: Sequence[TableColumn]
    rows: Sequence[Sequence[Cell]]
    table_note: str
    trends: Sequence[PageFigure]
    resonances: ReportTable | None
    not_drawn: str
    sections: Sequence[ReportSection]
    runs: Sequence[RunView]
    methods: Sequence[str]
    references: Sequence[str]
    provenance: Sequence[str]
    inputs: Sequence[tuple[str, str, str]]
    with_runs: bool
    channel: str
    watched: Watched | None
    header: HeaderView | None


UPLOT: Final = "1.6.32"
"""Version of the script that draws on top of the figures (docs/decisions/0007)."""

LOOK: Final = {
    "colours": style.COLOURS,
    "dashes": style.DASHES,
    "markers": to_svg.MARKERS,
    "steps": axes.COLOURS,
}


def write_report(path: Path, report: Report) -> None:
    """Write a report, whole or not at all."""
    files.write_text(path, html(report))


def html(report: Report) -> str:
    """Return a report as one HTML document that needs no other file and no network."""
    own = None if report.header is None else report.header.template
    templates = environment(own)
    css = _style(templates, _ours(templates, "vendor/uplot/uPlot.min.css"))
    script = _script(templates)
    content = {
        "page": _page(report),
        "look": figure.quoted(json.dumps(LOOK)),
        "style": css,
        "script": script,
        "style_hash": _source_hash(css),
        "script_hash": _source_hash(script),
    }
    return axes.shared(rendered(templates, own, content))


def _style(templates: Environment, uplot: str = "") -> Markup:
    """Return the style of the page, that of the drawings included."""
    return Markup(  # noqa: S704 - ours
        templates.get_template("page.css").render(
            uplot=uplot, colours=style.COLOURS, dashes=_dashes(), shades=style.SHADES
        )
    )


def svg_file(drawing: Markup) -> str:
    """Return a drawing of the page as an SVG file that needs no page."""
    css = _style(environment(None))
    first = '<svg xmlns="http://www.w3.org/2000/svg" '
    head, body = drawing.removeprefix("<svg ").split(">", 1)
    return f"{first}{head}><style>{css}</style>{body}"


def _ours(templates: Environment, name: str) -> Markup:
    """Return a file of ours as it is."""
    loader = templates.loader
    assert loader is not None  # noqa: S101 - set where it is made
    return Markup(loader.get_source(templates, name)[0])  # noqa: S704 - ours


def _script(templates: Environment) -> Markup:
    """Return uPlot with its licence, and the code of this page, as one script."""
    licence, drawing, page, shown = (
        _ours(templates, name)
        for name in (
            "vendor/uplot/LICENSE.txt", "vendor/uplot/uPlot.iife.min.js", "page.js", "live.js"
        )
    )  # fmt: skip
    drawing = drawing.partition("*/")[2].strip()  # its own heading; the licence says more
    heading = f"/*! uPlot {UPLOT}\n\n{licence.strip()}\n*/"
    return Markup("\n").join((Markup(heading), drawing, page, shown))  # noqa: S704 - ours


def _dashes() -> list[str]:
    """Return the dashes in steps of the drawings."""
    return [" ".join(str(int(n) * axes.UNIT) for n in dash.split()) for dash in style.DASHES]


def _source_hash(text: str) -> str:
    """Return the name of a style or script in a content-security policy."""
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


def _page(report: Report) -> _Page:
    units = report.units
    shown = [run_in(run, units) for run in report.runs if run.status != "discarded"]
    views = [run_view(run, i, units) for i, run in enumerate(shown, 1)]
    methods = report.methods or methods_of(shown)
    columns, rows = view.table(shown, views, report.channel, units)
    with_runs = bool(report.runs) or not report.sections
    opening = view.tally(report.runs) if with_runs else ""
    return _Page(
        title=report.title,
        made=f"shakerproc {__version__}, {files.now():%Y-%m-%d %H:%M} UTC",
        verdict=units.text(
            " ".join(
                filter(
                    None,
                    (opening, report.verdict or trend_sentence(report.runs, report.channel)),
                )
            ),
            [report.channel],
        ),
        counts=view.counts(report.runs),
        attention=view.attention(shown, views),
        columns=columns,
        rows=rows,
        table_note=view.table_note(report.runs, report.channel),
        trends=page_figures([trend_in(one, units) for one in report.trends]),
        resonances=resonances(shown, report.channel),
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
        watched=report.watched,
        header=None if report.header is None else with_expired(report.header, report.runs),
    )


def _not_drawn(report: Report) -> str:
    titles = "; ".join(title.rstrip(".") for title in report.without_points)
    return f"Not drawn, as no two values have a run: {titles}." if titles else ""


def _provenance(report: Report, methods: Methods) -> list[str]:
    options = ", ".join(f"{name} = {value}" for name, value in report.options.items())
    rest = "what the command says, the log says, and the defaults, in this order."
    return [
        f"shakerproc {__version__}; {methods.packages}.",
        f"Command: {report.command}" if report.command else "",
        f"Options: {options}" if options else f"Options: {rest}",
        "Every number of this page is in the JSON file and the tables beside it.",
    ]


def tried_header(log: TestLog) -> HeaderView | None:
    """Return the head of the report of a log, its template tried on an example.

    Raises
    ------
    LogError
        If the photo cannot be read, or the template is none, or fails on the example.
    """
    header = header_view(log)
    if header is not None and header.template is not None:
        failed = RunSummary("2", "failed", error="A sentence.", detail="A sentence.")
        table = ReportTable("Example", ("a",), (("1",),))
        section = ReportSection("Example", "example", ("A sentence.",), (table,))
        html(Report(log.title, (EXAMPLE, failed), channel="response", header=header,
                    sections=(section,)))  # fmt: skip
    return header


BROWSER_VARIABLE: Final = "SHAKERPROC_BROWSER"
"""Environment variable that names a browser, before all others."""

NAMES: Final = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome",
    "microsoft-edge", "microsoft-edge-stable", "msedge", "brave-browser",
)  # fmt: skip
"""Programs that print, as they are called on the search path."""

ON_WINDOWS: Final = (
    "Google/Chrome/Application/chrome.exe",
    "Microsoft/Edge/Application/msedge.exe",
    "Chromium/Application/chrome.exe",
)
ON_A_MAC: Final = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
)

LONGEST: Final = 300.0
"""Time that a browser may take [s]."""


def find_browser() -> str | None:
    """Return the path of a browser that can print, or None."""
    named = os.environ.get(BROWSER_VARIABLE)
    if named:
        return shutil.which(named)
    paths = (shutil.which(name) for name in NAMES)
    return next(filter(None, (*paths, *_usual_places())), None)


def _usual_places() -> Iterator[str]:
    """Yield browsers that stand where installers put them, off the search path."""
    if os.name == "nt":
        for variable in ("PROGRAMFILES", "PROGRAMFILES(X86)", "LOCALAPPDATA"):
            root = os.environ.get(variable)
            yield from (
                str(path) for end in ON_WINDOWS if root and (path := Path(root) / end).is_file()
            )
    elif sys.platform == "darwin":
        yield from (path for path in ON_A_MAC if Path(path).is_file())


def print_report(page: Path, target: Path) -> Path:
    """Print a report to PDF, whole or not at all, and return the file.

    Raises
    ------
    PrintingError
        If no browser is installed, or it does not print.
    """
    browser = find_browser()
    if browser is None:
        named = os.environ.get(BROWSER_VARIABLE)
        lack = f"{BROWSER_VARIABLE} names {named!r}, which is not there" if named else (
            "printing takes Chromium, Chrome or Edge, and none is found"
        )  # fmt: skip
        raise PrintingError(
            f"no PDF: {lack}. Install one, or open {page} in any browser and print it there."
        )
    with files.atomic_path(target) as temporary, tempfile.TemporaryDirectory() as profile:
        said = _run(browser, page, temporary, profile)
        if not temporary.is_file() or temporary.stat().st_size == 0:
            temporary.touch()
            raise PrintingError(
                f"no PDF of {page}: {browser} printed nothing{said}. Open the page in a "
                f"browser and print it there, or name another in {BROWSER_VARIABLE}."
            )
    return target


def _run(browser: str, page: Path, target: Path, profile: str) -> str:
    """Let a browser print; return the last thing it said, for an error message.

    Raises
    ------
    PrintingError
        If it takes too long or cannot be started.
    """
    command = [
        browser, "--headless", "--disable-gpu", "--no-first-run", "--no-default-browser-check",
        "--disable-extensions", "--disable-background-networking", "--no-pdf-header-footer",
        "--generate-pdf-document-outline",
        f"--user-data-dir={profile}", f"--print-to-pdf={target.resolve()}",
        page.resolve().as_uri(),
    ]  # fmt: skip
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        command.insert(1, "--no-sandbox")  # Chromium refuses to start as root with one
    try:
        done = subprocess.run(  # noqa: S603 - a browser and a page of ours
            command, capture_output=True, timeout=LONGEST, check=False
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise PrintingError(f"no PDF of {page}: {browser}: {error}") from error
    lines = done.stderr.decode("utf-8", "replace").strip().splitlines()
    return f" ({files.printable(lines[-1])[:200]})" if lines and done.returncode else ""
