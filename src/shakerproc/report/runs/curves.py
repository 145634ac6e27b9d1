"""Content of the figures of a run: its numbers and curves, and the axes around them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, final

import numpy as np

from shakerproc.campaign import trends
from shakerproc.data import FloatArray
from shakerproc.report.figures import style
from shakerproc.report.figures.figure import Axis, Curve, Span
from shakerproc.runs.curves import RunCurve, RunSurface
from shakerproc.runs.summary import SURFACE_STEPS, CurveSummary, RunSummary, SurfaceSummary

STILL: Final = 200
"""Points of a line in a still figure of a run, two for five pixels: 92 runs stay small."""

DECADES: Final = 9
"""Decades below the largest value that a logarithmic axis shows at most."""


@final
@dataclass(frozen=True, slots=True, eq=False)
class RunContent:
    """A run as its figures show it.

    Attributes
    ----------
    run : RunSummary
        Its numbers.
    curves : sequence of RunCurve
        Every curve for a file, those that a summary keeps for the page.
    surface : RunSurface, optional
        Its spectrogram.
    """

    run: RunSummary
    curves: Sequence[RunCurve]
    surface: RunSurface | None = None

    @property
    def styles(self) -> Mapping[str, int]:
        """Colour and dash of each channel."""
        channels = self.run.channels
        chosen = style.styles([c.role for c in channels])
        return dict(zip((c.name for c in channels), chosen, strict=True))

    @property
    def units(self) -> list[str]:
        """Units of the channels, each once."""
        return list(dict.fromkeys(c.unit for c in self.run.channels))

    @property
    def control_unit(self) -> str:
        """Unit of the control; empty without one."""
        return next((c.unit for c in self.run.channels if c.role == "control"), "")

    def unit_of(self, channel: str) -> str:
        """Return the unit of a channel."""
        return next((c.unit for c in self.run.channels if c.name == channel), "")

    def of(self, kind: str, unit: str | None = None) -> list[RunCurve]:
        """Return the curves of a kind, those of channels of one unit if it is given."""
        found = [curve for curve in self.curves if curve.kind == kind]
        return [c for c in found if unit is None or self.unit_of(c.channel) == unit]

    def lines(self, kind: str, unit: str | None = None) -> list[Curve]:
        """Return the curves of a kind as lines, each in the style of its channel."""
        styles = self.styles
        return [
            Curve(f"{c.channel} {c.part}".strip(), c.x, c.y, styles[c.channel])
            for c in self.of(kind, unit)
        ]


def kept(run: RunSummary) -> RunContent:
    """Return the content of a run's figures from its summary."""
    surface = None if run.surface is None else _surface(run.surface)
    return RunContent(run, [_curve(curve) for curve in run.curves], surface)


def _surface(kept: SurfaceSummary) -> RunSurface:
    steps = np.array([np.frombuffer(row.encode(), np.uint8) for row in kept.rows]) - ord("A")
    return RunSurface(
        kept.channel,
        kept.unit,
        np.linspace(*kept.time_s, steps.shape[1]),
        np.linspace(*kept.frequency_hz, steps.shape[0]),
        kept.low_db + (kept.high_db - kept.low_db) * steps / (SURFACE_STEPS - 1),
    )


def _curve(curve: CurveSummary) -> RunCurve:
    low = values_of(curve.low) if curve.low else None
    return RunCurve(
        curve.kind, curve.channel, values_of(curve.x), values_of(curve.y), low, curve.part
    )


def values_of(values: Sequence[float | None]) -> FloatArray:
    """Return stored values as an array, NaN for None. They are in any unit."""
    return np.array([np.nan if v is None else v for v in values], dtype=float)


def thin(lines: Sequence[Curve]) -> list[Curve]:
    """Return lines as thin ones without a name, beside others of the same colours."""
    return [replace(line, label="", thin=True) for line in lines]


def unnamed(lines: Sequence[Curve]) -> list[Curve]:
    """Return lines without names, below others of the same colours that have them."""
    return [replace(line, label="") for line in lines]


def frequency_axis(curves: Sequence[RunCurve | Curve]) -> Axis:
    """Return the axis from 0 to the highest frequency of the curves [Hz]."""
    return Axis("frequency [Hz]", 0.0, max(float(c.x.max()) for c in curves))


def swept_axis(curves: Sequence[Curve]) -> Axis:
    """Return the axis around the frequencies that sweeps pass [Hz]."""
    low, high = min(c.x.min() for c in curves), max(c.x.max() for c in curves)
    return Axis("frequency [Hz]", 0.98 * float(low), 1.02 * float(high))


def outside(run: RunSummary, axis: Axis) -> list[Span]:
    """Return the spans of a frequency axis outside the excited band."""
    if run.spectrum is None or run.facts.get("excitation") in trends.SINGLE_FREQUENCY:
        return []
    low, high = run.spectrum.band_hz
    return [Span(axis.low, low), Span(min(high, axis.high), axis.high)]


def logarithmic_axis(label: str, curves: Sequence[Curve], decades: int = DECADES) -> Axis:
    """Return a logarithmic axis of whole decades around the curves.

    Lines leave it below where they reach further down than so many decades; points do not.
    """
    values = _above_zero([c.y for c in curves])
    if not values.size:
        return Axis(label, 0.1, 1.0, logarithmic=True)
    high = np.ceil(np.log10(values.max()) + 1e-9)
    low = max(np.floor(np.log10(values.min()) - 1e-9), high - decades)
    points = _above_zero([c.y for c in curves if c.points])
    if points.size:
        low = min(low, np.floor(np.log10(points.min()) - 1e-9))
    return Axis(label, 10.0**low, 10.0 ** max(high, low + 1.0), logarithmic=True)


def even_axis(label: str, rows: Sequence[FloatArray]) -> Axis:
    """Return a linear axis around values, in the unit of its label, with a little room."""
    values = np.concatenate([*rows, np.zeros(0)])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    room = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
    return Axis(label, low - room, high + room)


def _above_zero(rows: Sequence[FloatArray]) -> FloatArray:
    values = np.concatenate([*rows, np.zeros(0)])
    return np.asarray(values[np.isfinite(values) & (values > 0.0)])
