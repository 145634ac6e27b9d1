"""Figures of a run, each described once, drawn as PNG and on the page."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from shakerproc import files
from shakerproc.campaign import trends
from shakerproc.numerals import numeral
from shakerproc.report.figures import style
from shakerproc.report.figures.figure import (
    Axis,
    Curve,
    Figure,
    Filling,
    Image,
    Mark,
    Plot,
    Span,
)
from shakerproc.report.runs.in_units import (
    RunContent,
    even_axis,
    frequency_axis,
    logarithmic_axis,
    outside,
    swept_axis,
)
from shakerproc.report.runs.responses import (
    coherence,
    harmonics,
    harmonics_plot,
    psd_ratio_plot,
    response,
    sweep,
)
from shakerproc.runs.levels import control_text as told_of_control
from shakerproc.runs.levels import density_unit
from shakerproc.runs.summarising import RANGE_DB, RunCurve
from shakerproc.runs.summary import ControlSummary, PeakSummary, RunSummary


def control_verdict(run: RunSummary, where: str) -> str:
    """Return whether the controls kept the limits that are drawn."""
    if run.control is None:
        return " The controls should stay between the thin lines."
    return f" Mean control (limits: thin lines) {told_of_control(run.control, where)}."


def alarm_lines(run: RunSummary) -> list[Curve]:
    """Return the limits of the control density as lines over the band."""
    if run.alarm is None or run.spectrum is None:
        return []
    limits = [("alarm limits", run.alarm, style.ALARM_STYLE)]
    if run.control is not None:
        limits = _limits(run.control, 10.0)
    return _lines(limits, run.spectrum.band_hz)


def _limits(
    control: ControlSummary, per_decade: float
) -> list[tuple[str, tuple[float, float], int]]:
    """Return name, values and style of the alarm and abort limits; 10 or 20 dB a decade."""
    found = []
    for name, decibels, number in (
        ("alarm", control.alarm_db, style.ALARM_STYLE),
        ("abort", control.abort_db, style.ABORT_STYLE),
    ):
        factor = 10.0 ** (decibels / per_decade)
        pair = (control.demanded / factor, control.demanded * factor)
        found.append((f"{name} ±{decibels:g} dB", pair, number))
    return found


def _lines(
    limits: list[tuple[str, tuple[float, float], int]], band: tuple[float, float]
) -> list[Curve]:
    """Return two lines for each pair of limits, of which the first has the name."""
    return [
        Curve(label, np.array(band), np.full(2, limit), number, thin=True)
        for name, pair, number in limits
        for label, limit in zip((name, ""), pair, strict=True)
    ]


def level(content: RunContent) -> Figure | None:
    """Return the amplitude of the control along a sweep, and its limits."""
    curves, run = content.of("level"), content.run
    if not curves or run.control is None:
        return None
    lines = [
        Curve(f"mean control {c.part}".strip(), c.x, c.y, style_of)
        for c, style_of in zip(curves, style.CONTROL_STYLES * len(curves), strict=False)
    ]
    axis = swept_axis(lines)
    band = run.spectrum.band_hz if run.spectrum else (axis.low, axis.high)
    limits = _lines(_limits(run.control, 20.0), band)
    top = 1.08 * max(float(np.nanmax(line.y)) for line in (*lines, *limits))
    plot = Plot(
        [*lines, *limits],
        axis,
        Axis(f"[{run.level_unit}]", 0.0, top),
        spans=outside(run, axis),
        title="Level of the control",
        caption=f"Fundamental along the sweep.{control_verdict(run, 'sweep')}",
        kind="level",
        height=2.9,
    )
    return Figure("level", [plot], "level of the control along the sweep; thin: limits")


def time(content: RunContent) -> Figure | None:
    """Return channels over the whole recording, the part outside the crop shaded."""
    curves, run = content.of("time"), content.run
    if not curves or run.duration_s is None:
        return None
    axis, spans, notes = Axis("time [s]", 0.0, run.promised_s or run.duration_s), [], []
    caption = "Extremes of each slice."
    if run.crop_s is not None:
        spans = [Span(0.0, run.crop_s[0]), Span(run.crop_s[1], axis.high)]
        caption += " Grey is cropped away: the run should fill what is white."
        notes.append(f"processed {run.crop_s[0]:.2f} to {run.crop_s[1]:.2f} s")
    if content.of("threshold"):
        caption += " Thin: threshold of the crop."
        notes.append("thin: threshold of the crop")
    marks = _happened(run, axis.high)
    plots = [replace(_channel(content, c, axis), spans=spans, marks=marks) for c in curves]
    below = [replace(plot, marks=[Mark(m.x, "") for m in marks]) for plot in plots[1:]]
    first = replace(plots[0], title="Time", caption=caption)
    return Figure("time", [first, *below], ", ".join(notes), together=True)


def _channel(content: RunContent, curve: RunCurve, axis: Axis) -> Plot:
    """Return one channel against time, with the threshold that it is compared with."""
    limits = [c for c in content.of("threshold") if c.channel == curve.channel]
    lines = [Curve("", c.x, c.y, style.ABORT_STYLE, thin=True) for c in limits]
    low = curve.y if curve.low is None else curve.low
    area = Filling(curve.channel, curve.x, low, curve.y, content.styles[curve.channel])
    label = f"[{content.unit_of(curve.channel)}]"
    return Plot(
        [area, *lines],
        axis,
        even_axis(label, [low, curve.y, *(line.y for line in lines)]),
        kind="time",
        channel=curve.channel,
        height=0.85,
    )


def _happened(run: RunSummary, end: float) -> list[Mark]:
    """Return the events of the log, a doubtful start, and where the recording is cut off."""
    marks = [Mark(at, files.printable(note)) for at, note in run.events if at <= end]
    if run.crop_s is not None and any(flag.kind == "crop" for flag in run.flags):
        marks.append(Mark(run.crop_s[0], "stands alone: a spike?"))
    if run.incomplete and run.duration_s is not None:
        marks.append(Mark(run.duration_s, f"cut off at {numeral(run.duration_s)} s"))
    return marks


def psd(content: RunContent) -> Figure | None:
    """Return the density of every channel, two axes for each unit."""
    plots = [_density(content, unit) for unit in content.units if content.of("psd", unit)]
    height = 3.0 if len(plots) == 1 else 2.2
    found = [replace(plot, height=height) for plot in plots]
    return Figure("psd", found, _worth(content.run)) if found else None


def _worth(run: RunSummary) -> str:
    s = run.spectrum
    return (
        ""
        if s is None
        else f"bins {numeral(s.bin_width_hz)} Hz, {s.degrees_of_freedom:.0f} DOF"
    )


def _density(content: RunContent, unit: str) -> Plot:
    """Return the densities of the channels of one unit, limits of the control among them."""
    run, lines = content.run, content.lines("psd", unit)
    axis, spread = frequency_axis(lines), _spread(run)
    lines = [replace(line, spread=spread) for line in lines]
    best = max(filter(None, _main_peaks(run, unit)), key=lambda p: p.height, default=None)
    marks, caption = [], ""
    if best is not None:
        marks = [Mark(best.frequency_hz, f"peak {best.frequency_hz:.1f} Hz")]
        caption = (
            "The tallest peak of a response inside the excited band is its peak frequency."
        )
    limits = alarm_lines(run) if unit == content.control_unit else []
    if limits:
        caption += control_verdict(run, "band")
    return Plot(
        [*lines, *limits],
        axis,
        logarithmic_axis(f"PSD [{density_unit(unit)}]", lines),
        marks,
        outside(run, axis),
        title="Power spectral density",
        caption=caption,
        kind="psd",
    )


def _spread(run: RunSummary) -> tuple[float, float] | None:
    """Return the 95 % bounds of a density as multiples of it, None of blows."""
    s = run.spectrum
    if s is None or s.low_factor is None or s.high_factor is None:
        return None
    return s.low_factor, s.high_factor


def _main_peaks(run: RunSummary, unit: str) -> list[PeakSummary | None]:
    return [
        trends.main_peak(run, c.name)
        for c in run.channels
        if c.role != "control" and c.unit == unit
    ]


def psd_and_response(content: RunContent) -> Figure | None:
    """Return the thesis' two-in-one figure: densities above, PSD ratio below.

    At a single frequency a ratio of densities says nothing: the harmonics stand there instead.
    """
    below = psd_ratio_plot(content) or harmonics_plot(content)
    if below is None:
        return None
    unit = content.control_unit or content.unit_of(content.of("psd")[0].channel)
    above = replace(_density(content, unit), height=2.85)
    plots = [above, replace(below, height=2.85)]
    return Figure("psd_and_response", plots, _worth(content.run))


def notch(content: RunContent) -> Figure | None:
    """Return two periods before and after the tone was taken out (figures 5.41 to 5.44)."""
    curves = content.of("notch")
    if not curves:
        return None
    tone = _tone(content.run)
    plots = [
        Plot(
            lines,
            Axis("time [s]", float(lines[0].x[0]), float(lines[0].x[-1])),
            even_axis(f"[{content.unit_of(name)}]", [line.y for line in lines]),
            title=f"Two periods of {name}, {tone} taken out",
            caption="What is left is what the joint adds to the tone: nothing in a linear one.",
            kind="notch",
            channel=name,
            height=1.2,
        )
        for name, lines in _before_and_after(content, curves).items()
    ]
    return Figure("notch", plots, f"two periods, {tone} taken out")


def notch_psd(content: RunContent) -> Figure | None:
    """Return the density of each response with and without the tone (figures 5.43 and 5.44)."""
    curves = content.of("notch_psd")
    if not curves:
        return None
    axis, tone = frequency_axis(curves), _tone(content.run)
    plots = [
        Plot(
            lines,
            axis,
            logarithmic_axis(f"[{density_unit(content.unit_of(name))}]", lines),
            spans=outside(content.run, axis),
            title=f"Power spectral density of {name}, {tone} taken out",
            kind="notch_psd",
            channel=name,
            height=1.8,
        )
        for name, lines in _before_and_after(content, curves).items()
    ]
    return Figure("notch_psd", plots, f"PSD, {tone} taken out")


def _tone(run: RunSummary) -> str:
    return trends.shown("notch_hz", run.facts.get("notch_hz"))


def _before_and_after(
    content: RunContent, curves: Sequence[RunCurve]
) -> dict[str, list[Curve]]:
    """Return the curves of each channel: before in grey, after in its colour."""
    found: dict[str, list[Curve]] = {}
    for c in curves:
        before = c.part == "before"
        number = style.CONTROL_STYLES[1] if before else content.styles[c.channel]
        found.setdefault(c.channel, []).append(Curve(c.part, c.x, c.y, number))
    return found


def spectrogram(content: RunContent) -> Figure | None:
    """Return the density of one channel against time and frequency."""
    found = content.surface
    if found is None:
        return None
    top = float(found.level.max())
    image = Image(
        found.time, found.frequency, found.level, top - RANGE_DB, top, f"dB re 1 {found.unit}"
    )
    plot = Plot(
        [],
        Axis("time [s]", float(found.time[0]), float(found.time[-1])),
        Axis("frequency [Hz]", 0.0, float(found.frequency[-1])),
        title="Spectrogram",
        caption=f"Density of {found.channel} in dB re 1 {found.unit}; of neighbouring cells "
        "the largest.",
        image=image,
        height=3.1,
    )
    return Figure("spectrogram", [plot], f"spectrogram of {found.channel}")


FIGURES: Final[Mapping[str, Callable[[RunContent], Figure | None]]] = MappingProxyType({
    "time": time,
    "psd": psd,
    "response": response,
    "sweep": sweep,
    "level": level,
    "coherence": coherence,
    "psd_and_response": psd_and_response,
    "harmonics": harmonics,
    "notch": notch,
    "notch_psd": notch_psd,
    "spectrogram": spectrogram,
})
"""Every figure of a run by its name, in the order of the page."""

IN_FILES: Final = tuple(name for name in FIGURES if name != "harmonics")
"""Those that are files; harmonics stand below the densities there."""

ON_PAGE: Final = tuple(name for name in FIGURES if name != "psd_and_response")
"""Those of the page, where densities and ratios are figures of their own."""
