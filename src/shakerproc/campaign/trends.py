"""Peak frequency, and every mode, across the runs of a log: against clearance, level, joint."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Final

from shakerproc.campaign.trend import Trend, TrendPoint, TrendRequest, TrendValue, followed
from shakerproc.errors import LogError
from shakerproc.modal.analysis import ModalAnalysis, TestModes, Track
from shakerproc.numerals import numeral
from shakerproc.runs.summary import ChannelSummary, PeakSummary, RunSummary, Value
from shakerproc.testlog import facts_of
from shakerproc.units import near_miss

SINGLE_FREQUENCY: Final = ("sine",)
"""Kinds of excitation whose tallest peak is the excitation and no resonance."""

_UNITS: Final = {
    "_g2_per_hz": ("g²/Hz", 1.0),
    "_n2_per_hz": ("N²/Hz", 1.0),
    "_g_rms": ("g rms", 1.0),
    "_n_rms": ("N rms", 1.0),
    "_n": ("N", 1.0),
    "_m": ("mm", 1e3),
    "_hz": ("Hz", 1.0),
    "_g": ("g", 1.0),
    "_s": ("s", 1.0),
}


def main_peak(run: RunSummary, channel: str) -> PeakSummary | None:
    """Return the tallest peak of a channel's PSD; None where there is none that means it."""
    if run.facts.get("excitation") in SINGLE_FREQUENCY:
        return None
    if any(flag.channel == channel for flag in run.unusable):
        return None
    channel_summary = next((c for c in run.channels if c.name == channel), None)
    return (
        channel_summary.psd_peaks[0]
        if channel_summary is not None and channel_summary.psd_peaks
        else None
    )


def trend_channel(runs: Sequence[RunSummary]) -> str:
    """Return the channel of the largest response: the largest sum of ranks over the runs."""
    score: dict[str, float] = {}
    for run in (run for run in runs if not run.unusable):
        responses = [c for c in run.channels if c.role == "response" and c.psd_peaks]
        largest = max((_height(c) for c in responses), default=0.0)
        for channel in responses:
            share = _height(channel) / largest if largest > 0.0 else 0.0
            score[channel.name] = score.get(channel.name, 0.0) + share
    return max(score, key=lambda name: score[name], default="")


def _height(channel: ChannelSummary) -> float:
    return channel.psd_peaks[0].height


def standard_trends(
    tests: Sequence[RunSummary | TrendValue], *, thesis: bool = False
) -> list[TrendRequest]:
    """Return the trends of every log; `thesis` names those of its figures 5.45 to 5.49."""
    joints = list(dict.fromkeys(str(t.facts["joint"]) for t in tests if t.facts.get("joint")))
    numbers = {"radial": ("5.46", "5.48"), "slot": ("5.47", "5.49")} if thesis else {}
    requests = [
        TrendRequest(
            _file_name("5.45" if thesis else "", "clearance_random"),
            "Peak frequency against clearance, random excitation.",
            "Look for a fall from zero clearance to the first gap.",
            "clearance_m",
            ("joint", "orientation", "level"),
            (("excitation", "random"),),
        )
    ]
    for joint in joints:
        level, clearance = numbers.get(joint, ("", ""))
        requests += [
            TrendRequest(
                _file_name(level, f"level_{joint}"),
                f"Peak frequency against level, {joint} joint, sweeps.",
                "A frequency that moves with level is a sign of a nonlinear joint.",
                "level_g",
                ("clearance_m", "orientation"),
                (("joint", joint), ("excitation", "sine sweep")),
            ),
            TrendRequest(
                _file_name(clearance, f"clearance_{joint}"),
                f"Peak frequency against clearance, every {joint} out-of-plane test.",
                "All levels and kinds of excitation together: look whether they agree.",
                "clearance_m",
                ("excitation", "level"),
                (("joint", joint), ("orientation", "out of plane")),
            ),
        ]
    return requests + [
        TrendRequest(
            f"peak_frequency_against_{x}",
            f"Peak frequency against {_word(x)}.",
            "Each point is a test.",
            x,
            by,
        )
        for x, by in (
            ("level_g2_per_hz", ("joint", "clearance_m", "orientation")),
            ("joint", ("clearance_m", "excitation")),
            ("orientation", ("joint", "clearance_m")),
            ("excitation", ("joint", "clearance_m")),
        )
    ]


def _file_name(figure: str, quantity: str) -> str:
    """Return the name of a trend's files, harmless whatever the log calls its joints."""
    plain = re.sub(r"[^A-Za-z0-9_-]", "_", quantity)[:80]
    number = f"figure_{figure.replace('.', '_')}_" if figure else ""
    return f"{number}peak_frequency_against_{plain}"


def _word(column: str) -> str:
    return label_of(column).partition(" [")[0]


def chosen_trend(runs: Sequence[RunSummary], x: str, by: Sequence[str]) -> TrendRequest:
    """Return the trend that a person asked for by the names of columns.

    Raises
    ------
    LogError
        If the runs have no such column.
    """
    known = list(dict.fromkeys(name for run in runs for name in run.facts))
    columns = [column_of(name, known) for name in (x, *by)]
    grouping = f" by {', '.join(by)}" if by else ""
    name = _file_name("", "_".join((columns[0], *(("by", *columns[1:]) if by else ()))))
    return TrendRequest(
        name,
        f"Peak frequency against {x}{grouping}.",
        "Asked for.",
        columns[0],
        tuple(columns[1:]),
    )


def chosen_channel(wanted: str, known: Sequence[str]) -> str:
    """Return the channel that a person asked for by its name.

    Raises
    ------
    LogError
        If the tests have no such channel.
    """
    if wanted in known:
        return wanted
    meant = near_miss(wanted, list(known))
    question = f"; did you mean {meant!r}?" if meant else "."
    raise LogError(f"no channel {wanted!r}{question} The tests have {', '.join(known)}.")


def column_of(name: str, known: Sequence[str]) -> str:
    """Return the column of a name, with or without the unit at its end.

    Raises
    ------
    LogError
        If there is none.
    """
    plain = name.strip().replace(" ", "_")
    for candidate in (name, plain, *(plain + ending for ending in _UNITS)):
        if candidate in known:
            return candidate
    raise LogError(f"no column {name!r} in the log. It has {', '.join(known)}.")


def trend(runs: Sequence[RunSummary], request: TrendRequest, channel: str) -> Trend | None:
    """Return the trend of a peak; None where fewer than two values of x have a run."""
    return trend_over(peaks_of(runs, channel), request, channel, f"Channel {channel}, {{}}")


def peaks_of(runs: Sequence[RunSummary], channel: str) -> list[TrendValue]:
    """Return the peak of one mode of a channel in every run: the mode that is tallest most."""
    tallest = [main_peak(run, channel) for run in runs]
    mode = followed([
        () if peak is None else _peaks(run, channel)
        for run, peak in zip(runs, tallest, strict=True)
    ])
    return [
        TrendValue(
            run.test,
            run.facts,
            None if peak is None else peak.frequency_hz,
            run.spectrum.bin_width_hz if run.spectrum else math.nan,
            run.duration_s,
            run.promised_s,
            run.left_out if run.unusable else "",
            tallest_hz=None if top is None or top is peak else top.frequency_hz,
            unsure=frozenset(other.test for j, other in enumerate(runs) if mode.unsure(i, j)),
            how="by shape" if mode.by_shape else "",
        )
        for i, (run, peak, top) in enumerate(zip(runs, mode.peaks, tallest, strict=True))
    ]


def _peaks(run: RunSummary, channel: str) -> tuple[PeakSummary, ...]:
    return next(c.psd_peaks for c in run.channels if c.name == channel)


def trend_over(
    tests: Sequence[TrendValue], request: TrendRequest, channel: str, ending: str
) -> Trend | None:
    """Return the trend over a quantity; None where it has fewer than two values.

    Parameters
    ----------
    tests : sequence of TrendValue
        In the order of the log.
    request : TrendRequest
        What to set against what.
    channel, ending : str
        Whose values they are, and the end of the caption; of a peak that is followed, with a
        place for how.
    """
    series: dict[str, list[TrendPoint]] = {}
    taken: list[TrendValue] = []
    left_out: list[str] = []
    for one in tests:
        x = one.facts.get(request.x)
        if x is None or x == "" or not _takes_part(one, request, tests):
            continue
        if one.left_out:
            left_out.append(one.left_out)
        taken.append(one)
        if one.frequency_hz is None or one.left_out:
            continue
        label = ", ".join(filter(None, (shown(c, one.facts.get(c)) for c in request.by)))
        place = float(x) * _scale(request.x) if _is_number(x) else str(x)
        point = TrendPoint(
            one.test, place, one.frequency_hz, one.width_hz, one.present_s, one.promised_s
        )
        series.setdefault(label or "all runs", []).append(point)
    if len({p.x for points in series.values() for p in points}) < 2:
        return None
    key: Callable[[TrendPoint], tuple[bool, float, str]] = lambda p: (  # noqa: E731
        isinstance(p.x, str),
        p.x if isinstance(p.x, float) else 0.0,
        str(p.x),
    )
    ordered = {name: tuple(sorted(points, key=key)) for name, points in sorted(series.items())}
    sentences = [*remarks_on_trend(taken), *_jumps(ordered, taken)]
    caption = " ".join([request.caption, ending.format(_how(taken)), *sentences])
    if left_out:
        caption += f" Left out: {'; '.join(left_out)}."
    return Trend(request.name, request.title, caption, label_of(request.x), channel, ordered)


def _how(taken: Sequence[TrendValue]) -> str:
    """Return which peak the points of a trend are."""
    if not any(one.tallest_hz for one in taken):
        return "tallest peak of the PSD in the band."
    how = next((one.how for one in taken if one.how), "by continuity")
    return f"the mode that makes the tallest peak of most tests, followed {how}."


def remarks_on_trend(taken: Sequence[TrendValue]) -> list[str]:
    """Return where the tallest peak is not of the mode that is followed, in sentences."""
    away = [
        f"{numeral(one.tallest_hz, 4)} Hz in test {one.test}"
        + ("" if one.frequency_hz is not None else " (no peak of the mode there)")
        for one in taken
        if one.tallest_hz is not None and not one.left_out
    ]
    return [f"Another mode makes the tallest peak: {', '.join(away)}."] if away else []


def _jumps(
    series: Mapping[str, Sequence[TrendPoint]], taken: Sequence[TrendValue]
) -> list[str]:
    """Return between which tests a series may have jumped to another mode, in sentences."""
    unsure = {one.test: one.unsure for one in taken}
    return [
        f"From test {one.test} to {other.test} it moves further than half-way to another mode: "
        "it may be another mode there."
        for points in series.values()
        for one, other in pairwise(points)
        if other.test in unsure[one.test]
    ]


def _takes_part(one: TrendValue, request: TrendRequest, tests: Sequence[TrendValue]) -> bool:
    """Return whether a test has the values asked for, where any test has a value there."""
    return all(
        one.facts.get(column) == value
        for column, value in request.where
        if any(other.facts.get(column) for other in tests)
    )


def _is_number(value: Value) -> bool:
    return isinstance(value, float | int) and not isinstance(value, bool)


def _scale(column: str) -> float:
    return next((s for ending, (_, s) in _UNITS.items() if column.endswith(ending)), 1.0)


def label_of(column: str) -> str:
    """Return the name of a column for an axis: ``clearance [mm]`` for ``clearance_m``."""
    for ending, (unit, _) in _UNITS.items():
        if column.endswith(ending):
            return f"{column.removesuffix(ending).replace('_', ' ')} [{unit}]"
    return column.replace("_", " ")


def shown(column: str, value: Value) -> str:
    """Return a value of a column for people: ``0.05 mm`` for a clearance_m of 5e-5."""
    if value is None or value == "":
        return ""
    if isinstance(value, float | int) and not isinstance(value, bool):
        unit = next((u for ending, (u, _) in _UNITS.items() if column.endswith(ending)), "")
        places = ".2f" if unit == "mm" else ".4g"
        return f"{format(float(value) * _scale(column), places)} {unit}".strip()
    return str(value).replace("^2", "²") if column == "level" else str(value)


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
        same_excitation = [one for one in tests if one.facts.get("excitation") == excitation]
        shift_trend = trend_over(same_excitation, request, "", "")
        if shift_trend is None or not shift_trend.numeric:
            continue
        spans = [
            (abs(points[-1].frequency_hz - points[0].frequency_hz), label, points)
            for label, points in shift_trend.series.items()
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
    remarks = remarks_on_trend(ends)
    first, last = (one.test for one in ends)
    if last in ends[0].unsure:
        remarks.append(
            f"Fewer than three sensors cannot tell whether test {first} and test {last} show "
            "one mode."
        )
    return remarks


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
    columns = {}
    for number, track in enumerate(analysis.tracks, 1):
        seen = seen_of(analysis, track)
        requests = [*standard_trends(seen), *(_request(*one) for one in FURTHER.items())]
        drawn = [
            _trend(request, seen, number, _track_frequency(analysis, track))
            for request in requests
        ]
        kept = {trend.name: trend for trend in drawn if trend is not None}
        if kept:
            columns[number] = list(kept.values())
    return columns


def mode_shifts(analysis: ModalAnalysis) -> tuple[str, ...]:
    """Return the shift of each mode with clearance or level, a sentence each."""
    shifts = (
        shift_sentence(
            seen_of(analysis, track),
            f"frequency of mode {number} ({numeral(_track_frequency(analysis, track), 4)} Hz)",
        )
        for number, track in enumerate(analysis.tracks, 1)
        if len(track.sightings) > 1
    )
    return tuple(text for text in shifts if text)


def seen_of(analysis: ModalAnalysis, track: Track) -> list[TrendValue]:
    """Return the frequency of a mode in every test, and how far its interval reaches."""
    modes = {sighting.test: sighting.mode for sighting in track.sightings}
    trend_values = []
    for place, one in enumerate(analysis.tests):
        mode = modes.get(place)
        low, high = (0.0, 0.0) if mode is None else one.modes.frequency_bounds[:, mode]
        frequency = None if mode is None else float(one.modes.frequency[mode])
        trend_values.append(
            TrendValue(one.name, _facts(analysis, one), frequency, float(high - low))
        )
    return trend_values


def _facts(analysis: ModalAnalysis, one: TestModes) -> Mapping[str, Value]:
    """Return the facts of a test in its log; the name of the log, where there are two."""
    owner, colon, _ = one.name.rpartition(":")
    both = any(":" in other.name for other in analysis.tests)
    campaign = {"campaign": owner if colon else "this log"} if both else {}
    return {**facts_of(one.test), **campaign}


def _track_frequency(analysis: ModalAnalysis, track: Track) -> float:
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
    mode_trend = trend_over(seen, asked, f"mode {number}", ending)
    if mode_trend is None:
        return None
    return replace(mode_trend, quantity="natural frequency [Hz]", bars="95 % interval")
