"""Free decays: frequency and damping of every mode against its amplitude, by two methods."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final, TypeAlias, final

import numpy as np

from shakerproc.data import Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.analyses import RINGS, AbstractAnalysis
from shakerproc.runs.panels import Analysis, Cell, Panel, PanelLine, PanelScale
from shakerproc.runs.result import RunResult, shown_unit
from shakerproc.spectra.decays import (
    DecayCurve,
    DecayLine,
    DecayReading,
    DecayTrend,
    decay_curve,
    decay_lines,
    free_start,
    trend_of,
)
from shakerproc.spectra.responses import INTEGRATIONS

DISPUTED: Final = 0.1
"""Share of stretches in which two methods may disagree without a remark [-]: their intervals,
each of 95 %, miss each other in less than one of a hundred by chance."""

BEATS: Final = 1.2
"""How far an amplitude may rise again, as a factor, before two modes are taken to beat [-]:
noise of a tenth of the amplitude, at which reading ends, rarely makes as much."""

HARMONIC: Final = 0.005
"""How far from a whole multiple a harmonic lies at most [-]: a mode shifts while it decays."""

HIGHEST: Final = 5
"""Highest harmonic that is looked for [-]."""

MARGIN: Final = 0.03
"""Room above and below the limits in a figure, over the distance of both [-]."""

QUANTITIES: Final[Mapping[str, tuple[str, float]]] = {
    "frequency": ("natural frequency [Hz]", 1.0),
    "damping": ("damping ratio [%]", 100.0),
}
"""What is drawn: the label of its axis and the factor to its unit."""

Curve: TypeAlias = tuple[str, int, Sequence[DecayReading]]
"""Name, style and readings of a curve."""

METHODS: Final = ("least squares", "peaks and crossings")
"""What the two methods are called."""

LONGEST: Final = 2**25
"""Samples of all channels together that are read at most, 256 MiB [-]."""

DRAWN: Final = 6
"""Modes that are drawn at most, two figures each [-]."""


def remarks(curve: DecayCurve) -> Iterator[str]:
    """Yield remarks on the curves of a mode."""
    name = f"{numeral(curve.line.frequency, 4)} Hz"
    if curve.problem:
        yield f"{name}: no curve: {curve.problem}"
        return
    disputed = curve.disputed
    if len(disputed) > DISPUTED * len(curve.fitted):
        sizes = [curve.fitted[i].amplitude for i in disputed]
        whole = [one.amplitude for one in curve.fitted]
        yield (
            f"{name}: the two methods disagree by more than their intervals in {len(disputed)} "
            f"of {len(curve.fitted)} stretches, at {min(sizes) / max(whole):.0%} to "
            f"{max(sizes) / max(whole):.0%} of the largest amplitude. Another mode lies close "
            "by, or the frequency shifts within a stretch"
        )
    if curve.rises > BEATS:
        yield (
            f"{name}: the amplitude comes back to {numeral(curve.rises)} times what it was. "
            "Another mode lies close by, and the curves are those of both; a sensor at its "
            "node tells them apart"
        )
    shifts = [abs(one.frequency - curve.line.frequency) for one in curve.fitted]
    if max(shifts) > curve.reach:
        yield (
            f"{name}: the frequency shifts by {numeral(max(shifts))} Hz, and the filters pass "
            f"{numeral(curve.reach)} Hz to either side: amplitude and damping are too low there"
        )


def harmonic_of(line: DecayLine, lines: Sequence[DecayLine]) -> tuple[int, float] | None:
    """Return of which lower line a line may be a harmonic, and which one; None if of none."""
    for lower in lines:
        times = round(line.frequency / lower.frequency)
        off = abs(line.frequency / lower.frequency - times)
        if 2 <= times <= HIGHEST and off < HARMONIC * times:
            return times, lower.frequency
    return None


def signature(trend: DecayTrend, readings: Sequence[DecayReading]) -> str:
    """Return how frequency and damping go with amplitude, and which laws do that."""
    first, last = readings[0], readings[-1]
    frequency = (
        f"frequency {last.frequency:.5g} Hz at the smallest amplitude, "
        f"{first.frequency:.5g} Hz at the largest"
        if trend.shifts
        else "no trend of frequency with amplitude"
    )
    damping = (
        f"damping {numeral(100.0 * last.damping)} % there and "
        f"{numeral(100.0 * first.damping)} %"
        if trend.shifts and trend.damps
        else f"damping {numeral(100.0 * last.damping)} % at the smallest amplitude, "
        f"{numeral(100.0 * first.damping)} % at the largest"
        if trend.damps
        else "no trend of damping"
    )
    law = law_words(trend)
    return f"{frequency}; {damping}.{f' {law}' if law else ''}"


def law_words(trend: DecayTrend) -> str:
    """Return which laws would do that; empty where nothing changes."""
    shift = trend.shift if trend.shifts else 0.0
    sentences = (
        (trend.law == -1, "A part of the damping goes as 1/amplitude: dry friction "
         "(coulomb_friction)."),
        (trend.law == 1, "A part of the damping goes as amplitude: a quadratic law "
         "(quadratic_damping)."),
        (shift < 0.0 and trend.damps, "Softer at larger amplitude, with another damping: slip "
         "in a joint (jenkins, iwan, bouc_wen)."),
        (shift > 0.0, "Stiffer at larger amplitude: a gap or a hardening spring (gap, "
         "cubic_stiffness)."),
        (shift < 0.0, "Softer at larger amplitude: a softening spring (cubic_stiffness)."),
        (trend.damps, "Damping changes with amplitude, and stiffness does not."),
    )  # fmt: skip
    return next((text for holds, text in sentences if holds), "")


@final
@dataclass(frozen=True, slots=True)
class Amplitude:
    """The quantity along the axis: its channel, its shown unit and the factor to that."""

    channel: str
    unit: str
    factor: float


def decay_panels(
    name: str,
    about: str,
    caption: str,
    amplitude: Amplitude,
    curves: Sequence[Curve],
    *,
    limited: int,
) -> list[Panel]:
    """Return two figures, frequency and damping, of curves overlaid.

    Parameters
    ----------
    name : str
        Of the files, before the quantity.
    about, caption : str
        Which mode, and what to look for.
    amplitude : Amplitude
        What lies along the axis.
    curves : sequence of Curve
        What is drawn.
    limited : int
        Of how many of them, the first, the 95 % limits are drawn.
    """
    along = PanelScale(f"amplitude of {amplitude.channel} [{amplitude.unit}]")
    panels = []
    for quantity, (label, factor) in QUANTITIES.items():
        lines = [_lines(one, quantity, (amplitude.factor, factor)) for one in curves]
        limits = [edge for edges, _ in lines[:limited] for edge in edges]
        drawn = (*limits, *(line for _, line in lines))
        title = f"{quantity.capitalize()} of {about}"
        panels.append(
            Panel(f"{name}_{quantity}", title, caption, along, _across(label, drawn), drawn)
        )
    return panels


def _lines(
    curve: Curve, quantity: str, factors: tuple[float, float]
) -> tuple[list[PanelLine], PanelLine]:
    """Return both limits of a curve, and the curve."""
    name, style, readings = curve
    x = factors[0] * np.array([one.amplitude for one in readings])
    y = factors[1] * np.array([getattr(one, quantity) for one in readings])
    half = factors[1] * np.array([getattr(one, f"{quantity}_error") for one in readings])
    limits = [PanelLine("", x, edge, look="paper") for edge in (y - half, y + half)]
    return limits, PanelLine(name, x, y, style=style)


def _across(label: str, lines: Sequence[PanelLine]) -> PanelScale:
    shown = [line.y for line in lines if line.y.size]
    low, high = min(y.min() for y in shown), max(y.max() for y in shown)
    margin = MARGIN * (high - low)
    return PanelScale(
        label, logarithmic=False, ends=(float(low - margin), float(high + margin))
    )


@final
@dataclass(frozen=True, slots=True, eq=False)
class DecayMode:
    """A mode of a decay in the channel that shows it best, `factor` to its shown unit."""

    number: int
    channel: str
    unit: str
    factor: float
    integrations: int | None
    curve: DecayCurve
    start: float

    @property
    def methods(self) -> tuple[tuple[str, tuple[DecayReading, ...]], ...]:
        """Name and readings of both methods."""
        return tuple(zip(METHODS, (self.curve.fitted, self.curve.charted), strict=True))


@final
class DecayAnalysis(AbstractAnalysis):
    """Frequency and damping against amplitude for every mode of the free part of a run."""

    kind: ClassVar[str] = "decays"

    def of(self, recording: Recording, result: RunResult) -> Analysis | None:
        """Return the curves of a run; None where nothing is left to ring in it.

        What a decay does not tell is a flag of a free decay, and a sentence of a shock, which
        need not ring.
        """
        if result.test.excitation not in RINGS:
            return None
        try:
            modes, start = _modes(recording, result)
        except SpectrumError as error:
            return _nothing(self.kind, str(error), result)
        if not modes:
            return _nothing(self.kind, _no_mode(result), result)
        known = [mode for mode in modes if mode.curve.fitted]
        problems = [text for mode in modes for text in remarks(mode.curve)]
        expected = result.test.excitation == "free decay"
        return Analysis(
            kind=self.kind,
            title="Frequency and damping against amplitude",
            columns=_columns(known),
            summary=tuple(_row(mode) for mode in modes),
            panels=tuple(panel for mode in known[:DRAWN] for panel in _panels(mode)),
            sentences=(
                *_sentences(modes, start, result),
                *(() if expected else problems),
            ),
            problems=tuple(problems) if expected else (),
        )


def _modes(recording: Recording, result: RunResult) -> tuple[list[DecayMode], float]:
    """Return the modes of the free part, and where that begins [s].

    Raises
    ------
    SpectrumError
        If there is none.
    """
    channels, crop, rate = result.channels, result.crop, result.recorded.sample_rate
    driving = {"control"} if result.controls else {"force"}
    inputs = [i for i, c in enumerate(channels) if c.role in driving]
    rows = [
        i for i, c in enumerate(channels) if c.role not in {"control", "force", "condition"}
    ]
    if not rows:
        raise SpectrumError(
            "no channel responds; give the role response to what measures the motion"
        )
    if crop.n_samples * len(channels) > LONGEST:
        raise SpectrumError(
            f"{numeral(crop.n_samples / rate)} s of {len(channels)} channels are too long to "
            "be "
            "read as a decay; crop: {from: ..., to: ...} to the part that rings"
        )
    samples = recording.samples(crop.start, crop.stop)
    start = free_start(samples[rows], samples[inputs])
    free = samples[rows][:, start:]
    lines = decay_lines(free, rate, result.band, count=result.test.processing.peaks.count)
    modes = []
    for number, line in enumerate(lines, 1):
        channel = channels[rows[line.row]]
        unit, factor = shown_unit(channel.unit)
        order = INTEGRATIONS.get(channel.unit)
        modes.append(
            DecayMode(
                number,
                channel.name,
                unit,
                factor,
                None if order is None else order + 1,
                decay_curve(free[line.row], rate, line),
                (crop.start + start) / rate,
            )
        )
    return modes, (crop.start + start) / rate


def _nothing(kind: str, why: str, result: RunResult) -> Analysis:
    flagged = result.test.excitation == "free decay"
    return Analysis(
        kind=kind,
        title="Frequency and damping against amplitude: not known",
        columns={},
        summary=(),
        panels=(),
        sentences=(why,),
        problems=(why,) if flagged else (),
    )


def _no_mode(result: RunResult) -> str:
    low, high = result.band
    return (
        f"no mode stands out of the noise within {numeral(low, 4)} to {numeral(high, 4)} Hz "
        "after the input; correct from and to, or look whether anything rings"
    )


def _displacement(mode: DecayMode, one: DecayReading) -> float | None:
    """Return the amplitude as a displacement [mm]; None for a channel without motion."""
    if mode.integrations is None:
        return None
    size: float = (2.0 * np.pi * one.frequency) ** mode.integrations
    return 1e3 * one.amplitude / size


def _columns(modes: Sequence[DecayMode]) -> dict[str, list[Any]]:
    """Return the table: a row for each mode, stretch and method."""
    rows = [
        {
            "mode": mode.number,
            "channel": mode.channel,
            "method": method,
            "stretch": k,
            "time_s": mode.start + one.time,
            "amplitude": one.amplitude * mode.factor,
            "unit": mode.unit,
            "displacement_mm": _displacement(mode, one),
            "frequency_hz": one.frequency,
            "frequency_low_hz": one.frequency - one.frequency_error,
            "frequency_high_hz": one.frequency + one.frequency_error,
            "damping_percent": 100.0 * one.damping,
            "damping_low_percent": 100.0 * (one.damping - one.damping_error),
            "damping_high_percent": 100.0 * (one.damping + one.damping_error),
        }
        for mode in modes
        for method, readings in mode.methods
        for k, one in enumerate(readings, 1)
    ]
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}


def _row(mode: DecayMode) -> dict[str, Cell]:
    """Return a mode at both ends of its decay, by least squares."""
    curve = mode.curve
    ends = (curve.fitted[0], curve.fitted[-1]) if curve.fitted else (None, None)
    trend = trend_of(curve.fitted)
    cells: dict[str, Cell] = {"mode": float(mode.number), "channel": mode.channel}
    for name, one in zip(("largest", "smallest"), ends, strict=True):
        cells[f"{name}_amplitude"] = None if one is None else one.amplitude * mode.factor
    cells["unit"] = mode.unit
    for name, one in zip(("largest", "smallest"), ends, strict=True):
        cells[f"frequency_at_{name}_hz"] = (
            curve.line.frequency if one is None and name == "largest" else
            None if one is None else one.frequency
        )  # fmt: skip
    for name, one in zip(("largest", "smallest"), ends, strict=True):
        cells[f"damping_at_{name}_percent"] = None if one is None else 100.0 * one.damping
    cells["damping_exponent"] = None if trend is None else trend.exponent
    cells["stretches"] = float(len(curve.fitted))
    cells["disagree"] = float(len(curve.disputed))
    cells["withheld"] = curve.problem
    return cells


def _sentences(modes: Sequence[DecayMode], start: float, result: RunResult) -> Iterator[str]:
    """Yield the start of the free part, and the law that each mode points to."""
    yield (
        f"The free part begins at {numeral(start, 4)} s. Damping is that of the decay of the "
        "measured quantity; intervals of the table are those of 95 %."
    )
    lines = [mode.curve.line for mode in modes]
    for mode in modes:
        name = f"Mode {mode.number} ({numeral(mode.curve.line.frequency, 4)} Hz)"
        trend = trend_of(mode.curve.fitted)
        if trend is not None:
            yield f"{name}: {signature(trend, mode.curve.fitted)}"
        lower = harmonic_of(mode.curve.line, lines)
        if lower is not None:
            times, frequency = lower
            yield (
                f"{name} is {times} times {numeral(frequency, 4)} Hz: it may be a harmonic of "
                "that mode, not a mode."
            )
    if len(result.channels) - len(result.controls) == 1:
        yield (
            "One response only: two modes closer than the filters are wide show as one, whose "
            "amplitude beats."
        )


def _panels(mode: DecayMode) -> list[Panel]:
    """Return frequency and damping against amplitude, both methods overlaid."""
    curves = [(name, style, readings) for style, (name, readings) in enumerate(mode.methods)]
    return decay_panels(
        f"decays_{mode.number}",
        f"mode {mode.number}, {numeral(mode.curve.line.frequency, 4)} Hz",
        "Two methods overlaid; grey: 95 % limits of each.",
        Amplitude(mode.channel, mode.unit, mode.factor),
        curves,
        limited=len(curves),
    )
