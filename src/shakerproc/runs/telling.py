"""What the trends come to, in one sentence."""

from collections.abc import Sequence
from typing import Final

from shakerproc.runs.summary import RunSummary
from shakerproc.runs.trends import Point, TrendRequest, shown, trend

_ASKED: Final = (
    ("clearance_m", "random", ("joint", "orientation", "level")),
    ("clearance_m", "sine sweep", ("joint", "orientation", "level")),
    ("level_g2_per_hz", "random", ("joint", "clearance_m", "orientation")),
    ("level_g", "sine sweep", ("joint", "clearance_m", "orientation")),
)
"""What is asked, in this order: quantity, excitation, and what else must be equal."""


def trend_sentence(runs: Sequence[RunSummary], channel: str) -> str:
    """Return what omega_e does with clearance or level, empty where nothing can be said.

    Of several series (joints, orientations) the one that moves most is told.
    """
    for column, excitation, equal in _ASKED:
        request = TrendRequest("", "", "", column, equal, (("excitation", excitation),))
        alike = [run for run in runs if run.facts.get("excitation") == excitation]
        found = trend(alike, request, channel)
        if found is None or not found.numeric:
            continue
        spans = [
            (abs(points[-1].frequency_hz - points[0].frequency_hz), label, points)
            for label, points in found.series.items()
            if len({p.x for p in points}) >= 2
        ]
        if spans:
            _, label, points = max(spans, key=lambda span: span[0])
            return _sentence(channel, points, column, f"{excitation}, {label}")
    return ""


def _sentence(channel: str, points: Sequence[Point], column: str, where: str) -> str:
    first, last = points[0], points[-1]
    start, stop = first.frequency_hz, last.frequency_hz
    low, high = (_place(p, column) for p in (first, last))
    width = max(first.bin_width_hz, last.bin_width_hz)
    word = "clearance" if column == "clearance_m" else "level"
    if abs(stop - start) < width:
        return (
            f"ω_e of {channel} stays at {start:.0f} Hz from {low} to {high} of {word}, within "
            f"a bin of {width:.1f} Hz ({where})."
        )
    verb = "falls" if stop < start else "rises"
    meaning = "" if word == "clearance" else ": the mark of a nonlinear joint"
    return (
        f"ω_e of {channel} {verb} from {start:.0f} Hz at {low} to {stop:.0f} Hz at {high} of "
        f"{word}, by {abs(stop / start - 1.0):.0%} ({where}){meaning}."
    )


def _place(point: Point, column: str) -> str:
    assert isinstance(point.x, float)  # noqa: S101 - numeric trends only
    return shown(column, point.x * (1e-3 if column == "clearance_m" else 1.0))
