"""Trends in sentences."""

import math
from collections.abc import Sequence
from typing import Final

from shakerproc.campaign.trend import TrendPoint, TrendRequest, TrendValue
from shakerproc.campaign.trends import peaks_of, shown, told_of, trend_over
from shakerproc.numerals import numeral
from shakerproc.runs.summary import RunSummary

_ASKED: Final = (
    ("clearance_m", "random", ("joint", "orientation", "level")),
    ("clearance_m", "sine sweep", ("joint", "orientation", "level")),
    ("level_g2_per_hz", "random", ("joint", "clearance_m", "orientation")),
    ("level_g", "sine sweep", ("joint", "clearance_m", "orientation")),
    ("level_n2_per_hz", "random", ("joint", "clearance_m", "orientation")),
    ("level_n_rms", "random", ("joint", "clearance_m", "orientation")),
    ("level_n_rms", "multisine", ("joint", "clearance_m", "orientation")),
    ("level_n", "sine sweep", ("joint", "clearance_m", "orientation")),
)
"""What is asked, in this order: quantity, excitation, and what else must be equal."""


def trend_sentence(runs: Sequence[RunSummary], channel: str) -> str:
    """Return the shift of the peak frequency with clearance or level; empty if unknown."""
    return shift_sentence(peaks_of(runs, channel), f"peak frequency of {channel}")


def shift_sentence(tests: Sequence[TrendValue], name: str) -> str:
    """Return the shift of a frequency with clearance or level; empty if unknown.

    Of several series (joints, orientations) the one with the largest shift is told.
    """
    for column, excitation, equal in _ASKED:
        request = TrendRequest("", "", "", column, equal, (("excitation", excitation),))
        alike = [one for one in tests if one.facts.get("excitation") == excitation]
        found = trend_over(alike, request, "", "")
        if found is None or not found.numeric:
            continue
        spans = [
            (abs(points[-1].frequency_hz - points[0].frequency_hz), label, points)
            for label, points in found.series.items()
            if len({p.x for p in points}) >= 2
        ]
        if spans:
            _, label, points = max(spans, key=lambda span: span[0])
            ends = (points[0].test, points[-1].test)
            shift = _sentence(name, points, column, f"{excitation}, {label}")
            return " ".join([shift, *_remarks([one for one in tests if one.test in ends])])
    return ""


def _remarks(ends: Sequence[TrendValue]) -> list[str]:
    """Return remarks on the first and the last test of a shift, a sentence each."""
    told = told_of(ends)
    first, last = (one.test for one in ends)
    if last in ends[0].unsure:
        told.append(
            f"Fewer than three sensors cannot tell whether test {first} and test {last} show "
            "one mode."
        )
    return told


def _sentence(name: str, points: Sequence[TrendPoint], column: str, where: str) -> str:
    first, last = points[0], points[-1]
    start, stop = first.frequency_hz, last.frequency_hz
    low, high = (_place(p, column) for p in (first, last))
    width = max(first.bin_width_hz, last.bin_width_hz)
    places = max(0, -math.floor(math.log10(width))) if width > 0.0 else 0
    word = "clearance" if column == "clearance_m" else "level"
    if abs(stop - start) < width:
        return (
            f"The {name} stays at {start:.{places}f} Hz from {low} to {high} of {word}, within "
            f"the {numeral(width)} Hz to which it is known ({where})."
        )
    verb = "falls" if stop < start else "rises"
    meaning = "" if word == "clearance" else ": a sign of a nonlinear joint"
    return (
        f"The {name} {verb} from {start:.{places}f} Hz at {low} to "
        f"{stop:.{places}f} Hz at {high} of {word}, by {_per_cent(stop / start - 1.0)} "
        f"({where}){meaning}."
    )


def _place(point: TrendPoint, column: str) -> str:
    assert isinstance(point.x, float)  # noqa: S101 - numeric trends only
    return shown(column, point.x * (1e-3 if column == "clearance_m" else 1.0))


def _per_cent(share: float) -> str:
    """Return the size of a share: whole per cent, two digits below one."""
    percent = 100.0 * abs(share)
    return f"{percent:.0f}%" if percent >= 0.995 else f"{numeral(percent, 2)}%"
