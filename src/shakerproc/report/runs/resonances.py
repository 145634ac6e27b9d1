"""The resonances of every run in one table, for the front of the report."""

from collections.abc import Iterator, Sequence
from typing import Final

from shakerproc.campaign import trends
from shakerproc.numerals import numeral
from shakerproc.report.page.sections import Table, filled
from shakerproc.runs.summary import ChannelSummary, RunSummary

FACTS: Final = ("specimen", "joint", "clearance_m", "orientation", "excitation", "level")


def resonances(runs: Sequence[RunSummary], channel: str) -> Table | None:
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
