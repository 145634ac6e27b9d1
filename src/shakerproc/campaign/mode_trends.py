"""Every mode against clearance, level, specimen and the rest, as the peak frequency is."""

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Final

from shakerproc.campaign.trend import Trend, TrendRequest, TrendValue
from shakerproc.campaign.trends import label_of, shift_sentence, standard_trends, trend_over
from shakerproc.modal.analysis import ModalAnalysis, TestModes
from shakerproc.modal.tracking import Track
from shakerproc.numerals import numeral
from shakerproc.runs.summary import Value
from shakerproc.testlog import facts_of

FURTHER: Final[Mapping[str, tuple[str, ...]]] = {
    "specimen": ("level", "clearance_m"),
    "campaign": ("level", "clearance_m"),
    "level_n": ("excitation", "specimen"),
    "level_n_rms": ("excitation", "specimen"),
    "level_n2_per_hz": ("excitation", "specimen"),
}
"""Columns along which modes are compared besides those of the peak frequency, and what makes
the series."""


def trends_of_modes(analysis: ModalAnalysis) -> dict[int, list[Trend]]:
    """Return the trends of each mode that is seen in several tests, by its number from 1."""
    found = {}
    for number, track in enumerate(analysis.tracks, 1):
        seen = seen_of(analysis, track)
        requests = [*standard_trends(seen), *(_request(*one) for one in FURTHER.items())]
        drawn = [_trend(request, seen, number, _place(analysis, track)) for request in requests]
        kept = {trend.name: trend for trend in drawn if trend is not None}
        if kept:
            found[number] = list(kept.values())
    return found


def told_of_modes(analysis: ModalAnalysis) -> tuple[str, ...]:
    """Return the shift of each mode with clearance or level, a sentence each."""
    told = (
        shift_sentence(
            seen_of(analysis, track),
            f"frequency of mode {number} ({numeral(_place(analysis, track), 4)} Hz)",
        )
        for number, track in enumerate(analysis.tracks, 1)
        if len(track.sightings) > 1
    )
    return tuple(text for text in told if text)


def seen_of(analysis: ModalAnalysis, track: Track) -> list[TrendValue]:
    """Return the frequency of a mode in every test, and how far its interval reaches."""
    modes = {sighting.test: sighting.mode for sighting in track.sightings}
    found = []
    for place, one in enumerate(analysis.tests):
        mode = modes.get(place)
        low, high = (0.0, 0.0) if mode is None else one.modes.frequency_bounds[:, mode]
        frequency = None if mode is None else float(one.modes.frequency[mode])
        found.append(TrendValue(one.name, _facts(analysis, one), frequency, float(high - low)))
    return found


def _facts(analysis: ModalAnalysis, one: TestModes) -> Mapping[str, Value]:
    """Return the facts of a test in its log; the name of the log, where there are two."""
    owner, colon, _ = one.name.rpartition(":")
    both = any(":" in other.name for other in analysis.tests)
    campaign = {"campaign": owner if colon else "this log"} if both else {}
    return {**facts_of(one.test), **campaign}


def _place(analysis: ModalAnalysis, track: Track) -> float:
    """Return the frequency of a mode where it was first seen [Hz]."""
    first = track.sightings[0]
    return float(analysis.tests[first.test].modes.frequency[first.mode])


def _request(column: str, by: tuple[str, ...]) -> TrendRequest:
    return TrendRequest(
        f"peak_frequency_against_{column}",
        f"Peak frequency against {label_of(column).partition(' [')[0]}.",
        "Each point is a test.",
        column,
        by,
    )


def _trend(
    request: TrendRequest, seen: list[TrendValue], number: int, frequency: float
) -> Trend | None:
    """Return a trend of the peak frequency as one of a mode."""
    plain = re.sub(r"^figure_\d+_\d+_", "", request.name)
    asked = replace(
        request,
        name=plain.replace("peak_frequency", f"mode_{number}"),
        title=request.title.replace(
            "Peak frequency", f"Frequency of mode {number} ({numeral(frequency, 4)} Hz)"
        ),
    )
    ending = "Natural frequency with its 95 % interval."
    found = trend_over(seen, asked, f"mode {number}", ending)
    if found is None:
        return None
    return replace(found, quantity="natural frequency [Hz]", bars="95 % interval")
