"""A user's template tried on an example before the long work, so that its errors come first."""

from typing import Final

from shakerproc.report.page.header import HeaderView, header_view
from shakerproc.report.page.page import Report, html
from shakerproc.report.page.sections import ReportSection, ReportTable
from shakerproc.runs.analysis import PanelScale
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


def tried_header(log: TestLog) -> HeaderView | None:
    """Return the head of the report of a log, its template tried on an example.

    Raises
    ------
    LogError
        If the photo cannot be read, or the template is none, or fails on the example.
    """
    found = header_view(log)
    if found is not None and found.template is not None:
        failed = RunSummary("2", "failed", error="A sentence.", detail="A sentence.")
        table = ReportTable("Example", ("a",), (("1",),))
        section = ReportSection("Example", "example", ("A sentence.",), (table,))
        html(Report(log.title, (EXAMPLE, failed), channel="response", header=found,
                    sections=(section,)))  # fmt: skip
    return found
