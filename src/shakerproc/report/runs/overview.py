"""The front of a report: how the runs went, the table of all runs, their resonances."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from markupsafe import Markup

from shakerproc.campaign import trends
from shakerproc.numerals import numeral
from shakerproc.report.figures import to_svg
from shakerproc.report.figures.figure import Axis
from shakerproc.report.figures.units import ShownUnits
from shakerproc.report.page.sections import ReportTable, filled
from shakerproc.report.runs.view import RunView, number
from shakerproc.runs.summary import ChannelSummary, RunSummary


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
    found: dict[Attention, list[tuple[str, str]]] = {}
    for run, view in zip(runs, views, strict=True):
        told = [Attention("flag", f.kind, f.channel, f.message) for f in run.flags]
        if run.status == "failed":
            told.insert(0, Attention("status-failed", "failed", "", run.error))
        for item in told:
            found.setdefault(item, []).append((run.test, view.anchor))
    items = [replace(item, tests=tests) for item, tests in found.items()]
    return sorted(items, key=lambda item: (item.what != "failed", item.what != "incomplete"))


@dataclass(frozen=True, slots=True)
class TableColumn:
    """A column of the table: its heading, and how it is sorted and filtered."""

    label: str
    numeric: bool
    choice: bool = False


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell: what is shown, its class, what it is sorted by, where it leads."""

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
        Cell(run.told_status, "status-odd" if run.incomplete else f"status-{run.status}"),
        Cell(_told_or(run, "joint")),
        Cell(_told_or(run, "specimen")),
        Cell(units.text(trends.shown("clearance_m", clearance)), "n", _order(clearance)),
        Cell(_told_or(run, "orientation")),
        Cell(_told_or(run, "excitation")),
        Cell(_told_or(run, "level"), "n", _order(level)),
        Cell(f"{number(run.measured_level)} {run.level_unit}".strip(), "n", run.measured_level),
        _number_cell(peak.frequency_hz if peak else None, ".1f"),
        _number_cell(response.quality if response else None, ".3g"),
        _number_cell(measured.coherence if measured else None, ".3f"),
        Cell(_thumbnail(run, channel)),
        Cell(", ".join(dict.fromkeys(flag.kind for flag in run.flags)), "flag"),
    ]


def _told_or(run: RunSummary, name: str) -> str:
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
    found = {run.test: list(_peaks(run, channel)) for run in runs if run.status == "done"}
    most = max(map(len, found.values()), default=0)
    if not most:
        return None
    rows = [
        [
            run.test,
            *(trends.shown(name, run.facts.get(name)) for name in FACTS),
            *(found[run.test] + [""] * most)[:most],
        ]
        for run in runs
        if run.test in found
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
