"""Terminal output of a batch."""

from pathlib import Path
from typing import Any

from shakerproc.campaign import trends
from shakerproc.campaign.batch import CampaignResult
from shakerproc.cli import output
from shakerproc.runs import RunSummary
from shakerproc.runs.flags import EXPIRED
from shakerproc.runs.remarks import by_tests


def tell(
    campaign: CampaignResult, document: dict[str, Any], root: Path, json_target: str | None
) -> None:
    """Say on the terminal what came of a batch."""
    channel = document["trend_channel"]
    rows = [_row(run, channel) for run in campaign.runs if run.status != "discarded"]
    output.print_table(
        (
            "test",
            "status",
            "joint",
            "clearance",
            "orientation",
            "excitation",
            "level",
            "peak frequency [Hz]",
            "Q",
            "coherence",
            "flags",
        ),
        rows,
        json_target=json_target,
        spare=("orientation", "excitation", "joint", "coherence", "Q"),
        elsewhere=f"{root / 'runs.csv'} and peaks.csv",
    )
    for run in campaign.runs:
        if run.status == "failed":
            output.message(f"test {run.test} failed: {run.error}")
        if run.left_out:
            output.warning(run.left_out)
    runs = [run for run in campaign.runs if run.status == "done"]
    expired = [[f.message for f in run.flags if f.kind == EXPIRED] for run in runs]
    told = ((r.test, (*r.remarks, *more)) for r, more in zip(runs, expired, strict=True))
    for line in by_tests(told):
        output.message(line)
    number = document["counts"]
    parts = [f"{n} {name}" for name, n in number.items() if n or name == "processed"]
    whose = f" (peak frequency of {channel})" if channel else ""
    output.data(f"{', '.join(parts)}{whose}", json_target=json_target)
    if document["verdict"]:
        output.data(document["verdict"], json_target=json_target)
    output.data(f"report: {root / 'report.html'}", json_target=json_target)


def _row(run: RunSummary, channel: str) -> tuple[object, ...]:
    peak = trends.main_peak(run, channel)
    seen = next((c for c in run.channels if c.name == channel), None)
    response = seen.response_peaks[0] if seen and seen.response_peaks else None
    return (
        run.test,
        run.told_status,
        run.facts.get("joint"),
        trends.shown("clearance_m", run.facts.get("clearance_m")),
        run.facts.get("orientation"),
        run.facts.get("excitation"),
        trends.shown("level", run.facts.get("level")),
        peak.frequency_hz if peak else None,
        response.quality if response else None,
        seen.coherence if seen else None,
        ", ".join(dict.fromkeys(flag.kind for flag in run.flags)),
    )
