"""The stored curves of a run as lines, and the axes around them."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from shakerproc.campaign import trends
from shakerproc.data import FloatArray
from shakerproc.report import svg
from shakerproc.runs.summary import CurveSummary, RunSummary

STILL: Final = 200
"""Points of a line in a still figure of a run, two for five pixels: 92 runs stay small."""

DECADES: Final = 7
"""Decades below the largest value that a logarithmic axis shows at most."""


def curves_of(run: RunSummary, kind: str) -> list[CurveSummary]:
    """Return the curves of one figure."""
    return [curve for curve in run.curves if curve.kind == kind]


def values_of(values: Sequence[float | None]) -> FloatArray:
    """Return stored values as an array, NaN for None. They are in any unit."""
    return np.array([np.nan if v is None else v for v in values], dtype=float)


def frequency_axis(curves: Sequence[CurveSummary]) -> svg.Axis:
    """Return the axis from 0 to the highest frequency of the curves [Hz]."""
    return svg.Axis("frequency [Hz]", 0.0, max(max(c.x) for c in curves))


def outside(run: RunSummary, axis: svg.Axis) -> list[svg.Span]:
    """Return what of a frequency axis lies outside the excited band."""
    if run.spectrum is None or run.facts.get("excitation") in trends.SINGLE_FREQUENCY:
        return []
    low, high = run.spectrum.band_hz
    return [svg.Span(axis.low, low), svg.Span(min(high, axis.high), axis.high)]


def lines_of(curves: Sequence[CurveSummary], chosen: Mapping[str, int]) -> list[svg.Curve]:
    """Return stored curves as lines, each in the style of its channel."""
    return [
        svg.Curve(
            f"{c.channel} {c.part}".strip(), values_of(c.x), values_of(c.y), chosen[c.channel]
        )
        for c in curves
    ]


def logarithmic_axis(
    label: str, curves: Sequence[svg.Curve], decades: int = DECADES
) -> svg.Axis:
    """Return a logarithmic axis of whole decades around the curves.

    Lines leave it below where they reach further down than so many decades; points do not.
    """
    values = _above_zero([c.y for c in curves])
    if not values.size:
        return svg.Axis(label, 0.1, 1.0, logarithmic=True)
    high = np.ceil(np.log10(values.max()) + 1e-9)
    low = max(np.floor(np.log10(values.min()) - 1e-9), high - decades)
    points = _above_zero([c.y for c in curves if c.points])
    if points.size:
        low = min(low, np.floor(np.log10(points.min()) - 1e-9))
    return svg.Axis(label, 10.0**low, 10.0 ** max(high, low + 1.0), logarithmic=True)


def _above_zero(rows: Sequence[FloatArray]) -> FloatArray:
    values = np.concatenate([*rows, np.zeros(0)])
    return np.asarray(values[np.isfinite(values) & (values > 0.0)])
