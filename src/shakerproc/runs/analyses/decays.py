"""Free decays: frequency and damping of every mode against its amplitude, by two methods."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final, final

import numpy as np

from shakerproc.data import Recording
from shakerproc.errors import SpectrumError
from shakerproc.numerals import numeral
from shakerproc.runs.analyses.base import RINGS, AbstractAnalysis
from shakerproc.runs.analyses.decay_panels import Amplitude, decay_panels
from shakerproc.runs.analyses.decay_words import harmonic_of, remarks, signature
from shakerproc.runs.analysis import Analysis, Cell, Panel
from shakerproc.runs.result import RunResult, shown_unit
from shakerproc.spectra.decays import (
    DecayCurve,
    DecayReading,
    decay_curve,
    decay_lines,
    free_start,
    trend_of,
)
from shakerproc.spectra.responses.estimators import INTEGRATIONS

METHODS: Final = ("least squares", "peaks and crossings")
"""What the two methods are called."""

LONGEST: Final = 2**25
"""Samples of all channels together that are read at most, 256 MiB [-]."""

DRAWN: Final = 6
"""Modes that are drawn at most, two figures each [-]."""


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
            told=(
                *_told(modes, start, result),
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
    channels, crop, rate = result.channels, result.crop, result.sample_rate
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
        told=(why,),
        problems=(why,) if flagged else (),
    )


def _no_mode(result: RunResult) -> str:
    low, high = result.band
    return (
        f"no mode stands out of the noise within {numeral(low, 4)} to {numeral(high, 4)} Hz "
        "after the input; correct from and to, or look whether anything rings"
    )


def _displacement(mode: DecayMode, one: DecayReading) -> float | None:
    """Return the amplitude as a displacement [mm]; None of what is no motion."""
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


def _told(modes: Sequence[DecayMode], start: float, result: RunResult) -> Iterator[str]:
    """Yield where the free part begins, and what each mode says of the law behind it."""
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
