"""The section of a report that sets its campaign beside an earlier one."""

from collections.abc import Sequence
from typing import Final

from shakerproc.campaign.earlier import Change, Earlier, changes
from shakerproc.numerals import numeral
from shakerproc.report.figures import style, to_svg
from shakerproc.report.figures.figure import Curve, Plot
from shakerproc.report.figures.units import ShownUnits
from shakerproc.report.page.sections import PageFigure, ReportSection, filled
from shakerproc.report.runs.curves import STILL, frequency_axis, kept, logarithmic_axis, outside
from shakerproc.report.runs.in_units import run_in
from shakerproc.runs.levels import density_unit
from shakerproc.runs.peak_rows import quantity_of
from shakerproc.runs.summary import PeakSummary, RunSummary

COLUMNS: Final = (
    "test", "channel", "mode", "peak before [Hz]", "now [Hz]", "change", "ζ before [%]",
    "now [%]", "height [dB]", "level [dB]",
)  # fmt: skip

_EARLIER_STYLE: Final = style.CONTROL_STYLES[1]


def earlier_section(
    runs: Sequence[RunSummary], earlier: Earlier, units: ShownUnits
) -> ReportSection:
    """Return the tests of both campaigns side by side: a table of modes, curves overlaid."""
    found = changes(runs, earlier.runs)
    before = {run.test: run for run in earlier.runs if run.status == "done"}
    pairs = [(run, before[run.test]) for run in runs if run.status == "done"
             and run.test in before]  # fmt: skip
    paragraphs = [_opening(earlier, found.rows, len(pairs))]
    for tests, whose in ((found.only_now, "this campaign"), (found.only_before, "the earlier")):
        if tests:
            paragraphs.append(f"Only in {whose}: {', '.join(tests)}.")
    other = [now.test for now, then in pairs if quantity_of(now) != quantity_of(then)]
    if other:
        told = ", ".join(other)
        paragraphs.append(f"Not compared, with a control in one campaign only: {told}.")
    rows = [_cells(row) for row in found.rows]
    table = filled("Every mode before and now.", COLUMNS, rows)
    drawn = [_overlaid(run_in(now, units), run_in(then, units)) for now, then in pairs]
    return ReportSection(
        "Against an earlier campaign",
        "earlier",
        paragraphs,
        (table,) if rows else (),
        [drawing for drawing in drawn if drawing is not None],
    )


def _opening(earlier: Earlier, rows: Sequence[Change], n_tests: int) -> str:
    shifts = [(abs(row.shift_hz), row) for row in rows if row.shift_hz is not None]
    said = f"Beside {earlier.title} ({earlier.folder}): {n_tests} tests in both."
    clear = [one for one in shifts if one[0] > one[1].bin_hz]
    if not shifts:
        return said
    if not clear:
        return f"{said} No peak moved by more than a bin."
    _, row = max(clear, key=lambda one: one[0] / (one[1].now or one[1].before).frequency_hz)  # type: ignore[union-attr]
    assert row.before is not None  # noqa: S101 - a shift has both
    assert row.now is not None  # noqa: S101
    return (
        f"{said} {len(clear)} of {len(shifts)} peaks moved by more than a bin, most that of "
        f"{row.channel} in test {row.test}: from {numeral(row.before.frequency_hz, 4)} to "
        f"{numeral(row.now.frequency_hz, 4)} Hz ({_share(row):+.1f} %)."
    )


def _share(row: Change) -> float:
    assert row.before is not None  # noqa: S101 - asked by the callers
    return 100.0 * (row.shift_hz or 0.0) / row.before.frequency_hz


def _cells(row: Change) -> list[str]:
    change = "new" if row.before is None else "gone"
    if row.shift_hz is not None:
        beyond = abs(row.shift_hz) > row.bin_hz
        change = f"{_share(row):+.2f} %{'' if beyond else ', within a bin'}"
    return [
        row.test, row.channel, str(row.mode), _hz(row.before), _hz(row.now), change,
        _damping(row.before), _damping(row.now), _db(row.height_db), _db(row.level_db),
    ]  # fmt: skip


def _hz(peak: PeakSummary | None) -> str:
    return "" if peak is None else f"{peak.frequency_hz:.1f}"


def _damping(peak: PeakSummary | None) -> str:
    """Return a damping ratio with half its 95 % interval [%]."""
    if peak is None or peak.damping_ratio is None:
        return ""
    half = ""
    if peak.damping_low is not None and peak.damping_high is not None:
        half = f" ± {numeral(50.0 * (peak.damping_high - peak.damping_low), 2)}"
    return f"{numeral(100.0 * peak.damping_ratio)}{half}"


def _db(value: float | None) -> str:
    return "" if value is None else f"{value:+.1f}"


def _unit(unit: str, run: RunSummary, kind: str) -> str:
    """Return the unit of a density, or of a response over the controls."""
    over = next((c.unit for c in run.channels if c.role == "control"), unit)
    if kind == "psd":
        return density_unit(unit)
    return "-" if unit == over else f"{unit}/{over}"


def _overlaid(now: RunSummary, before: RunSummary) -> PageFigure | None:
    """Return response functions of a test, or densities, now and before."""
    kind, told = ("gain", "|H1|") if quantity_of(now) == "|H1|" else ("psd", "PSD")
    content = kept(now)
    then = {curve.channel: curve for curve in kept(before).of(kind)}
    units = [content.unit_of(c.channel) for c in content.of(kind) if c.channel in then]
    if not units:
        return None
    curves = [c for c in content.of(kind, units[0]) if c.channel in then]
    lines = [line for line in content.lines(kind, units[0]) if line.label in then]
    grey = [
        Curve(
            f"{c.channel}, earlier",
            then[c.channel].x,
            then[c.channel].y,
            _EARLIER_STYLE,
            thin=True,
        )
        for c in curves
    ]
    axis, unit = frequency_axis(curves), _unit(units[0], now, kind)
    return PageFigure(
        f"Test {now.test}.",
        f"{told} now in colour, earlier thin and grey.",
        to_svg.plot(
            Plot(
                [*grey, *lines],
                axis,
                logarithmic_axis(f"{told} [{unit}]", [*lines, *grey], 5),
                spans=outside(now, axis),
            ),
            most=STILL,
            title=f"{told} of test {now.test}, now and earlier",
        ),
    )
